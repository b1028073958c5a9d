//! A flag downstream of a cylinder in a channel: hexahedra for the flag, blocks of cells for the fluid around it.

use super::blocks::{Block, PlanePoint, Side, extruded};
use super::{HexFace, HexMesh, HexShape, PolyMesh};
use crate::Vec3;
use crate::case::Flag;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// The box around the cylinder reaches so many radii up- and downstream of its centre.
const BOX: f64 = 3.0;
/// Cells along the flag grow to this multiple of those at its end.
const ALONG: f64 = 3.0;
/// Elements of the flag grow from the cylinder on, where the stress is largest, as this power of their number.
const ELEMENTS: f64 = 1.25;

impl Flag {
    /// Position of the flag's beginning on the cylinder at the height `y` (m).
    fn begin(&self, y: f64) -> f64 {
        let above = y - self.cylinder_y;
        self.cylinder_x + (self.cylinder_radius.powi(2) - above.powi(2)).sqrt()
    }

    /// Upstream and downstream side of the box around the cylinder, m.
    fn box_ends(&self) -> [f64; 2] {
        let (x, r) = (self.cylinder_x, self.cylinder_radius);
        [
            (x - BOX * r).max((x - r) / 3.0),
            (x + BOX * r).min(x + r + 0.5 * self.length),
        ]
    }

    /// One row of hexahedra along the flag. Surfaces: `start` on the cylinder, `wet`, and `sides` (in the planes of
    /// constant z); local coordinates along x, y, z.
    pub fn solid_mesh(&self) -> HexMesh {
        let n = self.mesh.elements;
        let shape = FlagShape(self.clone());
        let corner = |bit: usize| if bit == 1 { 1.0 } else { -1.0 };
        let vertices = (0..4 * (n + 1)).map(|vertex| {
            let (station, v) = (vertex / 4, vertex % 4);
            let (element, along) = match station {
                0 => (0, -1.0),
                station => (station - 1, 1.0),
            };
            shape.position(element, [along, corner(v & 1), corner(v >> 1)])
        });
        let vertices: Vec<Vec3> = vertices.collect();
        let hexes = (0..n).map(|e| std::array::from_fn(|v| 4 * (e + (v & 1)) + (v >> 1)));
        let hexes: Vec<[usize; 8]> = hexes.collect();
        let face = |axis, upper| HexFace { axis, upper };
        let both = |axis: u8| (0..n).flat_map(move |e| [false, true].map(|up| (e, face(axis, up))));
        let end = (n - 1, face(0, true));
        let surfaces = BTreeMap::from([
            ("start".to_owned(), vec![(0, face(0, false))]),
            ("wet".to_owned(), both(1).chain([end]).collect()),
            ("sides".to_owned(), both(2).collect()),
        ]);
        HexMesh {
            vertices,
            regions: vec![0; n],
            hexes,
            surfaces,
            directions: super::WallDirections::Local,
            shape: Arc::new(shape),
        }
    }

    /// One layer of cells around the flag: patches `inlet`, `outlet`, `wallRigid` (the channel), `cylinder`, `wallFsi`
    /// (the flag) and `sides` (empty), in this order.
    pub fn fluid_mesh(&self) -> PolyMesh {
        let patches = [
            ("inlet", "patch"),
            ("outlet", "patch"),
            ("wallRigid", "wall"),
            ("cylinder", "wall"),
            ("wallFsi", "wall"),
        ];
        extruded(&self.blocks(), self.depth, &patches)
    }

    /// Number of cells of [`fluid_mesh`](Self::fluid_mesh).
    pub fn cells(&self) -> usize {
        let blocks = self.blocks();
        let cells = blocks
            .iter()
            .map(|block| block.cells().iter().product::<usize>());
        cells.sum()
    }

    /// Four blocks around the cylinder, of which the flag cuts the one downstream in two; above and below the flag;
    /// three downstream of it; one in front.
    fn blocks(&self) -> Vec<Block> {
        let sizes = &self.mesh;
        let grown =
            |length: f64, largest: f64| growing(length, sizes.cell_size, sizes.growth, largest);
        let (height, length, end) = (self.channel_height, self.channel_length, self.end());
        let (cx, cy, r) = (self.cylinder_x, self.cylinder_y, self.cylinder_radius);
        let [front, back] = self.box_ends();
        let [bottom, top] = [-0.5, 0.5].map(|share| cy + share * self.thickness);

        // Shares of a line's length at its points, from the flag or the cylinder on.
        let around_end = equal((self.thickness / sizes.cell_size).round().max(2.0) as usize);
        let below = grown(bottom, sizes.largest_cell);
        let over = grown(height - top, sizes.largest_cell);
        let radial = grown(back - self.begin(top), sizes.largest_cell);
        let along = reversed(&grown(
            end - back,
            sizes.largest_cell.min(ALONG * sizes.cell_size),
        ));
        let wake = grown(length - end, sizes.largest_cell);
        let upstream = equal((front / sizes.largest_cell).ceil() as usize);

        // The circle, from corner to corner of the box as seen from its centre, counter-clockwise.
        let angle = |x: f64, y: f64| (y - cy).atan2(x - cx);
        let arc = |from: f64, to: f64, n: usize| -> Vec<PlanePoint> {
            let turn = |share: &f64| from + (to - from) * share;
            let on_circle = |phi: f64| [cx + r * phi.cos(), cy + r * phi.sin()];
            equal(n)
                .iter()
                .map(|share| on_circle(turn(share)))
                .collect()
        };
        let count = |from: f64, to: f64| ((to - from) * r / sizes.cell_size).round().max(4.0);
        let quarter = |from: f64, to: f64| arc(from, to, count(from, to) as usize);
        let [ne, nw, sw, se] = [
            angle(back, height),
            angle(front, height),
            angle(front, 0.0) + 2.0 * PI,
            angle(back, 0.0) + 2.0 * PI,
        ];
        let [mut arc_n, mut arc_w, mut arc_s] = [quarter(ne, nw), quarter(nw, sw), quarter(sw, se)];
        let joint = (0.5 * self.thickness / r).asin();
        let mut arc_ne = arc(joint, ne, over.len() - 1);
        let mut arc_se = arc(se, 2.0 * PI - joint, below.len() - 1);
        // Points that two arcs share, or an arc and the flag, to the last digit.
        arc_ne[0] = [self.begin(top), top];
        *last(&mut arc_se) = [self.begin(bottom), bottom];
        *last(&mut arc_ne) = arc_n[0];
        *last(&mut arc_n) = arc_w[0];
        *last(&mut arc_w) = arc_s[0];
        *last(&mut arc_s) = arc_se[0];

        // Radial lines outward.
        let spoke = |from: PlanePoint, to: PlanePoint| line(from, to, &radial);
        let (to_ne, to_nw) = (
            spoke(arc_n[0], [back, height]),
            spoke(arc_w[0], [front, height]),
        );
        let (to_sw, to_se) = (spoke(arc_s[0], [front, 0.0]), spoke(arc_se[0], [back, 0.0]));
        let on_top = spoke(arc_ne[0], [back, top]);
        let on_bottom = spoke([self.begin(bottom), bottom], [back, bottom]);

        // Lines across the channel: at the box's ends, at the flag's end, at the outlet.
        let up = |x: f64| line([x, top], [x, height], &over);
        let down = |x: f64| line([x, 0.0], [x, bottom], &reversed(&below));
        let through = |x: f64| line([x, bottom], [x, top], &around_end);
        let box_side = line([front, 0.0], [front, height], &equal(arc_w.len() - 1));
        let inlet = line([0.0, 0.0], [0.0, height], &equal(arc_w.len() - 1));
        let wall = |from: f64, to: f64, y: f64, shares: &[f64]| {
            Side::on("wallRigid", &line([from, y], [to, y], shares))
        };
        let to_end = |y: f64| line([back, y], [end, y], &along);
        let to_outlet = |y: f64| line([end, y], [length, y], &wake);
        let back_to_front = |line: &[PlanePoint]| line.iter().rev().copied().collect::<Vec<_>>();

        let block = |south, north, west, east| Block {
            south,
            north,
            west,
            east,
        };
        let (inner, on) = (Side::inner, Side::on);
        vec![
            block(
                wall(0.0, front, 0.0, &upstream),
                wall(0.0, front, height, &upstream),
                on("inlet", &inlet),
                inner(&box_side),
            ),
            // Around the cylinder: in front, below, above, downstream and below, downstream and above.
            block(
                inner(&back_to_front(&to_sw)),
                inner(&back_to_front(&to_nw)),
                inner(&box_side),
                on("cylinder", &back_to_front(&arc_w)),
            ),
            block(
                wall(front, back, 0.0, &equal(arc_s.len() - 1)),
                on("cylinder", &arc_s),
                inner(&back_to_front(&to_sw)),
                inner(&back_to_front(&to_se)),
            ),
            block(
                on("cylinder", &back_to_front(&arc_n)),
                wall(front, back, height, &equal(arc_n.len() - 1)),
                inner(&to_nw),
                inner(&to_ne),
            ),
            block(
                inner(&to_se),
                on("wallFsi", &on_bottom),
                on("cylinder", &arc_se),
                inner(&down(back)),
            ),
            block(
                on("wallFsi", &on_top),
                inner(&to_ne),
                on("cylinder", &arc_ne),
                inner(&up(back)),
            ),
            // Below and above the flag.
            block(
                wall(back, end, 0.0, &along),
                on("wallFsi", &to_end(bottom)),
                inner(&down(back)),
                inner(&down(end)),
            ),
            block(
                on("wallFsi", &to_end(top)),
                wall(back, end, height, &along),
                inner(&up(back)),
                inner(&up(end)),
            ),
            // Behind it.
            block(
                wall(end, length, 0.0, &wake),
                inner(&to_outlet(bottom)),
                inner(&down(end)),
                on("outlet", &down(length)),
            ),
            block(
                inner(&to_outlet(bottom)),
                inner(&to_outlet(top)),
                on("wallFsi", &through(end)),
                on("outlet", &through(length)),
            ),
            block(
                inner(&to_outlet(top)),
                wall(end, length, height, &wake),
                inner(&up(end)),
                on("outlet", &up(length)),
            ),
        ]
    }
}

/// Shape of the elements: straight, but for the beginning on the cylinder.
struct FlagShape(Flag);

impl HexShape for FlagShape {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let Self(flag) = self;
        let station = |i: usize| (i as f64 / flag.mesh.elements as f64).powf(ELEMENTS);
        let y = flag.cylinder_y + 0.5 * flag.thickness * xi[1];
        let (begin, end) = (flag.begin(y), flag.end());
        let [from, to] = [station(element), station(element + 1)];
        let share = from + (to - from) * 0.5 * (1.0 + xi[0]);
        Vec3::new(
            begin + share * (end - begin),
            y,
            0.5 * flag.depth * (1.0 + xi[2]),
        )
    }
}

/// Shares 0 to 1 of a line of `length` (m) with cells of the size `first`, the next ones larger by `growth` each, up to
/// `largest`; all a little larger or smaller, so that they fit.
fn growing(length: f64, first: f64, growth: f64, largest: f64) -> Vec<f64> {
    let (mut ends, mut size) = (vec![0.0], first);
    // The last cell may miss half of itself.
    while ends[ends.len() - 1] + 0.5 * size.min(largest) < length || ends.len() < 2 {
        ends.push(ends[ends.len() - 1] + size.min(largest));
        size *= growth;
    }
    let whole = ends[ends.len() - 1];
    ends.iter().map(|end| end / whole).collect()
}

/// Shares of a line with `n` equal cells.
fn equal(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

/// The same cells from the other end.
fn reversed(shares: &[f64]) -> Vec<f64> {
    shares.iter().rev().map(|share| 1.0 - share).collect()
}

/// Points of a straight line; its ends are exact.
fn line(from: PlanePoint, to: PlanePoint, shares: &[f64]) -> Vec<PlanePoint> {
    let at = |share: f64| std::array::from_fn(|k| (1.0 - share) * from[k] + share * to[k]);
    let mut points: Vec<PlanePoint> = shares.iter().map(|&share| at(share)).collect();
    (points[0], *last(&mut points)) = (from, to);
    points
}

fn last(points: &mut [PlanePoint]) -> &mut PlanePoint {
    points.last_mut().expect("a line has points")
}
