//! Files that people write: read whole, if they are files of text and not too large.

use crate::files::read_regular;
use std::io;
use std::path::Path;

/// Far larger than anything that people write.
pub const OF_PARAMETERS: u64 = 1 << 20;

/// The text of a file, which must be UTF-8.
///
/// # Errors
/// If it cannot be read, is no regular file, is larger than `most_bytes`, or is not UTF-8, in words.
pub fn read(path: &Path, most_bytes: u64) -> io::Result<String> {
    String::from_utf8(read_regular(path, most_bytes)?).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|&&byte| byte == b'\n').count();
        let reason = format!("line {line} is not UTF-8; it must be plain text");
        io::Error::new(io::ErrorKind::InvalidData, reason)
    })
}
