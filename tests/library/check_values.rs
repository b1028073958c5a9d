//! What `fsi-driver check` says of values that are not those of vessels, and which unit it takes them for.

use fsi_driver::analysis::plausibility::warnings;
use fsi_driver::case::{Case, Preset};
use std::path::{Path, PathBuf};
use std::process::Command;

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case")
}

/// What is said of the case of a file with these values.
fn said(file: &Path, set: &[&str]) -> Vec<String> {
    let set = set.iter().map(|pair| pair.split_once('=').unwrap());
    let set: Vec<_> = set.map(|(key, value)| (key.into(), value.into())).collect();
    let case = Case::load(file, Preset::Paper, &set).unwrap_or_else(|errors| panic!("{errors}"));
    warnings(&case)
}

/// A carotid of 3.2 mm, and what else is said of it.
fn carotid(folder: &Path, thicknesses: &str) -> PathBuf {
    let text = format!(
        "extends = \"defaults\"\n[vessel]\nradius_m = 3.2e-3\n[[vessel.piece]]\npiece = \"line\"\nlength_m = 0.05\n\
         [[vessel.section]]\nname = \"carotid\"\nlayers = [\"media\", \"adventitia\"]\n{thicknesses}\n\
         [[vessel.material]]\nname = \"media\"\nmaterial = \"neo_hooke\"\nmu_Pa = 3e5\nkappa_Pa = 1e8\n\
         [[vessel.material]]\nname = \"adventitia\"\nmaterial = \"neo_hooke\"\nmu_Pa = 2e5\nkappa_Pa = 1e8\n"
    );
    let file = folder.join("case.toml");
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn the_unit_that_was_probably_meant_is_named() {
    const LOADED: &str = "initial.start=equilibrium";
    let folder = tempfile::tempdir().unwrap();
    let carotid = carotid(folder.path(), "thicknesses_m = [0.4e-3, 0.3e-3]");
    for (set, parts) in [
        (
            &["windkessel.initial_pressure_Pa=80", LOADED][..],
            &[
                "windkessel.initial_pressure_Pa (--set): 80 Pa is 0.6 mmHg",
                "80 mmHg is 10666 Pa",
            ][..],
        ),
        (
            &["windkessel.initial_pressure_Pa=80"],
            &["80 mmHg is 10666 Pa"],
        ),
        (
            &["windkessel.initial_pressure_Pa=10.7", LOADED],
            &["10.7 kPa is 10700 Pa"],
        ),
        (
            &["windkessel.initial_pressure_Pa=106640", LOADED],
            &["106640 dyn/cm2 is 10664 Pa"],
        ),
        (
            &["windkessel.resistance_Pa_s_m3=1500"],
            &[
                "the expected mean pressure, all resistances times the mean flow",
                "1500 dyn s/cm5 is 1.5e8 Pa s/m³",
            ],
        ),
        (
            &["windkessel.resistance_Pa_s_m3=13.4"],
            &["13.4 mmHg s/ml is 1.787e9 Pa s/m³"],
        ),
        (
            &["windkessel.proximal_resistance_Pa_s_m3=1500"],
            &["1500 dyn s/cm5 is 1.5e8"],
        ),
        (
            &["windkessel.compliance_m3_Pa=1.8e-5"],
            &["time constant R C", "1.8e-5 cm5/dyn is 1.8e-10 m³/Pa"],
        ),
        (
            &["windkessel.compliance_m3_Pa=0.024"],
            &["0.024 ml/mmHg is 1.8e-10 m³/Pa"],
        ),
        (&["blood.density_kg_m3=1.06"], &["1.06 g/cm3 is 1060 kg/m³"]),
        (&["blood.viscosity_Pa_s=3.5"], &["3.5 cP is 0.0035 Pa s"]),
        (&["blood.viscosity_Pa_s=0.035"], &["0.035 P is 0.0035 Pa s"]),
        (&["wall.density_kg_m3=1.1"], &["1.1 g/cm3 is 1100 kg/m³"]),
        (
            &["inflow.base_m3_s=0.3", "inflow.amplitude_m3_s=0.5"],
            &[
                "the highest velocity of the blood",
                "0.3 l/min is 5e-6 m³/s",
            ],
        ),
        (
            &["inflow.base_m3_s=5e-3", "inflow.amplitude_m3_s=9e-3"],
            &["0.005 l/s is 5e-6 m³/s"],
        ),
        (&["vessel.material[0].mu_Pa=54"], &["54 kPa is 54000 Pa"]),
        (
            &["vessel.material[0].mu_Pa=0.054"],
            &["0.054 MPa is 54000 Pa"],
        ),
        (&["vessel.material[1].mu_Pa=5.4"], &["5.4 kPa is 5400 Pa"]),
        (
            &["surroundings.spring_Pa_m=10"],
            &["the stiffness of tissue", "10 kPa/mm is 1e7 Pa/m"],
        ),
        (&["surroundings.pressure_Pa=5"], &["5 mmHg is 667 Pa"]),
        (
            &[
                "time.period_s=800",
                "time.step_s=1",
                "time.end_s=2400",
                "output.structure_interval_s=1",
                "output.fluid_interval_s=1",
            ],
            &["800 ms is 0.8 s"],
        ),
        (
            &[
                "time.step_s=0.5",
                "output.structure_interval_s=0.5",
                "output.fluid_interval_s=0.5",
            ],
            &["the number of steps in a beat is 2", "0.5 ms is 5e-4 s"],
        ),
        (
            &["time.end_s=3000"],
            &["the number of beats is 3000", "3000 ms is 3 s"],
        ),
        (
            &["vessel.section[0].thicknesses_m=[0.03, 0.04]"],
            &[
                "the thickness of the wall relative to the radius",
                "0.03 cm is 3e-4 m",
            ],
        ),
        (
            &[
                "vessel.material[0].mu_Pa=3e3",
                "vessel.material[1].mu_Pa=2e3",
            ],
            &["cannot carry the expected 127 mmHg"],
        ),
        // No unit is to blame.
        (
            &["vessel.section[0].thicknesses_m=[4e-3, 3e-3]"],
            &[
                "in the section carotid is 2.19, not 0.01 to 0.8 as usual: look at vessel.section[0].thicknesses_m (--set)",
            ],
        ),
        (
            &["inflow.base_m3_s=-5e-6", "inflow.amplitude_m3_s=-9e-6"],
            &["is its sign that of an outflow?"],
        ),
    ] {
        let said = said(&carotid, set);
        let found = said
            .iter()
            .any(|sentence| parts.iter().all(|part| sentence.contains(part)));
        assert!(found, "{set:?}: {said:#?}");
    }
    assert_eq!(said(&carotid, &[]), Vec::<String>::new());
    for usual in [
        &[
            "initial.start=equilibrium",
            "windkessel.initial_pressure_Pa=10666",
        ][..],
        &[
            "initial.start=equilibrium",
            "windkessel.initial_pressure_Pa=0",
        ],
        &[
            "surroundings.spring_Pa_m=1e7",
            "blood.density_kg_m3=1000",
            "blood.viscosity_Pa_s=4e-3",
        ],
        // A coronary artery and an aorta
        &[
            "vessel.radius_m=1.5e-3",
            "inflow.base_m3_s=6e-7",
            "inflow.amplitude_m3_s=1e-6",
            "windkessel.resistance_Pa_s_m3=1.3e10",
            "windkessel.compliance_m3_Pa=1e-11",
        ],
        &[
            "vessel.radius_m=12e-3",
            "vessel.section[0].thicknesses_m=[0.6e-3, 0.6e-3]",
            "inflow.base_m3_s=0",
            "inflow.amplitude_m3_s=5e-4",
            "windkessel.resistance_Pa_s_m3=1.1e8",
            "windkessel.proximal_resistance_Pa_s_m3=1.2e7",
            "windkessel.compliance_m3_Pa=1e-8",
        ],
    ] {
        assert_eq!(said(&carotid, usual), Vec::<String>::new());
    }
}

#[test]
fn benchmarks_that_are_no_vessels_are_hardly_spoken_of() {
    // Blood as good as without friction.
    const THIN: [&str; 2] = ["pulse-wave/case.toml", "pulse-wave/closed.toml"];
    for entry in std::fs::read_dir(project()).unwrap() {
        let files = std::fs::read_dir(entry.unwrap().path());
        for file in files.into_iter().flatten().map(|file| file.unwrap().path()) {
            let is_case = file.extension().is_some_and(|end| end == "toml")
                && std::fs::read_to_string(&file)
                    .unwrap()
                    .starts_with("extends");
            if is_case {
                let expected = usize::from(THIN.iter().any(|thin| file.ends_with(thin)));
                let said = said(&file, &[]);
                assert_eq!(said.len(), expected, "{}: {said:#?}", file.display());
            }
        }
    }
}

#[test]
fn check_says_what_is_to_be_expected_and_what_is_odd() {
    let check = |more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args([
                "check",
                "openfoam-case/S-0.0",
                "--preset",
                "coarse",
                "--fluid",
                "native",
            ])
            .args(more)
            .output()
            .unwrap();
        assert!(output.status.success());
        String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
    };
    let usual = check(&[]);
    for part in [
        // 440 ml/min; 98.1 mmHg by resistance and mean flow
        "flow    439.",
        "Womersley number 4.94",
        "98.1 mmHg on average to be expected, from",
        "wall    artery: h/r 0.344",
        "waves   in the artery under 98 mmHg: ",
        "lumen   the mesh's radii differ from those described by 0.",
        "cost    at least ",
        " on the disk",
    ] {
        assert!(usual.contains(part), "{part}: {usual}");
    }
    assert!(!usual.contains("warning"), "{usual}");
    let odd = check(&[
        "--set",
        "windkessel.initial_pressure_Pa=80",
        "geometry.graft_inner_radius_m=5e-3",
        "geometry.artery_inner_radius_m=2e-3",
        "geometry.blend_length_m=1e-5",
        "fluid.ranks=1",
    ]);
    for part in [
        "warning: windkessel.initial_pressure_Pa (--set): 80 Pa is 0.6 mmHg",
        "warning: the mesh's radii differ from those described by",
        "warning: `fluid.ranks` (--set) does nothing here",
    ] {
        assert!(odd.contains(part), "{part}: {odd}");
    }
}

/// The same of a vessel that branches.
#[test]
fn values_of_a_tree_that_are_not_usual_are_told() {
    let carotid = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/trees/carotid");
    assert_eq!(said(&carotid, &[]), Vec::<String>::new());
    let [left, right] = [1, 2].map(|i| format!("tree.opening[{i}].resistance_Pa_s_m3"));
    let proximal = [1, 2].map(|i| format!("tree.opening[{i}].proximal_resistance_Pa_s_m3=2"));
    let all = [format!("{left}=20"), format!("{right}=30")];
    let all: Vec<&str> = all.iter().chain(&proximal).map(String::as_str).collect();
    for (set, parts) in [
        (
            &["tree.unit=cm"][..],
            &[
                "the largest radius of the centre-lines is 35 mm, not 0.2 to 25 mm as usual: look at tree.unit (--set)",
            ][..],
        ),
        (
            &all,
            &[
                "all resistances together times the mean flow, is 6.193e-7 mmHg",
                "look at tree.opening[1].resistance_Pa_s_m3 (--set); 20 mmHg s/ml is 2.666e9 Pa s/m³",
            ],
        ),
        (
            &all[..1],
            &["the proximal share of the resistance is 1.5e7", &left],
        ),
        (
            &["wall.material[0].mu_Pa=200"],
            &[
                "the shear modulus of walls and grafts",
                "200 kPa is 200000 Pa",
            ],
        ),
    ] {
        let told = said(&carotid, set).join("\n");
        assert!(
            parts.iter().all(|part| told.contains(part)),
            "{set:?}: {told}"
        );
    }
}

/// A thick tube held along its axis, in linear elasticity (Lamé): `1/c² = 2 ρ (1 + ν)/E ((1 - 2 ν) a² + b²)/(b² - a²)`,
/// 5.008 m/s for inner and outer radii of 10 and 11 mm, 500 kPa and 0.3.
#[test]
fn the_speed_of_waves_is_found_without_pressure() {
    let output = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["check", "openfoam-case/womersley-thick"])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    let line = said
        .lines()
        .find(|line| line.starts_with("waves   in the tube"));
    let line = line.unwrap_or_else(|| panic!("{said}"));
    let speed = line
        .split(": ")
        .nth(1)
        .and_then(|text| text.split(' ').next());
    let speed: f64 = speed.unwrap().parse().unwrap_or_else(|_| panic!("{line}"));
    assert!((speed / 5.008 - 1.0).abs() < 5e-3, "{line}");
}
