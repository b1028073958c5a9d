//! A cross-section in the middle of a branch: the cells of the blood, or where a plane cuts the two meshes of a wall.

use super::super::{colour, html_colour, round_length};
use super::drawing::PIECES;
use super::{Drawn, LUMEN};
use crate::Vec3;
use crate::geometry::tree::Stack;
use crate::output::report::page::escape;
use fsi_numerics::twelve_digits;
use std::fmt::Write;

/// Width of a drawing, and of its margin.
const SIDE: f64 = 300.0;
const MARGIN: f64 = 16.0;
/// What of a wall is cut lies within so many radii of the lumen.
const NEAR: f64 = 1.8;
/// A face lies along the plane from this cosine between their normals on.
const ALONG: f64 = 0.7;

/// Where a cross-section lies, and how large it is drawn.
struct Plane {
    /// In its middle, m.
    centre: Vec3,
    /// To the right and upwards.
    axes: [Vec3; 2],
    /// Largest radius of the lumen, m.
    widest: f64,
    /// Pixels of a metre.
    scale: f64,
}

impl Plane {
    /// Across the middle of a branch, with room for `reach` radii.
    fn of(stack: &Stack, reach: f64) -> Self {
        let section = &stack.sections[stack.sections.len() / 2];
        let first = (section.rim[0] - section.centre).normalize();
        let quarter = section.rim[section.rim.len() / 4] - section.centre;
        let second = (quarter - first * first.dot(&quarter)).normalize();
        let arms = section.rim.iter().map(|x| (x - section.centre).norm());
        let widest = arms.fold(0.0, f64::max);
        Self {
            centre: section.centre,
            axes: [first, second],
            widest,
            scale: (0.5 * SIDE - 2.0 * MARGIN) / (reach * widest),
        }
    }

    fn normal(&self) -> Vec3 {
        self.axes[0].cross(&self.axes[1])
    }

    fn at(&self, x: &Vec3) -> String {
        let [right, up] = self
            .axes
            .map(|axis| self.scale * axis.dot(&(x - self.centre)));
        format!("{:.2},{:.2}", 0.5 * SIDE + right, 0.5 * SIDE - up)
    }

    /// Where the plane cuts a polygon, if it does.
    fn cut(&self, corners: &[Vec3]) -> Option<[Vec3; 2]> {
        let normal = self.normal();
        let height = |x: &Vec3| normal.dot(&(x - self.centre));
        let next = corners.iter().cycle().skip(1);
        let mut ends = corners.iter().zip(next).filter_map(|(a, b)| {
            let (low, high) = (height(a), height(b));
            ((low < 0.0) != (high < 0.0)).then(|| a + (b - a) * (low / (low - high)))
        });
        Some([ends.next()?, ends.next()?])
    }

    /// The drawing of this content, with a scale and the `name` of the branch.
    fn drawing(&self, content: &str, name: &str) -> String {
        let bar = round_length(0.5 * self.widest);
        let (x, y, long) = (10.0, SIDE - 9.0, bar * self.scale);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{SIDE}\" height=\"{SIDE}\" viewBox=\"0 0 {SIDE} {SIDE}\" \
             font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" \
             fill=\"white\"/>\n{content}<path d=\"M{x} {y}h{long:.2}\" stroke=\"black\" stroke-width=\"2\"/>\n\
             <text x=\"{:.2}\" y=\"{}\">{} mm</text>\n<text x=\"10\" y=\"16\">{}</text>\n</svg>\n",
            x + long + 6.0,
            y + 4.0,
            twelve_digits(1e3 * bar),
            escape(name)
        )
    }
}

impl Drawn<'_> {
    /// The cells in the cross-section in the middle of a branch.
    pub fn section(&self, stack: &Stack) -> String {
        let plane = Plane::of(stack, 1.0);
        let grid = self.tree.grid();
        let points = grid.positions(&stack.sections[stack.sections.len() / 2], 1.0);
        let mut cells = String::new();
        for quad in grid.quads() {
            let _ = write!(cells, "M{}Z", quad.map(|i| plane.at(&points[i])).join("L"));
        }
        let cells = format!(
            "<path d=\"{cells}\" fill=\"{}\" stroke=\"#a33\" stroke-width=\"0.5\"/>\n",
            html_colour(LUMEN)
        );
        plane.drawing(&cells, &self.branch(stack))
    }

    /// Where the plane across the middle of a branch cuts the faces of both meshes of the wall, its elements and the
    /// patch of the blood's.
    pub fn cut(&self, stack: &Stack) -> String {
        let plane = Plane::of(stack, 1.3);
        let is_near = |x: &Vec3| (x - plane.centre).norm() < NEAR * plane.widest;
        let mut layers = vec![String::new(); self.names.len()];
        let add = |corners: &[Vec3], path: &mut String| {
            if let Some(ends) = plane.cut(corners) {
                let _ = write!(path, "M{}L{}", plane.at(&ends[0]), plane.at(&ends[1]));
            }
        };
        let mesh = &self.domain.solid;
        for e in (0..mesh.hexes.len()).filter(|e| is_near(&mesh.shape.position(*e, [0.0; 3]))) {
            for (axis, upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
                let at = self.lattice(e, axis, upper);
                let n = PIECES + 1;
                // A face along the plane is not cut across.
                let normal = (at[n * n - 1] - at[0]).cross(&(at[n * n - n] - at[PIECES]));
                if plane.normal().dot(&normal).abs() > ALONG * normal.norm() {
                    continue;
                }
                for k in (0..n * n).filter(|k| k % n < PIECES && k / n < PIECES) {
                    let corners = [k, k + 1, k + n + 1, k + n].map(|k| at[k]);
                    add(&corners, &mut layers[mesh.regions[e]]);
                }
            }
        }
        let mut content = String::new();
        for (i, path) in layers.iter().enumerate() {
            let colour = html_colour(colour(i));
            let _ = writeln!(
                content,
                "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"2\"/>"
            );
        }
        let mut lumen = String::new();
        let surface = self.domain.surface();
        for name in &self.domain.wet_patches {
            for face in surface.patch_faces(name) {
                let corners: Vec<Vec3> = face.iter().map(|i| surface.points[*i]).collect();
                if corners.iter().all(is_near) {
                    add(&corners, &mut lumen);
                }
            }
        }
        let _ = writeln!(
            content,
            "<path d=\"{lumen}\" stroke=\"#a00\" stroke-width=\"1\"/>"
        );
        plane.drawing(&content, &self.branch(stack))
    }
}
