//! Stresses and strains of the wall as they stand in VTU files.

use super::vtu::Values;
use crate::pfem::evaluation::samples::Samples;
use crate::pfem::evaluation::stress::StressState;
use rayon::prelude::*;

/// Fields at the points of a sampler by name.
pub struct StressFields(Vec<(&'static str, Vec<f64>)>);

/// What a field takes from a state.
type StressMeasure = fn(&StressState) -> f64;

/// Of smooth stresses.
const STRESSES: [(&str, StressMeasure); 5] = [
    ("von_mises_Pa", |s| s.von_mises()),
    ("max_principal_stress_Pa", |s| s.principal_stresses()[0]),
    ("min_principal_stress_Pa", |s| s.principal_stresses()[2]),
    ("hoop_stress_Pa", |s| s.hoop_stress()),
    ("axial_stress_Pa", |s| s.axial_stress()),
];

/// As the displacement has them, element by element.
const RAW: [(&str, StressMeasure); 6] = [
    ("von_mises_raw_Pa", |s| s.von_mises()),
    ("max_principal_stress_raw_Pa", |s| s.principal_stresses()[0]),
    ("max_principal_strain", |s| s.principal_strains()[0]),
    ("min_principal_strain", |s| s.principal_strains()[2]),
    ("fibre_stretch_1", |s| s.fibre_stretches[0]),
    ("fibre_stretch_2", |s| s.fibre_stretches[1]),
];

/// All fields of the samples.
pub fn stress_fields(samples: &Samples) -> StressFields {
    let smooth = STRESSES.map(|field| (&samples.smooth, field));
    let raw = RAW.map(|field| (&samples.raw, field));
    let all: Vec<_> = smooth.into_iter().chain(raw).collect();
    let take = |(states, (name, measure)): (&Vec<StressState>, (&'static str, StressMeasure))| {
        (name, states.iter().map(measure).collect())
    };
    StressFields(all.into_par_iter().map(take).collect())
}

impl StressFields {
    /// Displacement and fields for a grid.
    pub fn point_data<'a>(&'a self, samples: &'a Samples) -> Vec<(&'a str, Values<'a>)> {
        let fields = self
            .0
            .iter()
            .map(|(name, values)| (*name, Values::Scalars(values)));
        std::iter::once(("displacement_m", Values::Vectors(&samples.displacement)))
            .chain(fields)
            .collect()
    }
}
