use super::*;
use crate::quadrature::Rule;
use std::f64::consts::PI;

/// Meshes of an eighth of a hollow cylinder, radii 2 and 3, height 2, that Gmsh has made of `block.geo` (2 by 3 by 2 elements, two
/// regions), and meshio has turned into VTK's format.
fn block(file: &str) -> WallFile {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/walls");
    let file = WallFile::read(&Path::new(folder).join(file));
    file.unwrap_or_else(|error| panic!("{error}"))
}

fn wall(file: &WallFile, wet: &str) -> HexMesh {
    let wet = [wet.to_owned()];
    let region = |name: &str| match name {
        "upper" | "2" => Ok(0),
        "lower" | "1" => Ok(1),
        other => Err(format!("{other:?}")),
    };
    file.mesh(1.0, &wet, region)
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Volume of a region and smallest Jacobian.
fn volume(mesh: &HexMesh, region: usize) -> (f64, f64) {
    let rule = Rule::gauss_legendre(5);
    let (mut sum, mut smallest) = (0.0, f64::INFINITY);
    for element in (0..mesh.hexes.len()).filter(|&e| mesh.regions[e] == region) {
        for (i, x) in rule.points.iter().enumerate() {
            for (j, y) in rule.points.iter().enumerate() {
                for (k, z) in rule.points.iter().enumerate() {
                    let tangent = |d: usize| {
                        let at = |step: f64| {
                            let mut xi = [*x, *y, *z];
                            xi[d] += step;
                            mesh.shape.position(element, xi)
                        };
                        (at(1e-5) - at(-1e-5)) / 2e-5
                    };
                    let jacobian = tangent(0).cross(&tangent(1)).dot(&tangent(2));
                    smallest = f64::min(smallest, jacobian);
                    sum += rule.weights[i] * rule.weights[j] * rule.weights[k] * jacobian;
                }
            }
        }
    }
    (sum, smallest)
}

/// Nodes on arcs of 30 degrees: straight edges lose 4.507 % of the volume, parabolas 1.553e-4, cubics gain 2.276e-5: computed by
/// themselves.
#[test]
fn hexahedra_of_all_orders_and_formats_have_the_shape_of_the_body() {
    let exact = PI / 4.0 * (9.0 - 4.0);
    for (file, inner, bottom, expected) in [
        ("block1.msh", "inner", "bottom", 4.507e-2),
        ("block8.inp", "inner", "bottom", 4.507e-2),
        ("block1.vtu", "3", "4", 4.507e-2),
        ("block2.msh", "inner", "bottom", 1.553e-4),
        ("block2.vtu", "3", "4", 1.553e-4),
        ("block20.msh", "inner", "bottom", 1.553e-4),
        ("block20.inp", "inner", "bottom", 1.553e-4),
        ("block20.vtu", "3", "4", 1.553e-4),
        ("block3.msh", "inner", "bottom", 2.276e-5),
    ] {
        let read = block(file);
        let mesh = wall(&read, inner);
        for region in [0, 1] {
            let (volume, smallest) = volume(&mesh, region);
            let error = (volume / exact - 1.0).abs();
            assert!(smallest > 0.0, "{file}: {smallest}");
            assert!((error / expected - 1.0).abs() < 2e-2, "{file}: {error:.2e}");
        }
        assert_eq!(mesh.surfaces[WET].len(), 6, "{file}");
        assert_eq!(mesh.surfaces[bottom].len(), 6, "{file}");
        for (element, face) in &mesh.surfaces[WET] {
            let mut xi = [0.0; 3];
            xi[face.axis as usize] = if face.upper { 1.0 } else { -1.0 };
            let x = mesh.shape.position(*element, xi);
            assert!((x.xy().norm() - 2.0).abs() < 0.07, "{file}: {x:?}");
        }
    }
}

#[test]
fn what_is_no_wall_is_refused_with_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        WallFile::read(&path).unwrap_err().to_string()
    };
    let msh = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    for (name, text, expected) in [
        ("a.msh", "", "it has no $MeshFormat"),
        (
            "a.msh",
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n",
            "of the version 2.2: expected 4.1",
        ),
        (
            "a.msh",
            "$MeshFormat\n4.1 1 8\n$EndMeshFormat\n",
            "it is binary",
        ),
        ("a.msh", msh, "it has no hexahedra"),
        (
            "a.msh",
            &format!("{msh}$Nodes\n1 1 1 1\n3 1 0 1\n1\nx 0 0\n"),
            "line 8: expected a number, found \"x\"",
        ),
        (
            "a.msh",
            &format!("{msh}$Elements\n1 1 1 1\n3 1 4 1\n1\n"),
            "line 7: an element of the type 4 is no hexahedron",
        ),
        (
            "a.inp",
            "*ELEMENT, TYPE=C3D10\n",
            "line 1: elements of the type C3D10 are no hexahedra",
        ),
        (
            "a.inp",
            "*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n",
            "the element 1 has the node 1, which there is not",
        ),
        ("a.vtu", "rubbish", "it is no VTK file"),
    ] {
        let error = read(name, text);
        assert!(error.contains(expected), "{error}");
    }
    let file = block("block1.msh");
    let no_wet = file.mesh(1.0, &["outer".into()], |_| Ok(0)).err().unwrap();
    assert!(
        no_wet.contains("it has no surface \"outer\"; it has \"bottom\", \"inner\""),
        "{no_wet}"
    );
}
