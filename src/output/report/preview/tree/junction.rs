//! The junctions, each drawn by itself from across its branches.

use super::super::legend::{self, Overlay};
use super::Drawn;
use crate::Vec3;
use crate::geometry::tree::MeetingPlace;
use crate::output::figure::solid::{DrawnSolid, View};
use crate::output::report::page::{escape, significant};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// Pixels of a picture, and how much larger its letters are than those of the vessel's picture.
const PIXELS: [usize; 2] = [1000, 700];
const LETTERS: f64 = 2.0;
/// How far around its centre a junction is drawn, in radii of the parent.
const REACH: f64 = 3.5;
/// Most junctions that are drawn: those with the worst cells.
const MOST: usize = 12;

/// A place where branches meet.
pub struct Junction<'a> {
    place: MeetingPlace<'a>,
    reach: f64,
    /// The smallest scaled Jacobian of the cells around it.
    jacobian: f64,
}

impl Drawn<'_> {
    /// Those that are drawn, and how many there are.
    pub fn junctions(&self) -> (Vec<Junction<'_>>, usize) {
        let qualities = self.tree.qualities();
        let places = self.tree.meeting_places().into_iter();
        let junctions = places.map(|place| {
            let reach = REACH * place.radius;
            let near = qualities
                .iter()
                .filter(|(_, x)| (x - place.centre).norm() < reach);
            Junction {
                jacobian: near.map(|(jacobian, _)| *jacobian).fold(1.0, f64::min),
                place,
                reach,
            }
        });
        let mut found: Vec<Junction> = junctions.collect();
        let count = found.len();
        if count > MOST {
            found.sort_by(|a, b| a.jacobian.total_cmp(&b.jacobian));
            found.truncate(MOST);
        }
        (found, count)
    }

    /// A figure of a junction.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn junction(&self, junction: &Junction<'_>) -> std::io::Result<String> {
        let ball = (junction.place.centre, junction.reach);
        let sections = self.tree.stacks().iter().flat_map(|stack| &stack.sections);
        let rims = sections.flat_map(|section| section.rim.iter().copied());
        let around: Vec<Vec3> = rims.filter(|x| (x - ball.0).norm() < ball.1).collect();
        let downstream = junction.place.downstream();
        let view = View::across(&around).with_to_the_right(&downstream);
        let drawing = self.drawing(&view.eye(), Some(ball));
        let colours = self.colours();
        let solid = DrawnSolid {
            points: &drawing.points,
            triangles: &drawing.triangles,
            colour: &|triangle, _, _| colours[drawing.parts[triangle]],
            lines: &drawing.lines,
        };
        let image = solid.pixels(&view, PIXELS);
        let is_near = |(_, x, _): &(f64, Vec3, usize)| (x - ball.0).norm() < ball.1;
        let worst = self.worst.iter().enumerate();
        let marked = worst.filter(|(_, place)| is_near(place));
        let marked: Vec<(usize, Vec3)> = marked.map(|(i, (_, x, _))| (i + 1, *x)).collect();
        let overlay = Overlay {
            flow: None,
            marked: &marked,
            names: &[],
            letters: LETTERS,
        };
        let png = legend::with_legend(&overlay, &image, PIXELS, &solid.projection(&view, PIXELS))?;
        let mut caption = self.tree.told(&junction.place, &self.keys.branches());
        let alternative = escape(&caption);
        if self.is_meshed() {
            let _ = write!(
                caption,
                " Smallest scaled Jacobian: {}.",
                significant(junction.jacobian, 2)
            );
        }
        Ok(format!(
            "<figure>\n<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n<figcaption>{}</figcaption>\n</figure>\n",
            alternative,
            STANDARD.encode(png),
            escape(&caption)
        ))
    }
}
