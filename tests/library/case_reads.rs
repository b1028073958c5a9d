//! Keys that do nothing in a case are reported, those that a file only inherits are not.

use fsi_driver::case::{Case, Override, Preset, ResolvedCase, ValuePlace};
use std::path::{Path, PathBuf};

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case")
}

fn load(file: &Path, set: &[&str]) -> ResolvedCase {
    let set = set.iter().map(|pair| pair.split_once('=').unwrap());
    let set: Vec<_> = set.map(|(key, value)| (key.into(), value.into())).collect();
    Case::load(file, Preset::Demo, &set).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The keys that are reported, and the sentences.
fn unread(case: &ResolvedCase) -> (Vec<String>, String) {
    let keys = case.unread.iter().flat_map(|unread| &unread.keys);
    let sentences: Vec<String> = case.unread.iter().map(ToString::to_string).collect();
    (
        keys.map(|(key, _)| key.clone()).collect(),
        sentences.join("\n"),
    )
}

/// A straight vessel with one layer, and what else is said of it.
fn write(folder: &Path, more: &str) -> PathBuf {
    let file = folder.join("case.toml");
    let text = format!(
        "extends = \"defaults\"\n[vessel]\nradius_m = 3e-3\n[[vessel.piece]]\npiece = \"line\"\nlength_m = 0.03\n\
         [[vessel.section]]\nname = \"artery\"\nlayers = [\"wall\"]\nthicknesses_m = [0.9e-3]\n\
         [[vessel.material]]\nname = \"wall\"\nmaterial = \"neo_hooke\"\nmu_Pa = 1e5\nkappa_Pa = 1e8\n{more}"
    );
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_value_of_the_command_line_that_is_not_read_is_reported() {
    for (set, key, when) in [
        (
            &[
                "outlet.condition=pressure",
                "outlet.pressure_Pa=1e4",
                "windkessel.compliance_m3_Pa=1e-10",
            ][..],
            "windkessel.compliance_m3_Pa",
            "outlet.condition = \"windkessel\"",
        ),
        (
            &[
                "inlet.condition=pressure",
                "inlet.pressure_Pa=1e4",
                "inflow.base_m3_s=1e-6",
            ],
            "inflow.base_m3_s",
            "where a flow is prescribed",
        ),
        (
            &["inflow.amplitude_m3_s=0", "inflow.systole_s=0.3"],
            "inflow.systole_s",
            "inflow.amplitude_m3_s other than 0",
        ),
        (
            &["fluid.mesh.core=4", "fluid.solver=native"],
            "fluid.mesh.core",
            "another fluid.solver than \"native\"",
        ),
        (
            &["fluid.max_correctors=9", "fluid.solver=native"],
            "fluid.max_correctors",
            "than \"native\"",
        ),
        (
            &["inflow.amplitude_m3_s=0", "time.until_periodic=1e-3"],
            "time.until_periodic",
            "where what drives the blood changes with the beat",
        ),
        (
            &["fluid.ranks=2", "fluid.solver=native"],
            "fluid.ranks",
            "\"openfoam\"",
        ),
        (
            &["fluid.native.degree=5"],
            "fluid.native.degree",
            "fluid.solver = \"native\"",
        ),
        (
            &["coupling.acceleration=aitken", "coupling.reuse_steps=3"],
            "coupling.reuse_steps",
            "quasi-Newton",
        ),
        (
            &["geometry.helix_radius_m=5e-3"],
            "geometry.helix_radius_m",
            "model.extension = \"helix\"",
        ),
        (
            &["geometry.arc_angle_deg=90"],
            "geometry.arc_angle_deg",
            "model.extension = \"arc\"",
        ),
        (
            &[
                "model.d_max_m=0",
                "geometry.imperfection=[[0,0,0],[0.8,1,0.9],[0,0,0]]",
            ],
            "geometry.imperfection",
            "model.d_max_m above 0",
        ),
        (
            &["surroundings.direction=all"],
            "surroundings.direction",
            "surroundings.spring_Pa_m",
        ),
        (
            &[
                "geometry.extension_length_m=0",
                "fluid.mesh.axial_extension=0",
            ],
            "fluid.mesh.axial_extension",
            "extension_length_m above 0",
        ),
    ] {
        let (keys, sentence) = unread(&load(&project().join("S-0.25"), set));
        assert_eq!(keys, [key], "{sentence}");
        assert!(
            sentence.starts_with(&format!(
                "`{key}` (--set) does nothing here: it is read only "
            )),
            "{sentence}"
        );
        assert!(sentence.contains(when), "{sentence}");
    }
    // Those that are read.
    for set in [
        &[
            "windkessel.compliance_m3_Pa=1e-10",
            "inflow.amplitude_m3_s=1e-6",
            "fluid.mesh.core=4",
            "fluid.ranks=1",
        ][..],
        &[
            "fluid.solver=native",
            "fluid.native.degree=5",
            "coupling.reuse_steps=3",
            "structure.p=3",
            "wall.media.k2=3",
        ],
        &[
            "model.extension=helix",
            "geometry.helix_radius_m=5e-3",
            "model.d_max_m=1e-4",
            "surroundings.spring_Pa_m=1e7",
            "surroundings.direction=all",
        ],
    ] {
        assert_eq!(unread(&load(&project().join("S-0.25"), set)).1, "");
    }
}

/// What stands in the case itself and is not read is reported with its line.
#[test]
fn unread_keys_are_reported_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let curve = folder.path().join("flow.csv");
    std::fs::write(&curve, "time_s,flow_m3_s\n0,1e-6\n0.3,4e-6\n0.6,1e-6\n").unwrap();
    let file = write(
        folder.path(),
        "[[vessel.material]]\nname = \"graft\"\nmaterial = \"neo_hooke\"\nmu_Pa = 1e6\nkappa_Pa = 1e8\n\
         [inflow]\nfile = \"flow.csv\"\namplitude_m3_s = 3e-6\n",
    );
    let (mut keys, sentences) = unread(&load(&file, &[]));
    keys.sort();
    let graft =
        ["kappa_Pa", "material", "mu_Pa", "name"].map(|name| format!("vessel.material[1].{name}"));
    assert_eq!(
        keys,
        [vec!["inflow.amplitude_m3_s".to_owned()], graft.to_vec()].concat()
    );
    assert!(
        sentences.contains(&format!(
            "`inflow.amplitude_m3_s` ({}:23) does nothing here",
            file.display()
        )),
        "{sentences}"
    );
    assert!(
        sentences.contains("they are read only if a layer is of this material"),
        "{sentences}"
    );

    // A rigid wall: what elastic walls have.
    let rigid = "extends = \"defaults\"\n[vessel]\nradius_m = 3e-3\n[[vessel.piece]]\npiece = \"line\"\nlength_m = 0.03\n\
                 [[vessel.section]]\nname = \"artery\"\nwall = \"rigid\"\n[wall]\ndensity_kg_m3 = 1000.0\n[coupling]\ne_rel = 1e-6\n";
    std::fs::write(&file, rigid).unwrap();
    assert_eq!(
        unread(&load(&file, &[])).0,
        ["coupling.e_rel", "wall.density_kg_m3"]
    );
}

/// A file for both solvers one that inherits and one of record are silent.
#[test]
fn files_for_both_solvers_are_silent() {
    let folder = tempfile::tempdir().unwrap();
    let meshes = "[fluid.mesh]\ncore = 4\n[fluid.native]\ncore = 1\n";
    let file = write(folder.path(), meshes);
    assert_eq!(unread(&load(&file, &[])).1, "");
    let file = write(
        folder.path(),
        "[fluid.mesh]\ncore = 4\n[fluid]\nsolver = \"native\"\n",
    );
    assert_eq!(unread(&load(&file, &[])).0, ["fluid.mesh.core"]);
    // Chosen for this run only.
    let file = write(folder.path(), "[fluid.mesh]\ncore = 4\n");
    let native = Override {
        place: ValuePlace::Option("--fluid"),
        key: "fluid.solver".into(),
        value: "native".into(),
    };
    let case = Case::load_with(&file, Preset::Demo, &[native]).unwrap();
    assert_eq!(unread(&case).1, "");
    let other = folder.path().join("other.toml");
    std::fs::write(
        &other,
        "extends = \"case.toml\"\n[fluid]\nsolver = \"native\"\n",
    )
    .unwrap();
    assert_eq!(unread(&load(&other, &[])).1, "");
    std::fs::write(
        &other,
        load(&file, &["fluid.solver=native"]).to_toml_string(),
    )
    .unwrap();
    assert_eq!(unread(&load(&other, &[])).1, "");
}

#[test]
fn no_case_of_the_repository_has_a_key_that_does_nothing() {
    for entry in std::fs::read_dir(project()).unwrap() {
        let files = std::fs::read_dir(entry.unwrap().path());
        for file in files.into_iter().flatten().map(|file| file.unwrap().path()) {
            let is_case = file.extension().is_some_and(|end| end == "toml")
                && std::fs::read_to_string(&file)
                    .unwrap()
                    .starts_with("extends");
            if is_case {
                let (_, sentences) = unread(&load(&file, &[]));
                assert_eq!(sentences, "", "{}", file.display());
            }
        }
    }
}
