//! # fsi-pfem: p-version finite elements for large deformations
//!
//! Hyperelastic bodies of curved hexahedra, at rest and in time: few large elements whose polynomials are raised until
//! the answer no longer changes. Thin, nearly incompressible, fibre-reinforced walls are what it is made for; it does
//! not know that a fluid exists.
//!
//! ## A guided tour
//!
//! 1. [`mesh`]: a [`HexMesh`](mesh::HexMesh) is hexahedra with their exact shape and named surfaces; of a block, of a
//!    tube, or your own [`HexShape`](mesh::HexShape).
//! 2. [`material`]: strain energies with stress and tangent. A [`Law`](material::Law) is one, perhaps with viscosity.
//! 3. [`space`]: the modes of an element (trunk or tensor product, a degree per direction), joined across elements;
//!    [`element`] gives the elements their shape and integrates over them.
//! 4. [`supports`]: what holds the body: clamps, symmetry, springs and dampers.
//! 5. [`Discretization`] is a body ready to be solved for.
//! 6. [`solution`]: [`statics`](solution::statics) by Newton's method with load steps, loss of stability, natural
//!    modes; [`Structure`] moves the body in time, under a load on its wet surface, behind the trait [`Solid`].
//! 7. [`evaluation`]: stresses, and where points lie; [`linear_algebra`]: sparse matrices and their factors.
//!
//! A bar that is pulled until it is longer by a tenth:
//!
//! ```
//! use fsi_pfem::discretization::{Discretization, Options};
//! use fsi_pfem::material::NeoHooke;
//! use fsi_pfem::mesh::block_mesh;
//! use fsi_pfem::solution::statics::{self, Load, StaticOptions};
//! use fsi_pfem::supports::Support;
//! use fsi_pfem::{Space, SpaceKind, Vec3};
//!
//! let mesh = block_mesh([1.0, 0.2, 0.2], [2, 1, 1]);
//! let rubber = NeoHooke { mu: 1e5, kappa: 1e6 };
//! let held = [Support::Clamped("start".into())];
//! let options = Options::new(Space::isotropic(SpaceKind::Trunk, 3));
//! let body = Discretization::new(&mesh, &[rubber], &held, &options)?;
//! let weight = Load::Forces(body.body_forces(Vec3::x() * 6e4)); // N/m³
//! let result = statics::solve(&body, &[weight], None, &StaticOptions::default())?;
//! let tip = body.displacement_at(1, [1.0, 0.0, 0.0], &result.displacement);
//! assert!((tip.x - 0.1).abs() < 0.02, "{tip}");
//! # Ok::<(), fsi_pfem::SolidError>(())
//! ```
//!
//! `examples/cantilever.rs` compares degrees with beam theory, and bends the beam beyond it.

// Tensors are named as in the paper: F, C, P, J.
#![allow(non_snake_case)]

pub mod discretization;
pub mod element;
pub mod evaluation;
pub mod linear_algebra;
pub mod material;
pub mod mesh;
pub mod solid;
pub mod solution;
pub mod space;
pub mod supports;

pub use discretization::Discretization;
pub use element::volume::Formulation;
pub use evaluation::samples::{Sampler, Samples};
pub use evaluation::stress::StressState;
pub use fsi_numerics::{Mat3, Vec3};
pub use solid::{NoUnloadedShape, Solid, SolidError, SurfaceLoad, SurfacePoint};
pub use solution::structure::{Gravity, PrescribedMotion, Structure, StructureOptions};
pub use space::{Space, SpaceKind};
