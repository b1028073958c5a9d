use super::*;
use crate::case::{FlowCurve, Inflow, Start, Windkessel};

fn files<'a>(inflow: &'a FlowCurve, time: &'a Time, templates: &'a Path) -> CaseFiles<'a> {
    CaseFiles {
        walls: vec!["wallFsi"],
        templates,
        blood: const { &Blood::newtonian(1050.0, 3.5e-3) },
        openings: Openings::Vessel(openings(inflow)),
        ramp: &Ramp { duration: 0.0 },
        time,
        convection: ConvectionScheme::Lust,
        ranks: 2,
        non_orthogonality_deg: 20.0,
        diffusion_number: 0.2,
        blend: None,
    }
}

fn openings(inflow: &FlowCurve) -> VesselOpenings {
    let windkessel = Windkessel {
        resistance: 2.85e9,
        compliance: 1.2e-10,
        initial_pressure: 1.1e4,
        proximal: None,
    };
    VesselOpenings::flow_and_windkessel(inflow.clone(), &windkessel, Start::Ramp)
}

fn curve(inflow: &FlowCurve) -> String {
    let mut files = openings(inflow).files(TIME.step);
    files.remove(0).1
}

fn pulse() -> Inflow {
    Inflow::pulse(3.5e-6, 4.5e-6, 0.5, 0.8)
}

fn inflow() -> FlowCurve {
    FlowCurve::new(&pulse(), 1.0).unwrap()
}

const TIME: Time = Time {
    step: 0.002,
    end: 3.0,
    period: 1.0,
    max_halvings: 0,
    until_periodic: None,
    scheme: FluidTimeScheme::ImplicitEuler,
};

fn rows(text: &str) -> Vec<[f64; 2]> {
    let number = |word: &str| word.parse().unwrap();
    let list = text
        .strip_prefix("(\n")
        .and_then(|text| text.strip_suffix(")\n"));
    list.expect("a list that ends")
        .lines()
        .map(|line| {
            let row = line.strip_prefix('(').and_then(|row| row.strip_suffix(')'));
            let (t, q) = row.and_then(|row| row.split_once(' ')).unwrap();
            [number(t), number(q)]
        })
        .collect()
}

#[test]
fn the_pressure_of_a_fine_mesh_is_corrected_consistently() {
    let (inflow, templates) = (inflow(), Path::new("nowhere"));
    let of = |diffusion_number| {
        let files = CaseFiles {
            diffusion_number,
            ..files(&inflow, &TIME, templates)
        };
        files.parameters()
    };
    assert!(of(0.18).contains("consistentPressure      no; // diffusion number 0.18"));
    assert!(of(1.58).contains("consistentPressure      yes; // diffusion number 1.58"));
}

#[test]
fn the_scheme_of_convection_is_that_of_the_case() {
    let (inflow, templates) = (inflow(), Path::new("nowhere"));
    let of = |convection| {
        let files = CaseFiles {
            convection,
            ..files(&inflow, &TIME, templates)
        };
        files.parameters()
    };
    for (scheme, line) in [
        (ConvectionScheme::LinearUpwind, "linearUpwind grad(U);"),
        (ConvectionScheme::Lust, "LUST grad(U);"),
        (ConvectionScheme::Linear, "linear;"),
    ] {
        let text = of(scheme);
        assert!(
            text.contains(&format!("convectionScheme        {line}")),
            "{text}"
        );
    }
}

#[test]
fn the_curve_between_its_points_is_the_formula() {
    let inflow = inflow();
    let rows = rows(&curve(&inflow));
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
fn a_curve_of_the_users_is_sampled_finely_over_the_whole_period() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flow.csv");
    // A comment, a part of the period, another period than 1 s.
    fs::write(
        &path,
        "# measured\ntime_s,flow_m3_s\n0.1,1e-6\n0.2,5e-6\n0.5,2e-6\n0.6,-1e-6\n",
    )
    .unwrap();
    let inflow = Inflow {
        file: Some(path),
        ..pulse()
    };
    let flow = FlowCurve::new(&inflow, 0.8).unwrap();
    let rows = rows(&curve(&flow));
    assert_eq!(rows.len(), 400 * 32 + 1);
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    assert_eq!((first[0], last[0]), (0.0, 0.8));
    assert_eq!(first[1], last[1]);
    // Straight lines between 40 µs apart samples miss the cubic by its curvature only.
    for pair in rows.windows(2) {
        let middle = 0.5 * (pair[0][0] + pair[1][0]);
        let linear = 0.5 * (pair[0][1] + pair[1][1]);
        assert!((linear - flow.flow(middle)).abs() < 3e-12, "at {middle}");
    }
    // Every step is a sample.
    for n in [1, 57, 400] {
        let row = rows[32 * n];
        assert!((row[0] - 0.002 * n as f64).abs() < 1e-15 && row[1] == flow.flow(row[0]));
    }
    // The extrema are those of the file.
    let flows = rows.iter().map(|row| row[1]);
    assert!((flows.clone().fold(f64::MIN, f64::max) - 5e-6).abs() < 1e-11);
    assert!((flows.fold(f64::MAX, f64::min) + 1e-6).abs() < 1e-11);
}

/// Parameters that are there only where a template asks for them.
const OF_OTHER_CASES: [&str; 7] = [
    "FOAM_CASE",
    "zeroShearViscosity",
    "relaxationTime",
    "shearExponent",
    "yasudaExponent",
    "kinematicYieldStress",
    "kinematicConsistency",
];

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
                    OF_OTHER_CASES.contains(&name.as_str())
                        || defined(&parameters)
                        || defined(&connection),
                    "{name}"
                );
            }
        }
    }
}
