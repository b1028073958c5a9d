//! A user-supplied OpenFOAM case with an elastic wall: `[fluid]` and `[wall]` of such a case.

use super::schema::{ValueKind, above, from, whole};
use super::table::choice;
use super::{GivenShape, NamedMaterial, TissueDirection, TreeKeys};
use crate::{table, words};
use std::path::PathBuf;

table! {
    /// An elastic wall on patches of a mesh of any shape: that of a user-supplied OpenFOAM case with its boundary
    /// conditions and models, or that of a tree.
    pub struct OwnCase {
        [fluid: OwnFluid, "the OpenFOAM case", absent "that of a tree"]
        [tree: Option<TreeKeys>, "a vessel that branches, in place of an OpenFOAM case; next to one it describes the wall alone"]
        [wall: OwnWall, "the elastic wall"]
    }
}

table! {
    /// The OpenFOAM case.
    #[derive(Default)]
    pub struct OwnFluid {
        /// It is copied; nothing in it is changed.
        case: Option<PathBuf> = "case", ValueKind::Path, "folder of your own OpenFOAM case for pimpleFoam, with its mesh or its blockMeshDict", absent "tree";
        patches: Vec<String> = "patches", ValueKind::Names(100), "patches of that case that the elastic wall touches", absent "the wall of a tree";
        openings: Vec<String> = "openings", ValueKind::Names(100), "patches of that case where it flows in or out, the inlet first",
            absent "its patches of the type patch, those called inlet… first";
        [region: Option<Vec<OwnRegion>>, "parts of the wet surface that are evaluated separately"]
    }
}

table! {
    /// The faces of the wet surface in a patch, along a branch, or whose middle lies in a box, and what of the wall
    /// lies there.
    pub struct OwnRegion {
        name: String = "name", ValueKind::Text(30), "name of the region";
        corners: Vec<[f64; 3]> = "box_m", ValueKind::Points(2), "two opposite corners of the box",
            absent "fluid.region.patch";
        patch: Option<String> = "patch", ValueKind::Text(100), "one of fluid.patches, in place of a box", absent "fluid.region.box_m";
        branch: Option<String> = "branch", ValueKind::Text(30), "branch of a tree, in place of a box", absent "fluid.region.box_m";
        from: Option<f64> = "from_m", from(0.0, 1e3), "arc length along fluid.region.branch where the region begins", absent "0";
        to: Option<f64> = "to_m", above(0.0, 1e3), "arc length along fluid.region.branch where it ends", absent "the end of the branch";
    }
}

table! {
    /// The wall: extruded from the wet patches, or from a file; or one that does not yield.
    pub struct OwnWall {
        /// What only other walls need may stay in the file.
        mode: Option<WallMode> = "mode", ValueKind::Word(WallMode::WORDS), "elastic or rigid", absent "elastic";
        [motion: Option<WallMotion>, "motion of the wall where it is prescribed", only MOVED]
        [extrude: Option<Extrusion>, "a wall that grows outward from the quadrilaterals of the wet patches", only OWN_ELASTIC]
        [file: Option<WallFile>, "a wall whose hexahedra are read from a file", only OWN_ELASTIC]
        [material: Option<Vec<NamedMaterial>>, "materials of the wall, if it is elastic", only USED]
        [support: Option<Vec<WallSupport>>, "supports of the wall", only OWN_ELASTIC]
        [initial: Option<WallInitial>, "state of the wall at t = 0, if it is not at rest", only OWN_ELASTIC]
        [gravity: Option<WallGravity>, "weight of the wall, if it has one", only OWN_ELASTIC]
    }
}

table! {
    /// A wall that is in static equilibrium at t = 0, under a pressure that is the same everywhere.
    pub struct WallInitial {
        pressure: f64 = "pressure_Pa", from(-1e6, 1e6), "pressure inside at t = 0";
        shape: Option<GivenShape> = "shape", ValueKind::Word(GivenShape::WORDS),
            "state of the wall that the given sizes describe: loaded is that under wall.initial.pressure_Pa", absent "loaded";
        axial_stretch: Option<f64> = "axial_stretch", from(0.8, 2.0), "stretch of the wall along its branches in the unloaded shape", absent "1";
    }
}

table! {
    /// A body force on the wall: its weight, less its buoyancy where the fluid is computed without weight.
    pub struct WallGravity {
        acceleration: Vec<f64> = "acceleration_m_s2", ValueKind::Amplitudes(3), "acceleration along x, y and z: gravity, times 1 minus the fluid's density over the wall's";
        ramp: Option<f64> = "ramp_s", from(0.0, 100.0), "how long it grows from t = 0 on, by half a cosine", absent "0";
    }
}

words! {
    /// Whether a wall is elastic.
    #[derive(Default)]
    pub enum WallMode {
        /// Deforms under the load of the blood: the coupled problem.
        Elastic = "elastic" (default),
        /// Rigid: only the flow is computed.
        Rigid = "rigid",
        /// Moves as wall.motion says: only the flow is computed, in a moving mesh.
        Prescribed = "prescribed",
    }
}

table! {
    /// The displacement of each point of a wall: that of the nearest row of one file, times a factor over time from
    /// another.
    pub struct WallMotion {
        displacements: PathBuf = "displacements", ValueKind::Path, "CSV file with the columns x,y,z,ux,uy,uz (m); each point of the wet patches takes the nearest row";
        factors: PathBuf = "factors", ValueKind::Path, "CSV file with the columns time_s,factor, from 0,0 on; linear in between, then constant";
    }
}

table! {
    /// Layers on the outer side of the wet patches.
    pub struct Extrusion {
        layers: Vec<String> = "layers", ValueKind::Names(20), "materials of the layers from the inside out, by name";
        thicknesses: Vec<f64> = "thicknesses_m", ValueKind::Sizes(20), "thickness of each layer", absent "wall.extrude.thicknesses";
        /// The radius is that of the largest ball that touches the wet surface there from within.
        shares: Vec<f64> = "thicknesses", ValueKind::Sizes(20), "thickness of each layer as a share of the lumen's radius there",
            absent "wall.extrude.thicknesses_m";
        /// Columns `x,y,z,factor`; each point of the surface takes that of the nearest row.
        factors: Option<PathBuf> = "factors", ValueKind::Path, "CSV file with the columns x,y,z,factor: the thickness times a factor, that of the nearest point",
            absent "1 everywhere";
        faces: Option<usize> = "faces_per_element", whole(1, 8), "faces of the patches along each side of an element",
            absent "the most that fit, up to 4";
        elements: Option<usize> = "elements_per_layer", whole(1, 20), "elements through each layer", absent "1";
        axis: Option<FibreAxis> = "axis", ValueKind::Word(FibreAxis::WORDS), "which direction of the wall is the axial one, from which fibres count",
            absent "flow where the wall ends at two openings or more, otherwise mesh";
        smoothing: Option<usize> = "smoothing", whole(0, 1000), "averages of the normals with those of the neighbouring points", absent "0; of a tree the first of 4, 16, 64, 256 with which no element is inside out";
        [branch: Option<Vec<BranchWall>>, "branches, or patches, whose layers are of other materials or thicknesses"]
    }
}

table! {
    /// The layers on a part of the surface: as many as elsewhere. Where it meets another one, the thickness is the
    /// mean.
    pub struct BranchWall {
        name: String = "name", ValueKind::Text(100), "branch of a tree, or one of fluid.patches";
        layers: Vec<String> = "layers", ValueKind::Names(20), "materials of the layers there", absent "wall.extrude.layers";
        thicknesses: Vec<f64> = "thicknesses_m", ValueKind::Sizes(20), "thickness of each layer there", absent "that of wall.extrude";
        shares: Vec<f64> = "thicknesses", ValueKind::Sizes(20), "the same as a share of the lumen's radius", absent "that of wall.extrude";
    }
}

/// The layers of an extruded wall on one of the patches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchLayers<'a> {
    /// Materials from the inside out, by name.
    pub materials: &'a [String],
    /// Thickness of each layer, m; empty where they are shares.
    pub thicknesses: &'a [f64],
    /// The same as shares of the radius.
    pub shares: &'a [f64],
}

impl Extrusion {
    /// The materials of all layers, by name.
    pub fn materials(&self) -> impl Iterator<Item = &String> {
        let of_branches = self.branch.iter().flatten();
        (self.layers.iter()).chain(of_branches.flat_map(|branch| &branch.layers))
    }

    /// The layers on the patch of this name, of which the branch of a tree is called `branch`.
    pub fn layers_of(&self, patch: &str, branch: Option<&str>) -> PatchLayers<'_> {
        let is_meant = |part: &&BranchWall| part.name == branch.unwrap_or(patch);
        let of_part = self.branch.iter().flatten().find(is_meant);
        let all = PatchLayers {
            materials: &self.layers,
            thicknesses: &self.thicknesses,
            shares: &self.shares,
        };
        let Some(part) = of_part else { return all };
        let has_size = !part.thicknesses.is_empty() || !part.shares.is_empty();
        let (thicknesses, shares) = match has_size {
            true => (&part.thicknesses[..], &part.shares[..]),
            false => (all.thicknesses, all.shares),
        };
        let materials = match part.layers.is_empty() {
            true => all.materials,
            false => &part.layers,
        };
        PatchLayers {
            materials,
            thicknesses,
            shares,
        }
    }
}

words! {
    /// Which direction of a wall is the axial one.
    pub enum FibreAxis {
        /// From the first opening to the others, by Laplace's equation on the wet surface.
        Flow = "flow",
        /// Along the rows of faces in which the surface bends less.
        Mesh = "mesh",
    }
}

table! {
    /// Hexahedra from a file: Gmsh's `.msh` (2.2 and 4.1), Abaqus' `.inp` or VTK's `.vtu`.
    pub struct WallFile {
        mesh: PathBuf = "mesh", ValueKind::Path, "file with the hexahedra of the wall: .msh, .inp or .vtu";
        unit: Option<f64> = "unit_m", above(0.0, 1e3), "length in metres of the unit of that file", absent "1";
        wet: Vec<String> = "wet", ValueKind::Names(100), "surfaces of that file that the fluid touches";
    }
}

choice! {
    /// Something that holds surfaces of the wall. An extruded wall has the surfaces `inner` and `outer`; `outer:` and a
    /// name is the part over that branch or patch; rims are called as the patches that the wet ones end at. Those of a
    /// file have its names.
    pub enum WallSupport by "support", "what holds these surfaces of the wall" {
        /// No displacement.
        Clamped = "clamped" {
            surfaces: Vec<String> = "surfaces", ValueKind::Names(100), "surfaces of the wall that are held";
        }
        /// No displacement in some directions.
        Sliding = "sliding" {
            surfaces: Vec<String> = "surfaces", ValueKind::Names(100), "surfaces of the wall that are held";
            held: Vec<String> = "held", ValueKind::Names(5), "directions in which they do not move: x, y, z; of ends of a tree also axial (they stay in their plane) and tangential (they do not turn)";
        }
        /// Springs and dampers; those of several tables add up.
        Springs = "springs" {
            surfaces: Vec<String> = "surfaces", ValueKind::Names(100), "surfaces of the wall that are held";
            spring: f64 = "spring_Pa_m", from(0.0, 1e15), "force per reference area and displacement";
            damping: Option<f64> = "damping_Pa_s_m", from(0.0, 1e12), "force per reference area and velocity", absent "0";
            direction: Option<TissueDirection> = "direction", ValueKind::Word(TissueDirection::WORDS),
                "direction of displacement that they resist; along or away from the lines of a tree", absent "all";
            at_rest: Option<GivenShape> = "at_rest", ValueKind::Word(GivenShape::WORDS),
                "state of the wall in which the springs carry no force; loaded is that at t = 0", absent "unloaded";
        }
    }
}

impl WallSupport {
    /// The surfaces that it holds.
    pub fn surfaces(&self) -> &[String] {
        match self {
            Self::Clamped { surfaces }
            | Self::Sliding { surfaces, .. }
            | Self::Springs { surfaces, .. } => surfaces,
        }
    }

    /// Whether springs carry no force in the loaded shape.
    pub fn rests_loaded(&self) -> bool {
        matches!(
            self,
            Self::Springs {
                at_rest: Some(GivenShape::Loaded),
                ..
            }
        )
    }
}

impl OwnCase {
    /// The vessel that branches whose lumen the driver meshes: none where an OpenFOAM case has a mesh of its own.
    pub fn meshed_tree(&self) -> Option<&TreeKeys> {
        self.tree.as_ref().filter(|_| self.fluid.case.is_none())
    }

    /// The patches from which a wall is extruded: of the branches of a tree, or those of the OpenFOAM case.
    pub fn wall_patches(&self) -> Vec<String> {
        match &self.tree {
            Some(tree) => tree.walls(),
            None => self.fluid.patches.clone(),
        }
    }
}

impl OwnWall {
    /// Elastic, rigid, or moved as prescribed.
    pub fn mode(&self) -> WallMode {
        self.mode.unwrap_or_default()
    }

    /// Whether it grows from the wet patches.
    pub fn is_extruded(&self) -> bool {
        self.mode() == WallMode::Elastic && self.extrude.is_some()
    }

    /// Its materials.
    pub fn materials(&self) -> &[NamedMaterial] {
        self.material.as_deref().unwrap_or_default()
    }

    /// The region that a material's name stands for: its place among the materials.
    pub fn region(&self, name: &str) -> Option<usize> {
        (self.materials().iter()).position(|material| material.name == name)
    }
}
