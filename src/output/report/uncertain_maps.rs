//! What the samples of uncertain inputs say of each place of the wall: maps, and a table.

use super::maps::{self, MapField, OSI, TAWSS, UnrolledPart};
use super::page::{figure, significant};
use super::table::PageTable;
use crate::output::figure::colour::Palette;
use crate::output::figure::map::{Map, Up};
use crate::output::results::Results;
use crate::uncertainty::{FieldChaos, Inputs};
use nalgebra::DMatrix;
use std::io;

/// Fields of the wall.
const FIELDS: [MapField; 2] = [TAWSS, OSI];
/// Where the samples' polynomials miss more of the variance, no input is said to lead.
const LARGE_ERROR: f64 = 0.3;
/// A standard deviation below this share of the largest mean is no spread to be explained.
const SMALL: f64 = 1e-6;

/// Polynomials of the fields on the faces of a wall.
pub(super) struct UncertainWall {
    fields: Vec<(MapField, FieldChaos)>,
    names: Vec<String>,
    faces: usize,
}

impl UncertainWall {
    /// Of runs at these germs; none if they are too few, or their walls have different faces.
    pub fn new(
        runs: &[&Results],
        germs: &[Vec<f64>],
        inputs: &Inputs,
        names: Vec<String>,
    ) -> Option<Self> {
        let faces = runs.first()?.faces.len();
        if faces == 0 || runs.iter().any(|run| run.faces.len() != faces) {
            return None;
        }
        let chaos = |field: MapField| {
            let value = |run: usize, face: usize| (field.value)(&runs[run].faces[face]);
            let values = DMatrix::from_fn(runs.len(), faces, value);
            Some((field, FieldChaos::fit(inputs, germs, &values)?))
        };
        Some(Self {
            fields: FIELDS.into_iter().map(chaos).collect::<Option<_>>()?,
            names,
            faces,
        })
    }

    /// For each face its place and of each field the mean, the standard deviation, the leave-one-out error and the
    /// total index of each input. `run` is one of those that were used.
    pub fn table(&self, run: &Results) -> PageTable {
        let mut heads = ["x_m", "phi_deg", "centre_x_m", "centre_y_m", "centre_z_m"]
            .map(str::to_owned)
            .to_vec();
        for (field, _) in &self.fields {
            let of_field = ["mean", "standard deviation", "leave-one-out error"];
            heads.extend(of_field.map(|what| format!("{}: {what}", field.label)));
            let indices = self.names.iter();
            heads.extend(indices.map(|name| format!("{}: total index of {name}", field.file)));
        }
        let mut table = PageTable::new(heads);
        for (i, face) in run.faces.iter().enumerate() {
            let place = [
                face.x_m,
                face.phi_deg,
                face.centre_x_m,
                face.centre_y_m,
                face.centre_z_m,
            ];
            let mut row: Vec<f64> = place.to_vec();
            for (_, chaos) in &self.fields {
                row.extend([
                    chaos.mean(i),
                    chaos.deviation(i),
                    chaos.leave_one_out_error(i),
                ]);
                row.extend((0..self.names.len()).map(|input| chaos.total_index(input, i)));
            }
            table.push(row.into_iter().map(|x| format!("{x:.5e}")).collect());
        }
        table
    }

    /// Maps of mean, standard deviation and leading input on the unrolled wall of one of the runs, and what they are.
    pub fn section(&self, run: &Results) -> io::Result<Option<(String, Vec<String>)>> {
        let parts = maps::parts(run)?;
        let mut figures = Vec::new();
        for part in &parts {
            for (field, chaos) in &self.fields {
                figures.extend(self.maps(part, field, chaos));
            }
        }
        let text = format!(
            "At each place a polynomial of degree {} of all inputs is fitted to the samples. The input with the largest \
             total index leads; none is shown where the polynomials of the other samples miss more than {} % of the \
             variance.",
            self.fields[0].1.degree(),
            significant(100.0 * LARGE_ERROR, 2)
        );
        Ok((!figures.is_empty()).then_some((text, figures)))
    }

    fn maps(&self, part: &UnrolledPart, field: &MapField, chaos: &FieldChaos) -> [String; 3] {
        let on_faces =
            |value: &dyn Fn(usize) -> f64| (0..self.faces).map(value).collect::<Vec<_>>();
        let means = on_faces(&|face| chaos.mean(face));
        let deviations = on_faces(&|face| chaos.deviation(face));
        let errors = on_faces(&|face| chaos.leave_one_out_error(face));
        let totals: Vec<Vec<f64>> = (0..self.names.len())
            .map(|input| on_faces(&|face| chaos.total_index(input, face)))
            .collect();
        let largest = |values: &[f64]| {
            let own = part.faces.iter().map(|&face| values[face]);
            own.fold(0.0, f64::max)
        };
        let least = SMALL * largest(&means);
        let leading = |x: f64, phi: f64| {
            let error = part.value(&errors, x, phi);
            let is_known = error <= LARGE_ERROR && part.value(&deviations, x, phi) > least;
            let at = totals.iter().map(|values| part.value(values, x, phi));
            let first = at.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            first
                .filter(|_| is_known)
                .map_or(f64::NAN, |(i, _)| i as f64)
        };
        let (name, label) = (field.label, field.label);
        let quantity = name.split(" / ").next().unwrap_or(name);
        let numbers = |title: &str, values: &[f64]| {
            let svg = Map {
                title: format!("{} {title}", part.name).trim().to_owned(),
                label: label.into(),
                field: &|x, phi| part.value(values, x, phi),
                x: part.x,
                up: Up::Angle,
                range: [0.0, largest(values)],
                palette: Palette::sequential(),
                classes: Vec::new(),
                marks: Vec::new(),
            }
            .to_svg();
            figure(&svg, &format!("{quantity}, {title} over the inputs."), None)
        };
        let count = self.names.len();
        let leads = Map {
            title: format!("{} leading input", part.name).trim().to_owned(),
            label: String::new(),
            field: &leading,
            x: part.x,
            up: Up::Angle,
            range: [-0.5, count as f64 - 0.5],
            palette: Palette::classes(count),
            classes: self.names.clone(),
            marks: Vec::new(),
        };
        [
            numbers("mean", &means),
            numbers("standard deviation", &deviations),
            figure(
                &leads.to_svg(),
                &format!("{quantity}: the input with the largest total index at each place."),
                None,
            ),
        ]
    }
}
