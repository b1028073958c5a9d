//! Polygons in Wavefront's OBJ.

use super::PolyData;
use crate::files::Fault;
use tobj::{LoadError, LoadOptions};

pub fn read(bytes: &[u8]) -> Result<PolyData, Fault> {
    let options = LoadOptions {
        triangulate: true,
        ..LoadOptions::default()
    };
    // Colours are of no use here.
    let found = tobj::load_obj_buf(&mut &bytes[..], &options, |_| {
        Err(LoadError::MaterialParseError)
    });
    let (models, _) = found.map_err(|e| format!("no OBJ that can be read: {e}"))?;
    let mut data = PolyData::default();
    for model in &models {
        let first = data.points.len();
        let points = model.mesh.positions.chunks_exact(3);
        data.points.extend(points.map(|p| [p[0], p[1], p[2]]));
        for corners in model.mesh.indices.chunks_exact(3) {
            let corners: Vec<usize> = corners
                .iter()
                .map(|corner| first + *corner as usize)
                .collect();
            data.add_polygon(&corners)?;
        }
    }
    Ok(data)
}
