//! A box of hexahedra.

use super::{HexFace, HexMesh, HexShape, WallDirections};
use crate::Vec3;
use std::array;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A box from the origin to `size` (m) in equal elements along x, y and z; all belong to region 0. Its sides are the
/// surfaces `start` (x = 0), `end`, `right` (y = 0), `left`, `bottom` (z = 0) and `top`.
pub fn block_mesh(size: [f64; 3], elements: [usize; 3]) -> HexMesh {
    let [nx, ny, nz] = elements;
    let block = Block { size, elements };
    let vertex = |[i, j, k]: [usize; 3]| i + (nx + 1) * (j + (ny + 1) * k);
    let hexes: Vec<[usize; 8]> = (0..nx * ny * nz)
        .map(|e| {
            let at = block.place(e);
            array::from_fn(|v| vertex(array::from_fn(|d| at[d] + (v >> d & 1))))
        })
        .collect();
    let mut vertices = vec![Vec3::zeros(); (nx + 1) * (ny + 1) * (nz + 1)];
    for (e, hex) in hexes.iter().enumerate() {
        for (v, &index) in hex.iter().enumerate() {
            let corner = array::from_fn(|d| 2.0 * (v >> d & 1) as f64 - 1.0);
            vertices[index] = block.position(e, corner);
        }
    }
    let names = [["start", "end"], ["right", "left"], ["bottom", "top"]];
    let mut surfaces = BTreeMap::new();
    for (axis, names) in names.iter().enumerate() {
        for (upper, name) in [false, true].into_iter().zip(names) {
            let last = if upper { elements[axis] - 1 } else { 0 };
            let there = (0..hexes.len()).filter(|&e| block.place(e)[axis] == last);
            let axis = axis as u8;
            let faces = there.map(|e| (e, HexFace { axis, upper })).collect();
            surfaces.insert((*name).to_owned(), faces);
        }
    }
    HexMesh {
        vertices,
        regions: vec![0; hexes.len()],
        hexes,
        surfaces,
        directions: WallDirections::Local,
        shape: Arc::new(block),
    }
}

struct Block {
    size: [f64; 3],
    elements: [usize; 3],
}

impl Block {
    /// Number of an element along each axis.
    fn place(&self, element: usize) -> [usize; 3] {
        let [nx, ny, _] = self.elements;
        [element % nx, element / nx % ny, element / (nx * ny)]
    }
}

impl HexShape for Block {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let place = self.place(element);
        Vec3::from_fn(|d, _| {
            let share = (place[d] as f64 + 0.5 * (1.0 + xi[d])) / self.elements[d] as f64;
            share * self.size[d]
        })
    }
}
