//! The rows of `convergence.csv`.

use super::Computed;
use super::cases::TestCase;
use super::errors::Errors;
use super::plan::{Choice, Quadrature};
use crate::pfem::SpaceKind;
use crate::pfem::element::mapping::MappingKind;
use serde::{Deserialize, Serialize};

/// A row: a discretization, its errors and its cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct ConvergenceRow {
    /// `circular`, `graft` or `irregular`.
    pub test_case: TestCase,
    /// `trunk` or `tensor_product`.
    pub space: SpaceKind,
    /// Degree along the axis and around the circumference.
    pub p: usize,
    /// Degree through the wall.
    pub p_T: usize,
    /// `2x4x2` or `4x8x4`: axial, circumferential, radial.
    pub mesh: String,
    /// `standard` (degree + 1 points in each direction) or `increased` (degree + 3).
    pub quadrature: String,
    /// Degree of the mapping along the edges, or `exact`.
    pub p_G: String,
    /// Displacement coefficients, held ones included.
    pub dofs: usize,
    /// Strain energy, at four more points per direction than the degree.
    pub strain_energy_J: f64,
    /// Error of the strain energy (15), with its sign.
    pub e_E: f64,
    /// Error of the displacements (15), (16).
    pub e_d: f64,
    /// Error of the von Mises stresses (15), (16).
    pub e_sv: f64,
    /// Newton iterations in this discretization: of all load steps, or, from p = 5 on, those after a start from a lower
    /// degree.
    pub newton_iterations: usize,
    /// Wall-clock seconds of these iterations in residuals and tangents.
    pub assembly_s: f64,
    /// Wall-clock seconds of these iterations in factorizations and substitutions.
    pub solve_s: f64,
    /// Largest memory of the process during this computation.
    pub peak_memory_MB: f64,
}

/// Case, space, mesh, quadrature, whether degrees differ, `p_G`, `p_T`, `p`.
type Order<'a> = (&'a str, &'a str, &'a str, bool, bool, usize, usize, usize);

impl ConvergenceRow {
    /// The row of a computed choice.
    pub fn new(choice: &Choice, computed: &Computed, errors: &Errors, peak_memory: f64) -> Self {
        let stats = &computed.stats;
        Self {
            test_case: choice.case,
            space: choice.space,
            p: choice.p,
            p_T: choice.p_thickness,
            mesh: choice.mesh.name().to_owned(),
            quadrature: choice.quadrature.name().to_owned(),
            p_G: mapping(choice.mapping),
            dofs: computed.dofs,
            strain_energy_J: computed.solution.energy,
            e_E: errors.energy,
            e_d: errors.displacement,
            e_sv: errors.von_mises,
            newton_iterations: stats.iterations,
            assembly_s: stats.assembly_s + stats.residual_s,
            solve_s: stats.factorization_s + stats.substitution_s,
            peak_memory_MB: peak_memory,
        }
    }

    /// What rows are sorted by.
    pub fn order(&self) -> Order<'_> {
        let space = self.space.name();
        let varied = self.p_T != self.p || self.p_G != self.p.to_string();
        let geometry = match self.p_G.parse() {
            Ok(degree) if degree == self.p => 0,
            Ok(degree) => degree,
            Err(_) => usize::MAX,
        };
        let thickness = if self.p_T == self.p { 0 } else { self.p_T };
        let mesh = self.mesh.as_str();
        let more = self.quadrature != Quadrature::Standard.name();
        (
            self.test_case.name(),
            space,
            mesh,
            more,
            varied,
            geometry,
            thickness,
            self.p,
        )
    }

    /// Whether this is the row of a choice.
    pub fn is_of(&self, choice: &Choice) -> bool {
        self.test_case == choice.case
            && self.space == choice.space
            && (self.p, self.p_T) == (choice.p, choice.p_thickness)
            && self.mesh == choice.mesh.name()
            && self.quadrature == choice.quadrature.name()
            && self.p_G == mapping(choice.mapping)
    }
}

fn mapping(kind: MappingKind) -> String {
    match kind {
        MappingKind::Blended(degree) => degree.to_string(),
        MappingKind::Exact => "exact".to_owned(),
    }
}
