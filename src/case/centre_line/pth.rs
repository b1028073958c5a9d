//! Paths of SimVascular (`Paths/NAME.pth`): XML with the points that were clicked, and those of the spline through
//! them.

use super::CentreLine;
use super::LineFile;
use crate::files::{Fault, fault, read_regular, text};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::path::Path;

/// Far larger than any path.
const MOST_BYTES: u64 = 64 << 20;

pub fn read(path: &Path) -> Result<LineFile, Fault> {
    let bytes = read_regular(path, MOST_BYTES).map_err(|error| error.to_string())?;
    let points = points(&text::decode(&bytes)?)?;
    Ok(LineFile {
        understood: format!("SimVascular's path: {} points, no radii", points.len()),
        line: CentreLine {
            points,
            radii: Vec::new(),
        },
        unit: None,
    })
}

/// The points of the spline at the first of the times that there may be.
fn points(text: &str) -> Result<Vec<[f64; 3]>, Fault> {
    let mut reader = Reader::from_str(text);
    // Old files begin with two roots.
    reader.config_mut().check_end_names = false;
    let (mut points, mut is_within) = (Vec::new(), false);
    loop {
        let event = reader.read_event().map_err(|error| {
            let at = reader.error_position();
            format!("no XML from byte {at} on ({error}): the file is cut off or damaged")
        })?;
        match event {
            Event::Start(tag) if tag.name().as_ref() == b"path_points" => is_within = true,
            Event::End(tag) if tag.name().as_ref() == b"path_points" => return Ok(points),
            Event::Start(tag) | Event::Empty(tag) if is_within && tag.name().as_ref() == b"pos" => {
                points.push(position(&tag)?);
            }
            Event::Eof if is_within => {
                return Err("the file ends within its points: it is cut off".into());
            }
            Event::Eof => {
                return Err("it has no <path_points>: this is no path of SimVascular".into());
            }
            _ => {}
        }
    }
}

fn position(tag: &BytesStart<'_>) -> Result<[f64; 3], Fault> {
    let mut position = [f64::NAN; 3];
    for attribute in tag.attributes().flatten() {
        let value = attribute.unescape_value().unwrap_or_default();
        let axis = [b"x", b"y", b"z"]
            .iter()
            .position(|name| attribute.key.as_ref() == *name);
        if let Some(axis) = axis {
            position[axis] = value.trim().parse().unwrap_or(f64::NAN);
        }
    }
    match position.iter().all(|x| x.is_finite()) {
        true => Ok(position),
        false => Err(fault!(
            "expected numbers x, y and z, found {:?}",
            String::from_utf8_lossy(tag)
        )),
    }
}
