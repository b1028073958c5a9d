//! VTK's polydata in XML, as VMTK, SimVascular, 3D Slicer and ParaView write it: numbers in ASCII, in base64 or as raw
//! bytes after the XML, compressed by zlib or not (*VTK File Formats*, kitware.com).

mod data;
mod grid;

pub use grid::Grid;

use super::PolyData;
use crate::files::{Fault, fault};
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

/// A file before its numbers are read.
struct Parsed<'a> {
    pieces: Vec<Piece>,
    layout: Layout,
    /// What follows the underscore of the appended data.
    appended: Option<(&'a [u8], Encoding)>,
}

pub fn read(bytes: &[u8]) -> Result<PolyData, Fault> {
    let parsed = parse(bytes, "PolyData", "expected VTK's PolyData (.vtp)")?;
    let mut all = PolyData::default();
    for piece in &parsed.pieces {
        add(&mut all, piece, &parsed)?;
    }
    Ok(all)
}

/// The pieces of a data set of the type `kind`.
fn parse<'a>(bytes: &'a [u8], kind: &str, expected: &str) -> Result<Parsed<'a>, Fault> {
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
                return Err(fault!(
                    "the file ends within <{}>: it is cut off",
                    within[within.len() - 1]
                ));
            }
            _ => {}
        }
    }
    let (found, layout) = layout.ok_or("no <VTKFile>: this is not a VTK file in XML")?;
    match found == kind {
        true => Ok(Parsed {
            pieces,
            layout,
            appended,
        }),
        false => Err(fault!("{expected}, found {found}: save it as such")),
    }
}

fn last_array(pieces: &mut [Piece]) -> Option<&mut Array> {
    pieces.last_mut()?.arrays.last_mut()
}

fn attributes(tag: &BytesStart<'_>) -> Result<HashMap<String, String>, Fault> {
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
    layout: &mut Option<(String, Layout)>,
    pieces: &mut Vec<Piece>,
) -> Result<(), Fault> {
    let keys = attributes(tag)?;
    let key = |name: &str| keys.get(name).map(String::as_str);
    match name {
        "VTKFile" => {
            let found = Layout::new(key("byte_order"), key("header_type"), key("compressor"))?;
            *layout = Some((key("type").unwrap_or("no type").to_owned(), found));
        }
        "Piece" => {
            let mut piece = Piece::default();
            for (name, value) in &keys {
                let count = value.parse();
                let count = count
                    .map_err(|_| format!("{name} = {value:?} of a piece is not a whole number"))?;
                piece.counts.insert(name.clone(), count);
            }
            pieces.push(piece);
        }
        "DataArray" => {
            let whole = |name: &str, absent: usize| match key(name) {
                None | Some("") => Ok(absent),
                Some(text) => text
                    .parse()
                    .map_err(|_| format!("{name} = {text:?} of an array is not a whole number")),
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

impl Parsed<'_> {
    /// The numbers of an array, so many if that is known.
    fn numbers(&self, array: &Array, wanted: Option<usize>) -> Result<Vec<f64>, Fault> {
        let called = match array.name.as_str() {
            "" => format!("the array in <{}>", array.within),
            name => format!("the array {name:?} in <{}>", array.within),
        };
        let source = match (array.format, self.appended) {
            (Format::Ascii, _) => return in_number(data::ascii(&array.text), wanted, &called),
            (Format::Binary, _) => (&array.text[..], Encoding::Base64),
            (Format::Appended, Some((bytes, encoding))) => {
                let rest = bytes.get(array.offset..);
                let rest = rest.ok_or_else(|| {
                    format!("{called} lies beyond the end of the file: it is cut off")
                })?;
                (rest, encoding)
            }
            (Format::Appended, None) => {
                return Err(fault!("{called} is appended data, and the file has none"));
            }
        };
        in_number(
            data::binary(source, &array.number, &self.layout),
            wanted,
            &called,
        )
    }

    /// Points of each of the `count` cells within an element, the first of the piece's `points` being `first`.
    fn cells(
        &self,
        piece: &Piece,
        within: &str,
        count: usize,
        [first, points]: [usize; 2],
    ) -> Result<Vec<Vec<usize>>, Fault> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let array =
            |name| (piece.find(within, name)).ok_or_else(|| format!("<{within}> has no {name}"));
        let ends = self.numbers(array("offsets")?, Some(count))?;
        let indices = self.numbers(array("connectivity")?, None)?;
        let mut from = 0;
        let cell = |end: &f64| {
            let range = from..*end as usize;
            from = range.end;
            let indices = indices
                .get(range)
                .ok_or_else(|| format!("the offsets of <{within}> do not fit its connectivity"))?;
            let point = |i: &f64| match *i as usize {
                i if i < points => Ok(first + i),
                i => Err(fault!("<{within}> names point {i}, and there are {points}")),
            };
            indices.iter().map(point).collect()
        };
        ends.iter().map(cell).collect()
    }

    /// Positions of the points of a piece.
    fn positions(&self, piece: &Piece) -> Result<Vec<[f64; 3]>, Fault> {
        let points = piece.count("NumberOfPoints");
        if points == 0 {
            return Ok(Vec::new());
        }
        let array = piece.find("Points", "").ok_or("the file has no points")?;
        let positions = self.numbers(array, Some(points.saturating_mul(3)))?;
        Ok(positions
            .chunks_exact(3)
            .map(|p| [p[0], p[1], p[2]])
            .collect())
    }
}

impl Piece {
    fn count(&self, name: &str) -> usize {
        self.counts.get(name).copied().unwrap_or(0)
    }

    /// An array within an element; the first one without a name.
    fn find(&self, within: &str, name: &str) -> Option<&Array> {
        let mut arrays = self.arrays.iter();
        arrays.find(|array| array.within == within && (name.is_empty() || array.name == name))
    }
}

fn add(all: &mut PolyData, piece: &Piece, parsed: &Parsed<'_>) -> Result<(), Fault> {
    let count = |name: &str| piece.count(name);
    let first = all.points.len();
    let points = count("NumberOfPoints");
    if points == 0 {
        return Ok(());
    }
    all.points.extend(parsed.positions(piece)?);
    let cells = |within: &str, count: usize| parsed.cells(piece, within, count, [first, points]);
    all.lines.extend(cells("Lines", count("NumberOfLines"))?);
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
    add_arrays(all, piece, parsed, first)
}

/// Numbers of the points and lines of a piece whose points begin at `first`.
fn add_arrays(
    all: &mut PolyData,
    piece: &Piece,
    parsed: &Parsed<'_>,
    first: usize,
) -> Result<(), Fault> {
    let [points, verts, lines] =
        ["NumberOfPoints", "NumberOfVerts", "NumberOfLines"].map(|name| piece.count(name));
    let numbers = |array: &Array, wanted: Option<usize>| parsed.numbers(array, wanted);
    // Numbers of several ways, a component each.
    for array in piece.arrays.iter().filter(|array| {
        array.within == "PointData" && array.name == "CenterlineId" && array.components > 1
    }) {
        let n = array.components;
        let values = numbers(array, Some(points.saturating_mul(n)))?;
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
    found: Result<Vec<f64>, Fault>,
    wanted: Option<usize>,
    called: &str,
) -> Result<Vec<f64>, Fault> {
    let found = found.map_err(|reason| format!("{called}: {reason}"))?;
    match wanted {
        Some(wanted) if wanted != found.len() => Err(fault!(
            "{called} has {} numbers, and {wanted} were announced",
            found.len()
        )),
        _ => Ok(found),
    }
}

#[cfg(test)]
mod tests;
