//! The three test cases of section 3.1.
//!
//! Materials and pressure are those of the paper. Sizes are assumed, as the paper leaves them to a source of its own:
//! inner radius 3 mm; two layers of 0.5 mm (artery), one of 0.5 mm (graft). A length of 6 mm is enough where nothing
//! varies along the axis. The irregular artery is 12 mm long, so that its bumps are about as long as they are wide;
//! they are those of the artery of the FSI models, with the amplitude 1 mm.

use crate::Vec3;
use crate::analysis::tube::{Tube, TubeEnds, TubeGrid, nearest_vertex};
use crate::case::Material;
use crate::case::words;
use crate::geometry::{HexMesh, Imperfection, irregular_tube_mesh};
use crate::pfem::element::surface::LoadKind;
use crate::pfem::supports::Support;

/// Pressure inside, Pa [paper].
const PRESSURE: f64 = 1.6e4;
/// Inner radius, m [assumed].
const INNER_RADIUS: f64 = 3e-3;
/// Thickness of each layer, m [assumed].
const THICKNESS: f64 = 0.5e-3;
/// Length of the circular tubes, m [assumed].
const SHORT: f64 = 6e-3;
/// Length of the irregular tube, m [assumed].
const LONG: f64 = 12e-3;
/// Largest radius deviation of the irregular tube, m [paper].
const DEVIATION: f64 = 1e-3;
/// Support values of the imperfection, relative to its largest value: 7 along the axis by 5 around [assumed].
const SUPPORT: [[f64; 5]; 7] = [
    [0.00, 0.00, 0.00, 0.00, 0.00],
    [0.25, 0.95, 0.30, 0.85, 0.75],
    [0.75, 0.60, 0.10, 0.45, 0.90],
    [0.25, 0.50, 0.80, 1.00, 0.85],
    [0.60, 0.85, 0.85, 0.45, 0.25],
    [0.25, 0.45, 0.65, 0.15, 0.10],
    [0.00, 0.00, 0.00, 0.00, 0.00],
];

words! {
    /// A test case.
    #[derive(clap::ValueEnum)]
    pub enum TestCase {
        /// Circular shaped artery: two layers of the HGO material.
        Circular = "circular",
        /// Idealized bypass graft: one layer of the Neo-Hookean material.
        Graft = "graft",
        /// Irregular shaped artery.
        Irregular = "irregular",
    }
}

/// One of the two meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mesh {
    /// 2 × 4 × 2 elements: axial, circumferential, radial.
    Initial,
    /// 4 × 8 × 4 elements.
    Refined,
}

impl Mesh {
    /// `2x4x2` or `4x8x4`.
    pub fn name(self) -> &'static str {
        match self {
            Mesh::Initial => "2x4x2",
            Mesh::Refined => "4x8x4",
        }
    }

    fn grid(self, layers: usize) -> TubeGrid {
        let factor = match self {
            Mesh::Initial => 1,
            Mesh::Refined => 2,
        };
        TubeGrid {
            axial: 2 * factor,
            circumferential: 4 * factor,
            radial_per_layer: 2 * factor / layers,
            layers,
        }
    }
}

impl TestCase {
    /// The tube under its load, on one of the meshes.
    pub fn tube(self, mesh: Mesh) -> Tube {
        let layers: Vec<(f64, Material)> = self
            .materials()
            .into_iter()
            .map(|material| (THICKNESS, material))
            .collect();
        let grid = mesh.grid(layers.len());
        let tube = match self {
            TestCase::Circular | TestCase::Graft => {
                Tube::circular(INNER_RADIUS, SHORT, &layers, grid, TubeEnds::Axial)
            }
            TestCase::Irregular => {
                let support = SUPPORT.map(|row| row.to_vec());
                let mesh = irregular_tube_mesh(
                    INNER_RADIUS,
                    [THICKNESS; 2],
                    Imperfection::new(&support, [0.0, LONG], DEVIATION),
                    grid.axial,
                    grid.circumferential,
                    grid.radial_per_layer,
                );
                Tube {
                    grid,
                    supports: statically_determinate(&mesh),
                    mesh,
                    materials: self.materials(),
                    pressure: 0.0,
                    kind: LoadKind::Follower,
                    axial_stretch: 1.0,
                    outer_pressure: 0.0,
                }
            }
        };
        tube.loaded(PRESSURE, LoadKind::Follower)
    }

    /// Table 1 of the paper: the graft's, or those of media and adventitia.
    pub fn materials(self) -> Vec<Material> {
        let fibred = |mu, kappa, k1, k2, fibre_angle_deg| Material::HolzapfelGasserOgden {
            mu,
            kappa,
            k1,
            k2,
            fibre_angle_deg,
            tension_only: false,
            dispersion: None,
            viscosity: None,
        };
        match self {
            TestCase::Graft => vec![Material::NeoHooke {
                mu: 3.33e5,
                kappa: 1.67e9,
                viscosity: None,
            }],
            TestCase::Circular | TestCase::Irregular => vec![
                fibred(5.4e4, 1e9, 640.0, 3.54, 10.0),
                fibred(5.4e3, 1e8, 5.1e3, 15.4, 40.0),
            ],
        }
    }
}

/// `u_x = 0` at the ends, and at x = 0 three components of vertices of the outer surface: two in z on opposite sides,
/// one in y between them. The load is in equilibrium by itself, so these carry nothing. (The paper holds two nodes with
/// one component each; a third one is needed to stop both translations and the rotation.)
fn statically_determinate(mesh: &HexMesh) -> Vec<Support> {
    let sliding = |name: &str| Support::Surface(name.into(), [true, false, false]);
    let outer = INNER_RADIUS + 2.0 * THICKNESS;
    let vertex = |y: f64, z: f64| nearest_vertex(mesh, &Vec3::new(0.0, y, z));
    vec![
        sliding("start"),
        sliding("end"),
        Support::Vertex(vertex(outer, 0.0), [false, false, true]),
        Support::Vertex(vertex(-outer, 0.0), [false, false, true]),
        Support::Vertex(vertex(0.0, outer), [false, true, false]),
    ]
}
