//! The keys of a vessel along any path, of any sections: what stands in the table `[vessel]`.

use super::Material;
use super::schema::{Key, KeyTable, Schema, ValueKind, above, from, join};
use super::table::choice;
use crate::tabular::units::{self, Unit};
use crate::{table, words};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Most points of a centre-line.
pub(super) const MOST_POINTS: usize = 5000;
/// Most cross-sections of a table of radii, and most angles.
const MOST_ROWS: usize = 1000;
const MOST_ANGLES: usize = 200;

table! {
    /// A vessel along any path. Its centre-line comes from a file, from points or from pieces; the arc length `s` is
    /// counted downstream from where the first elastic section begins.
    pub struct VesselDescription {
        /// It counts as if its points and radii stood in the case.
        centre_line: Option<PathBuf> = "centre_line", ValueKind::Path, "file with the centre-line: CSV with the columns x,y,z or x,y,z,r, VTK's polydata (.vtp), or SWC",
            absent "vessel.points_m or vessel.piece";
        unit: Option<LengthUnit> = "unit", ValueKind::Word(LengthUnit::WORDS), "unit of the lengths in that file", absent "none: needed with a file";
        branch: Option<String> = "branch", ValueKind::Text(100), "which of several lines: CenterlineIds=0, GroupIds=2, Line=1; of SWC the number of its end",
            absent "the only one";
        is_reversed: Option<bool> = "reverse", ValueKind::Flag, "whether the blood flows from the end of the file's line to its beginning", absent "false";
        /// A smoothing spline: waves of three times this length keep 99 %, of a third of it 1 %.
        smoothing: Option<f64> = "smoothing_m", above(0.0, 1.0), "length of the waves of the centre-line's points that are halved; radii change by their own scatter at most",
            absent "none: the line passes all points";
        least_bend: Option<f64> = "least_bend_m", above(0.0, 1.0), "where the centre-line bends with a smaller radius it is smoothed more, until it does not",
            absent "none: bends stay as they are";
        lumen: Option<PathBuf> = "lumen", ValueKind::Path, "file with the lumen's surface: STL, or VTK's polydata (.vtp)",
            absent "circles of the radius";
        lumen_unit: Option<LengthUnit> = "lumen_unit", ValueKind::Word(LengthUnit::WORDS), "unit of the lengths in that file", absent "vessel.unit";
        /// Along and around, as `smoothing_m`.
        lumen_smoothing: Option<f64> = "lumen_smoothing_m", from(0.0, 1.0), "length of the waves of the lumen's surface that are halved",
            absent "three times the median length of a triangle in a cross-section";
        /// Rows in equal distances from the beginning of the centre-line to its end, columns in equal angles from 0.
        lumen_radii: Vec<Vec<f64>> = "lumen_radii_m", ValueKind::Radii(MOST_ROWS, MOST_ANGLES), "radii of the lumen along and around, in place of a surface",
            absent "vessel.lumen, or circles of the radius";
        points: Vec<[f64; 3]> = "points_m", ValueKind::Points(MOST_POINTS), "points that the centre-line passes as a cubic spline",
            absent "vessel.centre_line or vessel.piece";
        radii: Vec<f64> = "radii_m", ValueKind::Sizes(MOST_POINTS), "radius of the lumen at each of vessel.points_m", absent "vessel.radius_m";
        radius: Option<f64> = "radius_m", above(0.0, 0.1), "radius of the lumen where the centre-line begins",
            absent "those of the file, or vessel.radii_m", only OWN_RADIUS;
        /// It tapers as a cone.
        end_radius: Option<f64> = "end_radius_m", above(0.0, 0.1), "radius of the lumen where the centre-line ends", absent "vessel.radius_m", only OWN_RADIUS;
        blend_length: Option<f64> = "blend_length_m", above(0.0, 10.0), "length of the cosine blends, centred on the joints of sections",
            absent "the diameter at the joint", only JOINTS;
        upstream: Option<f64> = "upstream_extension_m", from(0.0, 10.0), "length of a straight rigid tube upstream of the centre-line", absent "0";
        downstream: Option<f64> = "downstream_extension_m", from(0.0, 10.0), "length of a straight rigid tube downstream of the centre-line", absent "0";
        first: Vec<f64> = "angle_zero", ValueKind::Numbers(3), "direction of the angle 0 at the beginning, three components",
            absent "the side to which the centre-line bends, or +y if it is straight";
        [piece: Option<Vec<CurvePiece>>, "pieces of the centre-line, downstream"]
        [section: Vec<VesselSection>, "sections, downstream"]
        [feature: Option<Vec<Feature>>, "narrowings and widenings of the lumen"]
        [region: Option<Vec<VesselRegion>>, "parts that are evaluated separately, in addition to the elastic sections"]
        [material: Option<Vec<NamedMaterial>>, "materials of the wall, if it is elastic", only USED]
    }
}

words! {
    /// A unit of length.
    pub enum LengthUnit {
        /// Metre.
        Metre = "m",
        /// Centimetre.
        Centimetre = "cm",
        /// Millimetre.
        Millimetre = "mm",
        /// Micrometre.
        Micrometre = "um",
    }
}

impl LengthUnit {
    /// The unit in any usual spelling, such as `millimetre` or `µm`.
    pub fn spelled(word: &str) -> Option<Self> {
        let unit = Unit::parse(word).filter(|unit| unit.dimension == units::LENGTH)?;
        let is = |known: &Self| (known.metres() / unit.size - 1.0).abs() < 1e-9;
        Self::ALL.into_iter().find(is)
    }

    /// In metres.
    pub fn metres(self) -> f64 {
        Unit::known(self.name()).size
    }
}

choice! {
    /// A piece of a centre-line that begins in the direction in which the one before it ends; the first one along +x.
    pub enum CurvePiece by "piece", "shape of this piece of the centre-line" {
        /// A straight line.
        Line = "line" {
            length: f64 = "length_m", above(0.0, 10.0), "length along the piece";
        }
        /// A part of a circle.
        Arc = "arc" {
            length: f64 = "length_m", above(0.0, 10.0), "length along the piece";
            radius: f64 = "bend_radius_m", above(0.0, 1e9), "radius of the circle or of the helix";
            side_deg: Option<f64> = "side_deg", from(-360.0, 360.0), "angle in the cross-section of the side to which it bends", absent "0";
        }
        /// A part of a helix.
        Helix = "helix" {
            length: f64 = "length_m", above(0.0, 10.0), "length along the piece";
            radius: f64 = "bend_radius_m", above(0.0, 1e9), "radius of the circle or of the helix";
            pitch: f64 = "pitch_m", from(-10.0, 10.0), "rise of a helix in a turn; left-handed if negative";
            side_deg: Option<f64> = "side_deg", from(-360.0, 360.0), "angle in the cross-section of the side to which it bends", absent "0";
        }
    }
}

table! {
    /// A part of the vessel with the same layers throughout.
    pub struct VesselSection {
        name: String = "name", ValueKind::Text(30), "name of the section";
        wall: Option<WallKind> = "wall", ValueKind::Word(WallKind::WORDS), "elastic or rigid", absent "elastic";
        length: Option<f64> = "length_m", above(0.0, 10.0), "length along the centre-line",
            absent "the rest of the centre-line";
        radius: Option<f64> = "radius_m", above(0.0, 0.1), "radius of the lumen", absent "that of the vessel";
        layers: Vec<String> = "layers", ValueKind::Names(20), "materials of the layers from the inside out, by name", absent "none: the wall is rigid";
        thicknesses: Vec<f64> = "thicknesses_m", ValueKind::Sizes(20), "thickness of each layer", absent "section.thicknesses";
        shares: Vec<f64> = "thicknesses", ValueKind::Sizes(20), "thickness of each layer as a share of the mean radius", absent "section.thicknesses_m";
    }
}

table! {
    /// A part of the elastic vessel between two cross-sections.
    pub struct VesselRegion {
        name: String = "name", ValueKind::Text(30), "name of the region in tables and on pages";
        from: f64 = "from_m", from(0.0, 10.0), "arc length s of its beginning";
        to: f64 = "to_m", above(0.0, 10.0), "arc length s of its end";
    }
}

words! {
    /// Whether the wall of a section is elastic.
    #[derive(Default)]
    pub enum WallKind {
        /// Elastic, with its layers.
        Elastic = "elastic" (default),
        /// Rigid.
        Rigid = "rigid",
    }
}

choice! {
    /// A part of the lumen that is narrower or wider than its section.
    pub enum Feature by "feature", "what is there" {
        /// A narrowing that thickens the wall inward; its outer surface stays.
        Stenosis = "stenosis" {
            at: f64 = "at_m", from(-10.0, 10.0), "arc length s of its middle";
            length: f64 = "length_m", above(0.0, 10.0), "its length; with a Gaussian profile four standard deviations";
            area_reduction: f64 = "area_reduction", above(0.0, 0.99), "share of the lumen's area that is lost in the middle";
            profile: Option<BumpProfile> = "profile", ValueKind::Word(BumpProfile::WORDS), "how it begins and ends", absent "cosine";
            eccentricity: Option<f64> = "eccentricity", from(0.0, 1.0), "how far the lumen lies to the side, relative to the change of its radius", absent "0";
            side_deg: Option<f64> = "side_deg", from(-360.0, 360.0), "angle in the cross-section of the side to which the lumen moves", absent "0";
        }
        /// A widening with the whole wall.
        Aneurysm = "aneurysm" {
            at: f64 = "at_m", from(-10.0, 10.0), "arc length s of its middle";
            length: f64 = "length_m", above(0.0, 10.0), "its length; with a Gaussian profile four standard deviations";
            growth: f64 = "growth_m", above(0.0, 0.1), "growth of the lumen's radius in the middle";
            profile: Option<BumpProfile> = "profile", ValueKind::Word(BumpProfile::WORDS), "how it begins and ends", absent "cosine";
            eccentricity: Option<f64> = "eccentricity", from(0.0, 1.0), "how far the lumen lies to the side, relative to the change of its radius", absent "0";
            side_deg: Option<f64> = "side_deg", from(-360.0, 360.0), "angle in the cross-section of the side to which the lumen moves", absent "0";
        }
    }
}

words! {
    /// How a narrowing or widening begins and ends.
    #[derive(Default)]
    pub enum BumpProfile {
        /// A whole cosine: once continuously differentiable, nothing beyond its length.
        Cosine = "cosine" (default),
        /// A Gaussian bell.
        Gaussian = "gaussian",
    }
}

/// A material: its name next to its own keys.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedMaterial {
    /// `name`: what sections call it.
    pub name: String,
    /// The others.
    #[serde(flatten)]
    pub material: Material,
}

impl KeyTable for NamedMaterial {
    fn describe(path: &str, schema: &mut Schema) {
        schema.add(Key {
            path: join(path, "name"),
            kind: ValueKind::Text(30),
            absent: None,
            about: "name by which sections refer to the material",
            choices: Vec::new(),
            problems: &[],
            only: Vec::new(),
        });
        Material::describe(path, schema);
    }
}
