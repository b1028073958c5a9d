//! Pages and comparisons of short real runs on two meshes.

use crate::run_support::*;
use base64::Engine;
use rustix::process::Signal;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

const STEPS: usize = 5;
const EVERY_STEP: [&str; 2] = ["--set", "output.structure_interval_s=0.002"];

fn fsi(words: &[&str], paths: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command.args(words).args(paths).output().unwrap()
}

fn page(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// The texts between two others.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    let parts = text.split(start).skip(1);
    parts.map(|part| part.split(end).next().unwrap()).collect()
}

/// A page must stand on nothing but itself, be small, and hold nothing but well-formed figures.
fn inspect(html: &str) {
    for foreign in ["src=\"http", "href=\"http", "<link", "@import", "url(http"] {
        assert!(!html.contains(foreign), "{foreign}");
    }
    assert!(html.len() < 15_000_000, "{} bytes", html.len());
    let ids = between(html, "<section id=\"", "\"");
    for target in between(html, "href=\"#", "\"") {
        assert!(ids.contains(&target), "nothing is called {target}");
    }
    let figures = between(html, "<svg", "</svg>");
    assert!(figures.len() > 8);
    for figure in figures {
        let svg = format!("<svg{figure}</svg>");
        resvg::usvg::Tree::from_str(&svg, &resvg::usvg::Options::default()).unwrap();
        // Pixels in base 64 may spell any word.
        let images = between(&svg, "base64,", "\"");
        let svg = images
            .iter()
            .fold(svg.clone(), |svg, image| svg.replace(image, ""));
        for nonsense in [
            "=\"NaN", "=\"inf", ",NaN", ",inf", "MNaN", "Minf", ">NaN", ">inf<",
        ] {
            assert!(!svg.contains(nonsense), "{nonsense} in {svg}");
        }
    }
}

/// The script that comes with a run, in a folder that was moved and without a display, if ParaView is there.
fn picture_by_paraview(run: &Path, elsewhere: &Path) {
    let has_paraview = Command::new("pvpython").arg("--version").output().is_ok();
    if !has_paraview || Command::new("Xvfb").arg("-version").output().is_err() {
        eprintln!("without ParaView and Xvfb the picture of view.py is not tried");
        return;
    }
    std::fs::rename(run, elsewhere).unwrap();
    let picture = run.with_file_name("picture.png");
    let mut command = Command::new("pvpython");
    command.env_remove("DISPLAY").arg(elsewhere.join("view.py"));
    complete({
        command.arg("--screenshot").arg(&picture);
        command
    });
    let image = resvg::tiny_skia::Pixmap::decode_png(&std::fs::read(&picture).unwrap()).unwrap();
    assert_eq!((image.width(), image.height()), (1600, 900));
    // From the data's bounds: what is shown fills the width but for the margins.
    let is_drawn = |column: &u32| {
        (0..600).any(|row| image.pixel(*column, row).unwrap().demultiply().red() < 200)
    };
    let drawn: Vec<u32> = (0..1600).filter(is_drawn).collect();
    assert!((40..120).contains(&drawn[0]), "{}", drawn[0]);
    let last = drawn[drawn.len() - 1];
    assert!((1480..1560).contains(&last), "{last}");
    std::fs::rename(elsewhere, run).unwrap();
    std::fs::remove_file(picture).unwrap();
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn pages_are_whole_and_comparisons_find_differences() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let study = at("study");
    std::fs::create_dir(&study).unwrap();
    let (a, b, other) = (study.join("one"), study.join("two"), study.join("three"));
    complete(driver(&a, STEPS, &EVERY_STEP));
    let finer = [
        "--set",
        "fluid.mesh.axial_per_section=9",
        "fluid.mesh.core=5",
    ];
    complete(driver(&b, STEPS, &[&EVERY_STEP[..], &finer].concat()));
    let smooth = ["--set", "model.d_max_m=0.0"];
    complete(driver(&other, STEPS, &[&EVERY_STEP[..], &smooth].concat()));

    // A run.
    let output = fsi(&["report"], &[&a]);
    assert!(output.status.success(), "{}", text(&output));
    let html = page(&a.join("report.html"));
    inspect(&html);
    assert_eq!(
        between(&html, "<h1>", "</h1>"),
        ["Blood and wall of S-0.25, run one"]
    );
    let case = between(&html, "<section id=\"case\">", "</section>")[0];
    for part in [
        "Holzapfel, Gasser and Ogden, mu 54.0 kPa",
        "Reynolds number",
        "Womersley number",
        "windkessel, R 1.785e9",
        "m/s at the mean pressure",
        "fsi-driver ",
    ] {
        assert!(case.contains(part), "{part}: {case}");
    }
    let warnings = between(&html, "<p class=\"warning\">", "</p>");
    let ramp = |warning: &&str| warning.contains("contains the smooth start");
    assert!(warnings.iter().any(ramp), "{warnings:?}");
    // The radius after steps 1, 2 and 4 of these five, and views that begin where the wall has moved.
    let radii = between(&html, "<section id=\"radius\">", "</section>")[0];
    assert_eq!(between(radii, "<figure>", "</figure>").len(), 3);
    let csv = between(
        &html,
        "download=\"flow.csv\" href=\"data:text/csv;base64,",
        "\"",
    )[0];
    let csv = base64::engine::general_purpose::STANDARD
        .decode(csv)
        .unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let history = rows(&a.join("history.csv"));
    let inflow: Vec<&str> = csv
        .lines()
        .filter(|line| line.starts_with("\"inflow\","))
        .collect();
    assert_eq!(inflow.len(), STEPS, "{csv}");
    let last: f64 = inflow[STEPS - 1]
        .rsplit(',')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    let expected = history[STEPS - 1]
        .iter()
        .find_map(|cell| cell.strip_prefix("Q_in_m3_s="));
    let expected: f64 = expected.unwrap().parse().unwrap();
    assert!(
        (1e-6 * last / expected - 1.0).abs() < 1e-5,
        "{last} ml/s, {expected} m³/s"
    );
    let scene = between(&html, "<script type=\"application/json\">", "</script>")[0];
    let scene: serde_json::Value = serde_json::from_str(scene).unwrap();
    let frames = scene["times"].as_array().unwrap().len();
    let points = scene["points"].as_u64().unwrap() as usize;
    let positions = scene["positions"].as_str().unwrap();
    let positions = base64::engine::general_purpose::STANDARD
        .decode(positions)
        .unwrap();
    assert_eq!((frames, positions.len()), (STEPS, 6 * points * frames));
    assert!(scene["fields"].to_string().contains("Von Mises"));
    assert_eq!(scene["frame"].as_u64(), Some(STEPS as u64 - 1));

    // What ParaView opens.
    assert!(a.join("openfoam/fluid.foam").is_file());
    picture_by_paraview(&a, &at("elsewhere"));
    let old = a.join("paraview.py");
    std::fs::write(&old, "").unwrap();
    let output = fsi(&["hemodynamics"], &[&a]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(a.join("view.py").is_file() && !old.exists());

    // A study, with a model that has not ended.
    let unfinished = study.join("unfinished");
    std::fs::create_dir(&unfinished).unwrap();
    std::fs::copy(
        a.join("case.resolved.toml"),
        unfinished.join("case.resolved.toml"),
    )
    .unwrap();
    let output = fsi(&["report"], &[&study]);
    assert!(output.status.success(), "{}", text(&output));
    let html = page(&study.join("report.html"));
    inspect(&html);
    assert!(html.contains("unfinished holds no hemodynamics.json"));
    // Cases of one's own keep their names, and are not held against the paper.
    assert_eq!(between(&html, "<h1>", "</h1>"), ["Study study"]);
    assert!(html.contains("<p class=\"lead\">3 run(s): one, three, two.</p>"));
    assert!(
        !html.contains("paper") && !html.contains("S-0."),
        "{}",
        html.len()
    );
    let differences = between(&html, "<section id=\"differences\">", "</section>")[0];
    let cells: Vec<&str> = between(differences, "<div>", "</div>");
    let expected = [
        "fluid.mesh.axial_per_section",
        "6",
        "6",
        "9",
        "fluid.mesh.core",
        "4",
        "4",
        "5",
        "model.d_max_m",
        "0.00025",
        "0.0",
        "0.00025",
    ];
    assert_eq!(cells, expected);
    let output = fsi(&["report"], &[folder.path().join("nothing").as_path()]);
    assert_eq!(output.status.code(), Some(2));
    let output = fsi(&["report"], &[&a.join("openfoam")]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output).contains("neither the folder of a run"),
        "{}",
        text(&output)
    );

    // Comparisons.
    let strict = ["compare", "--history", "0", "--wall", "0", "--osi", "0"];
    let output = fsi(&strict, &[&a, &a]);
    assert!(output.status.success(), "{}", text(&output));
    let output = fsi(&strict, &[&a, &b]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert!(
        text(&output).contains("TAWSS / Pa (mid-artery)"),
        "{}",
        text(&output)
    );
    let generous = ["compare", "--history", "1", "--wall", "1", "--osi", "0.5"];
    let maps = at("maps");
    let with_maps = [&generous[..], &["--out", maps.to_str().unwrap()]].concat();
    let output = fsi(&with_maps, &[&a, &b]);
    assert!(output.status.success(), "{}", text(&output));
    for name in [
        "outflow.svg",
        "map-TAWSS-A.svg",
        "map-OSI-difference.svg",
        "compare.csv",
    ] {
        assert!(maps.join(name).is_file(), "{name}");
    }
    assert_eq!(fsi(&with_maps, &[&a, &b]).status.code(), Some(2));
    let output = fsi(&generous, &[&a, &other]);
    // Of another model: nothing is judged, and what differs is said.
    assert!(output.status.success(), "{}", text(&output));
    let output = fsi(&["compare", "--history", "0", "--wall", "0"], &[&a, &other]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(
        text(&output).contains("model.d_max_m: 0.00025 and 0.0"),
        "{}",
        text(&output)
    );
    let output = fsi(&["compare", "--wall", "-1"], &[&a, &b]);
    assert_eq!(output.status.code(), Some(2));

    // The same runs as the paper calls them.
    let models = at("models");
    std::fs::create_dir(&models).unwrap();
    std::fs::rename(&a, models.join("S-0.25")).unwrap();
    std::fs::rename(&other, models.join("S-0.0")).unwrap();
    let output = fsi(&["report"], &[&models]);
    assert!(output.status.success(), "{}", text(&output));
    let html = page(&models.join("report.html"));
    inspect(&html);
    assert_eq!(between(&html, "id=\"findings\"", "<tbody>").len(), 1);
    assert!(html.contains("not computed"));
    // The flows balance the change of the volume to a small part of it, which is not shown as nothing.
    let balance = between(&html, "difference of the flows is dV/dt within ", " %")[0];
    assert!(
        (1e-6..1e-3).contains(&balance.parse::<f64>().unwrap()),
        "{balance}"
    );
    // A title of its own, which may hold anything, makes one of them a case like any other.
    let resolved = models.join("S-0.25/case.resolved.toml");
    let values = page(&resolved).replace("[output]\n", "[output]\ntitle = \"left <leg>\"\n");
    std::fs::write(&resolved, values).unwrap();
    let output = fsi(&["report"], &[&models]);
    assert!(output.status.success(), "{}", text(&output));
    let html = page(&models.join("report.html"));
    inspect(&html);
    assert!(html.contains("left &lt;leg>") || html.contains("left &lt;leg&gt;"));
    assert!(!html.contains("id=\"findings\"") && !html.contains("<leg>"));
    assert!(!html.contains("&amp;"), "escaped twice");
}

/// Its page says so and reloads itself; `--follow` remakes it until the run has ended; a comparison has to wait.
#[test]
fn a_run_that_is_going_on_has_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let html = out.join("report.html");
    let goes_on = |html: &str| {
        let reloads = html.contains("http-equiv=\"refresh\" content=\"60\"");
        assert_eq!(html.contains("The run is going on"), reloads);
        reloads
    };
    let output = fsi(&["report", "--follow"], &[folder.path()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output).contains("--follow:"), "{}", text(&output));

    let mut child = start(&mut driver(&out, 500, &crate::native_run::FEW));
    wait_for_steps(&mut child, &out, 1);
    let output = fsi(&["report"], &[&out]);
    assert!(output.status.success(), "{}", text(&output));
    let first = page(&html);
    assert!(goes_on(&first));
    inspect(&first);
    let output = fsi(&["compare"], &[&out, &out]);
    assert_eq!(output.status.code(), Some(2));
    let part = format!("is going on (process {} on", child.id());
    assert!(text(&output).contains(&part), "{}", text(&output));

    let mut follow = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    let mut follow = follow
        .args(["report", "--follow"])
        .arg(&out)
        .spawn()
        .unwrap();
    wait_for_steps(&mut child, &out, 3);
    eventually("the page is made again", Duration::from_secs(60), || {
        page(&html) != first
    });
    assert!(follow.try_wait().unwrap().is_none());
    signal(child.id() as i32, Signal::INT);
    child.wait().unwrap();
    assert!(follow.wait().unwrap().success());
    let last = page(&html);
    assert!(!goes_on(&last));
    inspect(&last);

    // One that was killed has results only once it is resumed.
    std::fs::remove_file(out.join("hemodynamics.json")).unwrap();
    let output = fsi(&["report"], &[&out]);
    assert!(text(&output).contains("--resume"), "{}", text(&output));
}
