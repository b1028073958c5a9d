//! Triangles in STL, the format of stereolithography: ASCII (`facet normal … outer loop vertex x y z …`) or binary (80 bytes
//! of comment, the number of triangles as u32, 50 bytes for each: normal and corners as f32, two bytes of attributes; all
//! little-endian).

use super::PolyData;
use std::collections::HashMap;

/// Bytes before the triangles, and of each.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

pub fn read(bytes: &[u8]) -> Result<PolyData, String> {
    let count = bytes
        .get(80..HEADER)
        .map(|field| u32::from_le_bytes([field[0], field[1], field[2], field[3]]) as usize);
    let expected = count.map(|count| HEADER + TRIANGLE * count);
    // Some programs begin binary files with "solid" as well: their length tells them apart.
    let corners = if expected == Some(bytes.len()) {
        binary(&bytes[HEADER..])
    } else if bytes.trim_ascii_start().starts_with(b"solid") {
        ascii(bytes)?
    } else if let Some(count) = count {
        return Err(format!(
            "a binary STL of {count} triangles has {} bytes, and this file has {}: it is cut off or damaged",
            HEADER + TRIANGLE * count,
            bytes.len()
        ));
    } else {
        return Err("neither an ASCII STL, which begins with \"solid\", nor a binary one".into());
    };
    if corners.is_empty() {
        return Err("the STL has no triangles".into());
    }
    Ok(merged(&corners))
}

fn binary(bytes: &[u8]) -> Vec<[f64; 3]> {
    let triangles = bytes.chunks_exact(TRIANGLE);
    let corners = triangles.flat_map(|triangle| triangle[12..48].chunks_exact(12));
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let point = |corner: &[u8]| [&corner[..4], &corner[4..8], &corner[8..]].map(number);
    corners.map(point).collect()
}

fn ascii(bytes: &[u8]) -> Result<Vec<[f64; 3]>, String> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| "an ASCII STL that is not plain text: is it cut off or damaged?")?;
    let mut corners = Vec::new();
    let mut in_loop = None;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next().map(str::to_lowercase).as_deref() {
            Some("outer") => in_loop = Some(corners.len()),
            Some("endloop") => {
                let found = in_loop.take().map_or(0, |start| corners.len() - start);
                if found != 3 {
                    return Err(format!(
                        "line {}: a facet of {found} corners, not 3",
                        number + 1
                    ));
                }
            }
            Some("vertex") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let [x, y, z] = numbers[..] else {
                    return Err(format!(
                        "line {}: expected \"vertex\" and three numbers, found {:?}",
                        number + 1,
                        line.trim()
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
