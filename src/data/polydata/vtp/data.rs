//! The numbers of VTK's arrays.

use crate::files::{Fault, fault};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Where the numbers of an array stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Ascii,
    Binary,
    Appended,
}

impl Format {
    pub fn new(word: Option<&str>) -> Result<Self, Fault> {
        match word {
            None | Some("ascii") => Ok(Self::Ascii),
            Some("binary") => Ok(Self::Binary),
            Some("appended") => Ok(Self::Appended),
            Some(other) => Err(fault!(
                "an array has the format {other:?}; VTK knows ascii, binary and appended"
            )),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    Base64,
    Raw,
}

/// How bytes become numbers in the whole file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    is_big_endian: bool,
    /// Bytes of a number in the headers of arrays.
    header: usize,
    is_compressed: bool,
}

impl Layout {
    pub fn new(
        order: Option<&str>,
        header: Option<&str>,
        compressor: Option<&str>,
    ) -> Result<Self, Fault> {
        let is_compressed = match compressor {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(fault!(
                    "compressed by {other}: only vtkZLibDataCompressor, VTK's own choice, can be read; save it without \
                     compression"
                ));
            }
        };
        Ok(Self {
            is_big_endian: order == Some("BigEndian"),
            header: if header == Some("UInt64") { 8 } else { 4 },
            is_compressed,
        })
    }

    fn whole(&self, bytes: &[u8]) -> u64 {
        let fold = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        match self.is_big_endian {
            true => bytes.iter().fold(0, fold),
            false => bytes.iter().rev().fold(0, fold),
        }
    }
}

/// Whether an array of this type has numbers.
pub fn is_number(word: &str) -> bool {
    size(word).is_some()
}

fn size(word: &str) -> Option<usize> {
    match word {
        "Int8" | "UInt8" => Some(1),
        "Int16" | "UInt16" => Some(2),
        "Int32" | "UInt32" | "Float32" => Some(4),
        "Int64" | "UInt64" | "Float64" => Some(8),
        _ => None,
    }
}

pub fn ascii(text: &[u8]) -> Result<Vec<f64>, Fault> {
    let text = std::str::from_utf8(text).map_err(|_| "expected numbers in ASCII")?;
    let number = |word: &str| word.parse().map_err(|_| fault!("{word:?} is not a number"));
    text.split_whitespace().map(number).collect()
}

/// Numbers of the type `word` from a block that begins where `source` does.
pub fn binary(
    (source, encoding): (&[u8], Encoding),
    word: &str,
    layout: &Layout,
) -> Result<Vec<f64>, Fault> {
    let size = size(word).ok_or_else(|| format!("numbers of the type {word:?} are not known"))?;
    let block = DataBlock { source, encoding };
    let bytes = match layout.is_compressed {
        true => compressed(&block, layout)?,
        false => {
            let header = block.take(0, layout.header)?;
            block.take(layout.header, layout.whole(&header) as usize)?
        }
    };
    if bytes.len() % size != 0 {
        return Err(fault!(
            "{} bytes are not a whole number of {word}",
            bytes.len()
        ));
    }
    let number = |bytes: &[u8]| -> f64 {
        let bits = layout.whole(bytes);
        let shift = 64 - 8 * size as u32;
        match word {
            "Float32" => f64::from(f32::from_bits(bits as u32)),
            "Float64" => f64::from_bits(bits),
            _ if word.starts_with('U') => bits as f64,
            _ => ((bits << shift) as i64 >> shift) as f64,
        }
    };
    Ok(bytes.chunks_exact(size).map(number).collect())
}

/// A header, `blocks, bytes of a block, bytes of the last, compressed bytes of each`, then the blocks.
fn compressed(block: &DataBlock<'_>, layout: &Layout) -> Result<Vec<u8>, Fault> {
    let width = layout.header;
    let numbers = |bytes: &[u8]| -> Vec<usize> {
        bytes
            .chunks_exact(width)
            .map(|bytes| layout.whole(bytes) as usize)
            .collect()
    };
    let start = numbers(&block.take(0, 3 * width)?);
    let [blocks, size, last] = [start[0], start[1], start[2]];
    if blocks == 0 {
        return Ok(Vec::new());
    }
    let header = blocks
        .checked_mul(width)
        .and_then(|bytes| bytes.checked_add(3 * width));
    let header = header.ok_or(CUT_OFF)?;
    let sizes = numbers(&block.take(0, header)?)[3..].to_vec();
    let total = sizes
        .iter()
        .try_fold(0, |sum: usize, size| sum.checked_add(*size));
    let packed = block.take(header, total.ok_or(CUT_OFF)?)?;
    let (mut bytes, mut from) = (Vec::new(), 0);
    for (i, packed_size) in sizes.iter().enumerate() {
        let whole = if i + 1 == blocks && last > 0 {
            last
        } else {
            size
        };
        let before = bytes.len();
        let stream = ZlibDecoder::new(&packed[from..from + packed_size]);
        stream
            .take(whole as u64)
            .read_to_end(&mut bytes)
            .map_err(|e| format!("the compressed data is damaged ({e})"))?;
        if bytes.len() - before != whole {
            return Err("the compressed data is damaged: a block is too short".into());
        }
        from += packed_size;
    }
    Ok(bytes)
}

const CUT_OFF: &str = "the data ends too early: the file is cut off or damaged";

/// Bytes that may be written in base64; parts with padding of their own follow each other.
struct DataBlock<'a> {
    source: &'a [u8],
    encoding: Encoding,
}

impl DataBlock<'_> {
    /// So many bytes from a place on.
    fn take(&self, from: usize, count: usize) -> Result<Vec<u8>, Fault> {
        let end = from.checked_add(count).ok_or(CUT_OFF)?;
        let found = match self.encoding {
            Encoding::Raw => self.source.get(from..end).map(<[u8]>::to_vec),
            Encoding::Base64 => decoded(self.source, end)?
                .get(from..end)
                .map(<[u8]>::to_vec),
        };
        found.ok_or(CUT_OFF.into())
    }
}

/// At least the first `wanted` bytes, if there are so many.
fn decoded(text: &[u8], wanted: usize) -> Result<Vec<u8>, Fault> {
    let padding =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::RequireCanonical);
    let engine = GeneralPurpose::new(&STANDARD, padding);
    let is_base64 = |byte: &u8| byte.is_ascii_alphanumeric() || b"+/=".contains(byte);
    let mut letters = (text.iter().copied())
        .filter(|byte| !byte.is_ascii_whitespace())
        .take_while(is_base64);
    let (mut bytes, mut part) = (Vec::new(), Vec::new());
    while bytes.len() < wanted {
        part.clear();
        // A part ends with its padding; long ones are taken in pieces.
        while part.len() < 1 << 16 && !part.ends_with(b"=") {
            let four: Vec<u8> = letters.by_ref().take(4).collect();
            part.extend_from_slice(&four);
            if four.len() < 4 {
                break;
            }
        }
        if part.is_empty() {
            break;
        }
        let decoded = engine
            .decode(&part)
            .map_err(|e| format!("no base64: {e}"))?;
        bytes.extend(decoded);
    }
    Ok(bytes)
}
