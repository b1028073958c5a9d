//! How a thin branch stands on the side of another one: what is chosen so that its hexahedra are good.
//!
//! The numbers were found by searching for the largest scaled Jacobian of the worst cell or element over straight and
//! bent parents. A branch across its parent asks for another shape than one that leaves at 30°.

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

/// What is tried, in this order: the usual one, and where that is poor the others, until one is good.
pub const SHAPES: [Shape; 5] = [
    // The usual one.
    Shape {
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
    },
    // Found for 30° and up to 0.4 of the parent's radius.
    Shape {
        foot: 1.0,
        climb: 0.28,
        tilt: 0.83,
        beside: 1.74,
        spread: 0.8,
        back: 0.05,
        upright: 0.2,
        near: 0.94,
        bottom: [0.35, 0.68],
        cut: 1.9,
    },
    // Found for 35° to 45° and 0.6 of the parent's radius: there the usual one is mostly good enough.
    Shape {
        foot: 0.95,
        climb: 0.1,
        tilt: 0.73,
        beside: 1.17,
        spread: 0.65,
        back: 0.93,
        upright: 0.43,
        near: 0.85,
        bottom: [0.49, 0.72],
        cut: 1.17,
    },
    // Found for 30°, 0.5 and 0.6 of the parent's radius.
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
