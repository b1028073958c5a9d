//! Files that people write: read whole, if they are files of text and not too large.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Far larger than anything that people write.
pub const OF_PARAMETERS: u64 = 1 << 20;
/// Far larger than anything that people measure.
pub const OF_A_CURVE: u64 = 64 << 20;

/// The text of a file. A device, a pipe or a socket is refused before it is opened: reading it might never end.
///
/// # Errors
/// If it cannot be read, is no regular file, is larger than `most_bytes`, or is not UTF-8, in words.
pub fn read(path: &Path, most_bytes: u64) -> io::Result<String> {
    let invalid = |reason: String| io::Error::new(io::ErrorKind::InvalidData, reason);
    let kind = fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return Err(invalid("this is a folder, not a file".into()));
    }
    if !kind.is_file() {
        return Err(invalid(
            "this is a device, a pipe or a socket, not a file".into(),
        ));
    }
    let mut bytes = Vec::new();
    File::open(path)?
        .take(most_bytes + 1)
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        return Err(invalid(format!(
            "larger than {} MiB: this cannot be the right file",
            most_bytes >> 20
        )));
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|&&byte| byte == b'\n').count();
        invalid(format!("line {line} is not UTF-8; it must be plain text"))
    })
}
