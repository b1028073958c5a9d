//! Random input: the reader never panics, and a case that it accepts can be meshed.

use fsi_driver::case::{Case, FlowCurve, Inflow, Preset};
use fsi_driver::geometry::{fluid_mesh, solid_mesh};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case")
}

fn load_text(text: &[u8]) -> bool {
    let scratch = tempfile::tempdir().unwrap();
    std::fs::write(scratch.path().join("case.toml"), text).unwrap();
    match Case::load(scratch.path(), Preset::Demo, &[]) {
        Ok(_) => true,
        Err(errors) => {
            assert!(!errors.0.is_empty() && !errors.to_string().is_empty());
            false
        }
    }
}

fn set(pairs: &[(&str, String)]) -> Vec<(String, String)> {
    pairs
        .iter()
        .map(|(key, value)| (key.to_string(), value.clone()))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(!load_text(&bytes));
    }

    #[test]
    fn damaged_defaults_are_read_without_panic(
        from in 0usize..9000,
        length in 0usize..60,
        patch in "[-a-z0-9_.=\\[\\]{}\"'#\n ,]{0,12}",
    ) {
        let mut text = std::fs::read_to_string(project().join("defaults.toml")).unwrap().into_bytes();
        let from = from.min(text.len());
        let to = (from + length).min(text.len());
        text.splice(from..to, patch.into_bytes());
        load_text(&text);
    }

    #[test]
    fn any_override_is_read_without_panic(key in "[a-z_.\\[\\]\"= ]{0,20}", value in "\\PC{0,20}") {
        let _ = Case::load(&project().join("S-0.25"), Preset::Demo, &[(key, value)]);
    }

    #[test]
    fn any_flow_curve_is_read_without_panic(text in "(time_s,flow_m3_s\n)?([-0-9.e,x#\" \n]{0,80})", t in -10.0..10.0f64) {
        let scratch = tempfile::tempdir().unwrap();
        let file = scratch.path().join("flow.csv");
        std::fs::write(&file, text).unwrap();
        let inflow = Inflow::of_file(file);
        if let Ok(curve) = FlowCurve::new(&inflow, 1.0) {
            prop_assert!(curve.flow(t).is_finite());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Sizes of vessels from an arteriole to an aorta, mostly sensible and sometimes not.
    #[test]
    fn an_accepted_vessel_can_be_meshed(
        model in prop::sample::select(vec!["S-0.5", "H-0.5", "A-0.5"]),
        radius in 1e-3..12e-3f64,
        ratio in 0.5..1.5f64,
        thickness in 0.05..0.4f64,
        imperfection in 0.0..1.0f64,
        section in 4.0..12.0f64,
        blend in 0.5..2.0f64,
        extension in 4.0..20.0f64,
        helix in 0.5..4.0f64,
        angle in 10.0..270.0f64,
        core in 2usize..8,
        axial in 8usize..20,
    ) {
        let m = |x: f64| format!("{x:e}");
        let artery = radius * ratio;
        let pairs = set(&[
            ("geometry.graft_inner_radius_m", m(radius)),
            ("geometry.artery_inner_radius_m", m(artery)),
            ("geometry.graft_thickness_m", m(thickness * radius)),
            ("geometry.media_thickness_m", m(thickness * artery / 2.0)),
            ("geometry.adventitia_thickness_m", m(thickness * artery / 2.0)),
            ("geometry.graft_length_m", m(section * radius)),
            ("geometry.artery_length_m", m(section * artery)),
            ("geometry.blend_length_m", m(blend * radius)),
            ("geometry.extension_length_m", m(extension * radius)),
            ("geometry.helix_radius_m", m(helix * radius)),
            ("geometry.arc_angle_deg", m(angle)),
            ("model.d_max_m", m(imperfection * artery)),
            ("fluid.mesh.core", core.to_string()),
            ("fluid.mesh.axial_extension", (2 * axial).to_string()),
            ("fluid.mesh.axial_per_section", axial.to_string()),
            ("structure.circumferential", (2 * core).to_string()),
        ]);
        if let Ok(case) = Case::load(&project().join(model), Preset::Demo, &pairs) {
            let smallest = fluid_mesh(case.vessel().unwrap()).cell_volumes().into_iter().fold(f64::INFINITY, f64::min);
            prop_assert!(smallest > 0.0, "a fluid cell has the volume {smallest:e}");
            let mesh = solid_mesh(case.vessel().unwrap());
            for element in 0..mesh.hexes.len() {
                let at = |xi| mesh.shape.position(element, xi);
                for w in [-0.9, 0.9] {
                    let h = 1e-3;
                    let column = |axis: usize| {
                        let mut xi = [[w, -w, w]; 2];
                        xi[0][axis] -= h;
                        xi[1][axis] += h;
                        at(xi[1]) - at(xi[0])
                    };
                    let jacobian = column(0).cross(&column(1)).dot(&column(2));
                    prop_assert!(jacobian > 0.0, "element {element} is inside out");
                }
            }
        }
    }
}
