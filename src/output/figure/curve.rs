//! Lines through points.

use std::fmt::Write;

/// Colours that stay apart in print and for the colour-blind (Okabe and Ito).
const COLOURS: [&str; 7] = [
    "#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9",
];

/// Shape of the points of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ▼
    Wedge,
}

impl Marker {
    /// All of them, to be given out in turn.
    pub const ALL: [Marker; 5] = [
        Marker::Circle,
        Marker::Square,
        Marker::Triangle,
        Marker::Diamond,
        Marker::Wedge,
    ];
}

/// A line through points.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name in the legend; `_{…}` and `^{…}` lower and raise.
    pub name: String,
    /// Points; those that the scales cannot show are left out.
    pub points: Vec<(f64, f64)>,
    /// Number of the colour.
    pub colour: usize,
    /// Shape of the points; a mere line without.
    pub marker: Option<Marker>,
    /// Whether line and points are open: dashed and white inside.
    pub open: bool,
}

impl Curve {
    pub(super) fn draw(&self, at: &[(f64, f64)], svg: &mut String) {
        self.line(at, svg);
        if let Some(marker) = self.marker {
            at.iter().for_each(|&point| self.mark(marker, point, svg));
        }
    }

    fn colour(&self) -> &'static str {
        COLOURS[self.colour % COLOURS.len()]
    }

    pub(super) fn line(&self, at: &[(f64, f64)], svg: &mut String) {
        let points: Vec<String> = at.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let dashes = if self.open {
            " stroke-dasharray=\"5 3\""
        } else {
            ""
        };
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"{dashes}/>",
            points.join(" "),
            self.colour()
        );
    }

    pub(super) fn mark(&self, marker: Marker, (x, y): (f64, f64), svg: &mut String) {
        let r = 3.6;
        let outline: &[(f64, f64)] = match marker {
            Marker::Circle => &[],
            Marker::Square => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Marker::Triangle => &[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)],
            Marker::Diamond => &[(0.0, -1.3), (1.1, 0.0), (0.0, 1.3), (-1.1, 0.0)],
            Marker::Wedge => &[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)],
        };
        let (colour, fill) = (
            self.colour(),
            if self.open { "white" } else { self.colour() },
        );
        let paint = format!("fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"1.2\"");
        if outline.is_empty() {
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" {paint}/>"
            );
        } else {
            let corner = |(a, b): &(f64, f64)| format!("{:.1},{:.1}", x + r * a, y + r * b);
            let corners: Vec<String> = outline.iter().map(corner).collect();
            let _ = writeln!(svg, "<polygon points=\"{}\" {paint}/>", corners.join(" "));
        }
    }
}
