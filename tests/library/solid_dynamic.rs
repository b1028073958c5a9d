//! `fsi-driver solid` with a pressure over time.

use crate::solid_support::{TubeCase, example, number, radial, with};

const SMALL: [(&str, &str); 3] = [
    ("p = 6 ", "p = 4 "),
    ("p_geometry = 6", "p_geometry = 4"),
    ("quadrature_points = 8", "quadrature_points = 6"),
];

#[test]
fn a_slowly_loaded_tube_ends_in_static_equilibrium() {
    let text = with(&example(), &SMALL);
    let at_rest = TubeCase::new(&text).solve();
    let dynamics = "[dynamics]\ndensity_kg_m3 = 1100.0\ndamping_1_s = 200.0\nstep_s = 0.02\nend_s = 2.0\n\
                    times_s = [0.0, 1.0]\nload_factors = [0.0, 1.0]\n";
    let tube = TubeCase::new(&format!("{text}{dynamics}"));
    let moved = tube.solve();
    for (a, b) in radial(&moved).iter().zip(radial(&at_rest)) {
        assert!((a / b - 1.0).abs() < 1e-4, "{a} instead of {b}");
    }
    let energy = number(&moved, "strain_energy_J") / number(&at_rest, "strain_energy_J");
    assert!((energy - 1.0).abs() < 1e-3);
    let mut history = csv::Reader::from_path(tube.results().join("history.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = history.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 100);
    let column = |row: usize, k: usize| rows[row][k].parse::<f64>().unwrap();
    assert!((column(24, 0) - 0.5).abs() < 1e-12 && (column(24, 1) - 8e3).abs() < 1e-6);
    assert!((column(99, 1) - 1.6e4).abs() < 1e-6);
}
