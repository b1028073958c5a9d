//! Files that `fsi-driver solid` refuses: all mistakes at once, each with line, key, what was found and what is
//! allowed, exit code 2, and nothing written.

use crate::solid_support::{TubeCase, example, with};

#[test]
fn all_mistakes_are_reported_at_once() {
    let text = with(
        &example(),
        &[
            ("inner_radius_m = 0.003", "inner_radius_m = -0.003"),
            ("k2 = 3.54", "k3 = 3.54"),
            ("circumferential = 4", "circumferential = 4.5"),
            ("kind = \"trunk\"", "kind = \"trank\""),
            ("p = 6 ", "p = [2, 3] "),
            ("p_geometry = 6", "p_geometry = \"exakt\""),
        ],
    );
    let said = TubeCase::new(&text).refused();
    for part in [
        "tube.toml:7: `tube.inner_radius_m` = -0.003: expected a number above 0.0",
        "tube.toml:16: unknown key `tube.layer[0].k3`; did you mean `tube.layer[0].k2`?",
        "`tube.layer[0].k2` is missing",
        "`mesh.circumferential` = 4.5: expected a whole number from 3 to 1000",
        "did you mean \"trunk\"?",
        "`space.p` = [2, 3]: expected a whole number from 1 to 12, or three of them",
        "did you mean \"exact\"?",
    ] {
        assert!(said.contains(part), "`{part}` is missing in\n{said}");
    }
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let changes = [
        (
            vec![("quadrature_points = 8", "quadrature_points = 4")],
            "degree 6 needs at least 6 points",
        ),
        (
            vec![("kappa_Pa = 1e9", "kappa_Pa = 1e4")],
            "expected more than 2/3 of tube.layer[0].mu_Pa",
        ),
        (
            vec![("fibre_angle_deg = 10.0", "poisson_ratio = 0.3")],
            "holzapfel_gasser_ogden has no such parameter",
        ),
        (
            vec![
                ("axial = 2", "axial = 1000"),
                ("circumferential = 4", "circumferential = 1000"),
            ],
            "take a smaller degree",
        ),
        (
            vec![("dispersion = 0.0", "dispersion = 0.4")],
            "`tube.layer[0].dispersion` = 0.4: expected a number from 0.0 to 0.3333333333333333",
        ),
        (
            vec![("# viscosity_Pa_s = 50.0", "viscosity_Pa_s = -50.0")],
            "`tube.layer[0].viscosity_Pa_s` = -50.0: expected a number from 0.0",
        ),
        (
            vec![("# axial_stretch = 1.2", "axial_stretch = 0.1")],
            "`supports.axial_stretch` = 0.1: expected a number from 0.5 to 3.0",
        ),
        (
            vec![
                ("# [outside]", "[outside]"),
                ("# spring_Pa_m = 2.0e7", "spring_Pa_m = -2.0e7"),
            ],
            "`outside.spring_Pa_m` = -20000000.0: expected a number from 0.0",
        ),
        (
            vec![
                ("# [outside]", "[outside]"),
                ("# damping_Pa_s_m", "damping_Pa_s_m"),
            ],
            "dampers resist no static displacement: add [dynamics]",
        ),
        (
            vec![
                ("# [outside]", "[outside]"),
                ("# pressure_Pa = 1.0e3", "pressure_kPa = 1.0"),
            ],
            "unknown key `outside.pressure_kPa`; did you mean `outside.pressure_Pa`?",
        ),
        (
            vec![("# [dynamics]", "[dynamics]")],
            "`dynamics.step_s` is missing",
        ),
        (
            vec![
                ("# [dynamics]", "[dynamics]"),
                ("# density", "density"),
                ("# step_s", "step_s"),
                ("# end_s", "end_s"),
                ("# times_s = [0.0, 0.2, 1.0]", "times_s = [0.0, 1.0]"),
                ("# load_factors", "load_factors"),
            ],
            "expected 2 numbers, as many as dynamics.times_s has",
        ),
    ];
    for (changes, part) in changes {
        let said = TubeCase::new(&with(&example(), &changes)).refused();
        assert!(said.contains(part), "`{part}` is missing in\n{said}");
    }
}

#[test]
fn incomplete_and_invalid_files_are_refused() {
    assert!(
        TubeCase::new("")
            .refused()
            .contains("`tube.inner_radius_m` is missing")
    );
    assert!(TubeCase::new("[tube").refused().contains("not valid TOML"));
    let extended = format!("extends = \"x.toml\"\n{}", example());
    assert!(
        TubeCase::new(&extended)
            .refused()
            .contains("unknown key `extends`")
    );
    assert!(
        TubeCase::new("[[tube.layer]]\n[[tube.layer]]")
            .refused()
            .contains("`tube.layer[1].material` is missing")
    );
    // A quoted key is no way into a list, least of all to its four-billionth table.
    let quoted = "length_m = 0.006\n\"layer[4000000000]\".k2 = 1.0\n";
    let quoted = with(&example(), &[("length_m = 0.006\n", quoted)]);
    let said = TubeCase::new(&quoted).refused();
    assert!(
        said.contains("unknown key `tube.\"layer[4000000000]\".k2`"),
        "{said}"
    );
    // Nor is it another way to write a key of a table, or to write it twice.
    for key in [
        "layer[-1].k2",
        "layer[1e30].k2",
        "layer[0].k2",
        "layer[18446744073709551616]",
        "länge[٣]",
        "inner_radius_m.",
        "",
    ] {
        let line = format!("length_m = 0.006\n{key:?} = 1.0\n");
        let said = TubeCase::new(&with(&example(), &[("length_m = 0.006\n", &line)])).refused();
        assert!(said.contains("unknown key `tube."), "{key:?}: {said}");
    }
    let dotted = format!("\"tube.inner_radius_m\" = 1.0\n{}", example());
    let said = TubeCase::new(&dotted).refused();
    assert!(
        said.contains("unknown key `\"tube.inner_radius_m\"`"),
        "{said}"
    );
    for (open, close) in [("[", "]"), ("{a=", "}")] {
        let nested = format!("a = {}1{}\n", open.repeat(10_000), close.repeat(10_000));
        TubeCase::new(&nested).refused();
    }
    let many = "[[tube.layer]]\n".repeat(50_000);
    assert!(TubeCase::new(&many).refused().contains("is missing"));
    let tube = TubeCase::new("");
    std::fs::remove_file(tube.folder.path().join("tube.toml")).unwrap();
    std::fs::create_dir(tube.folder.path().join("tube.toml")).unwrap();
    assert_eq!(tube.run(&[]).status.code(), Some(2));
}
