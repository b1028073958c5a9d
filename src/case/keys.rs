//! The table of all keys: their ranges and meanings.

use super::schema::{Key, Kind, Range};

/// A number above `low`, at most `high`.
pub(crate) const fn above(low: f64, high: f64) -> Kind {
    Kind::Real(Range {
        low,
        with_low: false,
        high,
    })
}

/// A number from `low` to `high`.
pub(crate) const fn from(low: f64, high: f64) -> Kind {
    Kind::Real(Range {
        low,
        with_low: true,
        high,
    })
}

/// A key that must be given.
pub(crate) const fn key(path: &'static str, kind: Kind, about: &'static str) -> Key {
    Key {
        path,
        kind,
        optional: false,
        about,
    }
}

/// A key that may be absent.
pub(crate) const fn optional(path: &'static str, kind: Kind, about: &'static str) -> Key {
    Key {
        path,
        kind,
        optional: true,
        about,
    }
}

/// Keys outside the materials, in the order of the file.
#[rustfmt::skip]
pub const KEYS: &[Key] = &[
    key("model.extension", Kind::Word(&["straight", "helix", "arc"]), "path of the rigid extension"),
    key("model.d_max_m", from(0.0, 0.1), "largest radius deviation of the imperfection"),
    key("geometry.graft_length_m", above(0.0, 10.0), "length of the graft section"),
    key("geometry.artery_length_m", above(0.0, 10.0), "length of the artery section"),
    key("geometry.graft_inner_radius_m", above(0.0, 0.1), "inner radius of the graft"),
    key("geometry.graft_thickness_m", above(0.0, 0.1), "wall thickness of the graft"),
    key("geometry.artery_inner_radius_m", above(0.0, 0.1), "inner radius of the artery"),
    key("geometry.media_thickness_m", above(0.0, 0.1), "thickness of the media"),
    key("geometry.adventitia_thickness_m", above(0.0, 0.1), "thickness of the adventitia"),
    key("geometry.blend_length_m", above(0.0, 10.0), "length of the cosine blend, centred on the joint"),
    key("geometry.extension_length_m", from(0.0, 10.0), "length of the rigid extension, 0 for none"),
    key("geometry.helix_radius_m", above(0.0, 1.0), "radius of the helix"),
    key("geometry.arc_angle_deg", above(0.0, 270.0), "angle that the arc turns through"),
    key("geometry.imperfection", Kind::Rows, "support values of the imperfection relative to model.d_max_m"),
    key("wall.density_kg_m3", above(0.0, 1e5), "density of the wall"),
    key("wall.damping_1_s", from(0.0, 1e4), "mass-proportional damping"),
    key("blood.density_kg_m3", above(0.0, 1e5), "density of the blood"),
    key("blood.viscosity_Pa_s", above(0.0, 1e3), "dynamic viscosity of the blood"),
    key("inflow.base_m3_s", from(-1.0, 1.0), "flow outside systole"),
    key("inflow.amplitude_m3_s", from(-1.0, 1.0), "height of the pulse above the base"),
    key("inflow.systole_s", above(0.0, 100.0), "duration of the pulse"),
    key("inflow.exponent", from(0.1, 10.0), "exponent that makes the rise faster than the fall"),
    optional("inflow.file", Kind::Path, "CSV file with the columns time_s,flow_m3_s over one period"),
    key("windkessel.resistance_Pa_s_m3", above(0.0, 1e15), "resistance R of the windkessel"),
    key("windkessel.compliance_m3_Pa", above(0.0, 1.0), "compliance C of the windkessel"),
    key("windkessel.initial_pressure_Pa", from(-1e6, 1e6), "pressure of the windkessel at t = 0"),
    key("ramp.duration_s", from(0.0, 100.0), "duration of the smooth start"),
    key("time.step_s", above(0.0, 1.0), "time step"),
    key("time.end_s", above(0.0, 1e4), "end of the run"),
    key("time.max_halvings", Kind::Whole(0, 4), "how often the step may be halved where it fails"),
    key("time.period_s", above(0.0, 1e3), "duration of a beat"),
    key("structure.p", Kind::Whole(3, 10), "degree of the trunk space; lower ones lock"),
    optional("structure.p_geometry", Kind::Whole(1, 10), "degree of the mapping"),
    optional("structure.quadrature_points", Kind::Whole(3, 30), "Gauss points per direction"),
    key("structure.axial_per_section", Kind::Whole(1, 1000), "elements along each section"),
    key("structure.circumferential", Kind::Whole(3, 1000), "elements around"),
    key("structure.radial_per_layer", Kind::Whole(1, 100), "elements through each layer"),
    optional("structure.time_scheme", Kind::Word(&["newmark", "damped_newmark", "implicit_euler"]), "time integration of the wall"),
    key("structure.newton_tolerance", from(1e-14, 0.1), "relative residual at which Newton's method ends"),
    key("structure.newton_max_iterations", Kind::Whole(1, 1000), "most Newton iterations"),
    key("fluid.templates", Kind::Path, "folder of the OpenFOAM dictionary templates"),
    key("fluid.ranks", Kind::Whole(1, 1024), "MPI ranks"),
    key("fluid.transport", Kind::Word(&["socket", "files"]), "way between driver and OpenFOAM"),
    key("fluid.answer_limit_s", above(0.0, 1e6), "longest time to wait for OpenFOAM's answer, or 50 times its longest so far"),
    key("fluid.max_correctors", Kind::Whole(1, 1000), "most outer correctors in a coupling iteration"),
    key("fluid.pressure_residual", above(0.0, 1.0), "first pressure residual that ends the correctors"),
    key("fluid.mesh.core", Kind::Whole(2, 200), "cells along a side of the square in the middle"),
    key("fluid.mesh.radial", Kind::Whole(1, 200), "cells from the square to the wall"),
    key("fluid.mesh.wall_grading", from(0.1, 100.0), "thickness of the innermost ring over that at the wall"),
    key("fluid.mesh.axial_extension", Kind::Whole(0, 10_000), "cells along the extension"),
    key("fluid.mesh.axial_per_section", Kind::Whole(1, 10_000), "cells along each section"),
    key("coupling.acceleration", Kind::Word(&["constant", "aitken", "iqn_ls", "multi_vector", "hybrid"]), "acceleration of the coupling"),
    key("coupling.surrogate", Kind::Word(&["none", "tube", "open_tube"]), "one-dimensional model behind the acceleration"),
    optional("coupling.relaxation", above(0.0, 1.0), "relaxation factor"),
    key("coupling.reuse_steps", Kind::Whole(0, 1000), "earlier steps whose columns are reused"),
    key("coupling.filter", from(0.0, 0.99), "share of a column that must be new"),
    key("coupling.predictor", Kind::Word(&["constant", "linear", "quadratic", "least_squares"]), "first trial of a step"),
    optional("coupling.criterion", Kind::Word(&["change", "residual"]), "what the limits are for"),
    key("coupling.e_rel", above(0.0, 0.1), "relative limit of the criterion"),
    key("coupling.e_abs_m", above(0.0, 1.0), "absolute limit of the criterion"),
    key("coupling.max_iterations", Kind::Whole(1, 10_000), "most coupling iterations of a step"),
    key("output.structure_interval_s", above(0.0, 1e4), "interval of the structure's files"),
    key("output.fluid_interval_s", above(0.0, 1e4), "interval of the fluid's files"),
    key("output.checkpoint_interval_min", from(0.0, 1e5), "wall-clock time between two checkpoints"),
    key("output.wall_history", Kind::Flag, "whether wall shear stress and displacement of each step are kept"),
    optional("output.window_start_s", from(0.0, 1e4), "start of the time window of the hemodynamics"),
    optional("output.window_end_s", above(0.0, 1e4), "end of the time window of the hemodynamics"),
    optional("output.probes_m", Kind::Points, "points of the unloaded lumen's surface whose motion is recorded"),
    key("flag.channel_length_m", above(0.0, 1e3), "length of the channel"),
    key("flag.channel_height_m", above(0.0, 1e3), "height of the channel"),
    key("flag.depth_m", above(0.0, 1e3), "extent of the plane problem along z"),
    key("flag.cylinder_x_m", above(0.0, 1e3), "position of the cylinder along the channel"),
    key("flag.cylinder_y_m", above(0.0, 1e3), "position of the cylinder above the lower wall"),
    key("flag.cylinder_radius_m", above(0.0, 1e3), "radius of the cylinder"),
    key("flag.length_m", above(0.0, 1e3), "length of the flag behind the cylinder"),
    key("flag.thickness_m", above(0.0, 1e3), "thickness of the flag"),
    key("flag.mean_velocity_m_s", from(-1e3, 1e3), "mean velocity of the inflow"),
    key("flag.mesh.elements", Kind::Whole(1, 1000), "elements along the flag"),
    key("flag.mesh.cell_size_m", above(0.0, 1e3), "size of the fluid's cells at the flag"),
    key("flag.mesh.growth", from(1.0, 2.0), "ratio of the sizes of neighbouring cells"),
    key("flag.mesh.largest_cell_m", above(0.0, 1e3), "largest size of a cell along the channel"),
];

/// Tables that a case may do without; where one has any key it needs all.
pub const OPTIONAL_TABLES: &[&str] = &["flag"];

/// Bodies and parts of the wall that have a material each.
pub const MATERIAL_TABLES: &[&str] = &["wall.graft", "wall.media", "wall.adventitia", "flag.solid"];

/// The materials by name with their parameters.
#[rustfmt::skip]
pub const MATERIALS: &[(&str, &[Key])] = &[
    ("neo_hooke", &[MU, KAPPA]),
    (
        "holzapfel_gasser_ogden",
        &[
            MU,
            KAPPA,
            key("k1_Pa", from(0.0, 1e12), "stiffness of the fibres"),
            key("k2", from(0.0, 1e4), "exponent of the fibres"),
            key("fibre_angle_deg", from(0.0, 90.0), "angle of the fibres from the circumferential direction"),
            optional("tension_only", Kind::Flag, "fibres that carry no compression"),
        ],
    ),
    (
        "saint_venant_kirchhoff",
        &[
            key("youngs_modulus_Pa", above(0.0, 1e13), "Young's modulus"),
            key("poisson_ratio", from(-0.99, 0.4999), "Poisson's ratio"),
        ],
    ),
];

const MU: Key = key("mu_Pa", above(0.0, 1e12), "shear modulus");
const KAPPA: Key = key("kappa_Pa", above(0.0, 1e13), "bulk modulus");

/// The key that names the material of a part of the wall.
pub const MATERIAL: Key = key(
    "material",
    Kind::Word(&[
        "neo_hooke",
        "holzapfel_gasser_ogden",
        "saint_venant_kirchhoff",
    ]),
    "material of this part of the wall",
);
