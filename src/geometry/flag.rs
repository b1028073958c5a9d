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

/// Position of the flag's beginning on the cylinder at the height `y` (m).
fn begin(flag: &Flag, y: f64) -> f64 {
    let above = y - flag.cylinder_y;
    flag.cylinder_x + (flag.cylinder_radius.powi(2) - above.powi(2)).sqrt()
}

/// Upstream and downstream side of the box around the cylinder, m.
fn box_ends(flag: &Flag) -> [f64; 2] {
    let (x, r) = (flag.cylinder_x, flag.cylinder_radius);
    [
        (x - BOX * r).max((x - r) / 3.0),
        (x + BOX * r).min(x + r + 0.5 * flag.length),
    ]
}

/// One row of hexahedra along the flag. Surfaces: `start` on the cylinder, `wet`, and `sides` (in the planes of
/// constant z); local coordinates along x, y, z.
pub fn solid_mesh(flag: &Flag) -> HexMesh {
    let n = flag.mesh.elements;
    let shape = FlagShape(flag.clone());
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
pub fn fluid_mesh(flag: &Flag) -> PolyMesh {
    let patches = [
        ("inlet", "patch"),
        ("outlet", "patch"),
        ("wallRigid", "wall"),
        ("cylinder", "wall"),
        ("wallFsi", "wall"),
    ];
    extruded(&blocks(flag), flag.depth, &patches)
}

/// Number of cells of [`fluid_mesh`].
pub fn cells(flag: &Flag) -> usize {
    let blocks = blocks(flag);
    let cells = blocks
        .iter()
        .map(|block| block.cells().iter().product::<usize>());
    cells.sum()
}

/// Blocks around the cylinder and downstream of it.
fn blocks(flag: &Flag) -> Vec<Block> {
    let lines = Lines::new(flag);
    let mut blocks = lines.around_cylinder();
    blocks.extend(lines.downstream());
    blocks
}

/// Lines between the blocks.
struct Lines<'a> {
    flag: &'a Flag,
    /// Heights of the flag's lower and upper side, m.
    sides: [f64; 2],
    /// Shares of the lengths of lines at their points: across the flag, from the flag to the lower and the upper wall,
    /// from the cylinder outward, along the flag, downstream of it, and from the inlet to the box.
    across: Vec<f64>,
    below: Vec<f64>,
    above: Vec<f64>,
    radial: Vec<f64>,
    along: Vec<f64>,
    wake: Vec<f64>,
    upstream: Vec<f64>,
}

impl<'a> Lines<'a> {
    fn new(flag: &'a Flag) -> Self {
        let sizes = &flag.mesh;
        let most = sizes.largest_cell;
        let grown =
            |length: f64, largest: f64| growing(length, sizes.cell_size, sizes.growth, largest);
        let [front, back] = box_ends(flag);
        let sides = [-0.5, 0.5].map(|share| flag.cylinder_y + share * flag.thickness);
        let [bottom, top] = sides;
        let end = flag.end();
        Self {
            flag,
            sides,
            across: equal((flag.thickness / sizes.cell_size).round().max(2.0) as usize),
            below: grown(bottom, most),
            above: grown(flag.channel_height - top, most),
            radial: grown(back - begin(flag, top), most),
            along: reversed(&grown(end - back, most.min(ALONG * sizes.cell_size))),
            wake: grown(flag.channel_length - end, most),
            upstream: equal((front / most).ceil() as usize),
        }
    }

    /// The circle counter-clockwise from the upper to the lower side of the flag, in five arcs that end where the
    /// corners of the box are seen from its centre.
    fn arcs(&self) -> [Vec<PlanePoint>; 5] {
        let Flag {
            cylinder_x: cx,
            cylinder_y: cy,
            cylinder_radius: r,
            channel_height: height,
            ..
        } = *self.flag;
        let [front, back] = box_ends(self.flag);
        let angle = |x: f64, y: f64| (y - cy).atan2(x - cx);
        let arc = |from: f64, to: f64, n: usize| -> Vec<PlanePoint> {
            let turn = |share: &f64| from + (to - from) * share;
            let on_circle = |phi: f64| [cx + r * phi.cos(), cy + r * phi.sin()];
            equal(n)
                .iter()
                .map(|share| on_circle(turn(share)))
                .collect()
        };
        let count = |from: f64, to: f64| {
            ((to - from) * r / self.flag.mesh.cell_size)
                .round()
                .max(4.0)
        };
        let quarter = |from: f64, to: f64| arc(from, to, count(from, to) as usize);
        let [ne, nw, sw, se] = [
            angle(back, height),
            angle(front, height),
            angle(front, 0.0) + 2.0 * PI,
            angle(back, 0.0) + 2.0 * PI,
        ];
        let joint = (0.5 * self.flag.thickness / r).asin();
        let mut arcs = [
            arc(joint, ne, self.above.len() - 1),
            quarter(ne, nw),
            quarter(nw, sw),
            quarter(sw, se),
            arc(se, 2.0 * PI - joint, self.below.len() - 1),
        ];
        // Points that two arcs share, or an arc and the flag, to the last digit.
        for i in 1..arcs.len() {
            *last(&mut arcs[i - 1]) = arcs[i][0];
        }
        let [lower, upper] = self.sides.map(|y| [begin(self.flag, y), y]);
        arcs[0][0] = upper;
        *last(&mut arcs[4]) = lower;
        arcs
    }

    /// Across the channel at `x` (m): above the flag, below it, and from its lower to its upper side.
    fn up(&self, x: f64) -> Vec<PlanePoint> {
        line(
            [x, self.sides[1]],
            [x, self.flag.channel_height],
            &self.above,
        )
    }

    fn down(&self, x: f64) -> Vec<PlanePoint> {
        line([x, 0.0], [x, self.sides[0]], &reversed(&self.below))
    }

    fn through(&self, x: f64) -> Vec<PlanePoint> {
        line([x, self.sides[0]], [x, self.sides[1]], &self.across)
    }

    /// Four blocks around the cylinder, of which the flag cuts the one downstream in two, after one upstream of them.
    fn around_cylinder(&self) -> Vec<Block> {
        let (flag, height) = (self.flag, self.flag.channel_height);
        let [front, back] = box_ends(flag);
        let [north_east, north, west, south, south_east] = self.arcs();
        // Radial lines outward.
        let spoke = |from: PlanePoint, to: PlanePoint| line(from, to, &self.radial);
        let to_ne = spoke(north[0], [back, height]);
        let to_nw = spoke(west[0], [front, height]);
        let to_sw = spoke(south[0], [front, 0.0]);
        let to_se = spoke(south_east[0], [back, 0.0]);
        let [on_bottom, on_top] = self.sides.map(|y| spoke([begin(flag, y), y], [back, y]));
        let box_side = line([front, 0.0], [front, height], &equal(west.len() - 1));
        let inlet = line([0.0, 0.0], [0.0, height], &equal(west.len() - 1));
        vec![
            block(
                wall(0.0, front, 0.0, &self.upstream),
                wall(0.0, front, height, &self.upstream),
                Side::on("inlet", &inlet),
                Side::inner(&box_side),
            ),
            block(
                Side::inner(&backwards(&to_sw)),
                Side::inner(&backwards(&to_nw)),
                Side::inner(&box_side),
                Side::on("cylinder", &backwards(&west)),
            ),
            block(
                wall(front, back, 0.0, &equal(south.len() - 1)),
                Side::on("cylinder", &south),
                Side::inner(&backwards(&to_sw)),
                Side::inner(&backwards(&to_se)),
            ),
            block(
                Side::on("cylinder", &backwards(&north)),
                wall(front, back, height, &equal(north.len() - 1)),
                Side::inner(&to_nw),
                Side::inner(&to_ne),
            ),
            block(
                Side::inner(&to_se),
                Side::on("wallFsi", &on_bottom),
                Side::on("cylinder", &south_east),
                Side::inner(&self.down(back)),
            ),
            block(
                Side::on("wallFsi", &on_top),
                Side::inner(&to_ne),
                Side::on("cylinder", &north_east),
                Side::inner(&self.up(back)),
            ),
        ]
    }

    /// Below and above the flag, and three blocks downstream of it.
    fn downstream(&self) -> Vec<Block> {
        let (flag, height) = (self.flag, self.flag.channel_height);
        let (back, end, length) = (box_ends(flag)[1], flag.end(), flag.channel_length);
        let [on_bottom, on_top] =
            (self.sides).map(|y| Side::on("wallFsi", &line([back, y], [end, y], &self.along)));
        let [lower, upper] = (self.sides).map(|y| line([end, y], [length, y], &self.wake));
        vec![
            block(
                wall(back, end, 0.0, &self.along),
                on_bottom,
                Side::inner(&self.down(back)),
                Side::inner(&self.down(end)),
            ),
            block(
                on_top,
                wall(back, end, height, &self.along),
                Side::inner(&self.up(back)),
                Side::inner(&self.up(end)),
            ),
            block(
                wall(end, length, 0.0, &self.wake),
                Side::inner(&lower),
                Side::inner(&self.down(end)),
                Side::on("outlet", &self.down(length)),
            ),
            block(
                Side::inner(&lower),
                Side::inner(&upper),
                Side::on("wallFsi", &self.through(end)),
                Side::on("outlet", &self.through(length)),
            ),
            block(
                Side::inner(&upper),
                wall(end, length, height, &self.wake),
                Side::inner(&self.up(end)),
                Side::on("outlet", &self.up(length)),
            ),
        ]
    }
}

fn block(south: Side, north: Side, west: Side, east: Side) -> Block {
    Block {
        south,
        north,
        west,
        east,
    }
}

/// On a wall of the channel.
fn wall(from: f64, to: f64, y: f64, shares: &[f64]) -> Side {
    Side::on("wallRigid", &line([from, y], [to, y], shares))
}

fn backwards(line: &[PlanePoint]) -> Vec<PlanePoint> {
    line.iter().rev().copied().collect()
}

/// Shape of the elements: straight, but for the beginning on the cylinder.
struct FlagShape(Flag);

impl HexShape for FlagShape {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let Self(flag) = self;
        let station = |i: usize| (i as f64 / flag.mesh.elements as f64).powf(ELEMENTS);
        let y = flag.cylinder_y + 0.5 * flag.thickness * xi[1];
        let (begin, end) = (begin(flag, y), flag.end());
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
