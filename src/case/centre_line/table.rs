//! Tables of points: `x,y,z` or `x,y,z,r`, whatever the columns are called and whatever separates them, as
//! spreadsheets, ParaView and VMTK (`vmtkcenterlines -ofile line.dat`) write them.

use super::LineFile;
use crate::tabular::units::{self, Unit};
use crate::tabular::{Fault, Sheet};
use std::f64::consts::PI;
use std::path::Path;

/// Words before the number of a component, as in `Points:0`.
const POSITIONS: [&str; 7] = [
    "points",
    "point",
    "coordinates",
    "coordinate",
    "coords",
    "position",
    "pos",
];
/// Parts of the names of widths.
const RADII: [&str; 6] = ["radius", "radii", "rayon", "radio", "raggio", "halbmesser"];
const DIAMETERS: [&str; 4] = ["diam", "diám", "diàm", "durchmesser"];
const AREAS: [&str; 4] = ["area", "aire", "fläche", "querschnitt"];
/// Points of several lines in one table jump back: a step of more than so many usual ones that ends so close to an
/// earlier point.
const JUMP: f64 = 20.0;

/// A width of the lumen and what makes a radius of it.
type Width = (usize, &'static str, fn(f64) -> f64);

pub fn read(path: &Path) -> Result<LineFile, Fault> {
    let is_header = |names: &[String]| position(names).is_some();
    let sheet = Sheet::read(path, 3, is_header)?;
    let (position, width) = columns(&sheet)?;
    let mut file = LineFile {
        unit: unit(&sheet, position, width)?,
        ..LineFile::default()
    };
    let line = &mut file.line;
    for row in &sheet.rows {
        let mut point = [0.0; 3];
        for (x, column) in point.iter_mut().zip(position) {
            *x = sheet.number(row, column)?;
        }
        line.points.push(point);
        if let Some((column, _, radius)) = width {
            let found = sheet.number(row, column)?;
            if found <= 0.0 {
                return Err(Fault::at(
                    row.line,
                    format!("expected a radius above 0, found {found}"),
                ));
            }
            line.radii.push(radius(found));
        }
    }
    if let Some(i) = jump_back(&line.points) {
        return Err(Fault::at(
            sheet.rows[i].line,
            "here the points jump back to an earlier one: the table holds several lines, of which it does not say where \
             they end; leave one of them in it, or save it as .vtp",
        ));
    }
    file.understood = understood(&sheet, position, width, file.unit);
    Ok(file)
}

/// What the width of the lumen is, and how its radius follows.
type Kind = (&'static str, fn(f64) -> f64);
const RADIUS: Kind = ("radius", |r| r);

/// The columns of the coordinates, and of the lumen's width.
fn columns(sheet: &Sheet) -> Result<([usize; 3], Option<Width>), Fault> {
    let names: Vec<String> = sheet
        .columns
        .iter()
        .map(|column| column.name.clone())
        .collect();
    let count = names.len();
    let Some((line, text)) = &sheet.header else {
        let line = sheet.rows.first().map_or(1, |row| row.line);
        let wrong = |reason: String| Err(Fault::at(line, reason));
        return match count {
            0 | 3 => Ok(([0, 1, 2], None)),
            4 => Ok(([0, 1, 2], Some((3, RADIUS.0, RADIUS.1)))),
            7 => wrong("expected 3 or 4 columns, found 7: is this a tree in SWC? Then its name must end with .swc".into()),
            _ => wrong(format!(
                "expected 3 or 4 numbers, found {count}: name the columns in a first line, x,y,z,r and any others"
            )),
        };
    };
    let Some(position) = position(&names) else {
        return Err(Fault::at(
            *line,
            format!("expected the columns x,y,z or x,y,z,r, found {text:?}"),
        ));
    };
    // A name of one letter counts as a whole only.
    let is_of_radius = |name: &str| tokens(name).contains(&"r") || is_one_of(name, &RADII);
    let is_of_diameter = |name: &str| tokens(name).contains(&"d") || is_one_of(name, &DIAMETERS);
    type Of<'a> = &'a dyn Fn(&str) -> bool;
    let kinds: [(Of<'_>, Kind); 4] = [
        (
            &|name| name.contains("maximuminscribedsphereradius"),
            RADIUS,
        ),
        (&is_of_radius, RADIUS),
        (&is_of_diameter, ("diameter", |d| 0.5 * d)),
        (
            &|name| is_one_of(name, &AREAS),
            ("area", |a| (a / PI).sqrt()),
        ),
    ];
    let others = names
        .iter()
        .enumerate()
        .filter(|(i, _)| !position.contains(i));
    let width = kinds.into_iter().find_map(|(of, (what, radius))| {
        let mut columns = others.clone().filter(|(_, name)| of(&name.to_lowercase()));
        columns.next().map(|(i, _)| (i, what, radius))
    });
    Ok((position, width))
}

fn is_one_of(name: &str, words: &[&str]) -> bool {
    words.iter().any(|word| name.contains(word))
}

fn tokens(name: &str) -> Vec<&str> {
    let tokens = name.split(|c: char| !c.is_alphanumeric());
    tokens.filter(|token| !token.is_empty()).collect()
}

/// The columns of x, y and z.
fn position(names: &[String]) -> Option<[usize; 3]> {
    let column = |axis: usize| {
        let letter = ["x", "y", "z"][axis];
        let number = ["0", "1", "2"][axis];
        names.iter().position(|name| {
            let small = name.to_lowercase();
            let tokens = tokens(&small);
            let is_component = |pair: &[&str]| POSITIONS.contains(&pair[0]) && pair[1] == number;
            tokens.contains(&letter)
                || tokens.windows(2).any(is_component)
                || tokens.iter().any(|token| {
                    let rest = token.strip_prefix(letter).or(token.strip_suffix(letter));
                    rest.is_some_and(|rest| {
                        POSITIONS.contains(&rest) || ["coord", "p"].contains(&rest)
                    })
                })
        })
    };
    Some([column(0)?, column(1)?, column(2)?])
}

/// The unit that the header says of the lengths, m.
fn unit(sheet: &Sheet, position: [usize; 3], width: Option<Width>) -> Result<Option<f64>, Fault> {
    let line = sheet.header.as_ref().map(|(line, _)| *line);
    let lengths = width
        .filter(|(_, what, _)| *what != "area")
        .map(|(column, ..)| column);
    let mut found: Option<Unit> = None;
    for column in position.into_iter().chain(lengths) {
        let unit = sheet.unit(column, units::LENGTH).map_err(|e| Fault {
            line,
            message: e.to_string(),
        })?;
        match (found, unit) {
            (Some(one), Some(other)) if !one.is(&other) => {
                return Err(Fault {
                    line,
                    message: "the columns are in different units of length: write them all in one"
                        .into(),
                });
            }
            _ => found = found.or(unit),
        }
    }
    Ok(found.map(|unit| unit.size))
}

/// The first point that lies at an earlier one, far from the one before it.
fn jump_back(points: &[[f64; 3]]) -> Option<usize> {
    let distance =
        |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let steps: Vec<f64> = points
        .windows(2)
        .map(|pair| distance(&pair[0], &pair[1]))
        .collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = *sorted.get(sorted.len() / 2)?;
    let jumps = (1..points.len()).filter(|i| steps[i - 1] > JUMP * usual);
    let is_back = |i: &usize| {
        // Not the points right before it.
        let earlier = points[..i.saturating_sub(2)].iter();
        earlier
            .into_iter()
            .any(|point| distance(point, &points[*i]) <= usual)
    };
    jumps.into_iter().find(is_back)
}

fn understood(
    sheet: &Sheet,
    position: [usize; 3],
    width: Option<Width>,
    unit: Option<f64>,
) -> String {
    let width_of = match width {
        None => "no radii".to_owned(),
        Some((column, what, _)) => format!("{what} in {}", sheet.listed([column])),
    };
    let used = position.into_iter().chain(width.map(|(column, ..)| column));
    let used: Vec<usize> = used.collect();
    let others: Vec<usize> = (0..sheet.columns.len())
        .filter(|i| !used.contains(i))
        .collect();
    let left_out = match others.is_empty() {
        true => String::new(),
        false => format!("; {} left out", sheet.listed(others)),
    };
    let unit = match unit {
        None => String::new(),
        Some(_) => "; the header says the unit".to_owned(),
    };
    format!(
        "{}; x, y, z in {}, {width_of}{left_out}{unit}",
        sheet.shape(),
        sheet.listed(position)
    )
}
