//! VTK's unstructured grids in XML, in the same encodings.

use super::{data, parse};
use crate::files;
use crate::files::Fault;
use std::collections::BTreeMap;
use std::path::Path;

/// Cells of any kind with numbers, in the unit of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Grid {
    /// Positions.
    pub points: Vec<[f64; 3]>,
    /// Numbers of the points of each cell.
    pub cells: Vec<Vec<usize>>,
    /// VTK's number of the kind of each cell.
    pub kinds: Vec<u8>,
    /// Arrays with numbers for each cell, by name: the components of a cell follow each other.
    pub of_cells: BTreeMap<String, Vec<f64>>,
}

impl Grid {
    /// Reads a file (`.vtu`).
    ///
    /// # Errors
    /// What is wrong with it, in a sentence.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let bytes = files::read_regular(path, super::super::MOST_BYTES);
        let bytes = bytes.map_err(|error| error.to_string())?;
        let parsed = parse(
            &bytes,
            "UnstructuredGrid",
            "expected VTK's UnstructuredGrid (.vtu)",
        )?;
        let mut all = Self::default();
        for piece in &parsed.pieces {
            let (first, before) = (all.points.len(), all.cells.len());
            all.points.extend(parsed.positions(piece)?);
            let range = [first, all.points.len() - first];
            let count = piece.count("NumberOfCells");
            all.cells
                .extend(parsed.cells(piece, "Cells", count, range)?);
            if count > 0 {
                let kinds = piece.find("Cells", "types").ok_or("<Cells> has no types")?;
                let kinds = parsed.numbers(kinds, Some(count))?;
                all.kinds.extend(kinds.iter().map(|kind| *kind as u8));
            }
            let arrays = piece
                .arrays
                .iter()
                .filter(|array| array.within == "CellData");
            for array in arrays.filter(|array| data::is_number(&array.number)) {
                let n = array.components;
                let values = parsed.numbers(array, Some(count.saturating_mul(n)))?;
                let column = all.of_cells.entry(array.name.clone()).or_default();
                column.resize(before * n, f64::NAN);
                column.extend(values);
            }
        }
        match all.points.iter().flatten().all(|x| x.is_finite()) {
            true => Ok(all),
            false => Err("a point has a coordinate that is not a finite number".into()),
        }
    }
}
