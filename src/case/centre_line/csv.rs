//! Tables of points.

use super::CentreLine;
use crate::case::text_file;
use std::path::Path;

/// Reads rows of `x,y,z` or `x,y,z,r`, with or without a header; between them stand commas, semicolons or blanks, and lines
/// that begin with `#` are comments.
pub fn read(path: &Path) -> Result<CentreLine, String> {
    let text = text_file::read(path, text_file::OF_A_CURVE).map_err(|error| error.to_string())?;
    let mut line = CentreLine::default();
    let mut columns = None;
    for (number, row) in text.lines().enumerate() {
        let number = number + 1;
        let row = row.trim().trim_start_matches('\u{feff}');
        if row.is_empty() || row.starts_with('#') {
            continue;
        }
        let fields: Vec<&str> = row
            .split([',', ';', ' ', '\t'])
            .filter(|field| !field.is_empty())
            .collect();
        let is_header =
            columns.is_none() && fields.iter().all(|field| field.parse::<f64>().is_err());
        if is_header {
            columns = Some(fields.len());
            let names: Vec<String> = fields.iter().map(|name| name.to_lowercase()).collect();
            let good = names.len() >= 3
                && (names.iter().zip(["x", "y", "z", "r"]))
                    .all(|(name, start)| name.starts_with(start));
            if !good || names.len() > 4 {
                return Err(format!(
                    "line {number}: expected the columns x,y,z or x,y,z,r, found {row:?}"
                ));
            }
            continue;
        }
        let expected = *columns.get_or_insert(fields.len());
        if fields.len() != expected || !(3..=4).contains(&expected) {
            let wanted = match expected {
                3 | 4 => expected.to_string(),
                _ => "3 or 4".to_owned(),
            };
            return Err(format!(
                "line {number}: expected {wanted} numbers, found {row:?}"
            ));
        }
        let numbers: Option<Vec<f64>> = (fields.iter())
            .map(|field| field.parse().ok().filter(|x: &f64| x.is_finite()))
            .collect();
        match numbers.as_deref() {
            Some([x, y, z]) => line.points.push([*x, *y, *z]),
            Some([x, y, z, r]) if *r > 0.0 => {
                line.points.push([*x, *y, *z]);
                line.radii.push(*r);
            }
            Some(_) => {
                return Err(format!(
                    "line {number}: expected a radius above 0, found {row:?}"
                ));
            }
            None => {
                return Err(format!(
                    "line {number}: expected finite numbers, found {row:?}"
                ));
            }
        }
    }
    Ok(line)
}
