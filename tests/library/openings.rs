//! Tables `[[opening]]`: what they are next to `[inflow]`, `[inlet]`, `[windkessel]` and `[outlet]`, and what is
//! refused.

use fsi_driver::case::{Case, Condition, FlowCurve, Preset, ResolvedCase, VesselSide};

fn load(lines: &str) -> Result<ResolvedCase, String> {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("extends = \"defaults\"\n{lines}");
    std::fs::write(folder.path().join("case.toml"), text).unwrap();
    Case::load(folder.path(), Preset::Paper, &[]).map_err(|errors| errors.to_string())
}

fn openings(lines: &str) -> Vec<fsi_driver::case::Opening> {
    let case = load(lines).unwrap_or_else(|errors| panic!("{errors}"));
    case.vessel().unwrap().openings(case.time.period).unwrap()
}

/// Each condition of the tables, as a list: the same openings, with the names that they had.
#[test]
fn a_list_says_what_the_tables_say() {
    for (tables, list) in [
        (
            "[inflow]\nbase_m3_s = 1e-6\namplitude_m3_s = 2e-6\nsystole_s = 0.3\nexponent = 0.9\n[inlet]\nprofile = \"womersley\"",
            "[[opening]]\nend = \"start\"\ncondition = \"flow\"\nbase_m3_s = 1e-6\namplitude_m3_s = 2e-6\nsystole_s = 0.3\n\
             exponent = 0.9\nprofile = \"womersley\"",
        ),
        (
            "[inlet]\ncondition = \"pressure\"\npressure_Pa = 1e4",
            "[[opening]]\nend = \"start\"\ncondition = \"pressure\"\npressure_Pa = 1e4",
        ),
        (
            "[outlet]\ncondition = \"resistance\"\nresistance_Pa_s_m3 = 1e9\npressure_Pa = 1e3",
            "[[opening]]\nend = \"end\"\ncondition = \"resistance\"\nresistance_Pa_s_m3 = 1e9\npressure_Pa = 1e3",
        ),
        (
            "[windkessel]\nresistance_Pa_s_m3 = 1e9\ncompliance_m3_Pa = 2e-10\ninitial_pressure_Pa = 1e4\n\
             proximal_resistance_Pa_s_m3 = 1e8",
            "[[opening]]\nend = \"end\"\ncondition = \"windkessel\"\nresistance_Pa_s_m3 = 1e9\ncompliance_m3_Pa = 2e-10\n\
             initial_pressure_Pa = 1e4\nproximal_resistance_Pa_s_m3 = 1e8",
        ),
    ] {
        assert_eq!(openings(tables), openings(list), "{list}");
        assert_ne!(openings(tables), openings(""), "{list}");
    }
    let names = openings("").into_iter().map(|opening| opening.name);
    assert_eq!(names.collect::<Vec<_>>(), ["inlet", "outlet"]);
}

/// Flows are counted along the vessel: what leaves is negative for those who count what enters. Openings at starts come
/// first.
#[test]
fn a_flow_at_the_end_leaves() {
    let openings = openings(
        "[[opening]]\nend = \"end\"\nname = \"tibial\"\ncondition = \"flow\"\nbase_m3_s = 3e-6\n\
         [[opening]]\nend = \"start\"\ncondition = \"pressure\"\npressure_Pa = 1e4",
    );
    assert_eq!(openings[0].end, VesselSide::Start);
    assert_eq!(openings[1].name, "tibial");
    let flow = openings[1]
        .condition
        .flow()
        .map(|curve: &FlowCurve| curve.flow(0.2));
    assert_eq!(flow, Some(-3e-6));
    assert!(matches!(openings[0].condition, Condition::Pressure(_)));
}

#[test]
fn lists_that_make_no_sense_are_refused() {
    let pressure =
        "[inlet]\ncondition = \"pressure\"\npressure_Pa = 1e4\n[[opening]]\nend = \"end\"\n";
    for (lines, key, reason) in [
        (
            "end = \"end\"\ncondition = \"flow\"\nbase_m3_s = 1e-6",
            "opening[0].condition",
            "a flow at each end",
        ),
        (
            "end = \"end\"\ncondition = \"flow_split\"\nfraction = 0.5",
            "opening[0].condition",
            "a flow at each end",
        ),
        (
            "end = \"start\"\ncondition = \"flow_split\"\nfraction = 0.5",
            "opening[0].condition",
            "cannot be prescribed at a start",
        ),
        (
            "end = \"end\"\ncondition = \"pressure\"",
            "opening[0].condition",
            "needs the pressure",
        ),
        (
            "end = \"end\"\ncondition = \"pressure\"\npressure_Pa = 1\nname = \"wallFsi\"",
            "opening[0].name",
            "expected a name of its own",
        ),
        (
            "end = \"end\"\ncondition = \"pressure\"\npressure_Pa = 1\nname = \"inlet\"",
            "opening[0].name",
            "expected a name of its own",
        ),
        (
            "end = \"end\"\ncondition = \"pressure\"\npressure_file = \"no.csv\"",
            "opening[0].pressure_file",
            "no.csv",
        ),
        (
            "end = \"end\"\ncondition = \"resistance\"",
            "opening[0].resistance_Pa_s_m3",
            "",
        ),
        (
            "end = \"end\"\ncondition = \"windkessel\"\nfraction = 0.5",
            "opening[0].fraction",
            "",
        ),
        (
            "end = \"middle\"\ncondition = \"flow\"",
            "opening[0].end",
            "\"start\", \"end\"",
        ),
    ] {
        let said = load(&format!("[[opening]]\n{lines}")).unwrap_err();
        assert!(
            said.contains(key) && said.contains(reason),
            "{lines}: {said}"
        );
    }
    for (lines, key, reason) in [
        (
            "condition = \"flow\"",
            "opening[0].condition",
            "needs the flow",
        ),
        (
            "condition = \"flow\"\nbase_m3_s = 1e-6\nflow_unit = \"ml/s\"",
            "opening[0].flow_unit",
            "there is none",
        ),
        (
            "condition = \"flow\"\nbase_m3_s = 1e-6\nsystole_s = 2.0",
            "opening[0].systole_s",
            "must fit into time.period_s",
        ),
        (
            "condition = \"flow_split\"\nfraction = 1.0",
            "opening[0].fraction",
            "expected less than 1",
        ),
        (
            "condition = \"pressure\"\npressure_Pa = 1e4\n[[opening]]\nend = \"end\"\ncondition = \"pressure\"\npressure_Pa = 1e4",
            "opening[1].end",
            "has one already",
        ),
        (
            "condition = \"flow\"\nbase_m3_s = 1e-6\n[ends]\noutlet = \"sliding\"",
            "ends.outlet",
            "a flow leaves through an outlet at rest",
        ),
    ] {
        let said = load(&format!("{pressure}{lines}")).unwrap_err();
        assert!(
            said.contains(key) && said.contains(reason),
            "{lines}: {said}"
        );
    }
}

/// Tables in whose place the list stands do nothing, and are told.
#[test]
fn tables_next_to_the_list_are_reported() {
    let case = load(
        "[windkessel]\ncompliance_m3_Pa = 1e-10\n[[opening]]\nend = \"end\"\ncondition = \"pressure\"\npressure_Pa = 1e4",
    );
    let unread: Vec<String> = case
        .unwrap()
        .unread
        .iter()
        .map(ToString::to_string)
        .collect();
    assert!(
        unread[0].contains("windkessel.compliance_m3_Pa"),
        "{unread:?}"
    );
    assert!(
        unread[0].contains("without an [[opening]] at the end"),
        "{unread:?}"
    );
}
