//! How far the lumen of a mesh is from the one that a case describes: between the places where the mesh takes its
//! radii.

use crate::case::{Case, Solver};
use crate::geometry::{Span, Vessel};
use crate::lagrange;
use crate::quadrature::Rule;
use std::f64::consts::TAU;

/// Places along each piece that are looked at, and angles at each.
const ALONG: usize = 24;
const AROUND: usize = 8;

/// What a mesh makes of a lumen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Largest difference of a radius from the described one, m.
    pub radius: f64,
    /// The same relative to the described one there.
    pub share: f64,
    /// Arc length of that place, m.
    pub at: f64,
    /// Difference of the volume, relative to the described one.
    pub volume: f64,
}

/// Shares of a radius and of the volume that are reported.
const MUCH: [f64; 2] = [0.03, 0.01];

impl Deviation {
    /// Whether the mesh's lumen is another one than described.
    pub fn is_large(&self) -> bool {
        self.share > MUCH[0] || self.volume.abs() > MUCH[1]
    }

    /// How far the lumen of a case, as its blood's mesh has it, is from what is described; `None` without a vessel.
    pub fn of_lumen(case: &Case) -> Option<Self> {
        let keys = case.vessel()?;
        let vessel = Vessel::new(keys);
        Some(match case.fluid.solver {
            Solver::Native => {
                let native = &keys.fluid.native;
                let nodes = Rule::gauss_lobatto(native.degree + 1).points;
                vessel.deviation(&vessel.spans(native), &nodes)
            }
            Solver::OpenFoam | Solver::External => {
                vessel.deviation(&vessel.spans(&keys.fluid.mesh), &[-1.0, 1.0])
            }
        })
    }
}

impl Vessel {
    /// Of a mesh with these pieces along it, whose radii are polynomials through those at the `nodes` (from -1 to 1) of
    /// each piece.
    pub fn deviation(&self, spans: &[Span], nodes: &[f64]) -> Deviation {
        let mut found = Deviation {
            radius: 0.0,
            share: 0.0,
            at: 0.0,
            volume: 0.0,
        };
        let (mut meshed, mut described) = (0.0, 0.0);
        let weights: Vec<(f64, Vec<f64>)> = (0..ALONG)
            .map(|i| 2.0 * (i as f64 + 0.5) / ALONG as f64 - 1.0)
            .map(|x| (x, lagrange::values(nodes, x)))
            .collect();
        for span in spans {
            let length = (span.to - span.from) / span.pieces as f64;
            for piece in 0..span.pieces {
                let place = |x: f64| span.from + length * (piece as f64 + 0.5 * (1.0 + x));
                for phi in (0..AROUND).map(|j| TAU * j as f64 / AROUND as f64) {
                    let of_nodes = nodes.iter().map(|x| self.lumen_radius(place(*x), phi));
                    let of_nodes: Vec<f64> = of_nodes.collect();
                    for (x, shares) in &weights {
                        let mesh: f64 = shares.iter().zip(&of_nodes).map(|(w, r)| w * r).sum();
                        let wanted = self.lumen_radius(place(*x), phi);
                        meshed += length * mesh.powi(2);
                        described += length * wanted.powi(2);
                        if (mesh - wanted).abs() > found.share * wanted {
                            found.radius = (mesh - wanted).abs();
                            found.share = found.radius / wanted;
                            found.at = place(*x);
                        }
                    }
                }
            }
        }
        found.volume = meshed / described - 1.0;
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Preset;

    fn deviation(set: &[(&str, &str)]) -> Deviation {
        let case = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/S-0.0");
        let set: Vec<_> = set
            .iter()
            .map(|(key, value)| ((*key).into(), (*value).into()))
            .collect();
        let case = Case::load(&case, Preset::Coarse, &set).unwrap();
        Deviation::of_lumen(&case).unwrap()
    }

    /// A jump of the radius is a cone in both fluids meshes and a blend is met.
    #[test]
    fn radius_jump_becomes_a_cone() {
        const JUMP: &[(&str, &str)] = &[
            ("geometry.graft_inner_radius_m", "5e-3"),
            ("geometry.artery_inner_radius_m", "2e-3"),
            ("geometry.blend_length_m", "1e-5"),
        ];
        let native = [JUMP, &[("fluid.solver", "native")]].concat();
        for set in [JUMP, &native] {
            let found = deviation(set);
            assert!(
                found.share > 0.25 && (found.at - 0.03).abs() < 4e-3,
                "{found:?}"
            );
        }
        for solver in ["openfoam", "native"] {
            let found = deviation(&[("fluid.solver", solver)]);
            assert!(
                found.share < 0.01 && found.volume.abs() < 2e-3,
                "{solver}: {found:?}"
            );
        }
    }
}
