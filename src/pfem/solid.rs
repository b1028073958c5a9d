//! The structure as a black box: load on the wet surface in, displacement of the wet surface out.

use crate::Vec3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A quadrature point of the wet surface in the reference configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Reference position, m.
    pub position: Vec3,
    /// Unit normal out of the solid.
    pub normal: Vec3,
    /// Quadrature weight times reference area, m².
    pub area: f64,
}

/// Load on the wet surface per deformed area, at its quadrature points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurfaceLoad {
    /// Pressure that follows the surface, Pa; positive against the outward normal of the solid.
    pub pressure: Vec<f64>,
    /// The rest of the traction, with a direction fixed in space, Pa.
    pub shear: Vec<Vec3>,
}

impl SurfaceLoad {
    /// The same pressure (Pa) at all `points` of a surface.
    pub fn uniform_pressure(pressure: f64, points: usize) -> Self {
        Self {
            pressure: vec![pressure; points],
            shear: vec![Vec3::zeros(); points],
        }
    }
}

/// Largest stresses and stretches at the quadrature points of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StressPeak {
    /// Reference position of the element's middle, m.
    pub element: Vec3,
    /// Largest von Mises stress, Pa.
    pub von_mises: f64,
    /// Largest principal Cauchy stress of the element, Pa.
    pub max_principal: f64,
    /// Largest stress around the deformed vessel, Pa.
    pub max_hoop: f64,
    /// Largest stress along it, Pa.
    pub max_axial: f64,
    /// Largest stretch of fibres, if there are any.
    pub max_fibre_stretch: Option<f64>,
    /// Reference position of the point of the largest von Mises stress, m.
    pub position: Vec3,
}

/// A structural solver that can repeat a time step from the same old state with different loads. Its accepted state can
/// be looked at from other threads.
pub trait Solid: Sync {
    /// The solution of one time step; thrown away, or handed to [`Solid::accept`].
    type Trial;
    /// Where a point of the fluid lies on the wet surface, prepared for fast evaluation.
    type Location;
    /// All that it keeps from one time step to the next.
    type Memory: Clone + Serialize + DeserializeOwned;

    /// Quadrature points of the wet surface.
    fn wet_points(&self) -> &[SurfacePoint];

    /// Outlines (m) of the faces of the wet surface; the wet points belong to them in order, as many to each.
    fn wet_faces(&self) -> Vec<Vec<Vec3>>;

    /// Finds the closest points of the wet surface in the reference configuration.
    fn locate(&self, points: &[Vec3]) -> Result<Vec<Self::Location>, SolidError>;

    /// Solves a time step of length `dt` (s) from the accepted state under `load`; `tolerance` is the relative
    /// residual that Newton's method must reach. `start` is an earlier trial of this step to start from.
    fn solve(
        &mut self,
        load: &SurfaceLoad,
        dt: f64,
        tolerance: f64,
        start: Option<&Self::Trial>,
    ) -> Result<Self::Trial, SolidError>;

    /// Displacement (m) at located points at the end of a step of length `dt` (s), where it does not depend on the
    /// load.
    fn foreseen(&self, _dt: f64, _at: &[Self::Location]) -> Option<Vec<Vec3>> {
        None
    }

    /// Displacement (m) of a trial at located points.
    fn displacement(&self, trial: &Self::Trial, at: &[Self::Location]) -> Vec<Vec3>;

    /// Deformed area vector (normal out of the solid times area, quadrature weight included, m²) at each wet point.
    fn deformed_areas(&self, trial: &Self::Trial) -> Vec<Vec3>;

    /// What the user should know after the last accepted step; each thing is reported once.
    fn notice(&mut self) -> Option<String> {
        None
    }

    /// Makes a trial the state from which the next time step starts.
    fn accept(&mut self, trial: Self::Trial);

    /// Displacement (m) of the accepted state at located points.
    fn accepted_displacement(&self, at: &[Self::Location]) -> Vec<Vec3>;

    /// Largest von Mises stress of each element in the accepted state; none from a structure without stresses.
    fn stress_peaks(&self) -> Result<Vec<StressPeak>, SolidError> {
        Ok(Vec::new())
    }

    /// What is needed to continue later, to the last bit.
    fn memory(&self) -> Self::Memory;

    /// Continues as the structure whose memory this is.
    ///
    /// # Errors
    /// If it belongs to another structure.
    fn recall(&mut self, memory: Self::Memory) -> Result<(), SolidError>;
}

/// Why the structural solver failed.
#[derive(Debug, thiserror::Error)]
pub enum SolidError {
    /// Newton's method found no equilibrium.
    #[error("the structure found no equilibrium: {0}")]
    NoEquilibrium(String),
    /// No unloaded shape was found of a body whose loaded one is given.
    #[error("{0}")]
    NoUnloadedShape(Box<NoUnloadedShape>),
    /// An element is, or became, inside out.
    #[error(
        "element {element} of the wall is inside out at ({:.4e}, {:.4e}, {:.4e}) m (Jacobian {jacobian:.3e})",
        .position[0], .position[1], .position[2]
    )]
    Inverted {
        /// Index of the element.
        element: usize,
        /// Determinant of the deformation gradient or of the mapping.
        jacobian: f64,
        /// Reference position, m.
        position: [f64; 3],
    },
    /// The model is not well posed.
    #[error("{0}")]
    Model(String),
}

/// Why no unloaded shape was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "no unloaded shape was found from which more than {:.1} % of the load lead to the given one ({last}{}). Is the pressure right, \
     and the wall as thick and as stiff as that of a vessel which carries it? Elements that are short where the ends are clamped, \
     and tissue (stiffer springs on the outside) or prestretch, make it easier to find",
    100.0 * .reached,
    nearby(*.place)
)]
pub struct NoUnloadedShape {
    /// Share of the load for which a shape was found.
    pub reached: f64,
    /// Middle of the last element that was inside out, in the given shape, m.
    pub place: Option<[f64; 3]>,
    /// What ended the last attempt.
    pub last: String,
}

/// Where the wall fails, in a message.
fn nearby(place: Option<[f64; 3]>) -> String {
    place.map_or(String::new(), |[x, y, z]| {
        format!("; elements were inside out near ({x:.4}, {y:.4}, {z:.4}) m")
    })
}
