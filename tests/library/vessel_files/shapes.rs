//! Tubes whose surface is known, and files of them.

use fsi_driver::Vec3;
use nalgebra::Rotation3;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

/// A tube along a straight line or an arc (m), from the origin along +x, bending to +y; `radius(s, φ)` with φ from -y
/// (the outside of the bend) for the arc, and from +y for the line.
pub struct TubeSurface {
    length: f64,
    /// Curvature, 1/m.
    kappa: f64,
    radius: Box<dyn Fn(f64, f64) -> f64>,
    /// Where it lies in files.
    place: (Rotation3<f64>, Vec3),
    /// How far (m) the points of its line lie next to it.
    scatter: f64,
}

impl TubeSurface {
    pub fn straight(length: f64, radius: impl Fn(f64, f64) -> f64 + 'static) -> Self {
        Self {
            length,
            kappa: 0.0,
            radius: Box::new(radius),
            place: (Rotation3::identity(), Vec3::zeros()),
            scatter: 0.0,
        }
    }

    pub fn bent(length: f64, bend: f64, radius: impl Fn(f64, f64) -> f64 + 'static) -> Self {
        Self {
            length,
            kappa: 1.0 / bend,
            radius: Box::new(radius),
            place: (Rotation3::identity(), Vec3::zeros()),
            scatter: 0.0,
        }
    }

    /// Turned and moved in files.
    pub fn placed(self, rotation: Rotation3<f64>, to: Vec3) -> Self {
        Self {
            place: (rotation, to),
            ..self
        }
    }

    /// With points of the line next to it, m.
    pub fn scattering(self, scatter: f64) -> Self {
        Self { scatter, ..self }
    }

    fn in_file(&self, point: Vec3) -> Vec3 {
        self.place.0 * point + self.place.1
    }

    /// Origin and the two directions of a cross-section.
    fn frame(&self, s: f64) -> [Vec3; 3] {
        if self.kappa == 0.0 {
            return [Vec3::new(s, 0.0, 0.0), Vec3::y(), Vec3::z()];
        }
        let (sin, cos) = (self.kappa * s).sin_cos();
        let origin = Vec3::new(sin, 1.0 - cos, 0.0) / self.kappa;
        // The vessel's angle 0 is where the line bends away from its chord: against its centre of curvature.
        let first = Vec3::new(sin, -cos, 0.0);
        [origin, first, Vec3::new(cos, sin, 0.0).cross(&first)]
    }

    fn point(&self, s: f64, phi: f64) -> Vec3 {
        let [origin, first, second] = self.frame(s);
        let r = (self.radius)(s, phi);
        origin + first * (r * phi.cos()) + second * (r * phi.sin())
    }

    /// By how much (m) a point lies outside of the surface along the radius of its cross-section.
    pub fn outside(&self, point: &Vec3) -> f64 {
        let s = match self.kappa {
            0.0 => point.x,
            kappa => point.x.atan2(1.0 / kappa - point.y) / kappa,
        };
        let [origin, first, second] = self.frame(s);
        let arm = point - origin;
        let (y, z) = (arm.dot(&first), arm.dot(&second));
        y.hypot(z) - (self.radius)(s, z.atan2(y))
    }

    /// Points of the centre-line in a unit of which so many are a metre.
    pub fn write_line(&self, path: &Path, pieces: u32, scale: f64) {
        let mut text = String::from("x,y,z\n");
        for i in 0..=pieces {
            // No chance, but no pattern either.
            let off = Vec3::new(12.9898, 78.233, 37.719) * f64::from(i * i % 1013);
            let off = off.map(|x| self.scatter * x.sin());
            let [origin, ..] = self.frame(self.length * f64::from(i) / f64::from(pieces));
            let p = self.in_file(origin + off) * scale;
            let _ = writeln!(text, "{:e},{:e},{:e}", p.x, p.y, p.z);
        }
        std::fs::write(path, text).unwrap();
    }

    fn triangles(&self, slices: usize, sides: usize, is_closed: bool) -> Vec<[Vec3; 3]> {
        let at = |i: usize, j: usize| {
            // Beyond the ends of the centre-line, so that all of it is within.
            let s = (self.length + 2e-3) * i as f64 / slices as f64 - 1e-3;
            let turn = (j % sides) as f64 + 0.5 * (i % 2) as f64;
            self.in_file(self.point(s, TAU * turn / sides as f64))
        };
        let mut all = Vec::new();
        for i in 0..slices {
            for j in 0..sides {
                let odd = i % 2;
                let (a, b, c, d) = (
                    at(i, j),
                    at(i, j + 1),
                    at(i + 1, j + odd),
                    at(i + 1, j + 1 + odd),
                );
                all.extend([[a, b, c], [b, d, c]]);
            }
        }
        if is_closed {
            for i in [0, slices] {
                let centre = (0..sides).map(|j| at(i, j)).sum::<Vec3>() / sides as f64;
                all.extend((0..sides).map(|j| [at(i, j), at(i, j + 1), centre]));
            }
        }
        all
    }

    /// The surface from 1 mm before the line to 1 mm after it: binary STL, ASCII STL if the name begins so, or VTP.
    pub fn write_surface(
        &self,
        path: &Path,
        slices: usize,
        sides: usize,
        is_closed: bool,
        scale: f64,
    ) {
        let triangles = self.triangles(slices, sides, is_closed);
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let coordinates = |p: &Vec3| [p.x, p.y, p.z].map(|x| (x * scale) as f32);
        let bytes = if name.ends_with(".vtp") {
            let mut points = String::new();
            for p in triangles.iter().flatten().map(coordinates) {
                let _ = write!(points, "{} {} {} ", p[0], p[1], p[2]);
            }
            let n = triangles.len();
            let indices: Vec<String> = (0..3 * n).map(|i| i.to_string()).collect();
            let ends: Vec<String> = (1..=n).map(|i| (3 * i).to_string()).collect();
            let array = |name: &str, kind: &str, more: &str, text: &str| {
                format!(
                    "<DataArray type=\"{kind}\" Name=\"{name}\" {more} format=\"ascii\">{text}</DataArray>"
                )
            };
            format!(
                "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
                 header_type=\"UInt64\"><PolyData><Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{n}\"><Points>{}</Points>\
                 <Polys>{}{}</Polys></Piece></PolyData></VTKFile>",
                3 * n,
                array("Points", "Float32", "NumberOfComponents=\"3\"", &points),
                array("connectivity", "Int64", "", &indices.join(" ")),
                array("offsets", "Int64", "", &ends.join(" "))
            )
            .into_bytes()
        } else if name.starts_with("ascii") {
            let mut text = String::from("solid tube\n");
            for triangle in &triangles {
                text += "facet normal 0 0 0\n outer loop\n";
                for p in triangle.iter().map(coordinates) {
                    let _ = writeln!(text, "  vertex {:e} {:e} {:e}", p[0], p[1], p[2]);
                }
                text += " endloop\nendfacet\n";
            }
            (text + "endsolid tube\n").into_bytes()
        } else {
            let mut bytes = b"solid, says this header of a binary file".to_vec();
            bytes.resize(80, b' ');
            bytes.extend((triangles.len() as u32).to_le_bytes());
            for triangle in &triangles {
                bytes.extend([0; 12]);
                bytes.extend(
                    triangle
                        .iter()
                        .flat_map(coordinates)
                        .flat_map(f32::to_le_bytes),
                );
                bytes.extend([0; 2]);
            }
            bytes
        };
        std::fs::write(path, bytes).unwrap();
    }
}

/// A line through three points, with radii.
pub fn vtp_of(points: &str, radii: &str) -> String {
    format!(
        "<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"3\" \
         NumberOfLines=\"1\"><PointData><DataArray type=\"Float64\" Name=\"MaximumInscribedSphereRadius\" \
         format=\"ascii\">{radii}</DataArray></PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" \
         format=\"ascii\">{points}</DataArray></Points><Lines><DataArray type=\"Int64\" Name=\"connectivity\" \
         format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3</DataArray></Lines>\
         </Piece></PolyData></VTKFile>"
    )
}
