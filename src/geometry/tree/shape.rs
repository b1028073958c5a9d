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
pub const INCLINED: [Shape; 5] = [
    // Found for up to 0.3 of the parent's radius.
    Shape {
        foot: 0.971,
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
        foot: 0.739,
        climb: 0.287,
        tilt: 0.314,
        beside: 0.896,
        spread: 0.206,
        back: 0.54,
        upright: 0.19,
        near: 1.005,
        bottom: [0.851, 0.782],
        cut: 1.06,
    },
    // Found for 0.6 from 35° on.
    Shape {
        foot: 0.793,
        climb: 0.084,
        tilt: 0.94,
        beside: 0.54,
        spread: 0.525,
        back: 0.73,
        upright: 0.377,
        near: 0.866,
        bottom: [0.832, 0.558],
        cut: 0.821,
    },
    // Found for 0.6 at 30°: longer, with larger cells.
    Shape {
        foot: 0.97,
        climb: 0.52,
        tilt: 0.35,
        beside: 1.19,
        spread: 0.37,
        back: 0.75,
        upright: 0.15,
        near: 0.82,
        bottom: [0.47, 1.05],
        cut: 0.5,
    },
    // The same where the parent turns aside.
    Shape {
        foot: 0.92,
        climb: 0.23,
        tilt: 0.97,
        beside: 0.9,
        spread: 0.57,
        back: 0.94,
        upright: 0.11,
        near: 0.91,
        bottom: [0.46, 0.72],
        cut: 1.64,
    },
];
