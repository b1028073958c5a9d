//! How a thin branch stands on the side of another one: what is chosen so that its hexahedra are good.
//!
//! The numbers were found by searching for the largest scaled Jacobian of the worst cell or element over straight and
//! bent parents, with junctions about as long as the usual ones: longer cells make a run less accurate. A branch across
//! its parent asks for another shape than one that leaves at 30°.

/// Lengths and shares. Those along the parent are in its radii, those along the branch in radii of the branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// The distances of the patch's border from the branch's line, relative to the usual ones.
    pub foot: f64,
    /// How much longer the patch is along the parent than around it, seen along the branch ...
    pub long: f64,
    /// ... and how far downstream of the branch's line its middle lies, in its half width.
    pub ahead: f64,
    /// How far the border climbs up the branch on the side where it leaves less sharply: 0 if it stays on the parent's
    /// wall, 1 if it would lie across the branch.
    pub climb: f64,
    /// How much more the core of the plug is tilted than the patch, at the patch.
    pub tilt: f64,
    /// Length of the parent between the patch and plane cross-sections.
    pub beside: f64,
    /// How far the cross-sections of the patch spread on the parent's other side, relative to that of a tube.
    pub spread: f64,
    /// How far these lie further back there, by the cotangent of the angle between the branch and the parent.
    pub back: f64,
    /// How much the core of the parent's cross-sections stays in that of a tube.
    pub upright: f64,
    /// Where their middles lie between the parent's other side (0) and the patch (1).
    pub near: f64,
    /// Height of the bowl's bottom, as a share of the plug's height and of its width at most.
    pub bottom: [f64; 2],
    /// Plane cross-sections of the branch begin so far from the patch.
    pub cut: f64,
}

/// Good for branches that leave at 50° to 130°.
pub const USUAL: Shape = Shape {
    foot: 1.0,
    long: 1.0,
    ahead: 0.0,
    climb: 0.0,
    tilt: 0.0,
    beside: 0.8,
    spread: 0.8,
    back: 0.0,
    upright: 0.35,
    near: 0.9,
    bottom: [0.45, 0.5],
    cut: 1.0,
};

/// For branches that leave at 25° to 50°, or backwards at 130° to 150°, in the order in which they are tried.
pub const INCLINED: [Shape; 8] = [
    // Found for up to 0.3 of the parent's radius.
    Shape {
        foot: 0.971,
        long: 1.0,
        ahead: 0.0,
        climb: 0.381,
        tilt: 0.82,
        beside: 0.871,
        spread: 0.247,
        back: 0.455,
        upright: 0.081,
        near: 0.909,
        bottom: [0.723, 0.63],
        cut: 1.17,
    },
    // Found for 0.4 and 0.5.
    Shape {
        foot: 0.807,
        long: 1.13,
        ahead: 0.051,
        climb: 0.22,
        tilt: 0.621,
        beside: 0.871,
        spread: 0.197,
        back: 0.558,
        upright: 0.161,
        near: 0.957,
        bottom: [0.664, 0.777],
        cut: 1.12,
    },
    // Found for 0.6 from 35° on.
    Shape {
        foot: 0.749,
        long: 1.014,
        ahead: 0.111,
        climb: 0.084,
        tilt: 1.1,
        beside: 0.529,
        spread: 0.549,
        back: 0.768,
        upright: 0.385,
        near: 0.867,
        bottom: [0.587, 0.558],
        cut: 0.725,
    },
    // Found for 0.6 at 30° where the parent turns aside.
    Shape {
        foot: 0.823,
        long: 1.16,
        ahead: 0.116,
        climb: 0.145,
        tilt: 1.1,
        beside: 1.012,
        spread: 0.598,
        back: 0.905,
        upright: 0.231,
        near: 0.945,
        bottom: [0.658, 0.628],
        cut: 1.3,
    },
    // Found for 0.55 and 0.6 at 30° to 33° where the parent turns aside by up to half as much.
    Shape {
        foot: 0.808,
        long: 1.203,
        ahead: 0.083,
        climb: 0.193,
        tilt: 0.777,
        beside: 1.048,
        spread: 0.473,
        back: 0.632,
        upright: 0.244,
        near: 0.938,
        bottom: [0.787, 0.745],
        cut: 0.951,
    },
    // Found for 0.6 at 30° where the parent goes straight on.
    Shape {
        foot: 0.94,
        long: 1.056,
        ahead: 0.124,
        climb: 0.418,
        tilt: 0.525,
        beside: 0.916,
        spread: 0.34,
        back: 0.591,
        upright: 0.181,
        near: 0.878,
        bottom: [0.484, 0.753],
        cut: 0.916,
    },
    // Found for 0.55 and 0.6 at 36° to 40° where the parent turns aside by up to three quarters as much.
    Shape {
        foot: 0.775,
        long: 1.033,
        ahead: 0.018,
        climb: 0.092,
        tilt: 0.5,
        beside: 0.534,
        spread: 0.611,
        back: 0.691,
        upright: 0.356,
        near: 0.906,
        bottom: [0.827, 0.588],
        cut: 0.843,
    },
    // Found for those that leave backwards at 150°.
    Shape {
        foot: 0.837,
        long: 1.088,
        ahead: -0.12,
        climb: 0.244,
        tilt: 1.01,
        beside: 0.757,
        spread: 0.216,
        back: 0.576,
        upright: 0.254,
        near: 0.837,
        bottom: [0.576, 0.68],
        cut: 0.803,
    },
];
