use super::*;

fn files<'a>(inflow: &'a Inflow, time: &'a Time, templates: &'a Path) -> CaseFiles<'a> {
    CaseFiles {
        templates,
        blood: &Blood {
            density: 1050.0,
            viscosity: 3.5e-3,
        },
        inflow,
        windkessel: &Windkessel {
            resistance: 2.85e9,
            compliance: 1.2e-10,
            initial_pressure: 1.1e4,
        },
        ramp: &Ramp { duration: 0.0 },
        time,
        flag: None,
        ranks: 2,
    }
}

fn inflow() -> Inflow {
    Inflow {
        base: 3.5e-6,
        amplitude: 4.5e-6,
        systole: 0.5,
        exponent: 0.8,
        file: None,
    }
}

const TIME: Time = Time {
    step: 0.002,
    end: 3.0,
    period: 1.0,
    max_halvings: 0,
};

fn rows(text: &str) -> Vec<[f64; 2]> {
    let number = |word: &str| word.parse().unwrap();
    text.lines()
        .skip(1)
        .map(|line| {
            line.split_once(',')
                .map(|(t, q)| [number(t), number(q)])
                .unwrap()
        })
        .collect()
}

#[test]
fn the_curve_between_its_points_is_the_formula() {
    let (inflow, templates) = (inflow(), PathBuf::new());
    let rows = rows(&files(&inflow, &TIME, &templates).curve().unwrap());
    assert_eq!(rows[32], [0.002, inflow.flow(0.002)]);
    for pair in rows.windows(2) {
        let middle = 0.5 * (pair[0][0] + pair[1][0]);
        let linear = 0.5 * (pair[0][1] + pair[1][1]);
        assert!(
            (linear / inflow.flow(middle) - 1.0).abs() < 2e-6,
            "at {middle}: {linear} {}",
            inflow.flow(middle)
        );
    }
    let last = rows.last().unwrap();
    assert_eq!(last, &[1.0, 3.5e-6]);
}

#[test]
fn a_curve_of_the_users_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flow.csv");
    let templates = PathBuf::new();
    let inflow = Inflow {
        file: Some(path.clone()),
        ..inflow()
    };
    let curve = |text: &str| {
        fs::write(&path, text).unwrap();
        files(&inflow, &TIME, &templates)
            .curve()
            .map_err(|error| error.to_string())
    };
    assert_eq!(
        rows(&curve("time_s, flow_m3_s\n0, 1e-6\n0.5, 2e-6\n1, 1e-6\n").unwrap())[1],
        [0.5, 2e-6]
    );
    for (text, reason) in [
        ("t,q\n0,1\n1,1\n", "the first line must be time_s,flow_m3_s"),
        ("time_s,flow_m3_s\n", "has no rows"),
        (
            "time_s,flow_m3_s\n0,1\n0.5,nan\n1,1\n",
            "line 3: not a finite number",
        ),
        (
            "time_s,flow_m3_s\n0,1\n0.5,1\n0.4,1\n1,1\n",
            "line 4: times must increase",
        ),
        (
            "time_s,flow_m3_s\n0,1\n0.9,1\n",
            "must cover one period, 0 to 1 s (time.period_s); found 0 to 0.9 s",
        ),
        ("time_s,flow_m3_s\n0,x\n", "line: 2"),
    ] {
        let error = curve(text).unwrap_err();
        assert!(
            error.contains(reason) && error.contains("flow.csv"),
            "{error}"
        );
    }
}

#[test]
fn the_templates_need_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let templates = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/base");
    files(&inflow(), &TIME, &templates)
        .write(folder.path())
        .unwrap();
    let parameters = fs::read_to_string(folder.path().join("system/fsiParameters")).unwrap();
    assert!(
        parameters.contains("density                 1.05e3; // kg/m3"),
        "{parameters}"
    );
    // every variable that a template uses is defined by one of the two generated files
    let connection = fs::read_to_string(folder.path().join("system/fsiConnection")).unwrap();
    for part in ["0", "constant", "system"] {
        for entry in fs::read_dir(templates.join(part)).unwrap() {
            let text = fs::read_to_string(entry.unwrap().path()).unwrap();
            for used in text.split('$').skip(1) {
                let name: String = used
                    .trim_start_matches(':')
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .collect();
                let defined = |text: &str| {
                    text.lines()
                        .any(|line| line.split_whitespace().next() == Some(&name))
                };
                assert!(
                    name == "FOAM_CASE" || defined(&parameters) || defined(&connection),
                    "{name}"
                );
            }
        }
    }
}
