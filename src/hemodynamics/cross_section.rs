//! Flow, pressure and area of a cross-section of a vessel, from its wall and its openings.
//!
//! Blood is incompressible: what passes a cross-section is what leaves through the openings beyond it, and what the
//! vessel there grows by. So it needs no field of the blood, and is as exact as the balance of volume of its solver.

use super::wall::{WallState, WetSurface, widened};
use crate::Vec3;
use crate::fluid::OpeningReport;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Where a cross-section is.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSectionPlace {
    /// What the case calls it.
    pub name: String,
    /// Patch of the branch; none of a vessel without branches.
    pub patch: Option<String>,
    /// Arc length (m) along the branch, or along the vessel's centre-line.
    pub at: f64,
    /// The openings, the inlet first, each with the patch of the branch that ends there; none of a vessel without
    /// branches.
    pub openings: Vec<BranchOpening>,
}

/// An opening where a branch ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BranchOpening {
    /// Name of the opening.
    pub name: String,
    /// Patch of the wall of its branch.
    pub patch: String,
}

/// A cross-section: a closed line of edges of the wall's faces, which zigzags where these lie in no rows.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSection {
    /// Faces beyond it, seen from the inlet.
    beyond: Vec<usize>,
    /// Faces next to it, on both sides.
    beside: Vec<usize>,
    /// Its edges, as the faces beyond turn.
    edges: Vec<[u32; 2]>,
    /// Names of the openings beyond; none of a vessel without branches, where all but the inlet are.
    openings: Option<Vec<String>>,
}

/// A cross-section at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossSectionState {
    /// What flows through it as it moves with the wall, m³/s, away from the inlet; none in the first step.
    pub flow: Option<f64>,
    /// Mean pressure on the faces next to it, Pa.
    pub pressure: f64,
    /// Area, m².
    pub area: f64,
}

/// The volumes (m³) that the walls beyond cross-sections have swept at the last two times (s), the last first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SweptVolumes(Vec<(f64, Vec<f64>)>);

impl SweptVolumes {
    /// Adds those at `time` and gives their rates of change (m³/s) there: by a backward difference over one step, or
    /// over two of any lengths (second order).
    fn rates(&mut self, time: f64, volumes: Vec<f64>, is_second_order: bool) -> Option<Vec<f64>> {
        let rate = |i: usize| {
            let (before, earlier) = (self.0.first()?, self.0.get(1).filter(|_| is_second_order));
            let step = time - before.0;
            let first = (volumes[i] - before.1[i]) / step;
            let Some(earlier) = earlier else {
                return Some(first);
            };
            let length = before.0 - earlier.0;
            let second = (before.1[i] - earlier.1[i]) / length;
            Some(first + step / (step + length) * (first - second))
        };
        let rates = (0..volumes.len()).map(rate).collect();
        self.0.insert(0, (time, volumes));
        self.0.truncate(2);
        rates
    }
}

impl CrossSection {
    /// The closed line of edges nearest to a place of the `wall`; none if no such line parts the wall there.
    pub fn new(wall: &WetSurface, place: &CrossSectionPlace) -> Option<Self> {
        let is_on = |face: usize| {
            let patch = place.patch.as_ref();
            patch.is_none_or(|patch| wall.is_of_patch(face, patch))
        };
        // The sides of the faces on the branch: whether they lie beyond.
        let sides: Vec<Option<bool>> = (0..wall.faces.len())
            .map(|face| is_on(face).then(|| wall.along(face) >= place.at))
            .collect();
        let mut at_edge: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        for (face, corners) in wall.faces.iter().enumerate() {
            for edge in edges(corners) {
                at_edge.entry(sorted(edge)).or_default().push(face);
            }
        }
        let is_cut = |faces: &[usize]| match faces {
            [a, b] => matches!((sides[*a], sides[*b]), (Some(a), Some(b)) if a != b),
            _ => false,
        };
        let crossed: Vec<[u32; 2]> = (at_edge.iter())
            .filter(|(_, faces)| is_cut(faces))
            .map(|(edge, _)| *edge)
            .collect();
        // A single face among irregular ones may lie on the other side than all of its neighbours.
        let cut = largest_part(crossed);
        let is_cut = |edge: [u32; 2]| cut.contains(&sorted(edge));
        let beside: BTreeSet<usize> = cut.iter().flat_map(|edge| at_edge[edge].clone()).collect();
        let mut is_beyond = vec![false; wall.faces.len()];
        let mut next: Vec<usize> = (beside.iter().copied())
            .filter(|face| sides[*face] == Some(true))
            .collect();
        while let Some(face) = next.pop() {
            if std::mem::replace(&mut is_beyond[face], true) {
                continue;
            }
            for edge in edges(&wall.faces[face]) {
                if !is_cut(edge) {
                    let faces = at_edge[&sorted(edge)].iter();
                    next.extend(faces.filter(|other| !is_beyond[**other]));
                }
            }
        }
        let edges: Vec<[u32; 2]> = (beside.iter())
            .filter(|face| is_beyond[**face])
            .flat_map(|face| edges(&wall.faces[*face]))
            .filter(|edge| is_cut(*edge))
            .collect();
        let is_apart = beside
            .iter()
            .all(|face| Some(is_beyond[*face]) == sides[*face]);
        if !is_apart || !is_closed(&edges) {
            return None;
        }
        let lies_beyond = |(number, opening): (usize, &BranchOpening)| {
            let is_here = place.patch.as_ref() == Some(&opening.patch);
            let first =
                || (0..wall.faces.len()).find(|face| wall.is_of_patch(*face, &opening.patch));
            match is_here {
                true => number > 0,
                false => first().is_some_and(|face| is_beyond[face]),
            }
        };
        let openings = place.patch.as_ref().map(|_| {
            let beyond = place.openings.iter().enumerate();
            let beyond = beyond.filter(|(number, opening)| lies_beyond((*number, opening)));
            beyond.map(|(_, opening)| opening.name.clone()).collect()
        });
        let beyond = is_beyond
            .iter()
            .enumerate()
            .filter(|(_, is_beyond)| **is_beyond);
        Some(Self {
            beyond: beyond.map(|(face, _)| face).collect(),
            beside: beside.into_iter().collect(),
            edges,
            openings,
        })
    }

    fn area(&self, wall: &WetSurface, displacement: &[[f32; 3]]) -> f64 {
        let at = |p: u32| wall.points[p as usize] + widened(&displacement[p as usize]);
        let origin = at(self.edges[0][0]);
        let vector = |[a, b]: &[u32; 2]| 0.5 * (at(*a) - origin).cross(&(at(*b) - origin));
        self.edges.iter().map(vector).sum::<Vec3>().norm()
    }
}

/// Cross-sections at the end of a step, with the pressure on each face (Pa) and the openings, of which the inlet is the
/// first.
pub fn observe(
    sections: &[CrossSection],
    wall: &WetSurface,
    state: &WallState,
    pressure: &[f64],
    openings: &[OpeningReport],
    earlier: &mut SweptVolumes,
    is_second_order: bool,
) -> Vec<CrossSectionState> {
    let swept = wall.swept(&state.displacement);
    let volume = |section: &CrossSection| section.beyond.iter().map(|face| swept[*face]).sum();
    let volumes = sections.iter().map(volume).collect();
    let rates = earlier.rates(state.time, volumes, is_second_order);
    let observe = |(i, section): (usize, &CrossSection)| {
        let is_beyond = |(number, opening): &(usize, &OpeningReport)| match &section.openings {
            Some(names) => names.contains(&opening.name),
            None => *number > 0,
        };
        let beyond = openings.iter().enumerate().filter(is_beyond);
        let leaves: f64 = beyond.map(|(_, opening)| -opening.flow).sum();
        let pressures = section.beside.iter().map(|face| pressure[*face]);
        CrossSectionState {
            flow: rates.as_ref().map(|rates| leaves + rates[i]),
            pressure: pressures.sum::<f64>() / section.beside.len() as f64,
            area: section.area(wall, &state.displacement),
        }
    };
    sections.iter().enumerate().map(observe).collect()
}

fn edges(corners: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| [*a, *b])
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The largest set of edges that are connected with each other.
fn largest_part(edges: Vec<[u32; 2]>) -> BTreeSet<[u32; 2]> {
    let mut at_point: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for edge in &edges {
        edge.iter()
            .for_each(|point| at_point.entry(*point).or_default().push(*edge));
    }
    let mut left: BTreeSet<[u32; 2]> = edges.into_iter().collect();
    let mut largest = BTreeSet::new();
    while let Some(edge) = left.pop_first() {
        let (mut part, mut next) = (BTreeSet::from([edge]), vec![edge]);
        while let Some(edge) = next.pop() {
            for other in edge.iter().flat_map(|point| &at_point[point]) {
                if left.remove(other) {
                    part.insert(*other);
                    next.push(*other);
                }
            }
        }
        if part.len() > largest.len() {
            largest = part;
        }
    }
    largest
}

/// Whether as many edges end at each point as begin there; the line may touch itself.
fn is_closed(edges: &[[u32; 2]]) -> bool {
    let mut balance: BTreeMap<u32, i32> = BTreeMap::new();
    for [a, b] in edges {
        *balance.entry(*a).or_default() += 1;
        *balance.entry(*b).or_default() -= 1;
    }
    !edges.is_empty() && balance.values().all(|balance| *balance == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemodynamics::wall::tests::tube;
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    fn at(at: f64) -> CrossSectionPlace {
        CrossSectionPlace {
            name: "middle".into(),
            patch: None,
            at,
            openings: Vec::new(),
        }
    }

    fn opening(name: &str, flow: f64) -> OpeningReport {
        OpeningReport {
            name: name.into(),
            flow,
            mean_pressure: 0.0,
            model_pressure: None,
        }
    }

    /// A tube whose radius grows as 1 + t + t²: its volume is known.
    #[test]
    fn flow_through_a_widening_tube_is_what_it_grows_by() {
        let wall = tube(8, 40);
        let section = CrossSection::new(&wall, &at(1.6)).unwrap();
        let polygon = 20.0 * (TAU / 40.0).sin();
        let area = |t: f64| polygon * 4.0 * (1.0 + t + t * t).powi(2);
        for (is_second_order, tolerance) in [(false, 0.03), (true, 3e-4)] {
            let mut earlier = SweptVolumes::default();
            let mut flow = None;
            for (step, t) in [0.0, 0.004, 0.01, 0.02].into_iter().enumerate() {
                let by = (t + t * t) as f32;
                let displacement: Vec<[f32; 3]> = (wall.points.iter())
                    .map(|x| [0.0, by * x.y as f32, by * x.z as f32])
                    .collect();
                let state = WallState {
                    time: t,
                    shear: Vec::new(),
                    displacement,
                };
                let found = observe(
                    std::slice::from_ref(&section),
                    &wall,
                    &state,
                    &vec![7.0; wall.faces.len()],
                    &[opening("inlet", 0.0), opening("outlet", -5.0)],
                    &mut earlier,
                    is_second_order,
                );
                assert_eq!(found[0].flow.is_none(), step == 0);
                assert_relative_eq!(found[0].area, area(t), max_relative = 1e-6);
                assert_eq!(found[0].pressure, 7.0);
                flow = found[0].flow;
            }
            // Two and a half metres lie beyond the line of edges at 1.5 m.
            let t: f64 = 0.02;
            let rate = 2.0 * (1.0 + t + t * t) * (1.0 + 2.0 * t) * polygon * 4.0;
            assert_relative_eq!(flow.unwrap(), 5.0 + 2.5 * rate, max_relative = tolerance);
        }
    }

    #[test]
    fn beyond_the_ends_of_a_wall_there_is_no_cross_section() {
        let wall = tube(8, 12);
        assert_eq!(CrossSection::new(&wall, &at(-0.1)), None);
        assert_eq!(CrossSection::new(&wall, &at(4.1)), None);
    }
}
