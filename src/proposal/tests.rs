use super::*;

#[test]
fn what_a_vessel_is_like_makes_a_case() {
    for (like, sections, features) in [
        (Like::Uniform, 1, 0),
        (Like::Stenosis, 1, 1),
        (Like::Aneurysm, 1, 1),
        (Like::Graft, 3, 0),
    ] {
        let input = ProposalInput {
            like,
            period: Some(0.8),
            ..ProposalInput::default()
        };
        let made = Proposal::new(&input).unwrap_or_else(|e| panic!("{like:?}: {e}"));
        assert_eq!(made.text.matches("[[vessel.section]]").count(), sections);
        assert_eq!(made.text.matches("[[vessel.feature]]").count(), features);
        assert!(made.text.contains("period_s = 0.8"));
        // 3 mm, 1.25 Hz, 3.33e-6 m²/s: 3e-3 √(7.854/3.333e-6) = 4.605.
        if like == Like::Uniform {
            assert!(
                made.remarks[1].contains("Womersley number 4.6"),
                "{:?}",
                made.remarks
            );
        }
    }
    let mistake = |input: &ProposalInput| Proposal::new(input).unwrap_err().to_string();
    let lumen = Some("x.stl".into());
    assert!(
        mistake(&ProposalInput {
            lumen,
            ..ProposalInput::default()
        })
        .contains("--lumen needs its centre-line")
    );
    let line = Some("x.csv".into());
    assert!(
        mistake(&ProposalInput {
            line,
            ..ProposalInput::default()
        })
        .contains("--from x.csv: No such file")
    );
}

/// As long as there is a thinner one; a given thickness stays. The thinner the wall is, the less compliance is left to
/// the windkessels.
#[test]
fn walls_of_trees_become_thinner_step_by_step() {
    let lines = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/examples/trees/carotid/lines.vtp"
    );
    let mut input = ProposalInput {
        line: Some(lines.into()),
        unit: Some(LengthUnit::Millimetre),
        ..ProposalInput::default()
    };
    let compliance = |proposal: &Proposal| -> f64 {
        let lines = proposal.text.lines();
        let values = lines.filter_map(|line| line.strip_prefix("compliance_m3_Pa = "));
        values.map(|value| value.parse::<f64>().unwrap()).sum()
    };
    let mut made = Proposal::new(&input).unwrap();
    let (mut shares, mut left) = (vec![0.2], vec![compliance(&made)]);
    while let Some(share) = made.make_thinner() {
        let line = format!("\nthicknesses = [{share}] # of the radius");
        assert!(made.text.contains(&line), "{}", made.text);
        shares.push(share);
        left.push(compliance(&made));
    }
    assert_eq!(shares, [0.2, 0.15, 0.1, 0.07, 0.05]);
    assert!(left.is_sorted_by(|thick, thin| thick > thin), "{left:?}");
    let soft = "the vessel itself is too soft for that";
    assert_eq!(made.text.matches(soft).count(), 2, "{left:?}");
    input.thickness = Some(7e-4);
    let mut given = Proposal::new(&input).unwrap();
    assert!(
        given.text.contains("thicknesses_m = [7e-4]"),
        "{}",
        given.text
    );
    assert!(!given.text.contains(soft), "{}", given.text);
    assert_eq!(given.make_thinner(), None);
}
