//! Face-based polyhedral meshes in OpenFOAM's layout.

use crate::Vec3;
use crate::files::named;
use std::path::Path;

/// A named part of the boundary: `size` faces from `start`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    /// Name, such as `inlet`.
    pub name: String,
    /// OpenFOAM's type, such as `patch` or `wall`.
    pub kind: String,
    /// First face.
    pub start: usize,
    /// Number of faces.
    pub size: usize,
}

/// A mesh as OpenFOAM's `polyMesh` folder holds it: internal faces first in upper-triangular order, then patch by
/// patch.
#[derive(Debug, Clone, PartialEq)]
pub struct PolyMesh {
    /// Positions of the points, m.
    pub points: Vec<Vec3>,
    /// Points of each face; the normal points from owner to neighbour, or out of the domain.
    pub faces: Vec<Vec<usize>>,
    /// Owner cell of each face.
    pub owner: Vec<usize>,
    /// Neighbour cell of each internal face.
    pub neighbour: Vec<usize>,
    /// Boundary patches in order of their faces.
    pub patches: Vec<Patch>,
}

/// A patch to be: name, OpenFOAM's type, and the points of its faces in any rotation or sense.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PatchFaces<'a> {
    /// Name, such as `inlet`.
    pub name: &'a str,
    /// OpenFOAM's type, such as `patch` or `wall`.
    pub kind: &'static str,
    /// Points of each face.
    pub faces: Vec<[usize; 4]>,
}

/// Faces of which one cell has been seen so far, by the lowest number of their points: few faces share it, so that they
/// are found without hashing.
struct UnpairedFaces {
    by_lowest: Vec<Vec<(usize, [usize; 4])>>,
}

impl UnpairedFaces {
    /// None yet, of a mesh with so many points.
    fn new(points: usize) -> Self {
        Self {
            by_lowest: vec![Vec::new(); points],
        }
    }

    /// The list that would hold a face, and its place there.
    fn find(&mut self, face: [usize; 4]) -> (&mut Vec<(usize, [usize; 4])>, Option<usize>) {
        let sorted = |mut face: [usize; 4]| {
            face.sort_unstable();
            face
        };
        let face = sorted(face);
        let list = &mut self.by_lowest[face[0]];
        let place = list.iter().position(|&(_, other)| sorted(other) == face);
        (list, place)
    }

    fn insert(&mut self, face: [usize; 4], cell: usize) {
        self.find(face).0.push((cell, face));
    }

    /// Removes the face with these points, in any order; returns its cell and its points as they were inserted.
    fn take(&mut self, face: [usize; 4]) -> Option<(usize, [usize; 4])> {
        let (list, place) = self.find(face);
        place.map(|place| list.swap_remove(place))
    }

    fn count(&self) -> usize {
        self.by_lowest.iter().map(Vec::len).sum()
    }
}

impl PolyMesh {
    /// Whether each of these points lies in a cell: on the inner side of all its faces, which are taken for plane.
    pub fn contains(&self, points: &[Vec3]) -> Vec<bool> {
        if points.is_empty() {
            return Vec::new();
        }
        let planes: Vec<(Vec3, Vec3)> = self.faces.iter().map(|face| self.plane(face)).collect();
        let mut cells = vec![(f64::INFINITY, f64::NEG_INFINITY, Vec::new()); self.cells()];
        for (face, (middle, area)) in planes.iter().enumerate() {
            let neighbour = self.neighbour.get(face).map(|cell| (*cell, -area));
            for (cell, area) in [(self.owner[face], *area)].into_iter().chain(neighbour) {
                let (low, high, faces) = &mut cells[cell];
                for point in &self.faces[face] {
                    let x = self.points[*point].x;
                    (*low, *high) = (low.min(x), high.max(x));
                }
                faces.push((middle, area));
            }
        }
        let inside = |x: &Vec3| {
            let within = |(middle, area): &(&Vec3, Vec3)| area.dot(&(x - *middle)) <= 0.0;
            let mut near = cells
                .iter()
                .filter(|(low, high, _)| (*low..=*high).contains(&x.x));
            near.any(|(_, _, faces)| faces.iter().all(within))
        };
        points.iter().map(inside).collect()
    }

    /// Middle and area vector of a face.
    fn plane(&self, face: &[usize]) -> (Vec3, Vec3) {
        let corner = |i: usize| self.points[face[i % face.len()]];
        let middle = (0..face.len()).map(corner).sum::<Vec3>() / face.len() as f64;
        let arm = |i: usize| corner(i) - middle;
        let area = (0..face.len()).map(|i| arm(i).cross(&arm(i + 1))).sum();
        (middle, area)
    }
}

/// Faces of a hexahedron with the vertices 0-3 around the bottom and 4-7 above them, normals outward.
pub(crate) const HEX_FACES: [[usize; 4]; 6] = [
    [0, 3, 2, 1],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];

impl PolyMesh {
    /// Builds the faces of hexahedra whose vertices 0-3 run around the bottom, counter-clockwise seen from the top,
    /// and 4-7 above them.
    ///
    /// # Panics
    /// If three cells share a face, or the patches are not exactly the boundary: mistakes of the program that calls.
    pub fn from_hexes(points: Vec<Vec3>, cells: &[[usize; 8]], patches: &[PatchFaces<'_>]) -> Self {
        let mut sides = UnpairedFaces::new(points.len());
        let mut internal: Vec<(usize, usize, [usize; 4])> = Vec::with_capacity(3 * cells.len());
        for (cell, vertices) in cells.iter().enumerate() {
            for face in HEX_FACES.map(|face| face.map(|v| vertices[v])) {
                match sides.take(face) {
                    Some((owner, outward)) => internal.push((owner, cell, outward)),
                    None => sides.insert(face, cell),
                }
            }
        }
        internal.sort_by_key(|&(owner, neighbour, _)| (owner, neighbour));
        let mut mesh = Self {
            points,
            faces: vec![],
            owner: vec![],
            neighbour: vec![],
            patches: vec![],
        };
        for (owner, neighbour, face) in internal {
            mesh.faces.push(face.to_vec());
            mesh.owner.push(owner);
            mesh.neighbour.push(neighbour);
        }
        for patch in patches {
            let start = mesh.faces.len();
            for &face in &patch.faces {
                let (owner, outward) = sides.take(face).unwrap_or_else(|| {
                    panic!(
                        "face {face:?} of patch {} is not on the boundary",
                        patch.name
                    )
                });
                mesh.faces.push(outward.to_vec());
                mesh.owner.push(owner);
            }
            let (name, kind) = (patch.name.to_owned(), patch.kind.to_owned());
            mesh.patches.push(Patch {
                name,
                kind,
                start,
                size: patch.faces.len(),
            });
        }
        let left = sides.count();
        assert!(left == 0, "{left} boundary faces belong to no patch");
        mesh
    }

    /// Number of cells. The last one may be a neighbour of all others next to it, and own no face.
    pub fn cells(&self) -> usize {
        let cells = self.owner.iter().chain(&self.neighbour);
        cells.max().map_or(0, |last| last + 1)
    }

    /// The patch of that name.
    pub fn patch(&self, name: &str) -> Option<&Patch> {
        self.patches.iter().find(|patch| patch.name == name)
    }

    /// Faces of the patch of that name; none if there is no such patch.
    pub fn patch_faces(&self, name: &str) -> &[Vec<usize>] {
        self.patch(name).map_or(&[], |patch| {
            &self.faces[patch.start..patch.start + patch.size]
        })
    }

    /// Centre (m) and area vector (m²) of a face, by triangles around the average of its points, as OpenFOAM has them.
    pub fn face_geometry(&self, face: usize) -> (Vec3, Vec3) {
        let corners: Vec<Vec3> = self.faces[face]
            .iter()
            .map(|&point| self.points[point])
            .collect();
        let middle = corners.iter().sum::<Vec3>() / corners.len() as f64;
        let (mut area, mut weighted, mut weight) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for (i, corner) in corners.iter().enumerate() {
            let next = corners[(i + 1) % corners.len()];
            let triangle = (next - corner).cross(&(middle - corner)) * 0.5;
            area += triangle;
            weighted += (corner + next + middle) / 3.0 * triangle.norm();
            weight += triangle.norm();
        }
        (
            if weight > 0.0 {
                weighted / weight
            } else {
                middle
            },
            area,
        )
    }

    /// Volume (m³) of each cell, by pyramids over its faces, as OpenFOAM has them.
    pub fn cell_volumes(&self) -> Vec<f64> {
        let cells = self.cell_geometry().into_iter();
        cells.map(|(volume, _)| volume).collect()
    }

    /// Volume (m³) and centre (m) of each cell, by pyramids over its faces, as OpenFOAM has them.
    pub fn cell_geometry(&self) -> Vec<(f64, Vec3)> {
        let geometry: Vec<_> = (0..self.faces.len())
            .map(|face| self.face_geometry(face))
            .collect();
        let cells = self.cells();
        let (mut middles, mut counts) = (vec![Vec3::zeros(); cells], vec![0.0; cells]);
        for (cell, face, _) in self.sides() {
            middles[cell] += geometry[face].0;
            counts[cell] += 1.0;
        }
        for (middle, count) in middles.iter_mut().zip(counts) {
            *middle /= count;
        }
        let mut found = vec![(0.0, Vec3::zeros()); cells];
        for (cell, face, sign) in self.sides() {
            let (centre, area) = geometry[face];
            let pyramid = sign * area.dot(&(centre - middles[cell])) / 3.0;
            found[cell].0 += pyramid;
            found[cell].1 += (0.75 * centre + 0.25 * middles[cell]) * pyramid;
        }
        found
            .iter_mut()
            .for_each(|(volume, centre)| *centre /= *volume);
        found
    }

    /// Volume (m³) of the whole mesh.
    pub fn volume(&self) -> f64 {
        self.cell_volumes().iter().sum()
    }

    /// Every side of every cell: cell, face, and +1 if the face's normal points out of the cell, otherwise -1.
    fn sides(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let owners = self
            .owner
            .iter()
            .enumerate()
            .map(|(face, &cell)| (cell, face, 1.0));
        owners.chain(
            self.neighbour
                .iter()
                .enumerate()
                .map(|(face, &cell)| (cell, face, -1.0)),
        )
    }

    /// Writes `constant/polyMesh` in the OpenFOAM case `case`; numbers are written so that they read back exactly.
    /// Each file is written under another name and then renamed: a reader never sees half a file.
    ///
    /// # Errors
    /// What the file system answers, with the path.
    pub fn write(&self, case: &Path) -> std::io::Result<()> {
        let folder = case.join("constant/polyMesh");
        std::fs::create_dir_all(&folder).map_err(named(&folder))?;
        let note = format!(
            "nPoints:{} nCells:{} nFaces:{} nInternalFaces:{}",
            self.points.len(),
            self.cells(),
            self.faces.len(),
            self.neighbour.len()
        );
        type Lines<'a> = dyn ExactSizeIterator<Item = String> + 'a;
        let list = |class: &str, object: &str, lines: &mut Lines<'_>| {
            let mut text = header(class, object, &note) + &format!("{}\n(\n", lines.len());
            for line in lines {
                text.push_str(&line);
                text.push('\n');
            }
            text.push_str(")\n");
            replace_file(&folder.join(object), &text)
        };
        let point = |p: &Vec3| format!("({:e} {:e} {:e})", p.x, p.y, p.z);
        let face = |points: &Vec<usize>| {
            let points: Vec<_> = points.iter().map(usize::to_string).collect();
            format!("{}({})", points.len(), points.join(" "))
        };
        let patch = |patch: &Patch| {
            let Patch {
                name,
                kind,
                start,
                size,
            } = patch;
            let group = match kind.as_str() {
                "patch" => String::new(),
                _ => format!(" inGroups 1({kind});"),
            };
            format!("    {name} {{ type {kind};{group} nFaces {size}; startFace {start}; }}")
        };
        list("vectorField", "points", &mut self.points.iter().map(point))?;
        list("faceList", "faces", &mut self.faces.iter().map(face))?;
        let mut owners = self.owner.iter().map(usize::to_string);
        list("labelList", "owner", &mut owners)?;
        let mut neighbours = self.neighbour.iter().map(usize::to_string);
        list("labelList", "neighbour", &mut neighbours)?;
        list(
            "polyBoundaryMesh",
            "boundary",
            &mut self.patches.iter().map(patch),
        )
    }
}

fn header(class: &str, object: &str, note: &str) -> String {
    format!(
        "FoamFile\n{{\n    version     2.0;\n    format      ascii;\n    class       {class};\n    note        \"{note}\";\n    \
         location    \"constant/polyMesh\";\n    object      {object};\n}}\n\n"
    )
}

fn replace_file(path: &Path, text: &str) -> std::io::Result<()> {
    let unfinished = path.with_extension("unfinished");
    std::fs::write(&unfinished, text)
        .and_then(|()| std::fs::rename(&unfinished, path))
        .map_err(named(path))
}
