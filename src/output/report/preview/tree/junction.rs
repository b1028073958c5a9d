//! The junctions, each drawn by itself from across its branches.

use super::super::legend::{self, Overlay};
use super::{Drawn, radius};
use crate::Vec3;
use crate::geometry::tree::Stack;
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

/// Where branches meet.
pub struct Junction<'a> {
    parent: &'a Stack,
    daughters: Vec<&'a Stack>,
    centre: Vec3,
    reach: f64,
    /// The smallest scaled Jacobian of the cells around it.
    jacobian: f64,
}

impl<'a> Drawn<'a> {
    /// Those that are drawn, and how many there are.
    pub fn junctions(&self) -> (Vec<Junction<'_>>, usize) {
        let stacks = self.tree.stacks();
        let qualities = self.tree.qualities();
        let last = stacks.iter().filter_map(|stack| stack.from).max();
        let junction = |number: usize| {
            let begins = |stack: &&Stack| stack.from == Some(number);
            let mut daughters: Vec<&Stack> = stacks.iter().filter(begins).collect();
            daughters.sort_by_key(|stack| stack.wall);
            let of_side = daughters
                .iter()
                .find_map(|stack| Some(&stacks[stack.plugs?]));
            let parent =
                of_side.or_else(|| stacks.iter().find(|stack| stack.to == Some(number)))?;
            let centre = daughters.first()?.sections[0].centre;
            let reach = REACH * radius(parent, parent.sections.len() / 2);
            let near = qualities
                .iter()
                .filter(|(_, x)| (x - centre).norm() < reach);
            Some(Junction {
                parent,
                daughters,
                centre,
                reach,
                jacobian: near.map(|(jacobian, _)| *jacobian).fold(1.0, f64::min),
            })
        };
        let mut found: Vec<Junction> = (0..=last.unwrap_or(0)).filter_map(junction).collect();
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
        let ball = (junction.centre, junction.reach);
        let sections = self.tree.stacks().iter().flat_map(|stack| &stack.sections);
        let rims = sections.flat_map(|section| section.rim.iter().copied());
        let around: Vec<Vec3> = rims.filter(|x| (x - ball.0).norm() < ball.1).collect();
        let parent = &junction.parent.sections;
        let downstream = junction.centre - parent[parent.len() / 2].centre;
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
        let mut caption = self.told(junction);
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
    /// Which branches meet, in a sentence.
    fn told(&self, junction: &Junction<'_>) -> String {
        let (thin, others): (Vec<&Stack>, Vec<&Stack>) =
            (junction.daughters.iter()).partition(|stack| stack.plugs.is_some());
        let [thin, others] = [thin, others].map(|stacks| {
            let names = stacks.iter().map(|stack| self.branch(stack));
            names.collect::<Vec<_>>().join(", ")
        });
        let parent = self.branch(junction.parent);
        match (&thin[..], &others[..]) {
            ("", _) => format!("{parent} divides into {others}."),
            (_, "") => format!("{thin} begins at the side of {parent}."),
            _ => format!("{thin} begins at the side of {parent}, which goes on as {others}."),
        }
    }
}
