//! Why a tree has no mesh: where, what was found, what is allowed, what to do.

use crate::Vec3;

/// Why a tree has no mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TreeError {
    /// A ray from this place (m) does not meet the surface.
    #[error("at {} the lumen is not closed around the centre-line: do the lines end there, or is a daughter inside its parent?", shown(.0))]
    Open(Vec3),
    /// The first line ends, at this place (m), within the tube around the second.
    #[error("it ends at {}, and a branch must leave the lumen that it begins in", shown(.2))]
    Within(usize, usize, Vec3),
    /// No surface between two lines that part near this place (m).
    #[error(
        "near {} two centre-lines part, but their lumens do not: their radii are too large for the angle between them, or one lies \
         within the other", shown(.0)
    )]
    Apex(Vec3),
    /// Branches leave this place (m) at angles that are too small.
    #[error("at {} branches leave in nearly the same direction: a junction carries angles of 20 degrees and more", shown(.0))]
    Angle(Vec3),
    /// A thin branch that is wide as soon as it leaves this place (m).
    #[error(
        "at {} a branch with a narrow neck widens, or bends back, as soon as it leaves: let the neck go on for half of its radius", shown(.0)
    )]
    Neck(Vec3),
    /// No mesh where branches part.
    #[error("{0} have no mesh, since {reason}; {CARRIED}", reason = .1.reason())]
    Parting(Box<Parted>, Box<TreeError>),
    /// Two junctions, at these places (m), so far (m) from each other along the branch between them, where it takes so
    /// much (m).
    #[error(
        "the junctions at {} and {} are too close: {:.2} mm apart along the branch between them, at least {:.2} mm needed: leave out \
         one of the branches (tree.leave_out), or let them part at one place", shown(.0), shown(.1), 1e3 * .2, 1e3 * .3
    )]
    Close(Vec3, Vec3, f64, f64),
    /// An opening so far (m) from the junction at this place (m), where it takes so much (m).
    #[error(
        "an opening is only {:.2} mm from the junction at {}, at least {:.2} mm needed: continue the centre-line there, or leave \
         the branch out (tree.leave_out)", 1e3 * .1, shown(.0), 1e3 * .2
    )]
    Short(Vec3, f64, f64),
    /// A lumen of this radius (m) bends, at this place (m), with that one (m).
    #[error(
        "near {} the mesh would be inside out: the lumen, of radius {:.2} mm, bends with a radius of {:.2} mm there: smooth the lines \
         (tree.smoothing_m; `new` does with --smoothing), or correct them", shown(.0), 1e3 * .1, 1e3 * .2
    )]
    Bend(Vec3, f64, f64),
    /// A hexahedron inside out near this place (m).
    #[error(
        "near {} the mesh would be inside out: the radius changes too sharply there, or a junction is too close", shown(.0)
    )]
    InsideOut(Vec3),
    /// The worst cell, at this place (m), has this scaled Jacobian.
    #[error("at {} a cell is nearly flat, its scaled Jacobian is {:.2}", shown(.0), .1)]
    Flat(Vec3, f64),
    /// A feature of the branch of this name, so far (m) along it, which is so long (m).
    #[error(
        "the middle of what is at at_m = {1:?} on the branch {0:?} lies beyond its end: it is {2:.4} m long, from the middle of the \
         junction on"
    )]
    Beyond(String, f64, f64),
    /// The triangles of the surface make none.
    #[error("the surface of the lumen: {0}")]
    Surface(crate::files::Fault),
    /// Lines do not begin at one place: this one (m) is far from the first.
    #[error("a centre-line begins at {}, far from where the first one does: are there two trees in the file?", shown(.0))]
    TwoTrees(Vec3),
}

/// Branches that part.
#[derive(Debug, Clone, PartialEq)]
pub struct Parted {
    /// Where, m.
    pub place: Vec3,
    /// Angle (degrees) of each daughter with the direction of the flow upstream, and its radius relative to that of the
    /// parent.
    pub daughters: Vec<(f64, f64)>,
}

impl std::fmt::Display for Parted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let of =
            |(angle, ratio): &(f64, f64)| format!("{angle:.0}° (with {ratio:.2} of its radius)");
        let daughters: Vec<String> = self.daughters.iter().map(of).collect();
        write!(
            f,
            "the branches that leave at {} at {} to their parent's direction",
            shown(&self.place),
            daughters.join(" and ")
        )
    }
}

/// What junctions carry, in words.
const CARRIED: &str = "junctions carry daughters at 25° to 120°, thin ones at 25° to 150° at the side of a vessel that goes straight on, three \
                       daughters 35° apart and four 50°: smooth the lines (tree.smoothing_m), correct them, or leave a branch out \
                       (tree.leave_out)";

impl TreeError {
    /// Why an end is left out, in a few words.
    pub fn briefly(&self) -> String {
        match self {
            Self::Within(..) => "it stays within the lumen around another line".into(),
            Self::Parting(parted, reason) => {
                format!(
                    "at the junction at {} {}",
                    shown(&parted.place),
                    reason.reason()
                )
            }
            Self::Close(x, _, found, needed) => format!(
                "its junction at {} is {:.2} mm from the next one, which takes {:.2} mm",
                shown(x),
                1e3 * found,
                1e3 * needed
            ),
            Self::Short(x, found, needed) => format!(
                "it ends {:.2} mm from the junction at {}, which takes {:.2} mm",
                1e3 * found,
                shown(x),
                1e3 * needed
            ),
            Self::Bend(x, radius, bend) => format!(
                "near {} the lumen, of radius {:.2} mm, bends with a radius of {:.2} mm",
                shown(x),
                1e3 * radius,
                1e3 * bend
            ),
            Self::InsideOut(x) => format!("near {} cells would be inside out", shown(x)),
            Self::Flat(x, quality) => format!(
                "at {} the worst cell has a scaled Jacobian of {quality:.2}",
                shown(x)
            ),
            Self::Open(x) => format!("at {} the lumen is not closed around it", shown(x)),
            other => other.to_string(),
        }
    }

    /// What it is, where lines part.
    fn reason(&self) -> &'static str {
        match self {
            Self::Open(_) => "the lumen is not closed around them",
            Self::Apex(_) => "their lumens do not part: the radii are too large for the angle",
            Self::Angle(_) => "they leave in nearly the same direction",
            Self::Neck(_) => "the thinner one widens, or bends back, as soon as it leaves",
            _ => "cells would be inside out",
        }
    }

    /// Where it is, m.
    pub(super) fn place(&self) -> Option<Vec3> {
        match self {
            Self::Open(x)
            | Self::Within(_, _, x)
            | Self::Apex(x)
            | Self::Angle(x)
            | Self::Neck(x)
            | Self::Close(x, ..)
            | Self::Short(x, ..)
            | Self::Bend(x, ..)
            | Self::InsideOut(x)
            | Self::Flat(x, _)
            | Self::TwoTrees(x) => Some(*x),
            Self::Beyond(..) => None,
            Self::Parting(parted, _) => Some(parted.place),
            Self::Surface(_) => None,
        }
    }
}

fn shown(x: &Vec3) -> String {
    format!("({:.4e}, {:.4e}, {:.4e}) m", x.x, x.y, x.z)
}
