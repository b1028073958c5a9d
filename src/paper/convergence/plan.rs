//! Which discretizations are computed, for which figure.

use super::cases::{Mesh, TestCase};
use crate::pfem::discretization::Options;
use crate::pfem::element::mapping::MappingKind;
use crate::pfem::{Formulation, Space, SpaceKind};

/// Degree of the reference solutions, which are in the trunk space: in the tensor product space one of this degree
/// needs more than 20 GB on the initial mesh already.
pub const REFERENCE_DEGREE: usize = 10;

/// How many Gauss points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quadrature {
    /// In each direction one more than the degree.
    Standard,
    /// In each direction three more than the degree.
    Increased,
}

impl Quadrature {
    /// Name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Quadrature::Standard => "standard",
            Quadrature::Increased => "increased",
        }
    }
}

/// One discretization of a test case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Choice {
    /// The tube.
    pub case: TestCase,
    /// The mesh.
    pub mesh: Mesh,
    /// Trunk or tensor product.
    pub space: SpaceKind,
    /// Degree along the axis and around the circumference.
    pub p: usize,
    /// Degree through the wall.
    pub p_thickness: usize,
    /// Quadrature.
    pub quadrature: Quadrature,
    /// Shape of the elements.
    pub mapping: MappingKind,
}

impl Choice {
    /// The same degree everywhere, the mapping's included, and standard quadrature.
    pub fn isotropic(case: TestCase, mesh: Mesh, space: SpaceKind, p: usize) -> Self {
        Self {
            case,
            mesh,
            space,
            p,
            p_thickness: p,
            quadrature: Quadrature::Standard,
            mapping: MappingKind::Blended(p),
        }
    }

    /// With another degree through the wall.
    pub fn thickness(self, p_thickness: usize) -> Self {
        Self {
            p_thickness,
            ..self
        }
    }

    /// With increased quadrature.
    pub fn increased(self) -> Self {
        Self {
            quadrature: Quadrature::Increased,
            ..self
        }
    }

    /// With another mapping.
    pub fn mapped(self, mapping: MappingKind) -> Self {
        Self { mapping, ..self }
    }

    /// Space, mapping and quadrature.
    pub fn options(&self) -> Options {
        let degrees = [self.p, self.p, self.p_thickness];
        let more = match self.quadrature {
            Quadrature::Standard => 1,
            Quadrature::Increased => 3,
        };
        let space = Space {
            kind: self.space,
            degrees,
        };
        Options {
            mapping: self.mapping,
            quadrature_points: degrees.map(|p| p + more),
            formulation: Formulation::Displacement,
            ..Options::new(space)
        }
    }

    /// Seconds that the computation may take, up to a factor that depends on the machine: assembly of all elements and
    /// factorization, both as measured on one machine.
    pub fn work(&self) -> f64 {
        let grid = self.case.tube(self.mesh).grid;
        let elements = (grid.axial * grid.circumferential * grid.radial()) as f64;
        let modes = self.options().space.modes().len() as f64;
        // The share of an element's modes that it does not leave to its neighbours, on average.
        let share = match self.space {
            SpaceKind::Trunk => 0.55,
            SpaceKind::TensorProduct => 0.75,
        };
        let dofs = 3.0 * share * modes * elements;
        let degree = self.p.max(self.p_thickness) as f64;
        let iteration = 8e-8 * elements * modes.powi(2) * degree + 5e-9 * dofs.powi(2);
        let iterations = match self.case {
            _ if self.p >= super::DIRECT => 5.0,
            TestCase::Irregular => 25.0,
            _ => 16.0,
        };
        0.1 + iterations * iteration
    }
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let space = match self.space {
            SpaceKind::Trunk => "trunk space",
            SpaceKind::TensorProduct => "tensor product space",
        };
        write!(
            f,
            "{} {}, {space}, p = {}",
            self.case.name(),
            self.mesh.name(),
            self.p
        )?;
        if self.p_thickness != self.p {
            write!(f, ", p_T = {}", self.p_thickness)?;
        }
        if self.quadrature == Quadrature::Increased {
            f.write_str(", more quadrature points")?;
        }
        match self.mapping {
            MappingKind::Blended(degree) if degree != self.p => write!(f, ", p_G = {degree}"),
            MappingKind::Exact => f.write_str(", exact mapping"),
            MappingKind::Blended(_) => Ok(()),
        }
    }
}

/// The reference of a test case and what is compared with it.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The reference.
    pub reference: Choice,
    /// The others, cheap ones first.
    pub choices: Vec<Choice>,
}

impl Plan {
    /// The full study of a test case, or a short one with low degrees.
    pub fn new(case: TestCase, quick: bool) -> Self {
        use Mesh::{Initial, Refined};
        use SpaceKind::{TensorProduct, Trunk};
        let limit = |full: usize, short: usize| if quick { short } else { full };
        let series = |mesh: Mesh, space: SpaceKind, last: usize| {
            (1..=last).map(move |p| Choice::isotropic(case, mesh, space, p))
        };
        let mut choices: Vec<Choice> = Vec::new();
        match case {
            TestCase::Circular => {
                // Figure 7.
                for p_thickness in 1..=4 {
                    let thinner = move |choice: Choice| choice.thickness(p_thickness);
                    let higher = move |choice: &Choice| choice.p > p_thickness;
                    let initial = series(Initial, TensorProduct, limit(8, 5));
                    choices.extend(initial.filter(higher).map(thinner));
                    let refined = series(Refined, TensorProduct, limit(5, 0));
                    choices.extend(refined.filter(higher).map(thinner));
                    for choice in series(Initial, Trunk, limit(8, 5)).filter(higher) {
                        choices.extend([thinner(choice), thinner(choice).increased()]);
                    }
                }
                choices.extend(series(Initial, Trunk, limit(9, 6)).map(Choice::increased));
                // The limits that mappings of low degree set.
                for degree in 2..=5 {
                    let fixed = |c: Choice| c.mapped(MappingKind::Blended(degree)).increased();
                    let higher = series(Initial, Trunk, limit(9, 5)).filter(|c| c.p > degree);
                    choices.extend(higher.map(fixed));
                }
                // Figures 7 and 8.
                choices.extend(series(Initial, Trunk, limit(9, 5)));
                choices.extend(series(Initial, TensorProduct, limit(7, 4)));
                choices.extend(series(Refined, Trunk, limit(7, 2)));
                choices.extend(series(Refined, TensorProduct, limit(4, 1)));
            }
            TestCase::Graft => {
                // Figure 9.
                choices.extend(series(Initial, Trunk, limit(9, 5)));
                choices.extend(series(Initial, TensorProduct, limit(7, 3)));
                choices.extend(series(Refined, Trunk, limit(6, 2)));
                let higher = series(Initial, Trunk, limit(8, 4)).filter(|c| c.p > 3);
                choices.extend(higher.map(|c| c.thickness(3)));
            }
            TestCase::Irregular => {
                // Figure 10.
                choices.extend(series(Initial, Trunk, limit(9, 4)));
                choices.extend(series(Refined, Trunk, limit(8, 3)));
                let exact = series(Initial, Trunk, limit(9, 4)).filter(|c| c.p > 1);
                choices.extend(exact.map(|c| c.mapped(MappingKind::Exact)));
                choices.extend(series(Refined, TensorProduct, limit(4, 1)));
            }
        }
        choices.sort_by(|a, b| a.work().total_cmp(&b.work()));
        let reference = match (case, quick) {
            (TestCase::Irregular, false) => {
                Choice::isotropic(case, Refined, Trunk, REFERENCE_DEGREE)
            }
            (_, false) => Choice::isotropic(case, Initial, Trunk, REFERENCE_DEGREE).increased(),
            (TestCase::Irregular, true) => Choice::isotropic(case, Refined, Trunk, 4),
            (_, true) => Choice::isotropic(case, Initial, Trunk, 7).increased(),
        };
        choices.retain(|choice| *choice != reference);
        Self { reference, choices }
    }
}
