//! The same vessels as other programs write them.

use super::shapes::TubeSurface;
use super::{described, load, try_load};

/// A tree of lines between two points each: (0, 0, 0), (10, 0, 0), and from there to (20, 0, 0) and to (10, 10, 0).
pub fn pairs_vtp(arrays: &str) -> String {
    let array = |kind: &str, name: &str, numbers: &str| {
        format!("<DataArray type=\"{kind}\" {name} format=\"ascii\">{numbers}</DataArray>")
    };
    format!(
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"4\" NumberOfLines=\"3\"><PointData>{}{arrays}</PointData><Points>{}</Points>\
         <Lines>{}{}</Lines></Piece></PolyData></VTKFile>",
        array(
            "Float64",
            "Name=\"MaximumInscribedSphereRadius\"",
            "3 2.5 2 1.5"
        ),
        array(
            "Float64",
            "NumberOfComponents=\"3\"",
            "0 0 0 10 0 0 20 0 0 10 10 0"
        ),
        array("Int64", "Name=\"connectivity\"", "1 2 0 1 1 3"),
        array("Int64", "Name=\"offsets\"", "2 4 6")
    )
}

#[test]
fn trees_of_pairs_have_the_branches_of_their_points() {
    let folder = tempfile::tempdir().unwrap();
    let arrays = "<DataArray type=\"Int32\" Name=\"CenterlineId\" NumberOfComponents=\"2\" format=\"ascii\">1 1 1 1 1 0 0 1</DataArray>\
                  <DataArray type=\"Int32\" Name=\"BranchId\" format=\"ascii\">0 0 1 2</DataArray>";
    std::fs::write(folder.path().join("tree.vtp"), pairs_vtp(arrays)).unwrap();
    let file = "centre_line = \"tree.vtp\"\nunit = \"mm\"\n";
    let error = try_load(folder.path(), file).unwrap_err();
    assert!(
        error.contains("\"CenterlineId=0\" (3 points, 20.0000 long), \"CenterlineId=1\" (3 points, 20.0000 long), \"BranchId=0\" (2 points, 10.0000 long)"),
        "{error}"
    );
    for (branch, end, radii) in [
        (
            "CenterlineId=0",
            [0.02, 0.0, 0.0],
            &[3e-3, 2.5e-3, 2e-3][..],
        ),
        ("End=2", [0.02, 0.0, 0.0], &[3e-3, 2.5e-3, 2e-3]),
        ("BranchId=0", [0.01, 0.0, 0.0], &[3e-3, 2.5e-3]),
    ] {
        let case = load(folder.path(), &format!("{file}branch = {branch:?}\n"));
        let vessel = described(&case);
        assert_eq!(
            (vessel.points[0], vessel.points[vessel.points.len() - 1]),
            ([0.0; 3], end),
            "{branch}"
        );
        assert_eq!(vessel.radii, radii, "{branch}");
    }
}

#[test]
fn centre_lines_in_tables_are_the_same_in_all_shapes() {
    let folder = tempfile::tempdir().unwrap();
    let rows = [
        [0.0, 0.0, 0.0, 3.0],
        [10.0, 0.5, 0.0, 2.9],
        [20.0, 1.5, 0.0, 2.8],
        [30.0, 3.0, 0.0, 2.5],
    ];
    let table = |head: &str, between: &str, of: &dyn Fn(&[f64; 4]) -> Vec<f64>| -> String {
        let row = |row: &[f64; 4]| {
            of(row)
                .iter()
                .map(f64::to_string)
                .collect::<Vec<_>>()
                .join(between)
                + "\n"
        };
        head.to_owned() + &rows.iter().map(row).collect::<String>()
    };
    let plain = |row: &[f64; 4]| row.to_vec();
    for (name, text) in [
        ("a.csv", table("x,y,z,r\n", ",", &plain)),
        ("b.dat", table("X Y Z MaximumInscribedSphereRadius \n", " ", &plain)),
        ("c.csv", table("\"MaximumInscribedSphereRadius\",\"Points:0\",\"Points:1\",\"Points:2\"\n", ",", &|r| vec![r[3], r[0], r[1], r[2]])),
        ("d.csv", table("\"x\",\"y\",\"z\",\"r\"\n", ",", &plain)),
        ("e.csv", table("x;y;z;r\n", ";", &plain).replace('.', ",")),
        ("f.txt", table("\u{feff}x (mm)\ty (mm)\tz (mm)\tdiameter (mm)\n", "\t", &|r| vec![r[0], r[1], r[2], 2.0 * r[3]])),
        ("g.csv", table("index,x,y,z,Radius,Curvature\n", ",", &|r| vec![7.0, r[0], r[1], r[2], r[3], 0.1])),
        ("h.csv", table("4\n", " ", &plain)),
        ("i.csv", table("# x y z r\n", " ", &plain)),
        ("j.csv", table("", "  ", &plain).replace('\n', "\r\n")),
        ("k.csv", table("coord_x,coord_y,coord_z,r\nmm,mm,mm,mm\n", ",", &plain)),
        ("l.swc", "\u{feff}# made by hand\r\n# SCALE 1.0 1.0 1.0\r\n1 1 0 0 0 3 0 9\r\n2 3 10 0.5 0 2.9 1 9\r\n3 3 20 1.5 0 2.8 2 9\r\n4 3 30 3 0 2.5 3 9\r\n".into()),
        ("m.swc", "# SCALE 10 10 10\n0 1 0 0 0 0.3 -1\n1 3 1 0.05 0 0.29 0\n2 3 2 0.15 0 0.28 1\n3 3 3 0.3 0 0.25 2\n".into()),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
        let case = load(folder.path(), &format!("centre_line = {name:?}\nunit = \"mm\"\n"));
        let vessel = described(&case);
        let found = vessel.points.iter().zip(&vessel.radii).map(|(p, r)| [p[0], p[1], p[2], *r]);
        for (found, row) in found.zip(&rows) {
            for (a, b) in found.iter().zip(row) {
                assert!((a - 1e-3 * b).abs() < 1e-9, "{name}: {found:?} {row:?}");
            }
        }
        assert_eq!(vessel.points.len(), 4, "{name}");
    }
    // A radius of zero in another branch is none of ours.
    let tree = "1 1 0 0 0 3 -1\n2 3 10 0 0 3 1\n3 3 20 0 0 3 2\n4 3 10 9 0 0 2\n";
    std::fs::write(folder.path().join("tree.swc"), tree).unwrap();
    let file = "centre_line = \"tree.swc\"\nunit = \"mm\"\n";
    load(folder.path(), &format!("{file}branch = \"3\"\n"));
    let error = try_load(folder.path(), &format!("{file}branch = \"4\"\n")).unwrap_err();
    assert!(
        error.contains("line 4: expected a radius above 0"),
        "{error}"
    );
}

#[test]
fn surfaces_of_other_programs_are_the_same_vessel() {
    let folder = tempfile::tempdir().unwrap();
    let here = |name: &str| folder.path().join(name);
    let tube = TubeSurface::straight(0.05, |_, phi| 3e-3 + 0.3e-3 * phi.cos());
    tube.write_line(&here("line.csv"), 20, 1e3);
    tube.write_surface(&here("good.stl"), 60, 48, false, 1e3);
    tube.write_surface(&here("ascii.stl"), 60, 48, false, 1e3);
    let (good, text) = (
        std::fs::read(here("good.stl")).unwrap(),
        std::fs::read_to_string(here("ascii.stl")).unwrap(),
    );
    let put = |name: &str, bytes: &[u8]| std::fs::write(here(name), bytes).unwrap();
    let mut without = good.clone();
    without[80..84].fill(0);
    put("count-zero.stl", &without);
    put("trailing.stl", &[&good[..], b"\0"].concat());
    put("more.stl", &[&good[..], &[7; 120]].concat());
    put("capitals.stl", text.to_uppercase().as_bytes());
    put(
        "bom.stl",
        format!("\u{feff}\r\n{}", text.replace('\n', "\r\n")).as_bytes(),
    );
    let (_, rest) = text.split_once('\n').unwrap();
    put(
        "latin1.stl",
        &[b"solid art\xe8re\n", rest.as_bytes()].concat(),
    );
    // Corners that differ by 2e-6 of the size, as they do where programs round each triangle for itself.
    let mut cracked = good.clone();
    for (i, number) in cracked[84..]
        .chunks_exact_mut(50)
        .flat_map(|t| {
            t[12..48]
                .chunks_exact_mut(4)
                .collect::<Vec<_>>()
                .into_iter()
        })
        .enumerate()
    {
        let x = f32::from_le_bytes((&*number).try_into().unwrap()) + [1e-4, -1e-4, 0.0][i / 9 % 3];
        number.copy_from_slice(&x.to_le_bytes());
    }
    put("cracks.stl", &cracked);
    // The same triangles in other formats.
    let corners: Vec<[f32; 3]> = (good[84..].chunks_exact(50))
        .flat_map(|t| t[12..48].chunks_exact(12))
        .map(|c| [0, 4, 8].map(|i| f32::from_le_bytes(c[i..i + 4].try_into().unwrap())))
        .collect();
    let points = |before: &str| {
        corners
            .iter()
            .map(|[x, y, z]| format!("{before}{x} {y} {z}\n"))
            .collect::<String>()
    };
    let count = corners.len();
    let faces = |before: &str, first: usize| {
        (0..count / 3)
            .map(|i| {
                format!(
                    "{before}{} {} {}\n",
                    3 * i + first,
                    3 * i + 1 + first,
                    3 * i + 2 + first
                )
            })
            .collect::<String>()
    };
    put(
        "tube.obj",
        format!("# made by hand\no tube\n{}{}", points("v "), faces("f ", 1)).as_bytes(),
    );
    let ply = format!(
        "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n{}{}",
        count / 3,
        points(""),
        faces("3 ", 0)
    );
    put("tube.ply", ply.as_bytes());
    let vtk = format!(
        "# vtk DataFile Version 3.0\ntube\nASCII\nDATASET POLYDATA\nPOINTS {count} float\n{}POLYGONS {} {}\n{}",
        points(""),
        count / 3,
        count / 3 * 4,
        faces("3 ", 0)
    );
    put("tube.vtk", vtk.as_bytes());
    let lumen = |name: &str| {
        let text = format!("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = {name:?}\n");
        described(&load(folder.path(), &text)).lumen_radii.clone()
    };
    let expected = lumen("good.stl");
    for name in [
        "count-zero.stl",
        "trailing.stl",
        "more.stl",
        "capitals.stl",
        "bom.stl",
        "latin1.stl",
        "cracks.stl",
        "tube.obj",
        "tube.ply",
        "tube.vtk",
    ] {
        let found = lumen(name);
        assert_eq!(found.len(), expected.len(), "{name}");
        for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((a - b).abs() < 5e-7, "{name}: {a} {b}");
        }
    }
}
