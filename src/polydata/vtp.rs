//! VTK's polydata in XML, as VMTK, SimVascular, 3D Slicer and ParaView write it: numbers in ASCII, in base64 or as raw bytes
//! behind the XML, compressed by zlib or not (*VTK File Formats*, kitware.com).

mod data;

use super::PolyData;
use data::{Encoding, Format, Layout};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::{BTreeMap, HashMap};

/// A `DataArray` before its numbers are read.
struct Array {
    /// The elements that it stands in: `Points`, `Lines`, `PointData`, …
    within: String,
    name: String,
    components: usize,
    number: String,
    format: Format,
    offset: usize,
    text: Vec<u8>,
}

#[derive(Default)]
struct Piece {
    counts: HashMap<String, usize>,
    arrays: Vec<Array>,
}

pub fn read(bytes: &[u8]) -> Result<PolyData, String> {
    let mut reader = Reader::from_reader(bytes);
    let (mut layout, mut pieces) = (None, Vec::new());
    let mut within: Vec<String> = Vec::new();
    let mut open = false;
    let mut appended: Option<(&[u8], Encoding)> = None;
    loop {
        let broken = |e: &dyn std::fmt::Display, at: u64| {
            format!("no XML from byte {at} on ({e}): the file is cut off or damaged")
        };
        let event = reader
            .read_event()
            .map_err(|e| broken(&e, reader.error_position()))?;
        match event {
            Event::Start(tag) | Event::Empty(tag) if tag.name().as_ref() == b"AppendedData" => {
                let keys = attributes(&tag)?;
                let encoding = match keys.get("encoding").map(String::as_str) {
                    Some("raw") => Encoding::Raw,
                    _ => Encoding::Base64,
                };
                let rest = &bytes[reader.buffer_position() as usize..];
                let start = rest.iter().position(|byte| *byte == b'_');
                let start = start.ok_or("the appended data does not begin with an underscore")?;
                appended = Some((&rest[start + 1..], encoding));
                break; // what follows may be no XML
            }
            Event::Start(tag) => {
                let name = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
                open |= name == "DataArray";
                begin(&name, &tag, &within, &mut layout, &mut pieces)?;
                within.push(name);
            }
            Event::Empty(tag) => {
                let name = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
                begin(&name, &tag, &within, &mut layout, &mut pieces)?;
            }
            Event::Text(text) if open && within.last().is_some_and(|n| n == "DataArray") => {
                if let Some(array) = last_array(&mut pieces) {
                    array.text.extend_from_slice(&text);
                }
            }
            Event::End(tag) => {
                if tag.name().as_ref() == b"DataArray" {
                    open = false;
                }
                within.pop();
            }
            Event::Eof if within.is_empty() => break,
            Event::Eof => {
                return Err(format!(
                    "the file ends within <{}>: it is cut off",
                    within[within.len() - 1]
                ));
            }
            _ => {}
        }
    }
    let layout = layout.ok_or("no <VTKFile>: this is no file of VTK in XML")?;
    let mut all = PolyData::default();
    for piece in &pieces {
        add(&mut all, piece, &layout, appended)?;
    }
    Ok(all)
}

fn last_array(pieces: &mut [Piece]) -> Option<&mut Array> {
    pieces.last_mut()?.arrays.last_mut()
}

fn attributes(tag: &BytesStart<'_>) -> Result<HashMap<String, String>, String> {
    let mut all = HashMap::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|e| format!("a broken attribute: {e}"))?;
        let name = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
        let value = attribute.unescape_value();
        let value = value.map_err(|e| format!("a broken value of {name}: {e}"))?;
        all.insert(name, value.into_owned());
    }
    Ok(all)
}

fn begin(
    name: &str,
    tag: &BytesStart<'_>,
    within: &[String],
    layout: &mut Option<Layout>,
    pieces: &mut Vec<Piece>,
) -> Result<(), String> {
    let keys = attributes(tag)?;
    let key = |name: &str| keys.get(name).map(String::as_str);
    match name {
        "VTKFile" => {
            match key("type") {
                Some("PolyData") => {}
                other => {
                    return Err(format!(
                        "expected VTK's PolyData (.vtp), found {}: save lines or triangles as polydata",
                        other.unwrap_or("no type")
                    ));
                }
            }
            *layout = Some(Layout::new(
                key("byte_order"),
                key("header_type"),
                key("compressor"),
            )?);
        }
        "Piece" => {
            let mut piece = Piece::default();
            for (name, value) in &keys {
                let count = value.parse();
                let count = count
                    .map_err(|_| format!("{name} = {value:?} of a piece is no whole number"))?;
                piece.counts.insert(name.clone(), count);
            }
            pieces.push(piece);
        }
        "DataArray" => {
            let whole = |name: &str, absent: usize| match key(name) {
                None | Some("") => Ok(absent),
                Some(text) => text
                    .parse()
                    .map_err(|_| format!("{name} = {text:?} of an array is no whole number")),
            };
            // Arrays of the whole file, such as its time, stand outside of pieces.
            let parent = within.last().cloned().unwrap_or_default();
            if let Some(piece) = pieces.last_mut()
                && within.iter().any(|name| name == "Piece")
            {
                piece.arrays.push(Array {
                    within: parent,
                    name: key("Name").unwrap_or_default().to_owned(),
                    components: whole("NumberOfComponents", 1)?.max(1),
                    number: key("type").unwrap_or_default().to_owned(),
                    format: Format::new(key("format"))?,
                    offset: whole("offset", 0)?,
                    text: Vec::new(),
                });
            }
        }
        _ => {}
    }
    Ok(())
}

fn add(
    all: &mut PolyData,
    piece: &Piece,
    layout: &Layout,
    appended: Option<(&[u8], Encoding)>,
) -> Result<(), String> {
    let count = |name: &str| piece.counts.get(name).copied().unwrap_or(0);
    let numbers = |array: &Array, wanted: Option<usize>| -> Result<Vec<f64>, String> {
        let called = match array.name.as_str() {
            "" => format!("the array in <{}>", array.within),
            name => format!("the array {name:?} in <{}>", array.within),
        };
        let source = match (array.format, appended) {
            (Format::Ascii, _) => return in_number(data::ascii(&array.text), wanted, &called),
            (Format::Binary, _) => (&array.text[..], Encoding::Base64),
            (Format::Appended, Some((bytes, encoding))) => {
                let rest = bytes.get(array.offset..);
                (
                    rest.ok_or_else(|| {
                        format!("{called} lies behind the end of the file: it is cut off")
                    })?,
                    encoding,
                )
            }
            (Format::Appended, None) => {
                return Err(format!("{called} is appended data, and the file has none"));
            }
        };
        in_number(data::binary(source, &array.number, layout), wanted, &called)
    };
    let find = |within: &str, name: &str| {
        let mut arrays = piece.arrays.iter();
        arrays.find(|array| array.within == within && (name.is_empty() || array.name == name))
    };
    let first = all.points.len();
    let points = count("NumberOfPoints");
    if points == 0 {
        return Ok(());
    }
    let array = find("Points", "").ok_or("the file has no points")?;
    let positions = numbers(array, Some(3 * points))?;
    all.points
        .extend(positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));

    let cells = |within: &str, count: usize| -> Result<Vec<Vec<usize>>, String> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let array = |name| find(within, name).ok_or_else(|| format!("<{within}> has no {name}"));
        let ends = numbers(array("offsets")?, Some(count))?;
        let indices = numbers(array("connectivity")?, None)?;
        let mut from = 0;
        let cell = |end: &f64| {
            let range = from..*end as usize;
            from = range.end;
            let indices = indices
                .get(range)
                .ok_or_else(|| format!("the offsets of <{within}> do not fit its connectivity"))?;
            let point = |i: &f64| match *i as usize {
                i if i < points => Ok(first + i),
                i => Err(format!(
                    "<{within}> names point {i}, and there are {points}"
                )),
            };
            indices.iter().map(point).collect()
        };
        ends.iter().map(cell).collect()
    };
    let (verts, lines) = (count("NumberOfVerts"), count("NumberOfLines"));
    all.lines.extend(cells("Lines", lines)?);
    for polygon in cells("Polys", count("NumberOfPolys"))? {
        let corners = 1..polygon.len().saturating_sub(1);
        all.triangles
            .extend(corners.map(|i| [polygon[0], polygon[i], polygon[i + 1]]));
    }
    for strip in cells("Strips", count("NumberOfStrips"))? {
        let triangles = strip.windows(3).enumerate();
        all.triangles.extend(triangles.map(|(i, t)| match i % 2 {
            0 => [t[0], t[1], t[2]],
            _ => [t[1], t[0], t[2]],
        }));
    }
    // Numbers of several ways, a component each.
    for array in piece.arrays.iter().filter(|array| {
        array.within == "PointData" && array.name == "CenterlineId" && array.components > 1
    }) {
        let n = array.components;
        let values = numbers(array, Some(n * points))?;
        for component in 0..n {
            let column = all
                .of_points
                .entry(format!("{}:{component}", array.name))
                .or_default();
            column.resize(first, f64::NAN);
            column.extend(values.iter().skip(component).step_by(n));
        }
    }
    for array in piece
        .arrays
        .iter()
        .filter(|array| array.components == 1 && !array.name.is_empty())
    {
        let extend = |map: &mut BTreeMap<String, Vec<f64>>, before: usize, values: &[f64]| {
            let column = map.entry(array.name.clone()).or_default();
            column.resize(before, f64::NAN);
            column.extend_from_slice(values);
        };
        match array.within.as_str() {
            "PointData" if data::is_number(&array.number) => {
                extend(&mut all.of_points, first, &numbers(array, Some(points))?);
            }
            // In the order vertices, lines, polygons, strips.
            "CellData" if lines > 0 && data::is_number(&array.number) => {
                let values = numbers(array, None)?;
                let of_lines = values.get(verts..verts + lines);
                let of_lines = of_lines
                    .ok_or_else(|| format!("the array {:?} has too few numbers", array.name))?;
                extend(&mut all.of_lines, all.lines.len() - lines, of_lines);
            }
            _ => {}
        }
    }
    Ok(())
}

/// Names the array in errors, and counts its numbers.
fn in_number(
    found: Result<Vec<f64>, String>,
    wanted: Option<usize>,
    called: &str,
) -> Result<Vec<f64>, String> {
    let found = found.map_err(|reason| format!("{called}: {reason}"))?;
    match wanted {
        Some(wanted) if wanted != found.len() => Err(format!(
            "{called} has {} numbers, and {wanted} were announced",
            found.len()
        )),
        _ => Ok(found),
    }
}

#[cfg(test)]
mod tests;
