//! VTK's unstructured grids: hexahedra with 8, 20 or 27 nodes; quadrilaterals as surfaces. The cell data `region` numbers
//! both, and its numbers are the names of regions and surfaces.

use super::gmsh::weighted;
use super::lattice::{Lattice, VTK as ORDER};
use super::{FileHex, WallFile};
use crate::Vec3;
use std::path::Path;
use vtkio::model::{Attribute, CellType, DataSet, Piece, Vtk};

/// Cell data that number regions and surfaces: the plain name, and those that other programs write.
const NUMBERS: [&str; 3] = ["region", "gmsh:physical", "CellEntityIds"];

pub fn read(path: &Path) -> Result<WallFile, String> {
    let vtk = Vtk::import(path).map_err(|e| format!("it is no VTK file that can be read: {e}"))?;
    let DataSet::UnstructuredGrid { pieces, .. } = vtk.data else {
        return Err("it holds no unstructured grid".into());
    };
    let mut file = WallFile::default();
    let mut directions = Vec::new();
    for piece in pieces {
        let Piece::Inline(piece) = piece else {
            return Err("its pieces lie in other files: merge them".into());
        };
        let first = file.nodes.len();
        let points: Vec<f64> = piece
            .points
            .cast_into()
            .ok_or("its points are no numbers")?;
        file.nodes
            .extend(points.chunks_exact(3).map(Vec3::from_row_slice));
        let data = |name: &str| -> Option<Vec<f64>> {
            piece
                .data
                .cell
                .iter()
                .find_map(|attribute| match attribute {
                    Attribute::DataArray(array) if array.name == name => {
                        array.data.clone().cast_into()
                    }
                    _ => None,
                })
        };
        let numbers = NUMBERS.iter().find_map(|name| data(name));
        let fibres = data("axial").zip(data("circumferential"));
        let (connectivity, offsets) = piece.cells.cell_verts.into_xml();
        let mut begin = 0;
        for (cell, (kind, end)) in piece.cells.types.iter().zip(offsets).enumerate() {
            let end = end as usize;
            let listed = connectivity
                .get(begin..end)
                .ok_or("its cells do not fit their offsets")?;
            let listed: Vec<usize> = listed.iter().map(|&node| first + node as usize).collect();
            begin = end;
            if listed.iter().any(|&node| node >= file.nodes.len()) {
                return Err(format!("the cell {cell} has a point that there is not"));
            }
            let name = (numbers.as_ref()).and_then(|numbers| numbers.get(cell));
            let name = name.map_or(String::new(), |number| format!("{}", *number as i64));
            let order = match kind {
                CellType::Quad | CellType::QuadraticQuad | CellType::BiquadraticQuad => {
                    let corners = listed.first_chunk().ok_or_else(|| short(cell))?;
                    file.add_face(&name, *corners);
                    continue;
                }
                CellType::Hexahedron => 1,
                CellType::QuadraticHexahedron | CellType::TriquadraticHexahedron => 2,
                CellType::Vertex
                | CellType::PolyVertex
                | CellType::Line
                | CellType::PolyLine
                | CellType::QuadraticEdge => continue,
                other => {
                    return Err(format!(
                        "the cell {cell} is of the type {other:?}: expected hexahedra with 8, 20 or 27 nodes, and quadrilaterals"
                    ));
                }
            };
            let count = match kind {
                CellType::Hexahedron => 8,
                CellType::QuadraticHexahedron => 20,
                _ => 27,
            };
            if listed.len() != count {
                return Err(short(cell));
            }
            let region = file.region(&name);
            let nodes = match count {
                20 => {
                    let positions = &mut file.nodes;
                    Lattice::serendipity(&listed, &ORDER, |weights| weighted(positions, weights))
                }
                _ => Lattice::full(order, &listed, &ORDER),
            };
            file.hexes.push(FileHex {
                nodes,
                region,
                label: cell.to_string(),
            });
            if let Some((axial, around)) = &fibres {
                let of =
                    |values: &[f64]| values.get(3 * cell..3 * cell + 3).map(Vec3::from_row_slice);
                directions.extend(of(axial).zip(of(around)).map(|(a, c)| [a, c]));
            }
        }
    }
    file.directions =
        (!directions.is_empty() && directions.len() == file.hexes.len()).then_some(directions);
    Ok(file)
}

fn short(cell: usize) -> String {
    format!("the cell {cell} has not as many points as its type needs")
}
