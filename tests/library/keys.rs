//! What the program says of its keys: `fsi-driver keys`, the JSON schema, completions and manual.

use fsi_driver::analysis::solid_file::SolidFile;
use fsi_driver::case::schema::ValueKind;
use fsi_driver::case::{Case, CaseError, Preset, defaults};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn driver(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .args(arguments)
        .output()
        .unwrap()
}

fn said(arguments: &[&str]) -> String {
    let output = driver(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_key_is_listed_in_80_columns() {
    for (option, schema) in [
        (None, Case::schema()),
        (Some("--solid"), SolidFile::schema()),
    ] {
        let text = said(&["keys"].into_iter().chain(option).collect::<Vec<_>>());
        let listed: Vec<_> = (text.lines())
            .filter(|line| !line.starts_with(' '))
            .map(|line| line.split(' ').next().unwrap())
            .collect();
        let keys: Vec<_> = schema.keys().iter().map(|key| key.path.as_str()).collect();
        assert_eq!(listed, keys);
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
    }
}

#[test]
fn a_key_is_found_by_its_name_its_meaning_and_its_words() {
    assert_eq!(
        said(&["keys", "dynamic viscosity"]),
        "blood.viscosity_Pa_s = 0.0035                                          [assumed]\n    \
         dynamic viscosity of the blood: a number above 0.0, at most 1000.0 Pa s;\n    \
         read only in other cases than an OpenFOAM case of your own\n"
    );
    let acceleration = said(&["keys", "iqn_ls"]);
    assert!(acceleration.starts_with("coupling.acceleration = \"iqn_ls\""));
    assert!(acceleration.contains("      aitken        Aitken's dynamic relaxation.\n"));
    assert!(said(&["keys", "Poisson"]).contains("saint_venant_kirchhoff"));
    let unknown = driver(&["keys", "viscosty"]);
    assert_eq!(unknown.status.code(), Some(2));
    let error = String::from_utf8(unknown.stderr).unwrap();
    assert!(error.contains("no key has `viscosty`"), "{error}");
    assert!(error.contains("did you mean `viscosity`?"), "{error}");
}

/// The numbers of a case with a unit in their name; the others have none.
#[test]
fn units_are_those_of_the_names() {
    let without: Vec<_> = (Case::schema().keys().iter())
        .filter(|key| matches!(key.kind, ValueKind::Real(_)) && key.unit().is_none())
        .map(|key| key.name())
        .collect();
    for name in &without {
        let tail = name.rsplit('_').next().unwrap();
        assert!(!["m", "s", "Pa", "deg", "min"].contains(&tail), "{name}");
    }
    assert!(without.contains(&"exponent") && without.contains(&"wall_grading"));
    let unit = |path: &str| Case::schema().find(path).unwrap().unit();
    assert_eq!(unit("windkessel.resistance_Pa_s_m3"), Some("Pa s/m³"));
    assert_eq!(unit("blood.viscosity_Pa_s"), Some("Pa s"));
    assert_eq!(unit("flag.mean_velocity_m_s"), Some("m/s"));
    assert_eq!(unit("model.d_max_m"), Some("m"));
}

/// What the JSON schema says of a document, by the parts of draft 7 that it uses; `at` is the schema of the document.
fn allows(root: &Value, at: &Value, document: &Value) -> bool {
    if let Some(reference) = at.get("$ref").and_then(Value::as_str) {
        return allows(
            root,
            root.pointer(reference.trim_start_matches('#')).unwrap(),
            document,
        );
    }
    at.as_object()
        .unwrap()
        .iter()
        .all(|(word, rule)| match word.as_str() {
            "type" => match rule.as_str().unwrap() {
                "object" => document.is_object(),
                "array" => document.is_array(),
                "string" => document.is_string(),
                "boolean" => document.is_boolean(),
                "number" => document.is_number(),
                "integer" => document.is_i64() || document.is_u64(),
                other => panic!("type {other}"),
            },
            "enum" => rule.as_array().unwrap().contains(document),
            "const" => rule == document,
            "minimum" => document
                .as_f64()
                .is_none_or(|x| x >= rule.as_f64().unwrap()),
            "exclusiveMinimum" => document.as_f64().is_none_or(|x| x > rule.as_f64().unwrap()),
            "maximum" => document
                .as_f64()
                .is_none_or(|x| x <= rule.as_f64().unwrap()),
            "minLength" => document.as_str().is_none_or(|text| !text.is_empty()),
            "maxLength" => document
                .as_str()
                .is_none_or(|text| text.chars().count() as u64 <= rule.as_u64().unwrap()),
            "minItems" => document
                .as_array()
                .is_none_or(|a| a.len() as u64 >= rule.as_u64().unwrap()),
            "maxItems" => document
                .as_array()
                .is_none_or(|a| a.len() as u64 <= rule.as_u64().unwrap()),
            "items" => document
                .as_array()
                .is_none_or(|a| a.iter().all(|x| allows(root, rule, x))),
            "properties" => document.as_object().is_none_or(|table| {
                table.iter().all(|(name, value)| {
                    rule.get(name)
                        .is_none_or(|known| allows(root, known, value))
                })
            }),
            "additionalProperties" => document.as_object().is_none_or(|table| {
                table
                    .keys()
                    .all(|name| at["properties"].get(name).is_some())
            }),
            "propertyNames" => document.as_object().is_none_or(|table| {
                table
                    .keys()
                    .all(|name| allows(root, rule, &Value::from(name.as_str())))
            }),
            "required" => document.as_object().is_none_or(|table| {
                let names = rule.as_array().unwrap().iter();
                names
                    .map(|name| name.as_str().unwrap())
                    .all(|name| table.contains_key(name))
            }),
            "allOf" => rule
                .as_array()
                .unwrap()
                .iter()
                .all(|rule| allows(root, rule, document)),
            "anyOf" => rule
                .as_array()
                .unwrap()
                .iter()
                .any(|rule| allows(root, rule, document)),
            "if" => !allows(root, rule, document) || allows(root, &at["then"], document),
            "then" | "$schema" | "title" | "description" | "default" | "x-taplo" => true,
            other => panic!("the test does not know the word {other}"),
        })
}

fn json(text: &str) -> Value {
    serde_json::to_value(toml::from_str::<toml::Table>(text).unwrap()).unwrap()
}

/// Every case of the project, and what is refused of a case key by key, is so by the schema, too. A real validator says
/// the same of the same documents where Python has one.
#[test]
fn the_json_schema_says_what_check_says() {
    let schema: Value = serde_json::from_str(&said(&["keys", "--json-schema"])).unwrap();
    let mut documents = Vec::new();
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case");
    for folder in std::fs::read_dir(&project).unwrap() {
        let file = folder.unwrap().path().join("case.toml");
        if let Ok(text) = std::fs::read_to_string(file) {
            documents.push((json(&text), true));
        }
    }
    assert!(documents.len() > 16);
    documents.push((json(defaults::TEXT), true));

    let values = [
        "-1",
        "0",
        "0.0",
        "1",
        "2.5",
        "-0.001",
        "1e30",
        "true",
        "\"\"",
        "\"files\"",
        "\"newmark\"",
        "\"linear\"",
        "\"neo_hooke\"",
        "[[0.0, 1.0]]",
        "[[0.0, 1.0, 2.0]]",
        "{ core = 4 }",
    ];
    let folder = tempfile::tempdir().unwrap();
    for key in Case::schema().keys() {
        // Tables that must be complete, and materials that must fit, are beyond one key.
        if !key.choices.is_empty() || key.path.starts_with("flag") {
            continue;
        }
        for value in values {
            // Alone, without defaults: what else is missing does not matter here.
            let text = match key.path.split_once("[].") {
                Some((list, name)) => format!("[[{list}]]\n{name} = {value}\n"),
                None => format!("{} = {value}\n", key.path),
            };
            std::fs::write(folder.path().join("case.toml"), &text).unwrap();
            let errors = Case::load(folder.path(), Preset::Paper, &[]).err();
            let of_one_key = |error: &CaseError| {
                matches!(
                    error,
                    CaseError::Value { .. } | CaseError::UnknownKey { .. }
                )
            };
            let refused = errors.is_some_and(|errors| errors.0.iter().any(of_one_key));
            documents.push((json(&text), !refused));
        }
    }
    for (text, good) in [
        (
            "[wall.graft]\nmaterial = \"neo_hooke\"\nmu_Pa = 1e5\n",
            true,
        ),
        ("[wall.graft]\nmaterial = \"neo_hooke\"\nk2 = 1.0\n", false),
        ("[wall.graft]\nk2 = 1.0\n", true), // the material may stand in another file
        ("[preset.demo]\nstructure.p = 3\n", true),
        ("[preset.demo]\nstructure.p = 99\n", false),
        ("[preset.quick]\nstructure.p = 3\n", false),
        ("[structure]\nq = 3\n", false),
        ("extends = 3\n", false),
    ] {
        documents.push((json(text), good));
    }
    for (document, good) in &documents {
        assert_eq!(allows(&schema, &schema, document), *good, "{document}");
    }
    agree_with_python(&schema, &documents);

    let solid: Value = serde_json::from_str(&said(&["keys", "--solid", "--json-schema"])).unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/solid.toml");
    let mut documents = vec![(json(&std::fs::read_to_string(example).unwrap()), true)];
    let mut bad = documents[0].0.clone();
    bad["tube"]["layer"][1]
        .as_object_mut()
        .unwrap()
        .remove("k2");
    documents.push((bad, false));
    for (document, good) in &documents {
        assert_eq!(allows(&solid, &solid, document), *good, "{document}");
    }
    agree_with_python(&solid, &documents);
}

/// Asks Python's `jsonschema`, if it is installed.
fn agree_with_python(schema: &Value, documents: &[(Value, bool)]) {
    const SCRIPT: &str = "import json, sys\nfrom jsonschema import Draft7Validator as V\n\
        schema, documents = json.load(open(sys.argv[1]))\nV.check_schema(schema)\nv = V(schema)\n\
        print(json.dumps([v.is_valid(d) for d in documents]))";
    let there = Command::new("python3")
        .args(["-c", "import jsonschema"])
        .output();
    if !there.is_ok_and(|output| output.status.success()) {
        eprintln!("python3 has no jsonschema here: the schema was read by this test alone");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("input.json");
    let only: Vec<_> = documents.iter().map(|(document, _)| document).collect();
    std::fs::write(&file, serde_json::to_vec(&(schema, &only)).unwrap()).unwrap();
    let output = Command::new("python3")
        .args(["-c", SCRIPT])
        .arg(&file)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    let verdicts: Vec<bool> = serde_json::from_slice(&output.stdout).expect(&error);
    assert_eq!(verdicts.len(), documents.len());
    for ((document, good), verdict) in documents.iter().zip(verdicts) {
        // To JSON 1.0 is a whole number, to TOML it is not.
        let whole = document.to_string().contains("0.0") && !good;
        assert!(verdict == *good || whole, "{document}: {verdict}");
    }
}

#[test]
fn completions_and_manual_know_every_command() {
    let folder = tempfile::tempdir().unwrap();
    said(&["man", folder.path().to_str().unwrap()]);
    for command in ["check", "study", "keys", "solid", "completions"] {
        for shell in ["bash", "zsh", "fish"] {
            assert!(said(&["completions", shell]).contains(command), "{shell}");
        }
        let page = folder.path().join(format!("fsi-driver-{command}.1"));
        assert!(std::fs::read_to_string(page).unwrap().contains(".TH"));
    }
    assert!(said(&["man"]).contains("pimpleFoam") || said(&["man"]).contains("OpenFOAM"));
}
