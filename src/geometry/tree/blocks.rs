//! The points of a tree and what lies between them: cells, or elements with their nodes.
//!
//! Branches are stacks of cross-sections. One that begins at the side of another branch has its first cross-sections in
//! that one's hole, whose points they go through, and a block of its own below its core; one that is closed has such a
//! block at its top. Their rings end at these blocks' sides.

use super::side::{Hole, border, coons, plug};
use super::{CrossSection, Middle, SectionGrid, Stack, Tree};
use crate::Vec3;
use rayon::prelude::*;

/// What a side of a cell or an element is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// The opening of this number: 0 where the root begins, that of a line plus one.
    Opening(usize),
    /// The wall of this number, see [`Stack::wall`].
    Wall(usize),
}

/// A cell or an element.
#[derive(Debug, Clone)]
pub struct Block {
    /// The stack that it is in.
    pub stack: usize,
    /// Numbers of its points, or nodes, fastest along its first direction, which points outward in the rings; the third
    /// one is that of the flow.
    pub points: Vec<usize>,
    /// Sides on the boundary: direction, and whether it is the upper one.
    pub sides: Vec<(usize, bool, Outside)>,
}

/// Numbers of the points.
#[derive(Debug, Clone)]
pub struct Numbers {
    /// How many there are.
    pub count: usize,
    /// Of each cross-section of each stack; `NONE` in holes.
    pub sections: Vec<Vec<Vec<usize>>>,
    /// Of the blocks over the core at the beginning and at the end of each stack, from the core on.
    pub caps: Vec<[Option<Vec<usize>>; 2]>,
}

/// No point.
pub const NONE: usize = usize::MAX;

/// Positions (m), in the order of [`Numbers`].
pub struct Positions {
    /// Of the points of each cross-section of each stack.
    pub sections: Vec<Vec<Vec<Vec3>>>,
    /// Of the blocks at the ends of each stack.
    pub caps: Vec<[Option<Vec<Vec3>>; 2]>,
}

/// How the wall is displaced (m): that of the rim of a cross-section, by stack and number, and of the top of a closed
/// stack.
pub struct Displaced<'a> {
    /// Of rims; what it says of points in holes, and of plugs, does not matter.
    pub rim: &'a (dyn Fn(usize, usize) -> Vec<Vec3> + Sync),
    /// Of tops, row by row.
    pub top: &'a (dyn Fn(usize) -> Vec<Vec3> + Sync),
}

impl Tree {
    /// Positions (m) of all points; the rims' distances from the centres are multiplied by `growth`.
    pub fn positions(&self, growth: f64, displaced: Option<&Displaced<'_>>) -> Positions {
        let grid = self.grid();
        let of_stack = |number: usize, stack: &Stack| -> Vec<Vec<Vec3>> {
            let plugged = self.plugged(stack);
            let shapes = &stack.sections[plugged..];
            let Some(displaced) = displaced else {
                let shapes = shapes.par_iter();
                return shapes.map(|shape| grid.positions(shape, growth)).collect();
            };
            let mut moved: Vec<Vec<Vec3>> = (plugged..stack.sections.len())
                .map(|j| (displaced.rim)(number, j))
                .collect();
            if let Some(hole) = &stack.hole {
                self.bridge(hole, &mut moved[..]);
            }
            (moved.par_iter().zip(shapes).zip(&stack.middles[plugged..]))
                .map(|((moved, shape), middle)| {
                    grid.positions(&self.displaced(shape, *middle, moved), growth)
                })
                .collect()
        };
        let mut sections: Vec<Vec<Vec<Vec3>>> = Vec::with_capacity(self.stacks.len());
        let mut caps = Vec::with_capacity(self.stacks.len());
        for (number, stack) in self.stacks.iter().enumerate() {
            let above = of_stack(number, stack);
            let mut cap = [None, None];
            let mut all = Vec::new();
            if let Some((parent, hole)) = self.hole_of(stack) {
                let at = |place: (isize, isize), ring: usize| {
                    let (row, point) = in_hole(grid, &hole, place);
                    sections[parent][row][grid.ring_point(ring, point)]
                };
                let plugs = (0..=grid.rings.len()).into_par_iter();
                all = plugs
                    .map(|ring| grid.positions(&plug(grid, &hole.shape, ring, at), 1.0))
                    .collect();
                cap[0] = Some(self.cap(&all[0], |i, j| at(self.in_cap(i, j), 0)));
            }
            all.extend(above);
            if let Some(top) = &stack.top {
                let last = &stack.sections[stack.sections.len() - 1];
                let u = displaced.map(|displaced| (displaced.top)(number));
                let n = grid.core + 1;
                let outer = |i: usize, j: usize| {
                    let k = i + n * j;
                    let x = last.centre + (top[k] - last.centre) * growth;
                    u.as_ref().map_or(x, |u| x + u[k])
                };
                cap[1] = Some(self.cap(&all[all.len() - 1], outer));
            }
            sections.push(all);
            caps.push(cap);
        }
        Positions { sections, caps }
    }

    /// How many of a stack's first cross-sections go through the points of another one.
    pub fn plugged(&self, stack: &Stack) -> usize {
        match self.hole_of(stack) {
            Some(_) => self.grid().rings.len() + 1,
            None => 0,
        }
    }

    /// The stack and its hole that a stack begins in.
    pub fn hole_of(&self, stack: &Stack) -> Option<(usize, Hole)> {
        let parent = stack.plugs?;
        Some((parent, self.stacks[parent].hole?))
    }

    /// A cross-section whose rim is displaced (m).
    fn displaced(&self, shape: &CrossSection, middle: Middle, moved: &[Vec3]) -> CrossSection {
        let grid = self.grid();
        let half = grid.around() / 2;
        let Middle { axis, share } = middle;
        let whole: Vec3 = moved
            .iter()
            .enumerate()
            .map(|(a, u)| u * grid.share(a))
            .sum();
        let ends = (moved[axis % moved.len()] + moved[(axis + half) % moved.len()]) * 0.5;
        let off = whole * share + ends * (1.0 - share);
        CrossSection {
            centre: shape.centre + whole * share + ends * (1.0 - share),
            rim: shape.rim.iter().zip(moved).map(|(x, u)| x + u).collect(),
            inner: (shape.inner.as_ref())
                .map(|inner| inner.iter().zip(moved).map(|(x, u)| x + u - off).collect()),
            lift: shape.lift,
        }
    }

    /// Displacements (m) of rims in a hole, where no wall is, from those around it.
    fn bridge(&self, hole: &Hole, rims: &mut [Vec<Vec3>]) {
        let grid = self.grid();
        let (n, h) = (grid.core, grid.core / 2);
        let point = |j: usize| (hole.middle + grid.around() + j - h) % grid.around();
        for i in 1..n {
            for j in 1..n {
                let u = coons(grid, i, j, |i, j| rims[hole.first + i][point(j)]);
                rims[hole.first + i][point(j)] = u;
            }
        }
    }

    /// The points of a block over the core of a cross-section: from there to `outer`, as far as the rings' points.
    fn cap(&self, section: &[Vec3], outer: impl Fn(usize, usize) -> Vec3) -> Vec<Vec3> {
        let grid = self.grid();
        let n = grid.core + 1;
        let mut all = Vec::with_capacity(n * n * (grid.rings.len() + 1));
        for k in 0..=grid.rings.len() {
            let t = if k == 0 { 0.0 } else { grid.rings[k - 1] };
            for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
                all.push(match grid.around_core(i, j) {
                    Some(a) => section[grid.ring_point(k, a)],
                    None => section[grid.core_point(i, j)] * (1.0 - t) + outer(i, j) * t,
                });
            }
        }
        all
    }

    /// The place in a hole of a point of the core.
    fn in_cap(&self, i: usize, j: usize) -> (isize, isize) {
        let h = self.grid().core as isize / 2;
        (i as isize - h, h - j as isize)
    }

    /// Numbers of all points: branches that meet have points in common.
    pub fn numbers(&self, positions: &Positions) -> Numbers {
        let grid = self.grid();
        let mut count = 0;
        let mut new = || {
            count += 1;
            count - 1
        };
        let mut sections: Vec<Vec<Vec<usize>>> = Vec::with_capacity(self.stacks.len());
        let mut caps = Vec::with_capacity(self.stacks.len());
        // Points of the junctions, to be found again.
        let mut shared: Vec<Vec<(usize, Vec3)>> = vec![Vec::new(); self.junctions.len()];
        for (stack, positions) in self.stacks.iter().zip(&positions.sections) {
            let of_parent = |place: (isize, isize), ring: usize| -> Option<usize> {
                let (parent, hole) = self.hole_of(stack)?;
                let (row, point) = in_hole(grid, &hole, place);
                Some(sections[parent][row][grid.ring_point(ring, point)])
            };
            let plugged = self.plugged(stack);
            let mut of_stack = Vec::with_capacity(positions.len());
            for (j, positions) in positions.iter().enumerate() {
                let mut here = vec![NONE; positions.len()];
                let junction = stack.junction(j).filter(|_| j >= plugged);
                let section = &stack.sections[j];
                let close = 1e-6 * (section.rim[0] - section.centre).norm();
                if j < plugged {
                    for (b, place) in border(grid.core).enumerate() {
                        here[grid.ring_point(grid.rings.len(), b)] =
                            of_parent(place, j).expect("plugs have a hole");
                    }
                }
                let is_missing = self.missing(stack, j);
                for (point, x) in positions.iter().enumerate() {
                    if here[point] != NONE || is_missing(point) {
                        continue;
                    }
                    let known = junction.and_then(|junction| {
                        let mut all = shared[junction].iter();
                        all.find(|(_, y)| (y - x).norm() < close)
                    });
                    here[point] = known.map_or_else(&mut new, |(number, _)| *number);
                    if let (None, Some(junction)) = (known, junction) {
                        let number = here[point];
                        shared[junction].push((number, *x));
                    }
                }
                of_stack.push(here);
            }
            let mut cap = |section: &[usize], outer: &dyn Fn(usize, usize) -> Option<usize>| {
                let (n, last) = (grid.core + 1, grid.rings.len());
                let point = |place: usize| {
                    let (k, i, j) = (place / (n * n), place % n, place / n % n);
                    let known = match grid.around_core(i, j) {
                        Some(a) => Some(section[grid.ring_point(k, a)]),
                        None if k == 0 => Some(section[grid.core_point(i, j)]),
                        None if k == last => outer(i, j),
                        None => None,
                    };
                    known.unwrap_or_else(&mut new)
                };
                (0..n * n * (last + 1)).map(point).collect::<Vec<usize>>()
            };
            let bottom =
                (plugged > 0).then(|| cap(&of_stack[0], &|i, j| of_parent(self.in_cap(i, j), 0)));
            let top =
                (stack.top.is_some()).then(|| cap(&of_stack[of_stack.len() - 1], &|_, _| None));
            caps.push([bottom, top]);
            sections.push(of_stack);
        }
        Numbers {
            count,
            sections,
            caps,
        }
    }

    /// Which points of a cross-section are in a hole.
    fn missing(&self, stack: &Stack, section: usize) -> impl Fn(usize) -> bool {
        let grid = self.grid();
        let (n, around) = (grid.core, grid.around());
        let in_core = (n + 1) * (n + 1);
        let middle = (stack.hole.as_ref())
            .filter(|hole| (hole.first + 1..hole.first + n).contains(&section))
            .map(|hole| hole.middle);
        move |point| {
            middle.is_some_and(|middle| {
                point >= in_core && off((point - in_core) % around, middle, around) < n / 2
            })
        }
    }

    /// All cells or elements, stack by stack, layer by layer downstream.
    pub fn blocks(&self, numbers: &Numbers) -> Vec<Block> {
        let grid = self.grid();
        let degree = grid.degree();
        let (n, around) = (grid.core, grid.around());
        let quads = grid.elements();
        let in_core = (n / degree).pow(2);
        let of_ring = around / degree;
        let mut all = Vec::new();
        for (number, stack) in self.stacks.iter().enumerate() {
            let rows = &numbers.sections[number];
            let [bottom, top] = &numbers.caps[number];
            let plugged = self.plugged(stack).saturating_sub(1) / degree;
            let last = (rows.len() - 1) / degree - 1;
            let in_rings = grid.rings.len() / degree;
            // From the parent's core up to that of the plug.
            if let Some(cap) = bottom {
                for k in (0..in_rings).rev() {
                    self.cap_blocks(cap, (k, false), number, &mut all);
                }
            }
            for layer in 0..=last {
                for (q, quad) in quads.iter().enumerate() {
                    let in_ring = q.checked_sub(in_core).map(|q| q % of_ring);
                    let is_missing = (stack.hole.as_ref()).zip(in_ring).is_some_and(|(hole, e)| {
                        let [from, to] = [e * degree, (e + 1) * degree];
                        (hole.first..hole.first + n).contains(&(layer * degree))
                            && [from, to]
                                .iter()
                                .all(|a| off(*a, hole.middle, around) <= n / 2)
                    });
                    if is_missing {
                        continue;
                    }
                    let layers = layer * degree..=(layer + 1) * degree;
                    let points = layers.flat_map(|j| quad.iter().map(move |&point| rows[j][point]));
                    let mut sides = Vec::new();
                    if q >= in_core && q + of_ring >= quads.len() && layer >= plugged {
                        sides.push((0, true, Outside::Wall(stack.wall)));
                    }
                    if layer == 0 && stack.from.is_none() {
                        sides.push((2, false, Outside::Opening(0)));
                    }
                    if let Some(line) = stack.end.filter(|_| layer == last) {
                        sides.push((2, true, Outside::Opening(1 + line)));
                    }
                    all.push(Block {
                        stack: number,
                        points: points.collect(),
                        sides,
                    });
                }
            }
            if let Some(cap) = top {
                for k in 0..in_rings {
                    let from = all.len();
                    self.cap_blocks(cap, (k, true), number, &mut all);
                    if k + 1 == in_rings {
                        for block in &mut all[from..] {
                            block.sides.push((0, true, Outside::Wall(stack.wall)));
                        }
                    }
                }
            }
        }
        all
    }

    /// Layer `k` of a block over a core; the first direction is outward at a top, the third one upward in a plug.
    fn cap_blocks(
        &self,
        cap: &[usize],
        (k, is_top): (usize, bool),
        stack: usize,
        all: &mut Vec<Block>,
    ) {
        let grid = self.grid();
        let (degree, n) = (grid.degree(), grid.core + 1);
        let side = grid.core / degree;
        let nodes = degree + 1;
        for element in 0..side * side {
            let (x, y) = (element % side * degree, element / side * degree);
            let points = (0..nodes * nodes * nodes).map(|node| {
                let (a, b, c) = (node % nodes, node / nodes % nodes, node / nodes / nodes);
                let (up, i, j) = match is_top {
                    true => (k * degree + a, b, c),
                    false => ((k + 1) * degree - c, a, b),
                };
                cap[(up * n + y + j) * n + x + i]
            });
            all.push(Block {
                stack,
                points: points.collect(),
                sides: Vec::new(),
            });
        }
    }
}

/// Distance of two points of a rim.
fn off(a: usize, b: usize, around: usize) -> usize {
    let off = (a + around - b) % around;
    off.min(around - off)
}

/// Cross-section and point of the rim at a place in a hole.
fn in_hole(grid: &SectionGrid, hole: &Hole, (i, j): (isize, isize)) -> (usize, usize) {
    let row = (hole.first + grid.core / 2).wrapping_add_signed(i);
    let point = (hole.middle + grid.around()).wrapping_add_signed(j);
    (row, point % grid.around())
}
