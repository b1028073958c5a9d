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

/// As long as there is a thinner one; a given thickness stays.
#[test]
fn walls_of_trees_become_thinner_step_by_step() {
    let mut text = format!("a\n{}\nb", tree::thickness_line(0.2));
    let mut shares = Vec::new();
    while let Some((thinner, share)) = tree::thinner(&text) {
        assert!(
            thinner.contains(&format!("thicknesses = [{share}] # of")),
            "{thinner}"
        );
        (text, shares) = (thinner, [&shares[..], &[share]].concat());
    }
    assert_eq!(shares, [0.15, 0.1, 0.07, 0.05]);
    assert!(tree::thinner("thicknesses_m = [7e-4] # or thicknesses").is_none());
}
