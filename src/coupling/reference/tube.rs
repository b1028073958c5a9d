//! The elastic tube as a partitioned problem whose interface looks as in three dimensions: points on rings.

use super::{Flow, Inlet, Monolithic, Outlet, Reference, StringWall, TubeFluid, WallSetup};
use crate::Vec3;
use crate::coupling::acceleration::Surrogate;
use crate::coupling::surrogate::{
    Axis, StationOptions, Stations, SurrogateBlood, SurrogateWall, TubeEnd, TubeSurrogate,
};
use crate::curve::SpaceCurve;
use nalgebra::DVector;
use std::f64::consts::{PI, TAU};

/// Points on a ring.
const RING: usize = 3;

/// What a tube consists of.
#[derive(Debug, Clone)]
pub struct TubeSetup {
    /// Its name in tables.
    pub name: &'static str,
    /// Inner radius at rest, m.
    pub radius: f64,
    /// Number of cells.
    pub cells: usize,
    /// Number of time steps.
    pub steps: usize,
    /// The flow.
    pub fluid: TubeFluid,
    /// The wall.
    pub wall: WallSetup,
    /// A factor with which constant relaxation converges.
    pub relaxation: f64,
}

impl TubeSetup {
    /// A femoral artery of 60 mm between a pump and a windkessel: time step 2 ms, a pulse of 0.12 s that widens it by a
    /// tenth. The added mass of the longest wave is about 6 times the wall's stiffness.
    pub fn artery() -> Self {
        let cells = 40;
        Self {
            name: "artery",
            radius: 3e-3,
            cells,
            steps: 60,
            fluid: TubeFluid {
                density: 1050.0,
                viscosity: 3.5e-3 / 1050.0,
                time_step: 2e-3,
                cell: 0.06 / cells as f64,
                inlet: Inlet::Flow(|t| 2e-5 * (PI * t / 0.12).sin().powi(2)),
                outlet: Outlet::Windkessel {
                    resistance: 2.85e9,
                    compliance: 1.2e-10,
                },
            },
            wall: WallSetup {
                stiffness: 4e7,
                tension: 100.0,
                mass: 1.0,
            },
            relaxation: 0.2,
        }
    }

    /// The tube of a much-used three-dimensional benchmark (radius 5 mm, wall 1 mm, length 50 mm, E 3e5 Pa, nu 0.3,
    /// 1200 kg/m³): 1333.2 Pa at the inlet for 3 ms, time step 0.1 ms. Inertia of the wall dominates its stiffness, and
    /// the added mass both.
    pub fn pressure_pulse() -> Self {
        let cells = 40;
        Self {
            name: "pressure pulse",
            radius: 5e-3,
            cells,
            steps: 100,
            fluid: TubeFluid {
                density: 1000.0,
                viscosity: 3e-6,
                time_step: 1e-4,
                cell: 0.05 / cells as f64,
                inlet: Inlet::Pressure(|t| if t < 3.05e-3 { 1333.2 } else { 0.0 }),
                outlet: Outlet::Pressure(0.0),
            },
            // Lamé's thick ring without axial stress, 1.03e7 Pa/m, and its mass per area of the inner surface.
            wall: WallSetup {
                stiffness: 3e5 / 5e-3 / (61.0 / 11.0 + 0.3),
                tension: 100.0,
                mass: 1.32,
            },
            relaxation: 0.08,
        }
    }

    fn wall(&self) -> StringWall {
        StringWall::at_rest(self.wall, self.cells, self.fluid.cell, self.fluid.time_step)
    }

    fn flow(&self) -> Flow {
        Flow::at_rest(self.fluid, &vec![self.radius; self.cells])
    }
}

/// The tube in a partitioned computation: the flow sees radii, the wall pressures.
#[derive(Debug, Clone)]
pub struct PartitionedTube {
    setup: TubeSetup,
    flow: Flow,
    wall: StringWall,
}

impl PartitionedTube {
    /// The tube at rest.
    pub fn new(setup: TubeSetup) -> Self {
        let (flow, wall) = (setup.flow(), setup.wall());
        Self { setup, flow, wall }
    }

    /// Radial directions of the points of a ring.
    fn directions() -> impl Iterator<Item = Vec3> {
        (0..RING).map(|k| {
            let (sin, cos) = (TAU * k as f64 / RING as f64).sin_cos();
            Vec3::new(0.0, cos, sin)
        })
    }

    /// Reference positions of the wall's points, m: a ring in the middle of each cell.
    pub fn points(&self) -> Vec<Vec3> {
        let cell = self.setup.fluid.cell;
        (0..self.setup.cells)
            .flat_map(|i| {
                let centre = Vec3::new((i as f64 + 0.5) * cell, 0.0, 0.0);
                Self::directions().map(move |e| (centre, e))
            })
            .map(|(centre, e)| centre + self.setup.radius * e)
            .collect()
    }

    /// Displacement of all points for a radial displacement of each ring.
    fn spread(radial: &[f64]) -> DVector<f64> {
        let vectors = radial
            .iter()
            .flat_map(|x| Self::directions().map(move |e| *x * e));
        DVector::from_vec(vectors.flat_map(|v| [v.x, v.y, v.z]).collect())
    }

    /// Radius of each ring for a displacement of all points, m.
    fn radii(&self, d: &DVector<f64>) -> Vec<f64> {
        let rings = d.as_slice().chunks_exact(3 * RING);
        rings
            .map(|ring| {
                let vectors = ring.chunks_exact(3).map(Vec3::from_column_slice);
                let sum: f64 = vectors
                    .zip(Self::directions())
                    .map(|(v, e)| v.dot(&e))
                    .sum();
                self.setup.radius + sum / RING as f64
            })
            .collect()
    }

    /// A surrogate with at most `most` stations and a wall that is stiffer than the right one by the factor `error`. It
    /// knows nothing of convection.
    pub fn surrogate_of(&self, most: usize, error: f64) -> TubeSurrogate {
        let fluid = &self.setup.fluid;
        let length = self.setup.cells as f64 * fluid.cell;
        let axis = Axis {
            line: SpaceCurve::x_axis(0.0, length),
            length,
        };
        let options = StationOptions {
            shape: SurrogateWall::Elements(1),
            most,
            around: 0,
        };
        let stations = Stations::new(&self.points(), axis, options).expect("points lie on rings");
        let rest = self.setup.wall();
        let points = self.points();
        let answer = |station: usize| {
            let rings = points.iter().step_by(RING);
            let pressure: Vec<f64> = rings
                .map(|x| stations.share(station, stations.place(x)))
                .collect();
            Self::spread(&rest.solve(&pressure)) / error
        };
        let answers: Vec<_> = (0..stations.count()).map(answer).collect();
        let blood = SurrogateBlood {
            density: fluid.density,
            viscosity: fluid.density * fluid.viscosity,
            time_step: fluid.time_step,
            radial_inertia: false,
        };
        let inlet = match fluid.inlet {
            Inlet::Flow(_) => TubeEnd::Flow,
            Inlet::Pressure(_) => TubeEnd::Pressure { rigid_length: 0.0 },
        };
        let outlet = match fluid.outlet {
            Outlet::Pressure(_) => TubeEnd::Pressure { rigid_length: 0.0 },
            Outlet::Windkessel {
                resistance,
                compliance,
            } => TubeEnd::Windkessel {
                proximal: 0.0,
                resistance,
                compliance,
                rigid_length: 0.0,
            },
        };
        TubeSurrogate::new(stations, &answers, Vec::new(), blood, inlet, outlet)
    }
}

impl Reference for PartitionedTube {
    fn name(&self) -> &str {
        self.setup.name
    }

    fn steps(&self) -> usize {
        self.setup.steps
    }

    fn at_rest(&self) -> DVector<f64> {
        Self::spread(&vec![0.0; self.setup.cells])
    }

    fn relaxation(&self) -> f64 {
        self.setup.relaxation
    }

    fn image(&mut self, d: &DVector<f64>) -> DVector<f64> {
        let flow = self.flow.solve(&self.radii(d));
        Self::spread(&self.wall.solve(&flow.pressure))
    }

    fn accept(&mut self, d: &DVector<f64>) {
        let flow = self.flow.solve(&self.radii(d));
        self.wall.accept(self.wall.solve(&flow.pressure));
        self.flow.accept(flow);
    }

    /// At most half as many stations as cells, and a wall that is a fifth too stiff.
    fn surrogate(&self) -> Box<dyn Surrogate> {
        Box::new(self.surrogate_of(self.setup.cells / 2, 1.2))
    }

    fn exact(&self) -> Vec<DVector<f64>> {
        let setup = &self.setup;
        let radius = vec![setup.radius; setup.cells];
        let mut both = Monolithic::new(setup.flow(), setup.wall(), radius);
        (0..setup.steps)
            .map(|_| Self::spread(&both.step()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pressure_pulse_widens_the_tube_as_in_three_dimensions() {
        // Three-dimensional computations with this time step: 1.19e-4 to 1.21e-4 m at 7.0 to 7.1 ms, mid-length. The
        // wave is a little faster here, without the radial inertia of the blood.
        let setup = TubeSetup::pressure_pulse();
        let middle = 3 * RING * setup.cells / 2 + 1;
        let history = PartitionedTube::new(setup).exact();
        let at = |step: &usize| history[*step][middle];
        let peak = (0..history.len())
            .max_by(|a, b| at(a).total_cmp(&at(b)))
            .unwrap();
        assert!((at(&peak) / 1.2e-4 - 1.0).abs() < 0.1, "{:e}", at(&peak));
        assert!((0.1 * (peak + 1) as f64 - 7.05).abs() < 1.0, "{peak}");
    }

    #[test]
    fn a_surrogate_with_the_right_data_foresees_the_interface() {
        // Small displacements: all that is left out is convection.
        let mut tube = PartitionedTube::new(TubeSetup::artery());
        let surrogate = tube.surrogate_of(tube.setup.cells / 2, 1.0);
        let wave = |i: usize| 1e-6 * (PI * (i as f64 + 0.5) / tube.setup.cells as f64).sin();
        let d = PartitionedTube::spread(&(0..tube.setup.cells).map(wave).collect::<Vec<_>>());
        let mut residual = |d: &DVector<f64>| tube.image(d) - d;
        let start = residual(&d);
        let left = residual(&(&d + surrogate.predict(&start)));
        assert!(
            left.norm() < 0.1 * start.norm(),
            "{}",
            left.norm() / start.norm()
        );
    }
}
