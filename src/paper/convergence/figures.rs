//! Figures 7 to 10 of the paper from the rows of the study, and one more on the limits that mappings set.

use crate::output::figure::{Curve, Figure, Marker, Panel, Scale};
use crate::paper::convergence::cases::{Mesh, TestCase};
use crate::paper::convergence::plan::Choice;
use crate::paper::convergence::table::ConvergenceRow;
use crate::pfem::SpaceKind::{self, TensorProduct, Trunk};
use crate::pfem::element::mapping::MappingKind;
use std::io;
use std::path::Path;

/// Highest degree that a curve may have.
const MOST: usize = 12;

/// A measure of the error: its column, and how axes name it.
type ErrorMeasure = (fn(&ConvergenceRow) -> f64, &'static str);

const ENERGY: ErrorMeasure = (|row| row.e_E.abs(), "strain energy |e_{E}|");
const DISPLACEMENT: ErrorMeasure = (|row| row.e_d, "displacement e_{d}");
const STRESS: ErrorMeasure = (|row| row.e_sv, "von Mises stress e_{σv}");

/// Draws the figures of the test cases that have rows.
pub fn write(rows: &[ConvergenceRow], folder: &Path) -> io::Result<()> {
    #[rustfmt::skip]
    let figures = [
        (TestCase::Circular, "figure-07-circular-energy", figure_7(rows), 2),
        (TestCase::Circular, "figure-08-circular-fields", figure_8(rows), 2),
        (TestCase::Circular, "figure-mapping-limit", mapping_limit(rows), 2),
        (TestCase::Graft, "figure-09-graft", figure_9(rows), 3),
        (TestCase::Irregular, "figure-10-irregular", figure_10(rows), 3),
    ];
    for (case, name, panels, columns) in figures {
        if rows.iter().any(|row| row.test_case == case) {
            Figure { panels, columns }.write(&folder.join(name))?;
        }
    }
    Ok(())
}

fn figure_7(rows: &[ConvergenceRow]) -> Vec<Panel> {
    let case = TestCase::Circular;
    let panel = |mesh: Mesh, space: SpaceKind, increased: bool| {
        let quadrature = move |c: Choice| if increased { c.increased() } else { c };
        let isotropic = move |p| Some(quadrature(Choice::isotropic(case, mesh, space, p)));
        let mut curves = vec![curve(rows, ENERGY.0, 0, "p_{T} = p", isotropic)];
        for p_thickness in 1..=4 {
            curves.push(curve(
                rows,
                ENERGY.0,
                p_thickness,
                &format!("p_{{T}} = {p_thickness}"),
                move |p| {
                    isotropic(p)
                        .filter(|_| p >= p_thickness)
                        .map(|c| c.thickness(p_thickness))
                },
            ));
        }
        let quadrature = match (space, increased) {
            (TensorProduct, _) => "",
            (Trunk, false) => ", p + 1 Gauss points",
            (Trunk, true) => ", p + 3 Gauss points",
        };
        let title = format!("{}, {}{quadrature}", name(space), size(mesh));
        panel(title, ENERGY, curves)
    };
    vec![
        panel(Mesh::Initial, TensorProduct, false),
        panel(Mesh::Refined, TensorProduct, false),
        panel(Mesh::Initial, Trunk, false),
        panel(Mesh::Initial, Trunk, true),
    ]
}

fn figure_8(rows: &[ConvergenceRow]) -> Vec<Panel> {
    let series = [
        (Trunk, Mesh::Initial),
        (Trunk, Mesh::Refined),
        (TensorProduct, Mesh::Initial),
        (TensorProduct, Mesh::Refined),
    ];
    [DISPLACEMENT, STRESS]
        .map(|measure| {
            let curves = series.iter().enumerate().map(|(i, &(space, mesh))| {
                let label = format!("{}, {}", name(space), size(mesh));
                let drawn = curve(rows, measure.0, 1 + i / 2, &label, move |p| {
                    Some(Choice::isotropic(TestCase::Circular, mesh, space, p))
                });
                opened(drawn, mesh == Mesh::Refined)
            });
            panel("circular shaped artery".into(), measure, curves.collect())
        })
        .into()
}

fn figure_9(rows: &[ConvergenceRow]) -> Vec<Panel> {
    let isotropic = |space, mesh| move |p| Some(Choice::isotropic(TestCase::Graft, mesh, space, p));
    [ENERGY, DISPLACEMENT, STRESS]
        .map(|measure| {
            let of = measure.0;
            let curves = vec![
                curve(rows, of, 1, "trunk space", isotropic(Trunk, Mesh::Initial)),
                curve(
                    rows,
                    of,
                    2,
                    "tensor product space",
                    isotropic(TensorProduct, Mesh::Initial),
                ),
                opened(
                    curve(
                        rows,
                        of,
                        1,
                        "trunk space, refined",
                        isotropic(Trunk, Mesh::Refined),
                    ),
                    true,
                ),
                curve(rows, of, 3, "trunk space, p_{T} = 3", |p| {
                    let choice = Choice::isotropic(TestCase::Graft, Mesh::Initial, Trunk, p);
                    (p >= 3).then(|| choice.thickness(3))
                }),
            ];
            panel("idealized bypass graft".into(), measure, curves)
        })
        .into()
}

fn figure_10(rows: &[ConvergenceRow]) -> Vec<Panel> {
    let isotropic =
        |space, mesh| move |p| Some(Choice::isotropic(TestCase::Irregular, mesh, space, p));
    [ENERGY, DISPLACEMENT, STRESS]
        .map(|measure| {
            let of = measure.0;
            let curves = vec![
                curve(
                    rows,
                    of,
                    1,
                    "trunk space, 2 × 4 × 2",
                    isotropic(Trunk, Mesh::Initial),
                ),
                opened(
                    curve(
                        rows,
                        of,
                        1,
                        "trunk space, 4 × 8 × 4",
                        isotropic(Trunk, Mesh::Refined),
                    ),
                    true,
                ),
                opened(
                    curve(
                        rows,
                        of,
                        2,
                        "tensor product, 4 × 8 × 4",
                        isotropic(TensorProduct, Mesh::Refined),
                    ),
                    true,
                ),
                curve(rows, of, 3, "trunk, 2 × 4 × 2, exact shape", |p| {
                    let choice = Choice::isotropic(TestCase::Irregular, Mesh::Initial, Trunk, p);
                    Some(choice.mapped(MappingKind::Exact))
                }),
            ];
            panel("irregular shaped artery".into(), measure, curves)
        })
        .into()
}

fn mapping_limit(rows: &[ConvergenceRow]) -> Vec<Panel> {
    let trunk = |p| Choice::isotropic(TestCase::Circular, Mesh::Initial, Trunk, p).increased();
    [ENERGY, DISPLACEMENT]
        .map(|measure| {
            let mut curves = vec![curve(rows, measure.0, 0, "p_{G} = p", move |p| {
                Some(trunk(p))
            })];
            for degree in 2..=5 {
                curves.push(curve(
                    rows,
                    measure.0,
                    degree - 1,
                    &format!("p_{{G}} = {degree}"),
                    move |p| (p >= degree).then(|| trunk(p).mapped(MappingKind::Blended(degree))),
                ));
            }
            panel(
                "trunk space, 2 × 4 × 2, p + 3 Gauss points".into(),
                measure,
                curves,
            )
        })
        .into()
}

/// The curve through the rows of the choices for p = 1, 2, …
fn curve(
    rows: &[ConvergenceRow],
    measure: fn(&ConvergenceRow) -> f64,
    number: usize,
    label: &str,
    choice: impl Fn(usize) -> Option<Choice>,
) -> Curve {
    let row = |p| choice(p).and_then(|choice| rows.iter().find(|row| row.is_of(&choice)));
    Curve {
        name: label.to_owned(),
        points: (1..=MOST)
            .filter_map(row)
            .map(|row| (row.dofs as f64, measure(row)))
            .collect(),
        colour: number,
        marker: Some(Marker::ALL[number % Marker::ALL.len()]),
        open: false,
    }
}

fn opened(curve: Curve, open: bool) -> Curve {
    Curve { open, ..curve }
}

fn panel(title: String, measure: ErrorMeasure, mut curves: Vec<Curve>) -> Panel {
    curves.retain(|curve| !curve.points.is_empty());
    Panel {
        title,
        x_label: "degrees of freedom".into(),
        y_label: format!("relative error of {}", measure.1),
        scales: [Scale::Logarithmic; 2],
        curves,
    }
}

fn name(space: SpaceKind) -> &'static str {
    match space {
        Trunk => "trunk space",
        TensorProduct => "tensor product space",
    }
}

fn size(mesh: Mesh) -> &'static str {
    match mesh {
        Mesh::Initial => "2 × 4 × 2",
        Mesh::Refined => "4 × 8 × 4",
    }
}
