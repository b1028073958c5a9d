//! A vessel: surfaces around a centre-line, section by section.

use super::feature::{Feature, thickening};
use super::random_radius::RandomRadius;
use super::section::Section;
use super::{HexMesh, Imperfection};
use super::{Surfaces, WallGrid};
use crate::Vec3;
use crate::case::{BloodVessel, FluidMesh, Material, Native, Shape, VesselSide, WallMesh};
use crate::case::{MAX_BEND_DEG, MAX_ELEMENT_BEND_DEG};
use crate::curve::SpaceCurve;
use fsi_pfem::mesh::equal_stations;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Index of the surface between blood and wall; those further out follow.
const LUMEN: usize = 0;
/// A described vessel has as many elements or cells as its keys say along this many radii.
const RADII: f64 = 10.0;
/// Share of an element by which a vessel may be longer than a whole number of them: radii of a file are never exact,
/// and what is one ten-thousandth thinner is to have the same mesh.
const SPARE: f64 = 0.01;
/// Cells next to a rim of the elastic part that `fluid.mesh.rim_parts` divides.
const RIM_CELLS: usize = 4;

/// A vessel: rigid sections upstream, elastic ones from s = 0 on, rigid ones downstream of those.
///
/// With the shares `w_i(s)` of the sections, cosine blends from 0 to 1, the radius of surface `k` is `r_k = (1 - w_i)
/// r_k + w_i r_{k,i}` for one section `i` after the other, and then what each feature takes off: for the paper's vessel
/// equation (17), where graft and artery follow each other and the shares in the imperfection are (1, 1/3, 0).
#[derive(Debug, Clone, PartialEq)]
pub struct Vessel {
    pub(super) line: SpaceCurve,
    pub(super) sections: Vec<Section>,
    pub(super) features: Vec<Feature>,
    pub(super) materials: Vec<Material>,
    /// What they are called.
    pub(super) names: Vec<String>,
    /// Whether numbers of elements are for a length in radii, not for a section.
    pub(super) counts_radii: bool,
}

/// A section in a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Arc length of its beginning, m.
    pub from: f64,
    /// Arc length of its end, m.
    pub to: f64,
    /// Elements or cells along it.
    pub pieces: usize,
    /// Whether its wall is elastic.
    pub is_elastic: bool,
}

/// Numbers of elements or cells along a vessel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxialNumbers {
    /// Along the paper's rigid extension.
    pub extension: usize,
    /// Along each other section, or along ten radii.
    pub per_section: usize,
    /// Angle (degrees) by which one of them may bend at most.
    pub most_bend_deg: f64,
    /// What is shorter next to the rims of the elastic part.
    pub rims: Rims,
}

/// How elements or cells next to the rims of the elastic part are divided: where a wall is held its displacement, and
/// with it the flow's shear, bends within a wall's thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rims {
    /// So many next to each rim ...
    pub pieces: usize,
    /// ... are cut into so many each.
    pub parts: usize,
}

impl Rims {
    /// All are equally long.
    pub const LIKE_OTHERS: Self = Self {
        pieces: 0,
        parts: 1,
    };
}

impl From<&FluidMesh> for AxialNumbers {
    fn from(mesh: &FluidMesh) -> Self {
        Self {
            extension: mesh.axial_extension,
            per_section: mesh.axial_per_section,
            most_bend_deg: MAX_BEND_DEG,
            rims: Rims {
                pieces: RIM_CELLS,
                parts: mesh.rim_parts.unwrap_or(1),
            },
        }
    }
}

impl From<&Native> for AxialNumbers {
    fn from(mesh: &Native) -> Self {
        Self::of_spectral_elements(mesh.axial_extension, mesh.axial_per_section)
    }
}

impl AxialNumbers {
    /// Those of the native fluid's elements.
    pub fn of_spectral_elements(extension: usize, per_section: usize) -> Self {
        Self {
            extension,
            per_section,
            most_bend_deg: MAX_ELEMENT_BEND_DEG,
            rims: Rims {
                pieces: 1,
                parts: 2,
            },
        }
    }
}

impl From<&WallMesh> for AxialNumbers {
    fn from(mesh: &WallMesh) -> Self {
        Self {
            extension: 0,
            per_section: mesh.axial_per_section,
            most_bend_deg: MAX_BEND_DEG,
            rims: Rims::LIKE_OTHERS,
        }
    }
}

impl Vessel {
    /// The vessel of a checked case.
    pub fn new(vessel: &BloodVessel) -> Self {
        let (mut shaped, is_of_paper) = match &vessel.shape {
            Shape::Anastomosis(vessel) => (Self::anastomosis(vessel), true),
            Shape::Vessel(vessel) => (Self::described(vessel), false),
        };
        let surfaces = shaped.layers() + 1;
        let shares = match is_of_paper {
            true => Imperfection::SHARE.to_vec(),
            false => (0..surfaces).map(|k| thickening(k, surfaces)).collect(),
        };
        let random = vessel.random_lumen.as_ref();
        let random = random.and_then(|keys| RandomRadius::new(keys, shares));
        shaped.features.extend(random.map(Feature::Random));
        shaped
    }

    /// The centre-line; its arc length is 0 where the elastic part begins, and x in the paper's vessels.
    pub fn centre_line(&self) -> &SpaceCurve {
        &self.line
    }

    /// Sections, downstream.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Sections with an elastic wall, downstream.
    pub fn elastic_sections(&self) -> impl Iterator<Item = &Section> {
        self.sections.iter().filter(|section| section.is_elastic)
    }

    /// Arc length (m) of the end of the elastic part, which begins at 0.
    pub fn end(&self) -> f64 {
        let ends = self.elastic_sections().map(|section| section.to);
        ends.fold(0.0, f64::max)
    }

    /// Materials by region of the wall's mesh.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The imperfection of the lumen, if it has one.
    pub fn imperfection(&self) -> Option<&Imperfection> {
        self.features.iter().find_map(|feature| match feature {
            Feature::Imperfection(imperfection) => Some(imperfection),
            Feature::Bump(_) | Feature::Lumen(_) | Feature::Random(_) => None,
        })
    }

    /// What the materials are called.
    pub fn material_names(&self) -> &[String] {
        &self.names
    }

    /// Material (an index) and thickness (m) of each layer of a section, from the inside out.
    pub fn layers_of(&self, section: &Section) -> Vec<(usize, f64)> {
        let thicknesses = section.surfaces.windows(2).map(|pair| pair[1] - pair[0]);
        section.materials.iter().copied().zip(thicknesses).collect()
    }

    /// Layers of the wall.
    pub fn layers(&self) -> usize {
        let mut sections = self.elastic_sections();
        sections.next().map_or(0, |section| section.materials.len())
    }

    /// Radius (m) of the lumen at the arc length `s` (m) of the centre-line.
    pub fn lumen_radius(&self, s: f64, phi: f64) -> f64 {
        self.radius(LUMEN, s, phi)
    }

    /// How far a point of the cross-section where the vessel begins, or ends, is from the centre-line, relative to the
    /// radius of the lumen in this direction.
    pub fn opening_share(&self, end: VesselSide, point: &Vec3) -> f64 {
        let s = match end {
            VesselSide::Start => self.sections[0].from,
            VesselSide::End => self.sections[self.sections.len() - 1].to,
        };
        let frame = self.line.frame(s);
        let [y, z] = frame.across(&(point - frame.origin));
        y.hypot(z) / self.lumen_radius(s, z.atan2(y))
    }

    /// Volume (m³) of the unloaded lumen between two cross-sections.
    pub fn lumen_volume(&self, from: f64, to: f64) -> f64 {
        // V = ∫∫ (r²/2 - κ·e r³/3) dφ ds; the periodic trapezoidal rule around, Gauss' two points in many short pieces
        // along.
        const AROUND: usize = 180;
        let pieces = 400;
        let h = (to - from) / pieces as f64;
        let mut sum = 0.0;
        for piece in 0..pieces {
            for gauss in [-1.0, 1.0] {
                let s = from + h * (piece as f64 + 0.5 + 0.5 * gauss / 3f64.sqrt());
                let bend = self.line.frame(s).across(&self.line.curvature(s));
                sum += (0..AROUND)
                    .map(|j| {
                        let phi = TAU * j as f64 / AROUND as f64;
                        let towards = bend[0] * phi.cos() + bend[1] * phi.sin();
                        let r = self.lumen_radius(s, phi);
                        r.powi(2) * (1.0 - 2.0 / 3.0 * towards * r)
                    })
                    .sum::<f64>();
            }
        }
        sum * 0.25 * h * TAU / AROUND as f64
    }

    /// The sections in a mesh, downstream; those without cells are left out.
    pub fn spans(&self, numbers: impl Into<AxialNumbers>) -> Vec<Span> {
        let numbers = numbers.into();
        let span = |section: &Section| Span {
            from: section.from,
            to: section.to,
            pieces: self.pieces(section, numbers),
            is_elastic: section.is_elastic,
        };
        let spans = self.sections.iter().map(span);
        let spans: Vec<Span> = spans.filter(|span| span.pieces > 0).collect();
        divided_at_rims(spans, numbers.rims)
    }

    fn pieces(&self, section: &Section, numbers: AxialNumbers) -> usize {
        const SAMPLES: usize = 200;
        let length = section.to - section.from;
        let at = |i: usize| section.from + length * (i as f64 + 0.5) / SAMPLES as f64;
        let mean = |value: &dyn Fn(f64) -> f64| {
            (0..SAMPLES).map(|i| value(at(i))).sum::<f64>() / SAMPLES as f64
        };
        let turn_deg = (length * mean(&|s| self.line.curvature(s).norm())).to_degrees();
        let by_turn = (turn_deg / numbers.most_bend_deg - SPARE).ceil() as usize;
        if !self.counts_radii {
            return match (section.is_elastic, numbers.extension) {
                (true, _) => numbers.per_section,
                // None is asked for.
                (false, 0) => 0,
                (false, extension) => extension.max(by_turn),
            };
        }
        let radii = length * mean(&|s| 1.0 / self.surface(LUMEN, s));
        let by_length = (numbers.per_section as f64 * radii / RADII - SPARE).ceil() as usize;
        by_length.max(by_turn).max(1)
    }

    /// Hexahedra of the elastic wall; their regions are indices into the [materials](Self::materials).
    pub fn solid_mesh(&self, mesh: &WallMesh) -> HexMesh {
        let spans = self.spans(mesh).into_iter().filter(|span| span.is_elastic);
        let (mut stations, mut section_of) = (vec![0.0], Vec::new());
        for (section, span) in spans.enumerate() {
            stations.extend(&equal_stations(span.from, span.to, span.pieces)[1..]);
            section_of.extend(vec![section; span.pieces]);
        }
        let grid = WallGrid {
            stations,
            circumferential: mesh.circumferential,
            radial_per_layer: mesh.radial_per_layer,
            layers: self.layers(),
        };
        let elastic: Vec<&Section> = self.elastic_sections().collect();
        grid.mesh(Arc::new(self.clone()), |axial, layer| {
            elastic[section_of[axial]].materials[layer]
        })
    }

    /// Radius (m) of a surface without features.
    fn surface(&self, index: usize, s: f64) -> f64 {
        let (first, others) = self.sections.split_first().expect("a vessel has a section");
        let mut radius = first.surface(index, s);
        for section in others {
            let w = section.share(s);
            radius = (1.0 - w) * radius + w * section.surface(index, s);
        }
        radius
    }
}

impl Surfaces for Vessel {
    fn radius(&self, index: usize, s: f64, phi: f64) -> f64 {
        let mut radius = self.surface(index, s);
        if self.features.is_empty() {
            return radius;
        }
        let lumen = self.surface(LUMEN, s);
        for feature in &self.features {
            radius -= feature.inward(index, self.layers() + 1, s, phi, lumen);
        }
        radius
    }

    fn point(&self, s: f64, y: f64, z: f64) -> Vec3 {
        self.line.frame(s).point(y, z)
    }
}

/// The same spans with the first and the last pieces of the elastic part divided.
fn divided_at_rims(spans: Vec<Span>, rims: Rims) -> Vec<Span> {
    if rims.parts == 1 {
        return spans;
    }
    let first = spans.iter().position(|span| span.is_elastic);
    let last = spans.iter().rposition(|span| span.is_elastic);
    let mut divided = Vec::new();
    for (index, span) in spans.into_iter().enumerate() {
        let length = (span.to - span.from) / span.pieces as f64;
        // A span between two rims has enough pieces for one before the other.
        let here = |rim: Option<usize>, left: usize| match rim == Some(index) {
            true => rims.pieces.min(left),
            false => 0,
        };
        let upstream = here(first, span.pieces);
        let downstream = here(last, span.pieces - upstream);
        let from = span.from + length * upstream as f64;
        let to = span.to - length * downstream as f64;
        let parts = [
            (span.from, from, upstream * rims.parts),
            (from, to, span.pieces - upstream - downstream),
            (to, span.to, downstream * rims.parts),
        ];
        let parts = parts.into_iter().filter(|(.., pieces)| *pieces > 0);
        divided.extend(parts.map(|(from, to, pieces)| Span {
            from,
            to,
            pieces,
            ..span
        }));
    }
    divided
}

/// Hexahedra of the deformable wall of a case; see [`Vessel::solid_mesh`].
pub fn solid_mesh(vessel: &BloodVessel) -> HexMesh {
    Vessel::new(vessel).solid_mesh(&vessel.structure)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(from: f64, to: f64, pieces: usize, is_elastic: bool) -> Span {
        Span {
            from,
            to,
            pieces,
            is_elastic,
        }
    }

    #[test]
    fn only_what_is_next_to_a_rim_is_divided() {
        let spans = vec![
            span(-4.0, 0.0, 4, false),
            span(0.0, 10.0, 10, true),
            span(10.0, 16.0, 3, true),
        ];
        let rims = Rims {
            pieces: 4,
            parts: 3,
        };
        let expected = [
            span(-4.0, 0.0, 4, false),
            span(0.0, 4.0, 12, true),
            span(4.0, 10.0, 6, true),
            // No more pieces than it has.
            span(10.0, 16.0, 9, true),
        ];
        assert_eq!(divided_at_rims(spans.clone(), rims), expected);
        assert_eq!(
            divided_at_rims(spans.clone(), Rims::LIKE_OTHERS),
            spans,
            "nothing asked for"
        );
        let one = vec![span(0.0, 1.0, 1, true)];
        let halves = Rims {
            pieces: 1,
            parts: 2,
        };
        assert_eq!(divided_at_rims(one, halves), [span(0.0, 1.0, 2, true)]);
        let three = vec![span(0.0, 3.0, 3, true)];
        let both = [
            span(0.0, 1.0, 2, true),
            span(1.0, 2.0, 1, true),
            span(2.0, 3.0, 2, true),
        ];
        assert_eq!(divided_at_rims(three, halves), both);
    }
}
