//! `fsi-driver new`, `preview` and `windkessel` of vessels that branch.

use crate::new_case::{driver, succeeds};
use crate::trees::{TREE, load, swc};
use fsi_driver::case::{Case, ConditionKeys, Preset};
use fsi_driver::geometry::tree::Tree;
use std::path::Path;

const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/trees");

fn copied(folder: &Path, name: &str) {
    let from = Path::new(EXAMPLES).join(name);
    std::fs::copy(&from, folder.join(from.file_name().unwrap())).unwrap();
}

/// Shares of the flow as the resistances (Pa s/m³) of a text divide it, the proximal ones included.
fn divided(folder: &Path) -> (Vec<String>, Vec<f64>, f64) {
    let case = Case::load(folder, Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
    let tree = case.tree().unwrap();
    let conductance = tree
        .opening
        .iter()
        .flatten()
        .filter_map(|keys| match keys.condition {
            ConditionKeys::Windkessel {
                resistance,
                proximal,
                ..
            } => Some(1.0 / (resistance + proximal.unwrap_or(0.0))),
            _ => None,
        });
    let all: Vec<f64> = conductance.collect();
    let sum: f64 = all.iter().sum();
    (
        tree.names(),
        all.iter().map(|g| g / sum).collect(),
        1.0 / sum,
    )
}

/// Fifteen branches in less than ten seconds; flow by Murray's law, which the example's radii obey.
#[test]
fn a_tree_becomes_a_case() {
    let folder = tempfile::tempdir().unwrap();
    copied(folder.path(), "arteries/tree.swc");
    let said = succeeds(
        folder.path(),
        &[
            "new",
            "arteries",
            "--from",
            "tree.swc",
            "--unit",
            "mm",
            "--rcr",
            "--leave-out-impossible",
        ],
    );
    assert!(
        said.contains("a tree with 8 ends")
            && said.contains("15 branches")
            && !said.contains("left out"),
        "{said}"
    );
    let (names, shares, _) = divided(&folder.path().join("arteries"));
    assert_eq!(names[0], "inlet");
    assert_eq!(names[8], "outlet8");
    // r0³ = r1³ + r2³ with r2 = 0.8 r1, three times.
    let larger = 1.0 / (1.0 + 0.8f64.powi(3));
    let [most, least] = [larger.powi(3), (1.0 - larger).powi(3)];
    assert!(
        (shares[0] - most).abs() < 2e-3 && (shares[7] - least).abs() < 2e-3,
        "{shares:?}"
    );
}

/// `new` takes off what the tubes of a tree's radii store, `windkessel --case` what its wall does in statics: of the
/// whole they leave the same to the windkessels.
#[test]
fn the_vessels_own_compliance_is_taken_off() {
    let folder = tempfile::tempdir().unwrap();
    copied(folder.path(), "carotid/lines.vtp");
    let lines = ["new", "made", "--from", "lines.vtp", "--unit", "mm"];
    succeeds(folder.path(), &lines);
    let made = std::fs::read_to_string(folder.path().join("made/case.toml")).unwrap();
    let settings = ["windkessel", "--case", "made", "--preset", "demo"];
    let computed = succeeds(folder.path(), &settings);
    let values = |text: &str, key: &str| -> Vec<f64> {
        let lines = text.lines().filter_map(|line| line.strip_prefix(key));
        let values = lines.filter_map(|rest| rest.strip_prefix(" = "));
        values.map(|value| value.parse().unwrap()).collect()
    };
    for (key, most) in [("compliance_m3_Pa", 0.06), ("resistance_Pa_s_m3", 2e-3)] {
        let [made, computed] = [&made, &computed].map(|text| values(text, key));
        assert_eq!([made.len(), computed.len()], [2, 2]);
        for (made, computed) in made.iter().zip(&computed) {
            let change = made / computed - 1.0;
            assert!(change.abs() < most, "{key}: {change:.1e}");
        }
    }
    let share = made.split("the vessel itself has ").nth(1).unwrap();
    let share: f64 = share.split(' ').next().unwrap().parse().unwrap();
    // Of all in that wall's statics 31 %.
    assert!((25.0..35.0).contains(&share), "{share}");
}

/// Seconds of the processor that a command takes.
fn processor_seconds(folder: &Path, arguments: &[&str]) -> f64 {
    let mut shell = std::process::Command::new("sh");
    shell
        .current_dir(folder)
        .args(["-ec", "\"$@\" > told; times", "sh"]);
    shell.arg(env!("CARGO_BIN_EXE_fsi-driver")).args(arguments);
    let output = shell.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let told = String::from_utf8(output.stdout).unwrap();
    // Those of the shell itself, then of what it started: minutes and seconds, of the program and of the system.
    let of_child = told.lines().nth(1).unwrap().split_whitespace();
    let seconds = of_child.map(|time| {
        let (minutes, seconds) = time.trim_end_matches('s').split_once('m').unwrap();
        60.0 * minutes.parse::<f64>().unwrap() + seconds.parse::<f64>().unwrap()
    });
    seconds.sum()
}

/// Fifteen branches: 4.0 s for `new` and 2.1 s for `preview` on one machine, 8.7 and 5.0 s on a slow one.
#[test]
#[cfg_attr(debug_assertions, ignore = "a limit for what is optimized")]
fn a_large_tree_is_proposed_and_drawn_within_seconds() {
    let folder = tempfile::tempdir().unwrap();
    copied(folder.path(), "arteries/tree.swc");
    let new = ["new", "c", "--from", "tree.swc", "--unit", "mm"];
    for (arguments, most) in [(&new[..], 20.0), (&["preview", "c"], 12.0)] {
        let seconds = processor_seconds(folder.path(), arguments);
        println!("{arguments:?}: {seconds} s");
        assert!((0.1..most).contains(&seconds), "{arguments:?}: {seconds} s");
    }
}

/// An artery with a sac at its side: one outlet, no opening at the end that is closed; and ends that cannot be.
#[test]
fn a_sac_is_no_opening() {
    let folder = tempfile::tempdir().unwrap();
    let mut lines = String::new();
    for i in 0..=8 {
        let before = if i == 0 { -1 } else { i };
        lines += &format!("{} 5 {} 0 0 2 {before}\n", i + 1, 2 * i);
    }
    // From the middle of the artery on: a neck, then the sac.
    let sac = [
        (1.0, 1.1),
        (2.0, 1.1),
        (3.0, 1.1),
        (4.0, 1.5),
        (5.0, 2.1),
        (6.0, 2.4),
    ];
    for (i, (y, radius)) in sac.iter().enumerate() {
        let before = if i == 0 { 5 } else { 9 + i };
        lines += &format!("{} 5 8 {y} 0 {radius} {before}\n", 10 + i);
    }
    std::fs::write(folder.path().join("lines.swc"), lines).unwrap();
    let new = |name: &str, more: &[&str]| {
        let options = ["new", name, "--from", "lines.swc", "--unit", "mm"];
        driver(folder.path(), &[&options, more].concat())
    };
    let made = new("case", &["--names", "inlet,artery,sac", "--closed", "sac"]);
    let said = String::from_utf8_lossy(&made.stdout);
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    assert!(
        said.contains("a tree with 2 ends, 1 of them closed"),
        "{said}"
    );
    assert!(said.contains("split     artery 100.0 %"), "{said}");
    let case = Case::load(&folder.path().join("case"), Preset::Demo, &[]).unwrap();
    let tree = case.tree().unwrap();
    assert_eq!(tree.open_names(), ["inlet", "artery"]);
    assert_eq!(tree.closed, ["sac"]);
    for (closed, reason) in [
        (
            "dome",
            "--closed dome: no line ends there; they end at artery, sac",
        ),
        ("artery,sac", "--closed: one end at least must be an outlet"),
    ] {
        let refused = new(
            "other",
            &["--names", "inlet,artery,sac", "--closed", closed],
        );
        let said = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(said.contains(reason), "{said}");
        assert!(!folder.path().join("other").exists());
    }
}

/// A carotid by its names and a given split; the windkessels that take off the wall's compliance; pictures.
#[test]
fn a_carotid_becomes_a_case_with_pictures() {
    let folder = tempfile::tempdir().unwrap();
    copied(folder.path(), "carotid/lines.vtp");
    let here = folder.path();
    let said = succeeds(
        here,
        &[
            "new",
            "c",
            "--from",
            "lines.vtp",
            "--unit",
            "mm",
            "--names",
            "common,internal,external",
            "--split",
            "65,35",
        ],
    );
    assert!(
        said.contains("internal 65.0 %, external 35.0 %: as given"),
        "{said}"
    );
    // Springs of a tenth of E h/r², with E = 3 mu, h = 0.2 r and the mean radius.
    let (_, mean) = said.split_once(" mm at the narrowest place, ").unwrap();
    let mean: f64 = mean.split(' ').next().unwrap().parse().unwrap();
    let text = std::fs::read_to_string(here.join("c/case.toml")).unwrap();
    let (_, springs) = text.split_once("spring_Pa_m = ").unwrap();
    let springs: f64 = springs.split(' ').next().unwrap().parse().unwrap();
    let expected = 0.1 * 3.0 * 2.5e5 * 0.2 / (1e-3 * mean);
    assert!(
        (springs / expected - 1.0).abs() < 0.01,
        "{springs} {expected}"
    );
    let (names, shares, whole) = divided(&here.join("c"));
    assert_eq!(names, ["common", "internal", "external"]);
    assert!((shares[0] - 0.65).abs() < 3e-3, "{shares:?}");
    let told = succeeds(
        here,
        &[
            "windkessel",
            "--case",
            "c",
            "--split",
            "65,35",
            "--preset",
            "demo",
        ],
    );
    assert!(
        told.contains("name = \"internal\"") && told.contains("from 80.0 to 120.0 mmHg"),
        "{told}"
    );
    let numbers = |key: &str| -> Vec<f64> {
        let lines = told
            .lines()
            .filter_map(|line| line.strip_prefix(&format!("{key} = ")));
        lines.map(|number| number.parse().unwrap()).collect()
    };
    let resistances = numbers("resistance_Pa_s_m3");
    let parallel = 1.0 / resistances.iter().map(|r| 1.0 / r).sum::<f64>();
    assert!((parallel / whole - 1.0).abs() < 5e-3, "{parallel} {whole}");
    let (_, rest) = told.split_once("the vessel itself has ").unwrap();
    let own: f64 = rest.split(' ').next().unwrap().parse().unwrap();
    println!("{told}");
    assert!(own > 0.0);

    // A wall that bursts has no initial state, but can be drawn: nothing is computed for that.
    std::fs::write(
        here.join("c/case.toml"),
        text.replace("mu_Pa = 2.5e5", "mu_Pa = 2.5e3"),
    )
    .unwrap();
    succeeds(
        here,
        &["preview", "c", "--preset", "demo", "--out", "pictures"],
    );
    let page = std::fs::read_to_string(here.join("pictures/preview.html")).unwrap();
    for part in [
        "The worst places of the blood",
        "3 branches",
        "internal",
        "class=\"viewer\"",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(
        std::fs::metadata(here.join("pictures/preview.png"))
            .unwrap()
            .len()
            > 50_000
    );
}

/// A junction of three daughters is drawn by itself, and so is one where a thin branch leaves a vessel that goes on.
#[test]
fn a_preview_shows_the_junctions() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let middle = "[[tree.opening]]\nname = \"middle\"\ncondition = \"resistance\"\nresistance_Pa_s_m3 = 1e9\n[wall.extrude]";
    let text = TREE
        .replace("\"left\", \"right\"", "\"left\", \"middle\", \"right\"")
        .replace("core = 2", "core = 4")
        .replace("[0.2]", "[0.1]")
        .replace("[wall.extrude]", middle);
    std::fs::create_dir(here.join("three")).unwrap();
    load(&here.join("three"), &text, &swc(&[-50.0, 0.0, 50.0])).unwrap_or_else(|e| panic!("{e}"));
    let page = |case: &str, out: &str| {
        succeeds(here, &["preview", case, "--out", out]);
        std::fs::read_to_string(here.join(out).join("preview.html")).unwrap()
    };
    let three = page("three", "a");
    for part in [
        "4 branches",
        "alt=\"inlet divides into left, middle, right.\"",
        "inlet divides into left, middle, right. Smallest scaled Jacobian: 0.3",
    ] {
        assert!(three.contains(part), "{part}");
    }
    // The vessel, and its junction.
    assert_eq!(three.matches("data:image/png").count(), 2);
    let side = page(&format!("{EXAMPLES}/side-branch"), "b");
    let told = "branch begins at the side of inlet, which goes on as artery.";
    assert!(side.contains(told), "{told}");
    // Fifteen branches have seven junctions.
    let many = page(&format!("{EXAMPLES}/arteries"), "c");
    assert_eq!(many.matches(" divides into ").count(), 2 * 7);
}

/// One sentence each, exit code 2, nothing written.
#[test]
fn what_does_not_fit_a_tree_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    copied(folder.path(), "carotid/lines.vtp");
    let here = folder.path();
    let from = ["new", "c", "--from", "lines.vtp"];
    for (more, reason) in [
        (&[][..], "--unit mm"),
        (&["--unit", "m"], "--unit mm would fit"),
        (&["--unit", "mm", "--names", "a,b"], "--names: expected 3"),
        (
            &["--unit", "mm", "--names", "a,b,b"],
            "two openings are called \"b\"",
        ),
        (&["--unit", "mm", "--names", "a,b,c d"], "letters, digits"),
        (
            &["--unit", "mm", "--split", "1"],
            "--split: expected 2 shares",
        ),
        (
            &["--unit", "mm", "--split", "0.5,-0.5"],
            "--split -0.5: expected shares above 0",
        ),
        (
            &["--unit", "mm", "--split", "0.7,0.7"],
            "--split: the shares add up to 1.4: expected 1, or 100 if they are in percent",
        ),
        (
            &["--unit", "mm", "--smoothing", "500mm"],
            "--smoothing: expected at most 8.0e-2, the length of the longest line",
        ),
        (
            &["--unit", "mm", "--thickness", "50mm"],
            "--thickness 50mm: expected a length from 1e-6 to 0.02 m",
        ),
        (
            &["--unit", "mm", "--split", "1,1", "--murray", "2"],
            "leave out --murray",
        ),
        (
            &["--unit", "mm", "--murray", "-1"],
            "--murray -1: expected an exponent",
        ),
        (
            &["--unit", "mm", "--like", "stenosis"],
            "--like is for a single vessel",
        ),
        (
            &["--unit", "mm", "--reverse"],
            "--reverse is for a single vessel",
        ),
        (
            &["--unit", "mm", "--radius", "3mm"],
            "leave it out: the radii of a tree are those along its lines",
        ),
        (
            &["--unit", "mm", "--lumen", "none.stl"],
            "none.stl: No such file",
        ),
        (&["--unit", "mm", "--flow", "none.csv"], "none.csv"),
    ] {
        let output = driver(here, &[&from[..], more].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{more:?}: {error}");
        assert!(
            error.contains(reason),
            "{more:?}: {error}\nexpected {reason}"
        );
        assert!(!here.join("c").exists());
    }
    let output = driver(
        here,
        &[
            "new",
            "tube",
            "--split",
            "1,1",
            "--from",
            "lines.vtp",
            "--branch",
            "CenterlineIds=0",
            "--unit",
            "mm",
        ],
    );
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && error.contains("--split is for a vessel that branches"),
        "{error}"
    );
}

/// A parent of 3 mm that divides; a daughter goes straight on, and another branch leaves it at 12°.
fn crowded() -> String {
    let mut rows = String::from("1 0 -20 0 0 3 -1\n");
    let mut id = 1;
    let mut line = |from: usize, begin: [f64; 2], angle: f64, r: f64, lengths: &[f64]| {
        let (sin, cos) = f64::to_radians(angle).sin_cos();
        let mut parent = from;
        for s in lengths {
            id += 1;
            let [x, y] = [begin[0] + s * cos, begin[1] + s * sin];
            rows += &format!("{id} 0 {x:.4} {y:.4} 0 {r} {parent}\n");
            parent = id;
        }
        id
    };
    let trunk: Vec<f64> = (1..=20).map(f64::from).collect();
    let long: Vec<f64> = (1..=18).map(f64::from).collect();
    let fork = line(1, [-20.0, 0.0], 0.0, 3.0, &trunk);
    line(fork, [0.0, 0.0], -40.0, 2.2, &long);
    let (sin, cos) = f64::to_radians(40.0).sin_cos();
    let near = line(fork, [0.0, 0.0], 40.0, 2.2, &long[..9]);
    line(near, [9.0 * cos, 9.0 * sin], 40.0, 2.2, &long[..9]);
    line(near, [9.0 * cos, 9.0 * sin], 52.0, 1.2, &long);
    rows
}

/// A vessel with more thin branches than a case has openings: the refusal says from which radius on there are few
/// enough, and that radius makes the case.
#[test]
fn a_tree_of_too_many_ends_is_cut_at_a_radius() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // A parent of 3 mm, two daughters of 2 mm, and 70 twigs of 0.4 mm along one of them.
    let mut text = String::new();
    let mut point = |id: i32, x: f64, y: f64, r: f64, parent: i32| {
        text += &format!("{id} 0 {x} {y} 0 {r} {parent}\n");
    };
    point(1, -20.0, 0.0, 3.0, -1);
    (2..=21).for_each(|i| point(i, f64::from(i) - 21.0, 0.0, 3.0, i - 1));
    for (first, towards) in [(100, 0.8), (300, -0.8)] {
        for i in 0..100 {
            let s = f64::from(i + 1);
            let parent = if i == 0 { 21 } else { first + i - 1 };
            point(first + i, s, towards * s, 3.0 - (s / 3.0).min(1.0), parent);
        }
    }
    for i in 0..70 {
        let [x, y] = [f64::from(21 + i), 0.8 * f64::from(21 + i)];
        point(1000 + 2 * i, x, y + 2.0, 0.4, 120 + i);
        point(1001 + 2 * i, x, y + 6.0, 0.4, 1000 + 2 * i);
    }
    std::fs::write(here.join("t.swc"), text).unwrap();
    let from = ["new", "c", "--from", "t.swc", "--unit", "mm"];
    let output = driver(here, &[&from[..], &["--leave-out", "outlet1"]].concat());
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.contains("71 ends") && error.contains("2 ends are left"),
        "{error}"
    );
    let output = driver(here, &from);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains("72 ends are more than 63: leave out thin vessels, as --least-radius "),
        "{error}"
    );
    let (_, least) = error.split_once("--least-radius ").unwrap();
    let (least, left) = least.split_once(' ').unwrap();
    assert!(left.contains("with which 2 ends are left"), "{error}");
    let said = succeeds(here, &[&from[..], &["--least-radius", least]].concat());
    assert!(
        said.contains("a tree with 2 ends of vessels of at least") && said.contains("3 branches"),
        "{said}"
    );
    let case = Case::load(&here.join("c"), Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        case.tree().unwrap().names(),
        ["inlet", "outlet1", "outlet2"]
    );
    for (wrong, reason) in [
        ("2.5mm", "--least-radius: a tree has two ends at least"),
        ("4mm", "--least-radius: no line is as wide as 4 mm"),
        ("-1mm", "--least-radius"),
    ] {
        let output = driver(
            here,
            &[
                "new",
                "d",
                "--from",
                "t.swc",
                "--unit",
                "mm",
                "--least-radius",
                wrong,
            ],
        );
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(reason), "{error}");
        assert!(!here.join("d").exists());
    }
}

/// A daughter that begins with a hook: `new` leads a smooth curve past it and says so, unless the lines are to stay as
/// they are.
#[test]
fn hooks_of_traced_lines_are_smoothed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut rows = String::from("1 0 -20 0 0 3 -1\n");
    for i in 2..=21 {
        rows += &format!("{i} 0 {} 0 0 3 {}\n", i - 21, i - 1);
    }
    let (sin, cos) = 40f64.to_radians().sin_cos();
    let hook = ["-1.8 1.5 1.4 3", "-2.4 2.8 2.2 2.8", "0.2 3.2 2.0 2.3"];
    for (first, towards) in [(100, -1.0), (200, 1.0)] {
        for i in 0..16 {
            let s = f64::from(i + 1);
            let straight = format!("{:.3} {:.3} 0 2", s * cos, s * sin * towards);
            let place = hook.get(i as usize).filter(|_| towards > 0.0);
            let place = place.map_or(straight, |x| (*x).to_owned());
            let parent = if i == 0 { 21 } else { first + i - 1 };
            rows += &format!("{} 0 {place} {parent}\n", first + i);
        }
    }
    std::fs::write(here.join("h.swc"), rows).unwrap();
    let from = ["new", "c", "--from", "h.swc", "--unit", "mm"];
    let said = succeeds(here, &from);
    println!("{said}");
    assert!(
        said.contains(
            "smoothing smooth curves replace the lines within 2 radii of where branches part, since"
        ) && said.contains("points move by up to "),
        "{said}"
    );
    let text = std::fs::read_to_string(here.join("c/case.toml")).unwrap();
    assert!(text.contains("\njunction_smoothing = 2.0 "), "{text}");
    assert!(!text.contains("\nsmoothing_m"), "{text}");
    let case = Case::load(&here.join("c"), Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
    let worst = Tree::meshes(case.tree().unwrap()).unwrap().worst.0;
    assert!((0.2..0.7).contains(&worst), "{worst}");
    for (radii, reason) in [
        ("0", "have no mesh, since"),
        (
            "20",
            "--junction-smoothing 20: expected radii, from 0 to 10",
        ),
    ] {
        let mut all = from;
        all[1] = "d";
        let output = driver(here, &[&all[..], &["--junction-smoothing", radii]].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(reason), "{error}");
        assert!(!here.join("d").exists());
    }
}

/// Without the flag the refusal says what it would leave out; with it the thinner branch of a junction without a mesh
/// is left out, with its share of the flow and the reason.
#[test]
fn ends_that_have_no_mesh_can_be_left_out() {
    // 1.2³/(2 · 2.2³ + 1.2³) of the flow.
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("t.swc"), crowded()).unwrap();
    let from = ["new", "c", "--from", "t.swc", "--unit", "mm"];
    let output = driver(here, &from);
    let error = String::from_utf8(output.stderr).unwrap();
    println!("{error}");
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains(
            "--leave-out-impossible leaves out 1 of the 3 ends (outlet3), 7.5 % of the flow"
        ),
        "{error}"
    );
    assert!(!here.join("c").exists());
    // Of two ends none can be left out, and the reason is that of the lines as they are.
    let two = [&from[..], &["--leave-out", "outlet1"]].concat();
    let reasons = [&two[..], &[&two[..], &["--leave-out-impossible"]].concat()].map(|arguments| {
        let output = driver(here, arguments);
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    });
    let [as_they_are, left_out] = reasons.each_ref().map(|reason| reason.split("; ").next());
    assert_eq!(as_they_are, left_out);
    assert!(
        reasons[1].contains("; there are no ends without which the others have a mesh"),
        "{reasons:?}"
    );
    let said = succeeds(here, &[&from[..], &["--leave-out-impossible"]].concat());
    println!("{said}");
    assert!(
        said.contains("left out  1 of 3 ends, with 7.5 % of the flow")
            && said.contains("they leave in nearly the same direction")
            && said.contains("outlet3 (7.5 %, radius 1.20 mm): at the junction at"),
        "{said}"
    );
    let case = Case::load(&here.join("c"), Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
    let tree = case.tree().unwrap();
    assert_eq!(tree.names(), ["inlet", "outlet1", "outlet2"]);
    let worst = Tree::meshes(tree).unwrap().worst.0;
    assert!((0.3..0.7).contains(&worst), "{worst}");
}

/// The normals of a tree's wall are averaged as often as it takes, and no more often: a wall of a third of the radius.
#[test]
fn a_thick_wall_is_built_where_branches_part() {
    let aorta = Path::new(EXAMPLES).join("aorta");
    let check = |more: &[&str]| {
        let mut all = vec!["check", aorta.to_str().unwrap(), "--fluid", "native"];
        all.extend(["--preset", "demo"]);
        let low = [
            "wall.initial.pressure_Pa=100",
            "tree.opening[1].initial_pressure_Pa=100",
            "tree.opening[2].initial_pressure_Pa=100",
        ];
        all.extend(low.iter().chain(more).flat_map(|set| ["--set", set]));
        driver(&std::env::temp_dir(), &all)
    };
    let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let usual = check(&[]);
    assert!(usual.status.success() && !said(&usual.stdout).contains("averaged"));
    let thick = "wall.extrude.thicknesses=[0.35]";
    let found = check(&[thick]);
    assert!(
        found.status.success() && said(&found.stdout).contains("averaged 16 times"),
        "{}{}",
        said(&found.stdout),
        said(&found.stderr)
    );
    let refused = check(&[thick, "wall.extrude.smoothing=4"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        said(&refused.stderr).contains("inside out")
            && said(&refused.stderr).contains("no wall.extrude.smoothing"),
        "{}",
        said(&refused.stderr)
    );
    let hopeless = check(&["wall.extrude.thicknesses=[5.0]"]);
    assert_eq!(hopeless.status.code(), Some(2));
    let reason = said(&hopeless.stderr);
    assert!(
        reason.contains("`wall.extrude.thicknesses` = [5.0]: the wall would be inside out ")
            && reason.contains(" mm along the branch \"")
            && reason.contains("with 256 averages of the normals as well"),
        "{reason}"
    );
}

/// A pressure that no wall of these layers carries is refused before an unloaded shape is looked for.
#[test]
fn a_pressure_that_the_wall_does_not_carry_is_refused() {
    let carotid = Path::new(EXAMPLES).join("carotid");
    let keys = [
        "wall.initial.pressure_Pa=5e5",
        "tree.opening[1].initial_pressure_Pa=5e5",
        "tree.opening[2].initial_pressure_Pa=5e5",
    ];
    let check = [
        "check",
        carotid.to_str().unwrap(),
        "--preset",
        "demo",
        "--fluid",
        "native",
    ];
    let set = keys.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> = check.into_iter().chain(set).collect();
    let output = driver(&std::env::temp_dir(), &arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains("`wall.initial.pressure_Pa` = 500000.0: the wall of the branch \"common\", 0.25 of the radius thick")
            && error.contains("does not carry 500.0 kPa (3750 mmHg)"),
        "{error}"
    );
}

/// `new` tries the wall: what `check` would refuse is not written.
#[test]
fn a_wall_that_would_be_inside_out_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    copied(here, "carotid/lines.vtp");
    let thick = [
        "new",
        "c",
        "--from",
        "lines.vtp",
        "--unit",
        "mm",
        "--thickness",
        "15mm",
    ];
    let output = driver(here, &thick);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains("the wall would be inside out near (")
            && error.contains("a smaller --thickness, or none, helps"),
        "{error}"
    );
    let left = std::fs::read_dir(here).unwrap().count();
    assert_eq!(left, 1, "only the file of the lines");
}

/// Names that are given to `new` are those of the case, in the order of the file; the refusal of others says what was
/// found and what is possible.
#[test]
fn names_of_ends_are_those_of_the_case() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("t.swc"), swc(&[-40.0, 40.0])).unwrap();
    let new = |name: &str, more: &str| {
        let begin = ["new", name, "--from", "t.swc", "--unit", "mm"];
        let all: Vec<&str> = begin.into_iter().chain(more.split(' ')).collect();
        driver(here, &all)
    };
    let made = new("c", "--names root,upper-end,lower_2");
    let said = String::from_utf8_lossy(&made.stdout);
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    assert!(said.contains("upper-end 50.0 %, lower_2 50.0 %"), "{said}");
    let case = Case::load(&here.join("c"), Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
    let tree = case.tree().unwrap();
    assert_eq!(tree.names(), ["root", "upper-end", "lower_2"]);
    let of_openings = tree.opening.iter().flatten();
    let of_openings: Vec<_> = of_openings.map(|keys| keys.name.as_str()).collect();
    assert_eq!(of_openings, ["root", "upper-end", "lower_2"]);
    for (wrong, reason) in [
        (
            "--names root,upper",
            "--names: expected 3, that of the inlet and then those of the 2 ends in the order of the file, found 2",
        ),
        ("--names a,b,c,d", "found 4"),
        ("--names ,,", "--names ,,: name 1 is empty"),
        ("--names a,,c", "--names a,,c: name 2 is empty"),
        ("--names a,b,a", "two openings are called \"a\""),
        (
            "--names a,b,wallFsi",
            "--names: \"wallFsi\" cannot be the name of an opening: expected letters, digits, _, - and .",
        ),
        (
            "--names a,b,c --leave-out upper",
            "--leave-out upper: no line ends there; they end at b, c",
        ),
        (
            "--closed outlet3",
            "--closed outlet3: no line ends there; they end at outlet1, outlet2",
        ),
    ] {
        let refused = new("other", wrong);
        let said = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{wrong}: {said}");
        assert!(said.contains(reason), "{wrong}: {said}\nexpected {reason}");
        assert!(!here.join("other").exists());
    }
}
