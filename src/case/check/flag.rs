//! Whether cylinder, flag, channel and their meshes fit together.

use super::{Report, material};
use crate::{Case, Flag, Solver, SurrogateModel};

/// Cells are at least this share of the height of the channel.
const SMALLEST_CELL: f64 = 1e-3;

pub(super) fn check(case: &Case, flag: &Flag, report: &mut Report<'_>) {
    let (x, y, r) = (flag.cylinder_x, flag.cylinder_y, flag.cylinder_radius);
    report(
        &["flag.cylinder_x_m", "flag.cylinder_radius_m"],
        x <= r,
        format!(
            "the cylinder must lie downstream of the inlet: more than flag.cylinder_radius_m = {r:?}"
        ),
    );
    report(
        &["fluid.solver"],
        case.fluid.solver == Solver::Native,
        "the driver's own solver knows no flag in a channel: expected \"openfoam\"".into(),
    );
    let (low, high) = (r, flag.channel_height - r);
    let expected = if low < high {
        format!("expected more than {low:?} and less than {high:?}")
    } else {
        format!(
            "no place is high enough in a channel of flag.channel_height_m = {:?} for a cylinder of flag.cylinder_radius_m = {r:?}",
            flag.channel_height
        )
    };
    report(
        &[
            "flag.cylinder_y_m",
            "flag.cylinder_radius_m",
            "flag.channel_height_m",
        ],
        y <= low || y >= high,
        format!("the cylinder must not touch the walls: {expected}"),
    );
    report(
        &["flag.thickness_m", "flag.cylinder_radius_m"],
        flag.thickness > r,
        format!(
            "the flag must be thinner than the cylinder: at most flag.cylinder_radius_m = {r:?}"
        ),
    );
    material("flag.solid", &flag.solid, report);
    let end = flag.end();
    report(
        &[
            "flag.channel_length_m",
            "flag.cylinder_x_m",
            "flag.cylinder_radius_m",
            "flag.length_m",
        ],
        flag.channel_length <= end,
        format!("the flag ends at x = {end:.6} m, and the channel must be longer"),
    );
    let size = flag.mesh.cell_size;
    let (least, most) = (SMALLEST_CELL * flag.channel_height, 0.5 * flag.thickness);
    report(
        &[
            "flag.mesh.cell_size_m",
            "flag.thickness_m",
            "flag.channel_height_m",
        ],
        size < least || size > most,
        format!(
            "expected from {least:.3e} (a thousandth of flag.channel_height_m) to {most:.3e} (half of flag.thickness_m)"
        ),
    );
    report(
        &["flag.mesh.largest_cell_m", "flag.mesh.cell_size_m"],
        flag.mesh.largest_cell < size,
        format!("expected at least flag.mesh.cell_size_m = {size:?}"),
    );
    report(
        &["coupling.surrogate"],
        !matches!(case.coupling.surrogate, SurrogateModel::None | SurrogateModel::Potential),
        "this surrogate is a tube, and a case with a [flag] has none: write \"potential\" or \"none\"".into(),
    );
}
