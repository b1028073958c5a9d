//! Blood in one dimension: a flow solver that fits on two pages.

use fsi_driver::Vec3;
use fsi_driver::case::Case;
use fsi_driver::fluid::{
    Fluid, FluidCost, FluidEffort, FluidError, FluidInterface, FluidMemory, FluidStep, FluidTrial,
    OpeningReport, Wanted,
};
use std::f64::consts::{PI, TAU};

/// Points on a ring of the wall.
const AROUND: usize = 16;
/// Cells along the tube.
const CELLS: usize = 24;
/// Inflow at its peak, m³/s, and when that is, s.
const PEAK: (f64, f64) = (1e-5, 1e-3);

/// Flow through a straight tube along x, from a pump into an open end, by implicit Euler:
/// ```text
/// ∂A/∂t + ∂Q/∂x = 0,        ρ ∂Q/∂t + A ∂p/∂x + 8 π μ Q/A = 0
/// ```
/// (continuity, and momentum with the friction of Poiseuille's profile, without convection). The wall prescribes the
/// areas `A` at the rings between the cells; so the flow `Q` follows from the inlet on, then the pressure `p` from the
/// outlet back, without a system of equations.
pub struct OneDimensionalFluid {
    interface: FluidInterface,
    density: f64,
    viscosity: f64,
    /// Length of a cell, m.
    cell: f64,
    /// At the end of the last accepted step.
    state: State,
    /// At the end of the step that is being solved.
    trial: Option<State>,
}

/// The flow at some time.
#[derive(Clone)]
struct State {
    /// s
    time: f64,
    /// Area of each cell, m².
    area: Vec<f64>,
    /// Flow into the tube and out of each cell, m³/s.
    flow: Vec<f64>,
    /// Pressure in each cell, Pa.
    pressure: Vec<f64>,
}

impl OneDimensionalFluid {
    /// Blood at rest in the deformable part of a case.
    pub fn new(case: &Case) -> Self {
        let geometry = &case.anastomosis().expect("the paper's vessel").geometry;
        let radius = geometry.graft_inner_radius;
        let cell = (geometry.graft_length + geometry.artery_length) / CELLS as f64;
        let point = |ring: f64, j: f64| {
            let (sin, cos) = (TAU * j / AROUND as f64).sin_cos();
            Vec3::new(ring * cell, radius * cos, radius * sin)
        };
        let rings = (0..=CELLS).flat_map(|i| (0..AROUND).map(move |j| (i as f64, j as f64)));
        let faces = (0..CELLS).flat_map(|i| (0..AROUND).map(move |j| (i, j)));
        let number = |i: usize, j: usize| (i * AROUND + j % AROUND) as u32;
        let interface = FluidInterface {
            points: rings.map(|(i, j)| point(i, j)).collect(),
            // By the right-hand rule their normals point out of the blood.
            faces: (faces.clone())
                .map(|(i, j)| {
                    vec![
                        number(i, j + 1),
                        number(i + 1, j + 1),
                        number(i + 1, j),
                        number(i, j),
                    ]
                })
                .collect(),
            face_centres: faces
                .map(|(i, j)| {
                    let [a, b] = [0.0, 1.0].map(|k| point(i as f64 + 0.5, j as f64 + k));
                    0.5 * (a + b)
                })
                .collect(),
        };
        let mut fluid = Self {
            interface,
            density: case.blood.density,
            viscosity: case.blood.viscosity,
            cell,
            state: State {
                time: 0.0,
                area: Vec::new(),
                flow: vec![0.0; CELLS + 1],
                pressure: vec![0.0; CELLS],
            },
            trial: None,
        };
        let still = vec![Vec3::zeros(); fluid.interface.points.len()];
        fluid.state.area = fluid.areas(&still);
        fluid
    }

    /// Area of each cell: the mean of the polygons at its two ends.
    fn areas(&self, displacement: &[Vec3]) -> Vec<f64> {
        let moved = self.interface.points.iter().zip(displacement);
        let moved: Vec<Vec3> = moved.map(|(x, u)| x + u).collect();
        let polygon = |ring: &[Vec3]| -> f64 {
            let next = |j: usize| ring[(j + 1) % AROUND];
            (0..AROUND).map(|j| 0.5 * ring[j].cross(&next(j)).x).sum()
        };
        let rings: Vec<f64> = moved.chunks_exact(AROUND).map(polygon).collect();
        rings
            .windows(2)
            .map(|ends| 0.5 * (ends[0] + ends[1]))
            .collect()
    }

    fn volume(&self, state: &State) -> f64 {
        self.cell * state.area.iter().sum::<f64>()
    }
}

/// A single pulse of inflow at a time (s), m³/s.
fn inflow(time: f64) -> f64 {
    PEAK.0 * (0.5 * PI * (time / PEAK.1).min(2.0)).sin().powi(2)
}

impl Fluid for OneDimensionalFluid {
    fn interface(&self) -> &FluidInterface {
        &self.interface
    }

    fn solve(
        &mut self,
        displacement: &[Vec3],
        dt: f64,
        _: FluidEffort,
    ) -> Result<FluidTrial, FluidError> {
        let old = &self.state;
        let area = self.areas(displacement);
        if let Some(i) = area.iter().position(|a| a.is_nan() || *a <= 0.0) {
            return Err(FluidError::NotSolved(format!(
                "the tube has collapsed in cell {i}"
            )));
        }
        let time = old.time + dt;
        let mut flow = vec![inflow(time)];
        for i in 0..CELLS {
            flow.push(flow[i] - self.cell * (area[i] - old.area[i]) / dt);
        }
        // From the middle of a cell to that of the next, and from that of the last one to the open end.
        let mut pressure = vec![0.0; CELLS];
        let mut behind = 0.0;
        for i in (0..CELLS).rev() {
            let length = if i + 1 < CELLS {
                self.cell
            } else {
                0.5 * self.cell
            };
            let (q, a) = (flow[i + 1], area[i]);
            let inertia = self.density * (q - old.flow[i + 1]) / dt;
            behind += length * (inertia + 8.0 * PI * self.viscosity * q / a) / a;
            pressure[i] = behind;
        }
        let radial = |centre: &Vec3| Vec3::new(0.0, centre.y, centre.z).normalize();
        let centres = self.interface.face_centres.iter().enumerate();
        let tractions = centres.map(|(k, centre)| pressure[k / AROUND] * radial(centre));
        let tractions = tractions.collect();
        self.trial = Some(State {
            time,
            area,
            flow,
            pressure,
        });
        Ok(FluidTrial {
            tractions,
            cost: FluidCost {
                sweeps: 1,
                residual: 0.0,
            },
        })
    }

    fn accept(&mut self, _: Wanted) -> Result<FluidStep, FluidError> {
        self.state = (self.trial.take())
            .ok_or_else(|| FluidError::NotSolved("nothing has been solved".into()))?;
        let opening = |name: &str, flow, mean_pressure| OpeningReport {
            name: name.into(),
            flow,
            mean_pressure,
            model_pressure: None,
        };
        let state = &self.state;
        Ok(FluidStep {
            time: state.time,
            openings: vec![
                opening("inlet", state.flow[0], state.pressure[0]),
                opening("outlet", -state.flow[CELLS], 0.0),
            ],
            volume: self.volume(state),
            wall_shear: vec![Vec3::zeros(); self.interface.faces.len()],
            ..FluidStep::default()
        })
    }

    fn memory(&mut self, _: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError> {
        let State {
            time,
            area,
            flow,
            pressure,
        } = &self.state;
        let numbers = [&[*time][..], area, flow, pressure].concat();
        Ok(FluidMemory {
            state: numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
            files: Vec::new(),
        })
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        let numbers: Vec<f64> = (memory.state.as_chunks().0.iter())
            .map(|bytes| f64::from_le_bytes(*bytes))
            .collect();
        if numbers.len() != 3 * CELLS + 2 {
            return Err(FluidError::Died(
                "the stored flow is that of another tube".into(),
            ));
        }
        let (area, flow) = (1 + CELLS, 2 + 2 * CELLS);
        self.state = State {
            time: numbers[0],
            area: numbers[1..area].to_vec(),
            flow: numbers[area..flow].to_vec(),
            pressure: numbers[flow..].to_vec(),
        };
        self.trial = None;
        Ok(())
    }
}
