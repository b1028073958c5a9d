//! Unstructured grids in VTK's XML format (`.vtu`), and their collection over time (`.pvd`).
//!
//! Arrays are stored inline as base64 with a 64-bit length in front, as the VTK file formats document lays down.

use super::write_atomically;
use crate::Vec3;
use crate::files::named;
use base64::Engine;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};
use vtkio::Vtk;
use vtkio::model::{Attribute, DataSet, Piece, UnstructuredGridPiece, VertexNumbers};

/// VTK's numbers of the polygon, the linear hexahedron, and the hexahedron of any degree.
const VTK_POLYGON: u8 = 7;
const VTK_HEXAHEDRON: u8 = 12;
const VTK_LAGRANGE_HEXAHEDRON: u8 = 72;

/// Values at the points or in the cells of a grid.
#[derive(Debug, Clone, Copy)]
pub enum Values<'a> {
    /// One number each.
    Scalars(&'a [f64]),
    /// One vector each.
    Vectors(&'a [Vec3]),
    /// One integer each.
    Integers(&'a [usize]),
}

/// Points of the cells of a grid.
#[derive(Debug, Clone, Copy)]
pub enum Cells<'a> {
    /// Linear hexahedra in VTK's order: around the bottom, then around the top.
    Hexes(&'a [[usize; 8]]),
    /// Polygons.
    Polygons(&'a [Vec<u32>]),
    /// Hexahedra with polynomials of a degree, known at equally spaced points: `(degree + 1)³` of each, fastest along
    /// the first of its right-handed axes.
    Lagrange {
        /// The degree.
        degree: usize,
        /// Their points.
        points: &'a [u32],
    },
}

/// A grid with named values.
#[derive(Debug, Clone)]
pub struct VtuGrid<'a> {
    /// Positions of the points, m.
    pub points: &'a [Vec3],
    /// Points of each cell.
    pub cells: Cells<'a>,
    /// Names (with unit) and values at the points.
    pub point_data: Vec<(&'a str, Values<'a>)>,
    /// Names and values in the cells.
    pub cell_data: Vec<(&'a str, Values<'a>)>,
}

impl VtuGrid<'_> {
    /// Writes the grid; the file is whole or absent.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        write_atomically(path, self.to_xml().as_bytes())
    }

    fn to_xml(&self) -> String {
        let (kind, connectivity, sizes): (u8, Vec<i64>, Vec<usize>) = match self.cells {
            Cells::Hexes(hexes) => (
                VTK_HEXAHEDRON,
                hexes.iter().flatten().map(|&p| p as i64).collect(),
                vec![8; hexes.len()],
            ),
            Cells::Polygons(faces) => (
                VTK_POLYGON,
                faces.iter().flatten().map(|&p| i64::from(p)).collect(),
                faces.iter().map(Vec::len).collect(),
            ),
            Cells::Lagrange { degree, points } => {
                let order = lagrange_order(degree);
                let cells = points.chunks_exact(order.len());
                (
                    VTK_LAGRANGE_HEXAHEDRON,
                    cells
                        .flat_map(|cell| order.iter().map(|&i| i64::from(cell[i])))
                        .collect(),
                    vec![order.len(); points.len() / order.len()],
                )
            }
        };
        let ends = sizes.iter().scan(0, |end, size| {
            *end += *size as i64;
            Some(*end)
        });
        let offsets: Vec<i64> = ends.collect();
        let types = vec![kind; sizes.len()];
        let mut xml = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n",
        );
        let (points, cells) = (self.points.len(), sizes.len());
        let _ = writeln!(
            xml,
            "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
        );
        for (section, data) in [
            ("PointData", &self.point_data),
            ("CellData", &self.cell_data),
        ] {
            let _ = writeln!(xml, "<{section}>");
            for (name, values) in data {
                write_values(&mut xml, name, values);
            }
            let _ = writeln!(xml, "</{section}>");
        }
        xml.push_str("<Points>\n");
        write_values(&mut xml, "Points", &Values::Vectors(self.points));
        xml.push_str("</Points>\n<Cells>\n");
        let bytes = |v: &[i64]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
        write_array(&mut xml, "connectivity", "Int64", 1, &bytes(&connectivity));
        write_array(&mut xml, "offsets", "Int64", 1, &bytes(&offsets));
        write_array(&mut xml, "types", "UInt8", 1, &types);
        xml.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
        xml
    }
}

/// The points of a Lagrange hexahedron in VTK's order, as places in the order fastest along the first axis: corners,
/// edges, faces, inside. For files of version 1.0; from 2.2 on two of the upright edges change places.
pub fn lagrange_order(degree: usize) -> Vec<usize> {
    let n = degree;
    let at = |i: usize, j: usize, k: usize| i + (n + 1) * (j + (n + 1) * k);
    let corners = [(0, 0), (n, 0), (n, n), (0, n)];
    let mut order: Vec<usize> = [0, n]
        .into_iter()
        .flat_map(|k| corners.map(|(i, j)| at(i, j, k)))
        .collect();
    let inner = 1..n;
    for k in [0, n] {
        order.extend(inner.clone().map(|i| at(i, 0, k)));
        order.extend(inner.clone().map(|j| at(n, j, k)));
        order.extend(inner.clone().map(|i| at(i, n, k)));
        order.extend(inner.clone().map(|j| at(0, j, k)));
    }
    for (i, j) in [(0, 0), (n, 0), (0, n), (n, n)] {
        order.extend(inner.clone().map(|k| at(i, j, k)));
    }
    // Two inner indices, the first fastest
    let pairs = || (1..n).flat_map(|b| (1..n).map(move |a| (a, b)));
    for i in [0, n] {
        order.extend(pairs().map(|(j, k)| at(i, j, k)));
    }
    for j in [0, n] {
        order.extend(pairs().map(|(i, k)| at(i, j, k)));
    }
    for k in [0, n] {
        order.extend(pairs().map(|(i, j)| at(i, j, k)));
    }
    for k in inner {
        order.extend(pairs().map(|(i, j)| at(i, j, k)));
    }
    order
}

fn write_values(xml: &mut String, name: &str, values: &Values) {
    match values {
        Values::Scalars(v) => {
            let bytes: Vec<u8> = v.iter().flat_map(|x| x.to_le_bytes()).collect();
            write_array(xml, name, "Float64", 1, &bytes);
        }
        Values::Vectors(v) => {
            let bytes: Vec<u8> = v
                .iter()
                .flat_map(|v| [v.x, v.y, v.z])
                .flat_map(f64::to_le_bytes)
                .collect();
            write_array(xml, name, "Float64", 3, &bytes);
        }
        Values::Integers(v) => {
            let bytes: Vec<u8> = v.iter().flat_map(|&x| (x as i64).to_le_bytes()).collect();
            write_array(xml, name, "Int64", 1, &bytes);
        }
    }
}

fn write_array(xml: &mut String, name: &str, kind: &str, components: usize, bytes: &[u8]) {
    let mut block = (bytes.len() as u64).to_le_bytes().to_vec();
    block.extend_from_slice(bytes);
    let encoded = base64::engine::general_purpose::STANDARD.encode(block);
    let _ = writeln!(
        xml,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">\n{encoded}\n</DataArray>"
    );
}

/// A time series of grids that ParaView opens as one.
#[derive(Debug, Clone)]
pub struct VtuSeries {
    path: PathBuf,
    entries: Vec<(f64, String)>,
}

impl VtuSeries {
    /// A series described by the file `path`; its grids lie in a folder of the same name without ending.
    pub fn new(path: PathBuf) -> io::Result<Self> {
        let folder = path.with_extension("");
        std::fs::create_dir_all(&folder).map_err(named(&folder))?;
        Ok(Self {
            path,
            entries: Vec::new(),
        })
    }

    /// The series of an earlier run, which has these grids; others are removed.
    pub fn resume(path: PathBuf, entries: Vec<(f64, String)>) -> io::Result<Self> {
        let series = Self {
            entries,
            ..Self::new(path)?
        };
        let folder = series.path.with_extension("");
        for file in std::fs::read_dir(&folder).map_err(named(&folder))? {
            let file = file.map_err(named(&folder))?.path();
            let listed =
                |(_, name): &(f64, String)| Path::new(name).file_name() == file.file_name();
            if !series.entries.iter().any(listed) {
                std::fs::remove_file(&file).map_err(named(&file))?;
            }
        }
        series.write_list()?;
        Ok(series)
    }

    /// Times (s) and files of all grids so far.
    pub fn entries(&self) -> &[(f64, String)] {
        &self.entries
    }

    /// Writes the grid of `time` (s), then the list of all grids.
    pub fn add(&mut self, time: f64, grid: &VtuGrid) -> io::Result<()> {
        let folder = self.path.with_extension("");
        let name = format!("{:05}.vtu", self.entries.len());
        grid.write(&folder.join(&name))?;
        let stem = folder
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        self.entries.push((time, format!("{stem}/{name}")));
        self.write_list()
    }

    /// Times (s) and files, relative to the folder of `path`, of a series that was written earlier; none if there is
    /// none.
    pub fn read(path: &Path) -> io::Result<Vec<(f64, PathBuf)>> {
        if !path.is_file() {
            return Ok(Vec::new());
        }
        let text = std::fs::read_to_string(path)?;
        let entry = |line: &str| {
            let value = |name: &str| line.split_once(name)?.1.split('"').next();
            let time = value("timestep=\"")?.parse().ok()?;
            Some((time, PathBuf::from(value("file=\"")?)))
        };
        Ok(text.lines().filter_map(entry).collect())
    }

    fn write_list(&self) -> io::Result<()> {
        let mut xml = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for (time, file) in &self.entries {
            let _ = writeln!(
                xml,
                "<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>"
            );
        }
        xml.push_str("</Collection>\n</VTKFile>\n");
        write_atomically(&self.path, xml.as_bytes())
    }
}

/// Points of a grid with numbers at each.
#[derive(Debug, Clone, PartialEq)]
pub struct PointValues {
    /// Positions, m.
    pub points: Vec<Vec3>,
    /// Fields of one number each, by name.
    pub fields: BTreeMap<String, Vec<f64>>,
}

/// Reads a grid.
///
/// # Errors
/// If the file is none.
pub fn read_piece(path: &Path) -> io::Result<UnstructuredGridPiece> {
    let read = Vtk::import(path).map_err(|e| bad(path, &e.to_string()))?;
    let DataSet::UnstructuredGrid { pieces, .. } = read.data else {
        return Err(bad(path, "not an unstructured grid"));
    };
    match pieces.into_iter().next() {
        Some(Piece::Inline(piece)) => Ok(*piece),
        _ => Err(bad(path, "no data within")),
    }
}

/// The numbers of the field `name` at the points of a grid, if it is there.
pub fn point_values(grid: &UnstructuredGridPiece, name: &str) -> Option<Vec<f64>> {
    grid.data
        .point
        .iter()
        .find_map(|attribute| match attribute {
            Attribute::DataArray(array) if array.name == name => array.data.clone().into_vec(),
            _ => None,
        })
}

/// Reads the points of a grid and all fields of one number each.
///
/// # Errors
/// If the file is not a grid.
pub fn read_points(path: &Path) -> io::Result<PointValues> {
    let piece = read_piece(path)?;
    let points = piece.points.into_vec::<f64>();
    let points = points.ok_or_else(|| bad(path, "its points are not numbers"))?;
    let points: Vec<Vec3> = points
        .chunks_exact(3)
        .map(Vec3::from_column_slice)
        .collect();
    let field = |attribute| match attribute {
        Attribute::DataArray(array) => Some((array.name, array.data.into_vec::<f64>()?)),
        _ => None,
    };
    let fields = piece.data.point.into_iter().filter_map(field);
    Ok(PointValues {
        fields: fields
            .filter(|(_, values)| values.len() == points.len())
            .collect(),
        points,
    })
}

/// Reads the vectors `name` at the points of a grid, each with its position (m).
///
/// # Errors
/// If the file is not a grid or has no such field.
pub fn read_vectors(path: &Path, name: &str) -> io::Result<Vec<(Vec3, Vec3)>> {
    let piece = read_piece(path)?;
    let values = point_values(&piece, name);
    let points = piece.points.into_vec::<f64>();
    let (Some(values), Some(points)) = (values, points) else {
        return Err(bad(path, &format!("no field {name} of numbers")));
    };
    if points.len() != values.len() {
        return Err(bad(path, &format!("{name} is not a field of vectors")));
    }
    let vectors = |numbers: &[f64]| -> Vec<Vec3> {
        numbers
            .chunks_exact(3)
            .map(Vec3::from_column_slice)
            .collect()
    };
    Ok(vectors(&points).into_iter().zip(vectors(&values)).collect())
}

/// Hexahedra that a run has written of its wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Hexes {
    /// Unloaded positions of the points, m.
    pub points: Vec<Vec3>,
    /// Their displacement, m.
    pub displacement: Vec<Vec3>,
    /// Points of each hexahedron in VTK's order.
    pub hexes: Vec<[u32; 8]>,
    /// Number of the material of each hexahedron.
    pub material: Vec<usize>,
    /// Number of the element that each hexahedron is a piece of.
    pub element: Vec<usize>,
}

/// Reads the wall at one time, whose vectors `displacement` are given at the points.
///
/// # Errors
/// If the file is not a grid of hexahedra with the fields of the wall.
pub fn read_hexes(path: &Path, displacement: &str) -> io::Result<Hexes> {
    let piece = read_piece(path)?;
    let of_cells = |name: &str| {
        let values = piece
            .data
            .cell
            .iter()
            .find_map(|attribute| match attribute {
                Attribute::DataArray(array) if array.name == name => {
                    array.data.clone().cast_into::<i64>()
                }
                _ => None,
            });
        let values: Vec<usize> = (values?.into_iter().map(|v| v as usize)).collect();
        Some(values)
    };
    let fields = (of_cells("material"), of_cells("element"));
    let (Some(material), Some(element)) = fields else {
        return Err(bad(path, "no fields material and element"));
    };
    let VertexNumbers::XML { connectivity, .. } = &piece.cells.cell_verts else {
        return Err(bad(path, "no cells"));
    };
    let (chunks, rest) = connectivity.as_chunks::<8>();
    let hexes: Vec<[u32; 8]> = chunks.iter().map(|hex| hex.map(|p| p as u32)).collect();
    let (points, displacement) = read_vectors(path, displacement)?.into_iter().unzip();
    let wall = Hexes {
        points,
        displacement,
        hexes,
        material,
        element,
    };
    let cells = [wall.material.len(), wall.element.len()];
    let inside = |p: &u32| (*p as usize) < wall.points.len();
    match rest.is_empty()
        && cells == [wall.hexes.len(); 2]
        && wall.hexes.iter().flatten().all(inside)
    {
        true => Ok(wall),
        false => Err(bad(path, "not a grid of hexahedra")),
    }
}

fn bad(path: &Path, what: &str) -> io::Error {
    let text = format!("{}: {what}", path.display());
    io::Error::new(io::ErrorKind::InvalidData, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_independent_reader_finds_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let corners = [
            [0, 0, 0],
            [1, 0, 0],
            [1, 1, 0],
            [0, 1, 0],
            [0, 0, 1],
            [1, 0, 1],
            [1, 1, 1],
            [0, 1, 1],
        ];
        let points: Vec<Vec3> = corners
            .iter()
            .map(|c| Vec3::from(c.map(f64::from)))
            .collect();
        let heights: Vec<f64> = points.iter().map(|p| 2.0 * p.z).collect();
        let grid = VtuGrid {
            points: &points,
            cells: Cells::Hexes(&[[0, 1, 2, 3, 4, 5, 6, 7]]),
            point_data: vec![
                ("height", Values::Scalars(&heights)),
                ("place", Values::Vectors(&points)),
            ],
            cell_data: vec![("region", Values::Integers(&[3]))],
        };
        let mut series = VtuSeries::new(folder.path().join("structure.pvd")).unwrap();
        series.add(0.25, &grid).unwrap();
        let pvd = std::fs::read_to_string(folder.path().join("structure.pvd")).unwrap();
        assert!(pvd.contains("timestep=\"0.25\"") && pvd.contains("file=\"structure/00000.vtu\""));

        let series = VtuSeries::read(&folder.path().join("structure.pvd")).unwrap();
        assert_eq!(series, [(0.25, PathBuf::from("structure/00000.vtu"))]);
        let file = folder.path().join(&series[0].1);
        let again = read_points(&file).unwrap();
        assert_eq!(again.points, points);
        let heights_alone = BTreeMap::from([("height".to_string(), heights.clone())]);
        assert_eq!(again.fields, heights_alone);
        let vectors = read_vectors(&file, "place").unwrap();
        assert!(vectors.len() == 8 && vectors.iter().all(|(x, place)| x == place));
        let missing = read_vectors(&file, "depth").unwrap_err().to_string();
        assert!(missing.contains("no field depth"), "{missing}");

        let read = vtkio::Vtk::import(folder.path().join("structure/00000.vtu")).unwrap();
        let DataSet::UnstructuredGrid { pieces, .. } = read.data else {
            panic!("not an unstructured grid")
        };
        let Piece::Inline(piece) = &pieces[0] else {
            panic!("not inline")
        };
        assert_eq!(piece.num_points(), 8);
        assert_eq!(piece.cells.types, [vtkio::model::CellType::Hexahedron]);
        let Attribute::DataArray(array) = &piece.data.point[0] else {
            panic!("no array")
        };
        assert_eq!(
            (
                array.name.as_str(),
                array.data.clone().into_vec::<f64>().unwrap()
            ),
            ("height", heights)
        );
        let Attribute::DataArray(array) = &piece.data.cell[0] else {
            panic!("no array")
        };
        assert_eq!(array.data.clone().into_vec::<i64>().unwrap(), [3]);
    }
}
