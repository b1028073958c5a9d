//! A vessel that branches: its wall cut open, its junctions, its meshes, and the worst places of these.

mod cross_section;
mod drawing;
mod junction;

use super::legend::{self, Overlay, Sign};
use super::{LUMEN, PIXELS, Preview, colour};
use crate::Vec3;
use crate::case::{ResolvedCase, TreeKeys};
use crate::geometry::tree::{Stack, Tree};
use crate::hemodynamics::WetSurface;
use crate::output::figure::solid::{DrawnSolid, View};
use crate::output::report::page::{Page, escape, figure, gallery, significant, table};
use crate::output::report::scene;
use crate::output::report::surface::{DrawnSurface, SurfaceField};
use crate::simulation::assembly::Domain;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use drawing::Drawing;

/// Places of the mesh that are pointed out, and how far they lie apart, in radii.
const WORST: usize = 5;
const APART: f64 = 1.0;
/// Length of the arrow of the flow, in radii: a vessel that bends farther on would cross a longer one.
const ARROW: f64 = 6.0;

/// What is drawn.
struct Drawn<'a> {
    case: &'a ResolvedCase,
    keys: &'a TreeKeys,
    names: Vec<String>,
    domain: Domain,
    tree: Tree,
    /// Worst cells: scaled Jacobian, place (m) and branch; none of a mesh that is not the driver's.
    worst: Vec<(f64, Vec3, usize)>,
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
    let worst = match case.has_own_openfoam() {
        true => Vec::new(),
        false => worst(&tree),
    };
    let drawn = Drawn {
        case,
        keys,
        names,
        domain,
        tree,
        worst,
    };
    let eye = View::of(&drawn.domain.solid.vertices).eye();
    let drawing = drawn.drawing(&eye, None);
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
    let centres: Vec<Vec3> = root.sections.iter().map(|section| section.centre).collect();
    let ends = [centres[0], arrow_ends(&centres, ARROW * root.radius(0))];
    let marked = drawn.worst.iter().enumerate();
    let marked: Vec<(usize, Vec3)> = marked.map(|(i, (_, x, _))| (i + 1, *x)).collect();
    let overlay = Overlay {
        flow: Some((ends, 1.3 * root.radius(0))),
        marked: &marked,
        names: &drawn.legend(drawing.has_fibres()),
        letters: 1.0,
    };
    let png = legend::with_legend(&overlay, &image, PIXELS, &solid.projection(&view, PIXELS))?;
    let sections = drawn.stacks().into_iter();
    let sections: Vec<String> = match drawn.is_meshed() {
        true => sections.map(|stack| drawn.section(stack)).collect(),
        false => sections.map(|stack| drawn.cut(stack)).collect(),
    };
    Ok(Preview {
        html: drawn.page(name, &png, &drawing, &sections)?,
        png,
        svg: super::cross_section::side_by_side(&sections),
    })
}

/// Where an arrow along the beginning of a branch with these centres (m) ends: half-way at most, and within a `reach`
/// (m) of where it begins, along the branch.
fn arrow_ends(centres: &[Vec3], reach: f64) -> Vec3 {
    let mut length = 0.0;
    let pieces = centres.windows(2).take((centres.len() - 1) / 2);
    let is_near = |piece: &&[Vec3]| {
        length += (piece[1] - piece[0]).norm();
        length <= reach
    };
    let within = pieces.take_while(is_near).count();
    centres[within.max(1)]
}

/// The worst cells, the next one always so far from those before that it is another place.
fn worst(tree: &Tree) -> Vec<(f64, Vec3, usize)> {
    let mut all = tree.qualities();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found: Vec<(f64, Vec3, usize)> = Vec::new();
    for (jacobian, x) in all {
        let is_near = |(_, y, stack): &(f64, Vec3, usize)| {
            (x - y).norm() < APART * tree.stacks()[*stack].radius(0)
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
    fn legend(&self, has_fibres: bool) -> Vec<(String, Sign)> {
        let mut names = legend::names(&self.names, false);
        names.retain(|(name, _)| has_fibres || name != "fibres");
        names
    }

    /// Whether the driver makes the blood's mesh.
    fn is_meshed(&self) -> bool {
        !self.case.has_own_openfoam()
    }

    /// The branches in the order of the case.
    fn stacks(&self) -> Vec<&Stack> {
        let mut stacks: Vec<&Stack> = self.tree.stacks().iter().collect();
        stacks.sort_by_key(|stack| stack.wall);
        stacks
    }

    fn branch(&self, stack: &Stack) -> String {
        self.tree.branch_name(stack, &self.keys.branches())
    }

    /// The nearest middle of a cross-section, and the radius there (m).
    fn middle(&self) -> impl Fn(&Vec3) -> (Vec3, f64) + '_ {
        let sections = self.tree.stacks().iter().flat_map(|stack| {
            (0..stack.sections.len()).map(|i| (stack.sections[i].centre, stack.radius(i)))
        });
        let sections: Vec<(Vec3, f64)> = sections.collect();
        move |x: &Vec3| {
            let all = sections.iter().copied();
            let nearest = all.min_by(|a, b| (a.0 - x).norm().total_cmp(&(b.0 - x).norm()));
            nearest.unwrap_or((*x, 1.0))
        }
    }

    /// What the page begins with.
    fn lead(&self) -> String {
        let wall = match self.case.has_elastic_wall() {
            true => format!(
                "wall of {} elements of degree {}",
                self.domain.solid.hexes.len(),
                self.case.structure.p
            ),
            false => "a rigid wall".into(),
        };
        format!(
            "Before anything is computed. {} branches; blood in {} cells{}; {wall}; {} of {} s.",
            self.tree.stacks().len(),
            self.domain.fluid.cells(),
            match self.is_meshed() {
                true => "",
                false => " of your OpenFOAM case",
            },
            self.case.steps_told(),
            self.case.time.step
        )
    }

    fn page(
        &self,
        name: &str,
        png: &[u8],
        drawing: &Drawing,
        sections: &[String],
    ) -> std::io::Result<String> {
        let mut page = Page::new(&format!("The vessel {name}"), &self.lead());
        let mut caption = String::from(
            "The wall is cut open towards the reader: lumen (rose) with the mesh of the blood, layers by material, elements of \
             the wall, fibres of the outermost layer if it has some.",
        );
        if self.is_meshed() {
            caption += " Numbers are the worst places of the blood's mesh, below.";
        }
        let picture = format!(
            "<figure class=\"whole\">\n<img alt=\"the vessel, its wall cut open\" src=\"data:image/png;base64,{}\">\n<figcaption>{}\
             </figcaption>\n</figure>\n",
            STANDARD.encode(png),
            escape(&caption)
        );
        page.section("picture", "The wall cut open", &picture);
        let html = format!(
            "<p>The wall with its layers, cut open. Drag to rotate, scroll to zoom.</p>\n{}{}",
            super::legend(&self.names),
            scene::viewer(&self.surface(drawing), 0)
        );
        page.section("view", "In three dimensions", &html);
        let (junctions, count) = self.junctions();
        if count > 0 {
            let drawn = junctions.iter().map(|junction| self.junction(junction));
            let drawn = drawn.collect::<std::io::Result<Vec<_>>>()?;
            let note = match count > drawn.len() {
                true => format!(
                    "<p>The {} with the worst cells of {count}.</p>\n",
                    drawn.len()
                ),
                false => String::new(),
            };
            page.section("junctions", "Junctions", &(note + &gallery(&drawn)));
        }
        if self.is_meshed() {
            page.section(
                "worst",
                "The worst places of the blood's mesh",
                &self.worst_places(),
            );
        }
        page.section("branches", "Branches", &self.branches());
        let drawings = sections.iter().map(|svg| figure(svg, "", None));
        let drawings = gallery(&drawings.collect::<Vec<_>>());
        match self.is_meshed() {
            true => page.section("sections", "Cells in the middle of each branch", &drawings),
            false => {
                let note = "<p>Across the middle of each branch: elements of the wall in the colours of their materials, and the \
                            wet patches of the OpenFOAM mesh in red.</p>\n";
                let legend = super::legend(&self.names);
                let html = format!("{note}{legend}{drawings}");
                page.section("sections", "How the two meshes fit together", &html);
            }
        }
        Ok(page.to_html())
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
        let rows = self.stacks().into_iter().map(|stack| {
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
                format!("{} to {}", mm(stack.radius(first)), mm(stack.radius(last))),
                (stack.sections.len() - 1).to_string(),
            ]
        });
        let along = match self.is_meshed() {
            true => "cells along",
            false => "faces of the wall along",
        };
        let heads = ["branch", "length / mm", "radius / mm", along];
        table(&heads, &rows.collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along a vessel that turns back the arrow keeps to its beginning; along a short one it ends half-way.
    #[test]
    fn the_arrow_of_the_flow_keeps_to_the_beginning() {
        let at = |i: usize| match i {
            0..=20 => Vec3::new(i as f64, 0.0, 0.0),
            _ => Vec3::new(40.0 - i as f64, 1.0, 0.0),
        };
        let centres: Vec<Vec3> = (0..=40).map(at).collect();
        assert_eq!(arrow_ends(&centres, 6.0), at(6));
        assert_eq!(arrow_ends(&centres[..=8], 6.0), at(4));
        // Sections that are farther apart than the arrow is long.
        assert_eq!(arrow_ends(&centres[..=8], 0.5), at(1));
    }
}
