//! The keys of the file of `fsi-driver solid`.

use crate::case::keys::{MATERIAL, above, from, key, optional};
use crate::case::schema::{self, Key, Kind};

/// Largest degree of the shape functions.
pub const MAX_DEGREE: i64 = 12;

/// Keys outside the layers, in the order of the file.
#[rustfmt::skip]
pub const KEYS: &[Key] = &[
    key("tube.inner_radius_m", above(0.0, 10.0), "inner radius of the unloaded tube"),
    key("tube.length_m", above(0.0, 100.0), "length of the tube"),
    key("mesh.axial", Kind::Whole(1, 1000), "elements along the axis"),
    key("mesh.circumferential", Kind::Whole(3, 1000), "elements around the circumference"),
    key("mesh.radial_per_layer", Kind::Whole(1, 100), "elements through each layer"),
    key("space.kind", Kind::Word(&["trunk", "tensor_product"]), "ansatz space"),
    key("space.p", Kind::Degrees(1, MAX_DEGREE), "degree of the shape functions; of three: axial, circumferential, thickness"),
    optional("space.p_geometry", Kind::WholeOr(1, MAX_DEGREE, "exact"), "degree of the mapping along the edges"),
    optional("space.quadrature_points", Kind::Whole(2, 30), "Gauss points per direction"),
    key("load.pressure_Pa", from(-1e9, 1e9), "pressure inside the tube"),
    key("load.kind", Kind::Word(&["follower", "dead"]), "load on the deformed or on the reference area"),
    optional("load.steps", Kind::Whole(1, 10_000), "load steps to begin with"),
    optional("supports.ends", Kind::Word(&["axial", "clamped"]), "u_x = 0 at the ends, or all components"),
    optional("dynamics.density_kg_m3", above(0.0, 1e5), "density of the wall"),
    optional("dynamics.damping_1_s", from(0.0, 1e4), "mass-proportional damping"),
    optional("dynamics.step_s", above(0.0, 1e4), "time step"),
    optional("dynamics.end_s", above(0.0, 1e6), "end of the analysis"),
    optional("dynamics.times_s", Kind::Numbers, "times at which the load is given"),
    optional("dynamics.load_factors", Kind::Numbers, "shares of load.pressure_Pa at these times"),
];

/// Keys that are needed as soon as there is a table `[dynamics]`.
pub const DYNAMICS: &[&str] = &[
    "dynamics.density_kg_m3",
    "dynamics.step_s",
    "dynamics.end_s",
    "dynamics.times_s",
    "dynamics.load_factors",
];

/// Key of every layer besides its material.
pub const THICKNESS: Key = key("thickness_m", above(0.0, 10.0), "thickness of this layer");

/// The name of the tables that hold the layers.
pub const LAYER: &str = "tube.layer";

/// The index of a layer and the key in it that a path such as `tube.layer[1].k2` names.
pub fn in_layer(path: &str) -> Option<(usize, &str)> {
    let rest = path.strip_prefix(LAYER)?.strip_prefix('[')?;
    let (index, name) = rest.split_once("].")?;
    Some((index.parse().ok()?, name))
}

/// Keys that a layer of any material can have.
fn of_layers() -> impl Iterator<Item = &'static Key> {
    let parameters = schema::MATERIALS.iter().flat_map(|(_, keys)| *keys);
    parameters.chain([&THICKNESS, &MATERIAL])
}

/// What is known of the key at `path`.
pub fn find(path: &str) -> Option<&'static Key> {
    match in_layer(path) {
        Some((_, name)) => of_layers().find(|key| key.path == name),
        None => KEYS.iter().find(|key| key.path == path),
    }
}

/// Paths that may stand where `path` stands: all keys, those of layers in the layer that `path` is in.
pub fn alternatives(path: &str) -> Vec<String> {
    let layer = in_layer(path).map_or(0, |(index, _)| index);
    let of_layers = of_layers().map(|key| format!("{LAYER}[{layer}].{}", key.path));
    let mut all: Vec<String> = KEYS.iter().map(|key| key.path.to_owned()).collect();
    all.extend(of_layers);
    all.sort();
    all.dedup();
    all
}
