//! Whether the surfaces of the paper's vessel, its extension and its meshes fit together.

use super::{MAX_BEND_DEG, Report, material};
use crate::interpolation::BicubicSurface;
use crate::{Anastomosis, Case, Extension, LumenMeshes, Solver};
use std::f64::consts::TAU;

/// The imperfection must leave at least this share of the artery's inner radius.
const LEAST_LUMEN: f64 = 0.2;

pub(super) fn check(
    case: &Case,
    vessel: &Anastomosis,
    fluid: &LumenMeshes,
    report: &mut Report<'_>,
) {
    surfaces(vessel, report);
    extension(vessel, report);
    meshes(case, vessel, fluid, report);
    let wall = &vessel.wall;
    material("wall.graft", &wall.graft, report);
    material("wall.media", &wall.media, report);
    material("wall.adventitia", &wall.adventitia, report);
}

fn surfaces(vessel: &Anastomosis, report: &mut Report<'_>) {
    let g = &vessel.geometry;
    let d_max = vessel.model.d_max;
    let most = (1.0 - LEAST_LUMEN) * g.artery_inner_radius;
    report(
        &["model.d_max_m", "geometry.artery_inner_radius_m"],
        d_max > most,
        format!(
            "the imperfection closes the lumen: at most {most:.4e} m, {:.0} % of geometry.artery_inner_radius_m = {:?}",
            100.0 * (1.0 - LEAST_LUMEN),
            g.artery_inner_radius
        ),
    );
    let surface = BicubicSurface::new(&g.imperfection);
    let (largest, ..) = surface.maximum();
    let (smallest, u, v) = surface.minimum();
    report(
        &["geometry.imperfection", "model.d_max_m"],
        largest <= 0.0 && d_max > 0.0,
        "all support values are zero, so no surface can reach model.d_max_m; raise one".into(),
    );
    report(
        &["geometry.imperfection"],
        smallest < -1e-9 * largest,
        format!(
            "the spline dips to {:.3} of its maximum at {:.0} % of the artery's length and {:.0}° around, but equation (17) needs \
             d >= 0: make the support values near there less different",
            smallest / largest,
            100.0 * u,
            360.0 * v
        ),
    );
    let section = g.graft_length.min(g.artery_length);
    report(
        &[
            "geometry.blend_length_m",
            "geometry.graft_length_m",
            "geometry.artery_length_m",
        ],
        0.5 * g.blend_length > section,
        format!(
            "half of the blend must fit into each section: at most {:?} m",
            2.0 * section
        ),
    );
}

fn extension(vessel: &Anastomosis, report: &mut Report<'_>) {
    let g = &vessel.geometry;
    let radius = g.graft_inner_radius;
    match vessel.model.extension {
        Extension::Straight => {}
        Extension::Arc => {
            let bend = g.extension_length / g.arc_angle_deg.to_radians();
            report(
                &[
                    "geometry.arc_angle_deg",
                    "geometry.extension_length_m",
                    "geometry.graft_inner_radius_m",
                ],
                bend <= radius,
                format!(
                    "the arc's radius {bend:.3e} m (extension_length_m over the angle) must exceed the lumen's, \
                     geometry.graft_inner_radius_m = {radius:?}: take a smaller angle or a longer extension"
                ),
            );
        }
        Extension::Helix => helix(vessel, report),
    }
}

fn helix(vessel: &Anastomosis, report: &mut Report<'_>) {
    const KEYS: [&str; 3] = [
        "geometry.helix_radius_m",
        "geometry.extension_length_m",
        "geometry.graft_inner_radius_m",
    ];
    let g = &vessel.geometry;
    let (a, length, lumen) = (g.helix_radius, g.extension_length, g.graft_inner_radius);
    let rise_squared = length.powi(2) - (TAU * a).powi(2);
    if rise_squared <= 0.0 {
        let most = length / TAU;
        report(
            &KEYS,
            true,
            format!(
                "one turn is longer than geometry.extension_length_m = {length:?}: less than {most:.3e} m"
            ),
        );
        return;
    }
    let bend = (length / TAU).powi(2) / a;
    report(
        &KEYS,
        bend <= lumen,
        format!(
            "the helix bends with the radius {bend:.3e} m, which must exceed geometry.graft_inner_radius_m = {lumen:?}"
        ),
    );
    // Distance of the two ends of a turn, measured across the vessel.
    let apart = rise_squared.sqrt() * TAU * a / length;
    report(
        &KEYS,
        apart <= 2.0 * lumen,
        format!(
            "neighbouring turns are {apart:.3e} m apart, which must exceed the diameter {:.3e} m: take a longer \
             extension, or another radius",
            2.0 * lumen
        ),
    );
}

fn meshes(case: &Case, vessel: &Anastomosis, fluid: &LumenMeshes, report: &mut Report<'_>) {
    let g = &vessel.geometry;
    let (key, what, cells) = match case.fluid.solver {
        Solver::OpenFoam => {
            let cells = fluid.mesh.axial_extension;
            ("fluid.mesh.axial_extension", "cell", cells)
        }
        Solver::Native => {
            let elements = fluid.native.axial_extension;
            ("fluid.native.axial_extension", "element", elements)
        }
        Solver::External => return,
    };
    let length = g.extension_length;
    report(
        &[key, "geometry.extension_length_m"],
        (length > 0.0) != (cells > 0),
        format!(
            "a rigid extension of the length {length:?} m with {cells} {what}s along it: both or neither must be zero"
        ),
    );
    let mesh = &fluid.mesh;
    let slices = mesh.axial_extension + 2 * mesh.axial_per_section;
    let ranks = case.fluid.ranks;
    report(
        &["fluid.ranks", "fluid.mesh.axial_per_section"],
        ranks > slices,
        format!(
            "each MPI rank takes a slice of the vessel, and there are {slices} cells along it: at most {slices}"
        ),
    );
    let turn = match vessel.model.extension {
        Extension::Straight => 0.0,
        Extension::Arc => g.arc_angle_deg,
        // κ L with κ = a/(a² + b²) and L = 2π √(a² + b²).
        Extension::Helix => 360.0 * (TAU * g.helix_radius / g.extension_length).min(1.0),
    };
    let least = (turn / MAX_BEND_DEG).ceil() as usize;
    report(
        &[key, "model.extension", "geometry.arc_angle_deg"],
        case.fluid.solver == Solver::OpenFoam && cells < least,
        format!(
            "the extension turns by {turn:.0}°, and the cells may turn by {MAX_BEND_DEG}° each at most: at least {least} cells"
        ),
    );
}
