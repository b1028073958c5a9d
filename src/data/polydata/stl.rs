//! Triangles in STL, the format of stereolithography: ASCII (`facet normal … outer loop vertex x y z …`) or binary (80
//! bytes of comment, the number of triangles as u32, 50 bytes for each: normal and corners as f32, two bytes of
//! attributes; all little-endian).

use super::PolyData;
use crate::files::text::{lines, stranger};
use crate::files::{Fault, fault};
use std::collections::HashMap;

/// Bytes before the triangles, and of each.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// So many triangles more than a file could hold are none: its bytes there mean something else.
const UNLIKELY: usize = 1000;

pub fn read(bytes: &[u8]) -> Result<PolyData, Fault> {
    if let Some(what) = stranger(bytes) {
        return Err(what.into());
    }
    let body = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let begins_as_text =
        (body.trim_ascii_start().get(..5)).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let count = bytes
        .get(80..HEADER)
        .map(|field| u32::from_le_bytes([field[0], field[1], field[2], field[3]]) as usize);
    let whole = bytes.len().saturating_sub(HEADER) / TRIANGLE;
    let triangles = |count: usize| binary(&bytes[HEADER..HEADER + TRIANGLE * count]);
    let corners = match count {
        // Some programs begin binary files with "solid" as well: their length tells them apart.
        Some(count) if HEADER + TRIANGLE * count == bytes.len() => triangles(count),
        _ if begins_as_text && is_text(body) => ascii(&text_of(body))?,
        // Some write their number only in the end, or never; and something after the last triangle.
        Some(0) => triangles(whole),
        Some(count) if count <= whole => triangles(count),
        Some(count) if count / UNLIKELY <= whole => {
            return Err(fault!(
                "a binary STL that announces {count} triangles and has {whole} of them: it is cut off"
            ));
        }
        _ => {
            return Err(
                "neither an ASCII STL, which begins with \"solid\", nor a binary one, which has the number of its \
                 triangles behind 80 bytes"
                    .into(),
            );
        }
    };
    if corners.is_empty() {
        return Err("the STL has no triangles".into());
    }
    Ok(merged(&corners))
}

/// Whether it goes on as text: no binary file is free of zeros.
fn is_text(bytes: &[u8]) -> bool {
    !bytes[..bytes.len().min(4096)].contains(&0)
}

/// Latin-1 if it is not UTF-8: the name of the solid may be in any encoding.
fn text_of(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().copied().map(char::from).collect(),
    }
}

fn binary(bytes: &[u8]) -> Vec<[f64; 3]> {
    let triangles = bytes.chunks_exact(TRIANGLE);
    let corners = triangles.flat_map(|triangle| triangle[12..48].chunks_exact(12));
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let point = |corner: &[u8]| [&corner[..4], &corner[4..8], &corner[8..]].map(number);
    corners.map(point).collect()
}

fn ascii(text: &str) -> Result<Vec<[f64; 3]>, Fault> {
    let mut corners = Vec::new();
    let mut in_loop = None;
    for (number, line) in lines(text) {
        let mut words = line.split_whitespace();
        match words.next().map(str::to_lowercase).as_deref() {
            Some("outer") => in_loop = Some(corners.len()),
            Some("endloop") => {
                let found = in_loop.take().map_or(0, |start| corners.len() - start);
                if found != 3 {
                    return Err(Fault::at(
                        number,
                        format_args!("a facet of {found} corners, not 3"),
                    ));
                }
            }
            Some("vertex") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let [x, y, z] = numbers[..] else {
                    let what = "expected \"vertex\" and three numbers";
                    return Err(Fault::at(
                        number,
                        format_args!("{what}, found {:?}", line.trim()),
                    ));
                };
                corners.push([x, y, z]);
            }
            _ => {}
        }
    }
    if in_loop.is_some() || !corners.len().is_multiple_of(3) {
        return Err("the file ends within a facet: it is cut off".into());
    }
    Ok(corners)
}

/// Triangles that share their points: corners at the same place are one.
fn merged(corners: &[[f64; 3]]) -> PolyData {
    let mut data = PolyData::default();
    let mut known: HashMap<[u64; 3], usize> = HashMap::new();
    let mut number = |corner: &[f64; 3]| {
        // -0.0 is 0.0.
        let key = corner.map(|x| (x + 0.0).to_bits());
        *known.entry(key).or_insert_with(|| {
            data.points.push(*corner);
            data.points.len() - 1
        })
    };
    let triangles = corners
        .chunks_exact(3)
        .map(|three| [0, 1, 2].map(|i| number(&three[i])));
    let triangles: Vec<[usize; 3]> = triangles.collect();
    data.triangles = triangles;
    data
}
