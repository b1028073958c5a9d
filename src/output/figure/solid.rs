//! Bodies in space: parallel projection with a depth buffer, lit from the eye.

use crate::Vec3;

/// From a body that lies along x towards the eye.
const EYE: [f64; 3] = [-0.35, 0.45, 1.0];
/// Windows are wider than they are high by this factor.
const WIDE: f64 = 1.9;
/// A line is drawn so far in front of the surface that it lies on, relative to the size of the body.
const LIFT: f64 = 4e-3;

/// From where a body is seen: along its longest extent to the right, and its second one upwards.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Middle of the box around it, m.
    middle: Vec3,
    axes: [Vec3; 3],
    /// Largest extent, those across counted [`WIDE`] times, m: a window that is wide shows all of it.
    pub size: f64,
}

impl View {
    /// The view of a body with these points. One whose longest extent is along x has x to the right and y upwards.
    pub fn of(points: &[Vec3]) -> Self {
        let [low, high] = bounds(points);
        let extent = high - low;
        match extent.x >= extent.y.max(extent.z) {
            true => Self::along([Vec3::x(), Vec3::y(), Vec3::z()], points),
            false => Self::across(points),
        }
    }

    /// The view of a body with these points from across its two largest extents, however it lies.
    pub fn across(points: &[Vec3]) -> Self {
        Self::along(principal(points), points)
    }

    /// The same, upside down if that is what it takes for `direction` to point to the right.
    #[must_use]
    pub fn with_to_the_right(self, direction: &Vec3) -> Self {
        let [right, up, towards] = self.axes;
        let axes = match right.dot(direction) < 0.0 {
            true => [-right, -up, towards],
            false => self.axes,
        };
        Self { axes, ..self }
    }

    /// The same body from behind, with the same side to the right.
    #[must_use]
    pub fn behind(self) -> Self {
        let [right, up, towards] = self.axes;
        Self {
            axes: [right, -up, -towards],
            ..self
        }
    }

    fn along(axes: [Vec3; 3], points: &[Vec3]) -> Self {
        let [low, high] = bounds(points);
        let middle = 0.5 * (low + high);
        let reach = |axis: &Vec3| {
            let along = points.iter().map(|p| (p - middle).dot(axis).abs());
            2.0 * along.fold(0.0, f64::max)
        };
        let [along, up, towards] = axes.each_ref().map(reach);
        Self {
            size: along.max(WIDE * up).max(WIDE * towards),
            middle,
            axes,
        }
    }

    /// A point in coordinates along the axes from the middle, m.
    pub fn turned(&self, point: &Vec3) -> Vec3 {
        let arm = point - self.middle;
        Vec3::from(self.axes.map(|axis| axis.dot(&arm)))
    }

    /// Direction towards the eye.
    pub fn eye(&self) -> Vec3 {
        let [x, y, z] = self.axes;
        (x * EYE[0] + y * EYE[1] + z * EYE[2]).normalize()
    }
}

/// Opposite corners of the box around points.
fn bounds(points: &[Vec3]) -> [Vec3; 2] {
    let ends = [f64::INFINITY, f64::NEG_INFINITY].map(Vec3::repeat);
    (points.iter()).fold(ends, |[low, high], p| [low.inf(p), high.sup(p)])
}

/// Directions of the largest, second and smallest extent, right-handed.
fn principal(points: &[Vec3]) -> [Vec3; 3] {
    let mean = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let spread = points.iter().map(|p| (p - mean) * (p - mean).transpose());
    let eigen = spread.sum::<crate::Mat3>().symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let axis = |i: usize| {
        let axis: Vec3 = eigen.eigenvectors.column(order[i]).into();
        axis * axis[axis.iamax()].signum()
    };
    let (first, second) = (axis(0), axis(1));
    [first, second, first.cross(&second)]
}

/// Where points in space lie in a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Projection {
    /// To the right, up, and towards the eye.
    axes: [Vec3; 3],
    /// Middle of the picture along the first two of them (m), and in pixels.
    middle: [f64; 2],
    centre: [f64; 2],
    /// Pixels of a metre.
    pub scale: f64,
}

impl Projection {
    /// Pixels from the left and from the top.
    pub fn at(&self, point: &Vec3) -> [f64; 2] {
        let [x, y, _] = self.with_depth(point);
        [x, y]
    }

    /// With how far the point is towards the eye, m.
    fn with_depth(&self, point: &Vec3) -> [f64; 3] {
        let [right, up, eye] = self.axes.each_ref().map(|axis| axis.dot(point));
        let x = self.centre[0] + self.scale * (right - self.middle[0]);
        let y = self.centre[1] - self.scale * (up - self.middle[1]);
        [x, y, eye]
    }
}

/// The colour of a place in a triangle: its number, its corners, their weights.
pub type Colour<'a> = &'a dyn Fn(usize, [usize; 3], [f64; 3]) -> [u8; 3];

/// Triangles, and lines on them.
pub struct DrawnSolid<'a> {
    /// Corners, m.
    pub points: &'a [Vec3],
    /// Numbers of the corners.
    pub triangles: &'a [[u32; 3]],
    /// How they are painted.
    pub colour: Colour<'a>,
    /// Straight lines (m) with their colours.
    pub lines: &'a [([Vec3; 2], [u8; 3])],
}

impl DrawnSolid<'_> {
    /// How it lies in a picture of so many columns and rows of pixels, which it fills.
    pub fn projection(&self, view: &View, [columns, rows]: [usize; 2]) -> Projection {
        let eye = view.eye();
        let right = view.axes[1].cross(&eye).normalize();
        let up = eye.cross(&right);
        let limits = |axis: &Vec3| {
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            let places = self.points.iter().map(|p| axis.dot(p));
            places.fold(ends, |(low, high), p| (low.min(p), high.max(p)))
        };
        let [(left, end), (floor, top)] = [limits(&right), limits(&up)];
        let scale = (columns as f64 / (end - left)).min(rows as f64 / (top - floor)) * 0.96;
        Projection {
            axes: [right, up, eye],
            middle: [0.5 * (left + end), 0.5 * (floor + top)],
            centre: [0.5 * columns as f64, 0.5 * rows as f64],
            scale,
        }
    }

    /// A picture of so many columns and rows of pixels, row by row from the top.
    pub fn pixels(&self, view: &View, size: [usize; 2]) -> Vec<[u8; 3]> {
        let [columns, rows] = size;
        let projection = self.projection(view, size);
        let eye = projection.axes[2];
        let at = |p: &Vec3| projection.with_depth(p);
        let mut normals = vec![Vec3::zeros(); self.points.len()];
        for corners in self.triangles {
            let [p, q, r] = corners.map(|p| self.points[p as usize]);
            let normal = (q - p).cross(&(r - p));
            corners.iter().for_each(|p| normals[*p as usize] += normal);
        }
        let light = |n: &Vec3| n.try_normalize(0.0).map_or(1.0, |n| n.dot(&eye).abs());
        let lights: Vec<f64> = normals.iter().map(light).collect();
        let mut pixels = vec![[255; 3]; columns * rows];
        let mut depths = vec![f64::NEG_INFINITY; columns * rows];
        for (number, triangle) in self.triangles.iter().enumerate() {
            let corner = triangle.map(|p| p as usize);
            let [a, b, c] = corner.map(|p| at(&self.points[p]));
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            if area == 0.0 {
                continue;
            }
            let range = |d: usize, most: usize| {
                let low = a[d].min(b[d]).min(c[d]).floor().max(0.0) as usize;
                let high = a[d].max(b[d]).max(c[d]).ceil().max(0.0) as usize;
                low..high.min(most)
            };
            for row in range(1, rows) {
                for column in range(0, columns) {
                    let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                    let v = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
                    let w = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
                    let u = 1.0 - v - w;
                    if u < 0.0 || v < 0.0 || w < 0.0 {
                        continue;
                    }
                    let mix = |values: [f64; 3]| u * values[0] + v * values[1] + w * values[2];
                    let depth = mix([a[2], b[2], c[2]]);
                    let pixel = row * columns + column;
                    if depth > depths[pixel] {
                        depths[pixel] = depth;
                        let colour = (self.colour)(number, corner, [u, v, w]);
                        let light = 0.5 + 0.5 * mix(corner.map(|p| lights[p]));
                        pixels[pixel] = colour.map(|c| (f64::from(c) * light) as u8);
                    }
                }
            }
        }
        let lift = LIFT * view.size;
        for (ends, colour) in self.lines {
            let [a, b] = ends.map(|x| at(&x));
            let steps = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).ceil().max(1.0) as usize;
            for step in 0..=steps {
                let t = step as f64 / steps as f64;
                let [x, y, depth] = [0, 1, 2].map(|d| a[d] + t * (b[d] - a[d]));
                if x < 0.0 || y < 0.0 || x >= columns as f64 || y >= rows as f64 {
                    continue;
                }
                let pixel = y as usize * columns + x as usize;
                if depth + lift >= depths[pixel] {
                    pixels[pixel] = *colour;
                }
            }
        }
        pixels
    }
}
