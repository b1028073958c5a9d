//! VTK's unstructured grids: hexahedra with 8, 20 or 27 nodes; quadrilaterals as surfaces. The cell data `region`
//! numbers both, and its numbers are the names of regions and surfaces.

use super::gmsh::weighted;
use super::lattice::{Lattice, VTK as ORDER};
use super::{FileHex, WallFile};
use crate::Vec3;
use crate::files::{Fault, fault};
use crate::polydata::Grid;
use std::path::Path;

/// Cell data that number regions and surfaces: the plain name, and those that other programs write.
const NUMBERS: [&str; 3] = ["region", "gmsh:physical", "CellEntityIds"];
/// VTK's numbers of points and lines, of quadrilaterals, and of hexahedra with their order and number of nodes.
const LINES: [u8; 5] = [1, 2, 3, 4, 21];
const QUADRILATERALS: [u8; 3] = [9, 23, 28];
const HEXAHEDRA: [(u8, usize, usize); 3] = [(12, 1, 8), (25, 2, 20), (29, 2, 27)];

pub fn read(path: &Path) -> Result<WallFile, Fault> {
    let grid = Grid::read(path)?;
    let mut file = WallFile {
        nodes: grid.points.iter().map(|x| Vec3::from(*x)).collect(),
        ..WallFile::default()
    };
    let numbers = NUMBERS.iter().find_map(|name| grid.of_cells.get(*name));
    if numbers.is_none() && grid.kinds.iter().any(|kind| QUADRILATERALS.contains(kind)) {
        return Err(fault!(
            "its cells have no numbers of regions and surfaces: expected an array {} of the cells",
            NUMBERS.join(", ")
        ));
    }
    let fibres = (grid.of_cells.get("axial")).zip(grid.of_cells.get("circumferential"));
    let mut directions = Vec::new();
    for (cell, (listed, kind)) in grid.cells.iter().zip(&grid.kinds).enumerate() {
        let name = numbers.and_then(|numbers| numbers.get(cell));
        let name = name.map_or(String::new(), |number| format!("{}", *number as i64));
        let short = || fault!("the cell {cell} has not as many points as its type needs");
        if LINES.contains(kind) {
            continue;
        }
        if QUADRILATERALS.contains(kind) {
            file.add_face(&name, *listed.first_chunk().ok_or_else(short)?);
            continue;
        }
        let known = HEXAHEDRA.iter().find(|(known, ..)| known == kind);
        let &(_, order, count) = known.ok_or_else(|| {
            format!(
                "the cell {cell} is of VTK's type {kind}: expected hexahedra with 8, 20 or 27 nodes, and quadrilaterals"
            )
        })?;
        if listed.len() != count {
            return Err(short());
        }
        let region = file.region(&name);
        let nodes = match count {
            20 => {
                let positions = &mut file.nodes;
                Lattice::serendipity(listed, &ORDER, |weights| weighted(positions, weights))
            }
            _ => Lattice::full(order, listed, &ORDER),
        };
        file.hexes.push(FileHex {
            nodes,
            region,
            label: cell.to_string(),
        });
        if let Some((axial, around)) = fibres {
            let of = |values: &[f64]| values.get(3 * cell..3 * cell + 3).map(Vec3::from_row_slice);
            directions.extend(of(axial).zip(of(around)).map(|(a, c)| [a, c]));
        }
    }
    file.directions =
        (!directions.is_empty() && directions.len() == file.hexes.len()).then_some(directions);
    Ok(file)
}
