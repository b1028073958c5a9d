//! A vessel that branches: its wall cut open, its meshes, and the worst places of these.

use super::legend::{self, Overlay, Sign};
use super::{CELL, EDGE, FIBRE, LUMEN, PIXELS, Preview, colour, html_colour};
use crate::Vec3;
use crate::case::{Material, ResolvedCase, TreeKeys};
use crate::geometry::HexMesh;
use crate::geometry::tree::{Stack, Tree};
use crate::hemodynamics::WetSurface;
use crate::output::figure::solid::{DrawnSolid, View};
use crate::output::report::page::{Page, escape, figure, gallery, significant, table};
use crate::output::report::scene;
use crate::output::report::surface::{DrawnSurface, SurfaceField};
use crate::simulation::assembly::Domain;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::collections::HashMap;
use std::fmt::Write;

/// Pieces of a side of an element in the picture and in the view to rotate.
const PIECES: usize = 4;
/// The wall is left out where it faces the eye: from this cosine of the angle on.
const OPEN: f64 = 0.25;
/// Places of the mesh that are pointed out, and how far they lie apart, in radii.
const WORST: usize = 5;
const APART: f64 = 1.0;
/// Half of the length of a fibre, in radii.
const LONG: f64 = 0.25;
/// Width of a drawing, and of its margin.
const SIDE: f64 = 300.0;
const MARGIN: f64 = 16.0;

/// What is drawn.
struct Drawn<'a> {
    case: &'a ResolvedCase,
    keys: &'a TreeKeys,
    names: Vec<String>,
    domain: Domain,
    tree: Tree,
    /// Worst cells: scaled Jacobian, place (m) and branch.
    worst: Vec<(f64, Vec3, usize)>,
}

/// Triangles with what they are (materials, then the lumen), and lines.
#[derive(Default)]
struct Drawing {
    points: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    parts: Vec<usize>,
    lines: Vec<([Vec3; 2], [u8; 3])>,
}

/// Draws the tree of a case.
///
/// # Errors
/// If it has no mesh, or the picture cannot be drawn.
pub fn preview(case: &ResolvedCase, keys: &TreeKeys, name: &str) -> std::io::Result<Preview> {
    let refused = |reason: String| std::io::Error::new(std::io::ErrorKind::InvalidInput, reason);
    let domain = Domain::new(case)
        .map_err(|e| refused(case.mistake(case.given(e.key), e.reason).to_string()))?;
    let tree = Tree::of_cells(keys).map_err(|e| refused(e.to_string()))?;
    let own = case
        .own()
        .map(|own| own.wall.materials())
        .unwrap_or_default();
    let names = own.iter().map(|named| named.name.clone()).collect();
    let worst = worst(&tree);
    let drawn = Drawn {
        case,
        keys,
        names,
        domain,
        tree,
        worst,
    };
    let drawing = drawn.drawing();
    let view = View::of(&drawing.points);
    let colours = drawn.colours();
    let solid = DrawnSolid {
        points: &drawing.points,
        triangles: &drawing.triangles,
        colour: &|triangle, _, _| colours[drawing.parts[triangle]],
        lines: &drawing.lines,
    };
    let image = solid.pixels(&view, PIXELS);
    let root = &drawn.tree.stacks()[0];
    let ends = [0, (root.sections.len() - 1) / 2].map(|i| root.sections[i].centre);
    let marked: Vec<Vec3> = drawn.worst.iter().map(|(_, x, _)| *x).collect();
    let overlay = Overlay {
        flow: (ends, 1.3 * radius(root, 0)),
        marked: &marked,
        names: &drawn.legend(),
    };
    let png = legend::with_legend(&overlay, &image, PIXELS, &solid.projection(&view, PIXELS))?;
    let sections: Vec<String> = drawn
        .tree
        .stacks()
        .iter()
        .map(|stack| drawn.section(stack))
        .collect();
    Ok(Preview {
        html: drawn.page(name, &png, &drawing, &sections),
        png,
        svg: super::cross_section::side_by_side(&sections),
    })
}

/// Mean radius (m) of a cross-section of a branch.
fn radius(stack: &Stack, i: usize) -> f64 {
    let section = &stack.sections[i];
    let all = section.rim.iter().map(|x| (x - section.centre).norm());
    all.sum::<f64>() / section.rim.len() as f64
}

/// The worst cells, the next one always so far from those before that it is another place.
fn worst(tree: &Tree) -> Vec<(f64, Vec3, usize)> {
    let mut all = tree.qualities();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found: Vec<(f64, Vec3, usize)> = Vec::new();
    for (jacobian, x) in all {
        let is_near = |(_, y, stack): &(f64, Vec3, usize)| {
            (x - y).norm() < APART * radius(&tree.stacks()[*stack], 0)
        };
        if found.iter().any(is_near) {
            continue;
        }
        let distance = |stack: &Stack| {
            let all = stack
                .sections
                .iter()
                .map(|section| (section.centre - x).norm());
            all.fold(f64::INFINITY, f64::min)
        };
        let stacks = tree.stacks().iter().enumerate();
        let nearest = stacks.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        found.push((jacobian, x, nearest.map_or(0, |(i, _)| i)));
        if found.len() == WORST {
            break;
        }
    }
    found
}

impl Drawn<'_> {
    /// Those of the materials, then that of the lumen.
    fn colours(&self) -> Vec<[u8; 3]> {
        let materials = (0..self.names.len()).map(colour);
        materials.chain([LUMEN]).collect()
    }

    /// What the colours of the picture stand for.
    fn legend(&self) -> Vec<(String, Sign)> {
        let mut names = legend::names(&self.names, false);
        let is_fibrous = |m: &Material| matches!(m, Material::HolzapfelGasserOgden { .. });
        if !self.domain.materials.iter().any(is_fibrous) {
            names.retain(|(name, _)| name != "fibres");
        }
        names
    }

    fn branch(&self, stack: &Stack) -> String {
        let names = self.keys.branches();
        names.get(stack.wall).cloned().unwrap_or_default()
    }

    /// The nearest middle of a cross-section, and the radius there (m).
    fn middle(&self) -> impl Fn(&Vec3) -> (Vec3, f64) + '_ {
        let sections = self.tree.stacks().iter().flat_map(|stack| {
            (0..stack.sections.len()).map(|i| (stack.sections[i].centre, radius(stack, i)))
        });
        let sections: Vec<(Vec3, f64)> = sections.collect();
        move |x: &Vec3| {
            let all = sections.iter().copied();
            let nearest = all.min_by(|a, b| (a.0 - x).norm().total_cmp(&(b.0 - x).norm()));
            nearest.unwrap_or((*x, 1.0))
        }
    }

    /// The lumen, and the wall where it does not hide that.
    fn drawing(&self) -> Drawing {
        let mut drawing = Drawing::default();
        let surface = self.domain.surface();
        let mut numbers: HashMap<usize, u32> = HashMap::new();
        for name in &self.domain.wet_patches {
            for face in surface.patch_faces(name) {
                let corners: Vec<u32> = (face.iter())
                    .map(|i| {
                        *numbers.entry(*i).or_insert_with(|| {
                            drawing.points.push(surface.points[*i]);
                            drawing.points.len() as u32 - 1
                        })
                    })
                    .collect();
                for i in 1..corners.len() - 1 {
                    drawing
                        .triangles
                        .push([corners[0], corners[i], corners[i + 1]]);
                    drawing.parts.push(self.names.len());
                }
                for (i, a) in face.iter().enumerate() {
                    let b = face[(i + 1) % face.len()];
                    if *a < b {
                        drawing
                            .lines
                            .push(([surface.points[*a], surface.points[b]], CELL));
                    }
                }
            }
        }
        if self.case.has_elastic_wall() {
            self.wall(&mut drawing);
        }
        drawing
    }

    fn wall(&self, drawing: &mut Drawing) {
        let mesh = &self.domain.solid;
        let eye = View::of(&mesh.vertices).eye();
        let middle = self.middle();
        let is_kept = |e: &usize| {
            let x = mesh.shape.position(*e, [0.0; 3]);
            let (centre, radius) = middle(&x);
            (x - centre).dot(&eye) < OPEN * radius
        };
        let kept: Vec<usize> = (0..mesh.hexes.len()).filter(is_kept).collect();
        // Faces that two of them share are within the wall.
        let mut faces: HashMap<[usize; 4], Vec<(usize, usize, bool)>> = HashMap::new();
        for &e in &kept {
            for (axis, upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
                let corners = (0..8).filter(|v| (v >> axis & 1 == 1) == upper);
                let mut corners: Vec<usize> = corners.map(|v| mesh.hexes[e][v]).collect();
                corners.sort_unstable();
                let key = [corners[0], corners[1], corners[2], corners[3]];
                faces.entry(key).or_default().push((e, axis, upper));
            }
        }
        let inner = mesh.surfaces.get("inner").into_iter().flatten();
        let inner: std::collections::HashSet<(usize, usize, bool)> = inner
            .map(|(e, face)| (*e, face.axis as usize, face.upper))
            .collect();
        let mut single: Vec<(usize, usize, bool)> = (faces.into_values())
            .filter(|all| all.len() == 1 && !inner.contains(&all[0]))
            .map(|all| all[0])
            .collect();
        single.sort_unstable();
        for (e, axis, upper) in single {
            self.face(mesh, e, axis, upper, drawing);
            if (axis, upper) == (2, true) {
                self.fibres(
                    mesh,
                    e,
                    middle(&mesh.shape.position(e, [0.0; 3])).1,
                    drawing,
                );
            }
        }
    }

    /// A face of an element in pieces, with its edges.
    fn face(&self, mesh: &HexMesh, e: usize, axis: usize, upper: bool, drawing: &mut Drawing) {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let at = |i: usize, j: usize| {
            let mut xi = [if upper { 1.0 } else { -1.0 }; 3];
            xi[a] = 2.0 * i as f64 / PIECES as f64 - 1.0;
            xi[b] = 2.0 * j as f64 / PIECES as f64 - 1.0;
            mesh.shape.position(e, xi)
        };
        let first = drawing.points.len() as u32;
        let n = PIECES + 1;
        drawing.points.extend((0..n * n).map(|k| at(k % n, k / n)));
        for k in (0..n * n).filter(|k| k % n < PIECES && k / n < PIECES) {
            let corner = |k: usize| first + k as u32;
            let [p, q, r, s] = [k, k + 1, k + n + 1, k + n].map(corner);
            drawing.triangles.extend([[p, q, r], [p, r, s]]);
            drawing.parts.extend([mesh.regions[e]; 2]);
        }
        for i in 0..PIECES {
            for side in [0, PIECES] {
                drawing.lines.push(([at(i, side), at(i + 1, side)], EDGE));
                drawing.lines.push(([at(side, i), at(side, i + 1)], EDGE));
            }
        }
    }

    /// Both families of fibres in the middle of an outer face.
    fn fibres(&self, mesh: &HexMesh, e: usize, radius: f64, drawing: &mut Drawing) {
        let Some(Material::HolzapfelGasserOgden {
            fibre_angle_deg, ..
        }) = self.domain.materials.get(mesh.regions[e])
        else {
            return;
        };
        let xi = [0.0, 0.0, 1.0];
        let h = 1e-3;
        let slope = |k: usize| {
            let (mut low, mut high) = (xi, xi);
            (low[k], high[k]) = (xi[k] - h, xi[k] + h);
            (mesh.shape.position(e, high) - mesh.shape.position(e, low)) / (2.0 * h)
        };
        let [along, around] = mesh
            .directions
            .tangents(e, xi, slope(0), slope(1))
            .map(|t| t.normalize());
        let x = mesh.shape.position(e, xi);
        let (sin, cos) = fibre_angle_deg.to_radians().sin_cos();
        for family in [1.0, -1.0] {
            let arm = (around * cos + along * (family * sin)) * (LONG * radius);
            drawing.lines.push(([x - arm, x + arm], FIBRE));
        }
    }

    /// The cells in the cross-section in the middle of a branch.
    fn section(&self, stack: &Stack) -> String {
        let section = &stack.sections[stack.sections.len() / 2];
        let grid = self.tree.grid();
        let points = grid.positions(section, 1.0);
        let first = (section.rim[0] - section.centre).normalize();
        let quarter = section.rim[section.rim.len() / 4] - section.centre;
        let second = (quarter - first * first.dot(&quarter)).normalize();
        let widest = section
            .rim
            .iter()
            .map(|x| (x - section.centre).norm())
            .fold(0.0, f64::max);
        let scale = (0.5 * SIDE - 2.0 * MARGIN) / widest;
        let at = |i: usize| {
            let arm = points[i] - section.centre;
            format!(
                "{:.2},{:.2}",
                0.5 * SIDE + scale * arm.dot(&first),
                0.5 * SIDE - scale * arm.dot(&second)
            )
        };
        let mut cells = String::new();
        for quad in grid.quads() {
            let _ = write!(cells, "M{}Z", quad.map(at).join("L"));
        }
        let bar = super::round_length(0.5 * widest);
        let (x, y) = (10.0, SIDE - 9.0);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{SIDE}\" height=\"{SIDE}\" viewBox=\"0 0 {SIDE} {SIDE}\" \
             font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" \
             fill=\"white\"/>\n<path d=\"{cells}\" fill=\"{}\" stroke=\"#a33\" stroke-width=\"0.5\"/>\n<path d=\"M{x} {y}h{:.2}\" \
             stroke=\"black\" stroke-width=\"2\"/>\n<text x=\"{:.2}\" y=\"{}\">{} mm</text>\n<text x=\"10\" y=\"16\">{}</text>\n</svg>\n",
            html_colour(LUMEN),
            bar * scale,
            x + bar * scale + 6.0,
            y + 4.0,
            1e3 * bar,
            escape(&self.branch(stack))
        )
    }

    fn page(&self, name: &str, png: &[u8], drawing: &Drawing, sections: &[String]) -> String {
        let wall = match self.case.has_elastic_wall() {
            true => format!(
                "wall of {} elements of degree {}",
                self.domain.solid.hexes.len(),
                self.case.structure.p
            ),
            false => "a rigid wall".into(),
        };
        let lead = format!(
            "Before anything is computed. {} branches; blood in {} cells; {wall}; {} of {} s.",
            self.tree.stacks().len(),
            self.domain.fluid.cells(),
            self.case.steps_told(),
            self.case.time.step
        );
        let mut page = Page::new(&format!("The vessel {name}"), &lead);
        let picture = format!(
            "<figure class=\"whole\">\n<img alt=\"the vessel, its wall cut open\" src=\"data:image/png;base64,{}\">\n<figcaption>{}\
             </figcaption>\n</figure>\n",
            STANDARD.encode(png),
            escape(
                "The wall is cut open towards the reader: lumen (rose) with the cells of the blood, layers by material, elements of the \
                 wall, fibres of the outermost layer if it has some. Numbers are the worst places of the blood's mesh, below."
            )
        );
        page.section("picture", "The wall cut open", &picture);
        let html = format!(
            "<p>The wall with its layers, cut open. Drag to rotate, roll to zoom.</p>\n{}{}",
            super::legend(&self.names),
            scene::viewer(&self.surface(drawing), 0)
        );
        page.section("view", "In three dimensions", &html);
        page.section(
            "worst",
            "The worst places of the blood's mesh",
            &self.worst_places(),
        );
        page.section("branches", "Branches", &self.branches());
        let drawings = sections.iter().map(|svg| figure(svg, "", None));
        page.section(
            "sections",
            "Cells in the middle of each branch",
            &gallery(&drawings.collect::<Vec<_>>()),
        );
        page.to_html()
    }

    fn surface(&self, drawing: &Drawing) -> DrawnSurface {
        let mut parts = vec![self.names.len(); drawing.points.len()];
        for (triangle, part) in drawing.triangles.iter().zip(&drawing.parts) {
            triangle.iter().for_each(|p| parts[*p as usize] = *part);
        }
        let middle = self.middle();
        let away = drawing
            .points
            .iter()
            .map(|x| 1e3 * (x - middle(x).0).norm());
        let faces = drawing.triangles.iter().map(|triangle| triangle.to_vec());
        DrawnSurface {
            wall: WetSurface::new(drawing.points.clone(), faces.collect()),
            times: vec![0.0],
            fields: vec![
                SurfaceField::of_kinds("Material", &parts, &self.colours()),
                SurfaceField::new("Distance from the centre-line", "mm", vec![away.collect()]),
            ],
            frames: vec![drawing.points.clone()],
        }
    }

    fn worst_places(&self) -> String {
        let rows = self
            .worst
            .iter()
            .enumerate()
            .map(|(i, (jacobian, x, stack))| {
                let place = [x.x, x.y, x.z].map(|c| significant(1e3 * c, 4)).join(", ");
                vec![
                    (i + 1).to_string(),
                    significant(*jacobian, 2),
                    place,
                    escape(&self.branch(&self.tree.stacks()[*stack])),
                ]
            });
        let note = "<p>The scaled Jacobian is 1 for a cube and 0 for a cell that is degenerate; below about 0.2 solvers take more \
                    iterations. It is smallest next to the apex of a junction.</p>\n";
        let heads = ["number", "scaled Jacobian", "place / mm", "branch"];
        format!("{note}{}", table(&heads, &rows.collect::<Vec<_>>()))
    }

    fn branches(&self) -> String {
        let mm = |x: f64| significant(1e3 * x, 3);
        let rows = self.tree.stacks().iter().map(|stack| {
            let pairs = stack.sections.windows(2);
            let length: f64 = pairs
                .map(|pair| (pair[1].centre - pair[0].centre).norm())
                .sum();
            let last = stack.sections.len() - 1;
            // Folded cross-sections are not round.
            let [first, last] = [
                usize::from(stack.from.is_some()) * last / 3,
                last - usize::from(stack.to.is_some()) * last / 3,
            ];
            vec![
                escape(&self.branch(stack)),
                mm(length),
                format!(
                    "{} to {}",
                    mm(radius(stack, first)),
                    mm(radius(stack, last))
                ),
                (stack.sections.len() - 1).to_string(),
            ]
        });
        let heads = ["branch", "length / mm", "radius / mm", "cells along"];
        table(&heads, &rows.collect::<Vec<_>>())
    }
}
