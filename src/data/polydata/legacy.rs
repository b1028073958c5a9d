//! Lines and polygons in VTK's old format (`# vtk DataFile`), ASCII or binary.

use super::PolyData;
use crate::files::{Fault, fault};
use vtkio::model::{Attribute, DataSet, Piece, VertexNumbers, Vtk};

pub fn read(bytes: &[u8]) -> Result<PolyData, Fault> {
    if !bytes.starts_with(b"# vtk DataFile") {
        return Err(
            "not a VTK file in the legacy format, which begins with \"# vtk DataFile\"".into(),
        );
    }
    let vtk = Vtk::parse_legacy_be(bytes);
    let vtk =
        vtk.map_err(|e| format!("not a readable VTK file ({e}): is it cut off or damaged?"))?;
    let DataSet::PolyData { pieces, .. } = vtk.data else {
        return Err("it holds no POLYDATA: save lines or triangles as polydata".into());
    };
    let mut data = PolyData::default();
    for piece in pieces {
        let Piece::Inline(piece) = piece else {
            continue;
        };
        let points: Vec<f64> = piece
            .points
            .cast_into()
            .ok_or("its points are not numbers")?;
        data.points
            .extend(points.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        for polygon in cells(piece.polys)? {
            data.add_polygon(&polygon)?;
        }
        for strip in cells(piece.strips)? {
            for (i, three) in strip.windows(3).enumerate() {
                let (b, c) = if i % 2 == 0 { (1, 2) } else { (2, 1) };
                data.add_polygon(&[three[0], three[b], three[c]])?;
            }
        }
        let count = data.points.len();
        for line in cells(piece.lines)? {
            if line.iter().any(|point| *point >= count) {
                return Err(fault!("a line has a point that there is not among {count}"));
            }
            data.lines.push(line);
        }
        for attribute in piece.data.point {
            let arrays = match attribute {
                Attribute::DataArray(array) => vec![(array.name, array.data)],
                Attribute::Field { data_array, .. } => data_array
                    .into_iter()
                    .map(|array| (array.name, array.data))
                    .collect(),
            };
            for (name, values) in arrays {
                let values: Option<Vec<f64>> = values.cast_into();
                if let Some(values) = values.filter(|values| values.len() == count) {
                    data.of_points.insert(name, values);
                }
            }
        }
    }
    Ok(data)
}

/// Points of each cell.
fn cells(numbers: Option<VertexNumbers>) -> Result<Vec<Vec<usize>>, Fault> {
    let wrong = || "the counts of its cells do not fit their points".to_owned();
    let mut cells = Vec::new();
    match numbers {
        None => {}
        Some(VertexNumbers::Legacy { vertices, .. }) => {
            let mut rest = &vertices[..];
            while let Some((count, more)) = rest.split_first() {
                let (cell, tail) = more.split_at_checked(*count as usize).ok_or_else(wrong)?;
                cells.push(cell.iter().map(|point| *point as usize).collect());
                rest = tail;
            }
        }
        Some(VertexNumbers::XML {
            connectivity,
            offsets,
        }) => {
            // The first offset may be zero.
            let mut begin = 0;
            for end in offsets {
                let cell = connectivity.get(begin..end as usize).ok_or_else(wrong)?;
                cells.push(cell.iter().map(|point| *point as usize).collect());
                begin = end as usize;
            }
        }
    }
    cells.retain(|cell: &Vec<usize>| !cell.is_empty());
    Ok(cells)
}
