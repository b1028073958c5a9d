use super::*;
use crate::files::fault;
use crate::quadrature::Rule;
use std::f64::consts::PI;

/// Meshes of an eighth of a hollow cylinder, radii 2 and 3, height 2, that Gmsh has made of `block.geo` (2 by 3 by 2
/// elements, two regions), and meshio has turned into VTK's format.
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
        other => Err(fault!("{other:?}")),
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

/// Nodes on arcs of 30 degrees: straight edges lose 4.507 % of the volume, parabolas 1.553e-4, cubics gain 2.276e-5:
/// computed by themselves.
#[test]
fn hexahedra_of_all_orders_and_formats_have_the_bodys_shape() {
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
        ("block1-v2.msh", "inner", "bottom", 4.507e-2),
        ("block1-v2-binary.msh", "inner", "bottom", 4.507e-2),
        ("block2-v2-binary.msh", "inner", "bottom", 1.553e-4),
        ("block2-binary.msh", "inner", "bottom", 1.553e-4),
        ("block3-binary.msh", "inner", "bottom", 2.276e-5),
        ("block2-zlib.vtu", "3", "4", 1.553e-4),
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
fn files_that_are_not_walls_are_refused_with_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        WallFile::read(&path).unwrap_err().to_string()
    };
    let msh = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    #[rustfmt::skip]
    let files = [
        ("a.msh", "", "it has no $MeshFormat"),
        ("a.msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n", "of the version 4: expected 2.2 or 4.1"),
        ("a.msh", "$MeshFormat\n4.1 1 8\n\u{0}\u{0}\u{0}\u{1}\n$EndMeshFormat\n", "in the order of another machine"),
        ("a.msh", "$MeshFormat\n4.1 1 8\n\u{1}\u{0}\u{0}\u{0}\n$Nodes\n\u{1}\u{0}", "it ends before it is complete"),
        (
            "a.msh",
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n900\n1 0 0 0\n",
            "900 entries are announced, more than there is room for",
        ),
        ("a.msh", "<?xml version=\"1.0\"?>\n<mitk_mesh/>", "SimVascular's description of a mesh"),
        ("a.msh", msh, "it has no hexahedra"),
        ("a.msh", &format!("{msh}$Nodes\n1 1 1 1\n3 1 0 1\n1\nx 0 0\n"), "line 8: expected a number, found \"x\""),
        (
            "a.msh",
            &format!("{msh}$Elements\n1 1 1 1\n3 1 4 1\n1\n"),
            "line 7: an element of the type 4 is not a hexahedron",
        ),
        ("a.inp", "*ELEMENT, TYPE=C3D10\n", "line 1: elements of the type C3D10 are not hexahedra"),
        ("a.inp", "*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n", "the element 1 has the node 1, which there is not"),
        ("a.vtu", "rubbish", "this is not a VTK file in XML"),
        ("a.vtu", "<VTKFile type=\"PolyData\"></VTKFile>", "expected VTK's UnstructuredGrid (.vtu), found PolyData"),
        ("a.inp", "*NODE\n1, 0, 0, 0\n*NGEN\n1, 9, 1\n", "line 3: *NGEN makes or moves nodes and elements by a rule"),
        ("a.inp", "*INCLUDE, INPUT=nowhere.inp\n", "line 1: nowhere.inp: it cannot be read: No such file"),
        ("a.inp", "*INCLUDE, INPUT=a.inp\n", "more than 10 files include each other"),
        ("a.inp", "*PART, NAME=a\n*END PART\n*PART, NAME=A\n", "line 3: there is another part \"A\""),
        ("a.inp", "*ASSEMBLY\n*INSTANCE, NAME=a-1, PART=b\n", "line 2: there is no part \"b\""),
        ("a.inp", "*PART, NAME=a\n*END PART\n*INSTANCE, NAME=a-1, PART=a\n1, 2\n", "line 4: expected the translation"),
        (
            "a.inp",
            "*PART, NAME=a\n*END PART\n*INSTANCE, NAME=a-1, PART=a\n0,0,0\n1,1,1,1,1,1,90\n",
            "line 5: the two points of the axis of rotation are the same",
        ),
        ("a.inp", &format!("{CUBE}*SURFACE, NAME=wet\nsolid, SPOS\n"), "line 14: expected a face S1 to S6"),
        ("a.inp", &format!("{CUBE}*SURFACE, NAME=wet\nshell, S1\n"), "line 14: there is no set of elements \"shell\""),
        (
            "a.inp",
            &CUBE.replace("1, 1,2,3,4,5,6,7,8", "1, 1,2,3,4,7,8,5,6"),
            "the hexahedron 1 around (0.5, 0.5, 0.5) is folded or flat",
        ),
        (
            "a.inp",
            &format!("{CUBE}*ELEMENT, TYPE=C3D8\n2, 1,2,3,4,5,6,7,8\n"),
            "the hexahedra 1 and 2 have the same nodes: is a part there twice?",
        ),
    ];
    for (name, text, expected) in files {
        let error = read(name, text);
        assert!(error.contains(expected), "{error}");
    }
    // Comments may precede everything, and numbers of regions have one of a few names.
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/walls"));
    let text = std::fs::read_to_string(data.join("block1-v2.msh")).unwrap();
    let path = folder.path().join("b.msh");
    std::fs::write(&path, format!("$Comments\nby hand\n$EndComments\n{text}")).unwrap();
    assert_eq!(WallFile::read(&path).unwrap().hexes.len(), 12);
    let text = std::fs::read_to_string(data.join("block1.vtu")).unwrap();
    let error = read("b.vtu", &text.replace("gmsh:physical", "other"));
    assert!(
        error.contains("expected an array region, gmsh:physical, CellEntityIds of the cells"),
        "{error}"
    );
    let file = block("block1.msh");
    let no_wet = file.mesh(1.0, &["outer".into()], |_| Ok(0)).err().unwrap();
    assert!(
        no_wet
            .message
            .contains("it has no surface \"outer\"; it has \"bottom\", \"inner\""),
        "{no_wet}"
    );
}

/// A cube with edges of length one.
const CUBE: &str = "*HEADING\n*NODE, NSET=all\n1, 0,0,0\n2, 1,0,0\n3, 1,1,0\n4, 0,1,0\n5, 0,0,1\n6, 1,0,1\n7, 1,1,1\n8, 0,1,1\n\
                    *ELEMENT, TYPE=C3D8R, ELSET=solid\n1, 1,2,3,4,5,6,7,8\n";

fn abaqus(texts: &[(&str, &str)]) -> WallFile {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in texts {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    WallFile::read(&folder.path().join(texts[0].0)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn parts_of_abaqus_come_to_lie_where_their_instances_are() {
    let part = CUBE.replace("*HEADING\n", "");
    let model = format!(
        "*HEADING\n** a comment\n*Part, name=Block\n{part}*Nset, nset=bottom, generate\n1, 4, 1\n\
         *Surface, type=ELEMENT, name=top\nsolid, S2\n*End Part\n*Assembly, name=Assembly\n\
         *Instance, name=Block-1, part=Block\n*End Instance\n\
         *Instance, name=Block-2, part=Block\n 0., 0., 1.\n 0., 0., 1., 0., 0., 2., 90.\n*End Instance\n\
         *Elset, elset=both, internal, instance=Block-1\n1,\n*Elset, elset=both, internal, instance=Block-2\n1,\n\
         *Surface, type=ELEMENT, name=wet\nboth, S1\n*Nset, nset=lid, instance=Block-2\n5, 6, 7, 8\n\
         *Node\n1, 9, 9, 9\n*End Assembly\n*Material, name=soft\n*Elastic\n1.0, 0.3\n"
    );
    let file = abaqus(&[("a.inp", &model)]);
    let mesh = file
        .mesh(1.0, &["WET".into()], |_| Ok(0))
        .unwrap_or_else(|e| panic!("{e}"));
    // Block-2 stands on Block-1, turned by 90 degrees about the axis through the origin: they share no face, but an
    // edge of nodes.
    assert_eq!((mesh.hexes.len(), mesh.vertices.len()), (2, 14));
    let centre = |element: usize| mesh.shape.position(element, [0.0; 3]);
    assert!((centre(0) - Vec3::new(0.5, 0.5, 0.5)).norm() < 1e-12);
    assert!(
        (centre(1) - Vec3::new(-0.5, 0.5, 1.5)).norm() < 1e-12,
        "{:?}",
        centre(1)
    );
    for (name, count) in [("wet", 2), ("top", 2), ("bottom", 2), ("lid", 1)] {
        assert_eq!(mesh.surfaces[name].len(), count, "{name}");
    }
    let (volume, smallest) = volume(&mesh, 0);
    assert!((volume - 2.0).abs() < 1e-9 && smallest > 0.0);
}

#[test]
fn abaqus_writes_the_same_mesh_in_many_ways() {
    let surface = "*SURFACE, NAME=wet, TYPE=ELEMENT\nsolid, S1\n";
    let flat = abaqus(&[("a.inp", &format!("{CUBE}{surface}"))]);
    let nodes = "1, 0,0,0\n2, 1,0,0\n3, 1,1,0\n4, 0,1,0\n5, 0,0,1\n6, 1,0,1\n7, 1,1,1\n8, 0,1,1\n";
    let cylinder = "1, 0,0,0\n2, 1,0,0\n3, 1.4142135623730951,45,0\n4, 1,90,0\n5, 0,0,1\n6, 1,0,1\n7, 1.4142135623730951,45,1\n8, 1,90,1\n";
    let elements = "*ELEMENT, TYPE=C3D8,\nELSET=solid\n1, 1,2,3,4,5,6,7,\n8\n";
    for texts in [
        vec![
            ("a.inp", format!("*INCLUDE, INPUT=mesh.txt\n{surface}")),
            ("mesh.txt", CUBE.to_owned()),
        ],
        vec![
            ("a.inp", format!("*NODE, INPUT=n.txt\n{elements}{surface}")),
            ("n.txt", nodes.to_owned()),
        ],
        vec![(
            "a.inp",
            format!("*NODE, SYSTEM=C\n{cylinder}{elements}{surface}"),
        )],
        vec![(
            "a.inp",
            format!(
                "*node , nset = all\r\n{}*Element, type=SC8R, elset=Solid\r\n1, 1,2,3,4,5,6,7,8\r\n{surface}",
                nodes.replace('\n', "\r\n")
            ),
        )],
        vec![(
            "a.inp",
            format!(
                "*PART, NAME=p\n{}{surface}*END PART\n",
                CUBE.replace("*HEADING\n", "")
            ),
        )],
        vec![(
            "a.inp",
            format!(
                "\u{feff}{CUBE}*NSET, NSET=lower, GENERATE\n1,4\n*SURFACE, TYPE=NODE, NAME=wet\nlower, 1.\n"
            ),
        )],
        vec![(
            "a.inp",
            format!("{CUBE}{surface}").replace("1,0,0", "1.0D0, 0.0d+00, "),
        )],
    ] {
        let texts: Vec<(&str, &str)> = texts
            .iter()
            .map(|(name, text)| (*name, text.as_str()))
            .collect();
        let file = abaqus(&texts);
        for (a, b) in file.nodes.iter().zip(&flat.nodes) {
            assert!((a - b).norm() < 1e-12, "{texts:?}: {a:?} {b:?}");
        }
        assert_eq!(file.hexes, flat.hexes, "{texts:?}");
        assert_eq!(file.surfaces["wet"], flat.surfaces["wet"], "{texts:?}");
    }
}

/// 27 nodes: corners, edges, the middle of the volume, of the faces S1 to S6.
#[test]
fn nodes_in_the_middle_of_faces_are_where_abaqus_has_them() {
    let at = |x: [f64; 3]| Vec3::from(x) + Vec3::new(0.1 * x[1] * x[2], 0.05 * x[0] * x[0], 0.0);
    #[rustfmt::skip]
    let corners = [
        [0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2],
    ];
    let mut all: Vec<[i32; 3]> = corners.to_vec();
    #[rustfmt::skip]
    let edges = [
        [0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7],
    ];
    for [a, b] in edges {
        all.push([0, 1, 2].map(|c| (corners[a][c] + corners[b][c]) / 2));
    }
    #[rustfmt::skip]
    all.extend([
        [1, 1, 1], [1, 1, 0], [1, 1, 2], [1, 0, 1], [2, 1, 1], [1, 2, 1], [0, 1, 1],
    ]);
    let mut text = "*NODE\n".to_owned();
    for (i, x) in all.iter().enumerate() {
        let x = at(x.map(f64::from));
        text += &format!("{}, {}, {}, {}\n", i + 1, x.x, x.y, x.z);
    }
    let numbers: Vec<String> = (1..=27).map(|i| i.to_string()).collect();
    text += &format!(
        "*ELEMENT, TYPE=C3D27, ELSET=solid\n1, {},\n{}\n*SURFACE, NAME=wet\n1, S1\n",
        numbers[..12].join(", "),
        numbers[12..].join(", ")
    );
    let mesh = abaqus(&[("a.inp", &text)])
        .mesh(1.0, &["wet".into()], |_| Ok(0))
        .unwrap();
    for xi in [
        [0.0; 3],
        [-1.0, 0.0, 0.0],
        [0.3, -0.2, 0.9],
        [0.0, 1.0, -0.4],
    ] {
        let exact = at(xi.map(|x| x + 1.0));
        assert!(
            (mesh.shape.position(0, xi) - exact).norm() < 1e-12,
            "{xi:?}"
        );
    }
}
