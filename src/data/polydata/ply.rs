//! Polygons in PLY, the format of Stanford's scanner: ASCII, or binary in either order of bytes.

use super::PolyData;
use crate::files::Fault;
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};

pub fn read(bytes: &[u8]) -> Result<PolyData, Fault> {
    let ply = Parser::<DefaultElement>::new().read_ply(&mut &bytes[..]);
    let ply = ply.map_err(|e| format!("no PLY that can be read: {e}"))?;
    let mut data = PolyData::default();
    for vertex in ply.payload.get("vertex").into_iter().flatten() {
        let point = ["x", "y", "z"].map(|axis| vertex.get(axis).and_then(number));
        let [Some(x), Some(y), Some(z)] = point else {
            return Err("its vertices have no x, y and z".into());
        };
        data.points.push([x, y, z]);
    }
    for face in ply.payload.get("face").into_iter().flatten() {
        let corners = ["vertex_indices", "vertex_index"]
            .iter()
            .find_map(|name| face.get(*name));
        let corners = corners
            .and_then(whole)
            .ok_or("its faces have no list vertex_indices of whole numbers")?;
        data.add_polygon(&corners)?;
    }
    Ok(data)
}

fn number(property: &Property) -> Option<f64> {
    match property {
        Property::Float(x) => Some(f64::from(*x)),
        Property::Double(x) => Some(*x),
        Property::Int(x) => Some(f64::from(*x)),
        Property::Short(x) => Some(f64::from(*x)),
        _ => None,
    }
}

fn whole(property: &Property) -> Option<Vec<usize>> {
    let list = property.to_u32_list()?;
    Some(list.into_iter().map(|corner| corner as usize).collect())
}
