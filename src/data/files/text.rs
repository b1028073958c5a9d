//! Text as other programs save it: with a byte order mark, in UTF-16, or in an old encoding of one byte a letter.

use crate::files::Fault;
/// The first bytes of files that are not text, and what they are.
const NO_TEXT: [(&[u8], &str); 8] = [
    (
        b"PK\x03\x04",
        "this is a zip archive, such as a workbook of Excel or LibreOffice: save the sheet as CSV",
    ),
    (
        b"\xd0\xcf\x11\xe0",
        "this is an old workbook of Excel: save the sheet as CSV",
    ),
    (b"\x1f\x8b", "this is compressed by gzip: unpack it"),
    (b"%PDF", "this is a PDF: copy the numbers into a text file"),
    (b"\x89HDF", "this is an HDF5 file: export the table as CSV"),
    (
        b"version https://git-lfs",
        "this is a pointer of Git LFS, not the file itself: fetch it with `git lfs pull`",
    ),
    (
        b"<!DOCTYPE",
        "this is a web page, not the file itself: download the raw file",
    ),
    (
        b"<html",
        "this is a web page, not the file itself: download the raw file",
    ),
];

/// What a file is that begins with these bytes, if it is known to be something else than the user meant to give.
pub fn stranger(bytes: &[u8]) -> Option<&'static str> {
    let begins = |start: &[u8]| {
        (bytes.get(..start.len())).is_some_and(|bytes| bytes.eq_ignore_ascii_case(start))
    };
    let found = NO_TEXT.iter().find(|(start, _)| begins(start));
    found.map(|(_, what)| *what)
}

/// The text of a file: UTF-8 or UTF-16 by its byte order mark, which is left out; otherwise UTF-8, or Latin-1 if it is
/// not that.
///
/// # Errors
/// If it is not text, in a sentence.
pub fn decode(bytes: &[u8]) -> Result<String, Fault> {
    if let Some(what) = stranger(bytes) {
        return Err(what.into());
    }
    let wide = |read: fn([u8; 2]) -> u16| {
        let units = bytes[2..].chunks_exact(2).map(|two| read([two[0], two[1]]));
        String::from_utf16_lossy(&units.collect::<Vec<_>>())
    };
    let text = match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            match std::str::from_utf8(bytes) {
                Ok(text) => text.to_owned(),
                Err(_) => bytes.iter().copied().map(char::from).collect(),
            }
        }
    };
    match text.contains('\0') {
        true => Err("this is a binary file, not text".into()),
        false => Ok(text),
    }
}

/// Lines with their numbers, counted from 1, whether they end as on Linux, Windows or an old Macintosh.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_old = text.contains('\r') && !text.contains('\n');
    let end = if is_old { '\r' } else { '\n' };
    (1..).zip(
        text.split(end)
            .map(|line| line.strip_suffix('\r').unwrap_or(line)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_read_in_the_encodings_that_programs_write() {
        let wide = |endian: fn(u16) -> [u8; 2]| -> Vec<u8> {
            let units = "\u{feff}Q (cm³/s)".encode_utf16();
            units.flat_map(endian).collect()
        };
        for bytes in [
            "Q (cm³/s)".as_bytes().to_vec(),
            b"\xef\xbb\xbfQ (cm\xc2\xb3/s)".to_vec(),
            b"Q (cm\xb3/s)".to_vec(),
            wide(u16::to_le_bytes),
            wide(u16::to_be_bytes),
        ] {
            assert_eq!(decode(&bytes).unwrap(), "Q (cm³/s)");
        }
        #[rustfmt::skip]
        let files = [
            (&b"PK\x03\x04rest"[..], "save the sheet as CSV"),
            (b"0,1\n\0\0", "a binary file"),
            (b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
            (b"<!doctype html>\n<html>", "a web page"),
        ];
        for (bytes, what) in files {
            assert!(decode(bytes).unwrap_err().message.contains(what));
        }
        for text in ["a\nb", "a\r\nb", "a\rb"] {
            assert_eq!(lines(text).collect::<Vec<_>>(), [(1, "a"), (2, "b")]);
        }
    }
}
