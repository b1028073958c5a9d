//! A soft tube inflated over ten seconds: see openfoam-case/slow-inflation/README.md.

use crate::benchmark_support::{probes, run};
use std::path::Path;

/// Radial displacement of the wall at mid-length at the end, m.
fn end(tolerance: &str) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let tolerance = format!("coupling.e_rel={tolerance}");
    let settings = ["--set", "time.end_s=11", &tolerance];
    run("slow-inflation", &out, &settings);
    probes(&out)[0].last().unwrap()[2]
}

/// The wall does not drift: it ends at the same place within the tolerance, which is that of statics within 1e-3.
#[test]
fn a_slow_inflation_ends_where_the_tolerance_does_not_matter() {
    let [loose, tight] = ["1e-5", "1e-7"].map(end);
    println!("{loose}, {tight}");
    assert!((tight / 1.304363e-3 - 1.0).abs() < 1e-6, "{tight}");
    assert!((loose / tight - 1.0).abs() < 1e-6, "{loose} {tight}");
}

/// Where the kept runs end stands on the page.
#[test]
fn the_page_has_the_ends_of_the_kept_runs() {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/slow-inflation");
    let end = |kept: &str| probes(&case.join("kept").join(kept))[0].last().unwrap()[2];
    let tight = end("tolerance-1e-7");
    let mut table = String::new();
    for (tolerance, kept) in [
        ("1e-5", "tolerance-1e-5"),
        ("1e-5, `coupling.criterion=residual`", "by-residual"),
    ] {
        let (end, change) = (1e3 * end(kept), end(kept) / tight - 1.0);
        table += &format!("| {tolerance} | {end:.9} | {change:.1e} |\n");
    }
    table += &format!("| 1e-7 | {:.9} | |\n", 1e3 * tight);
    let page = std::fs::read_to_string(case.join("README.md")).unwrap();
    assert!(page.contains(&table), "the page should have\n{table}");
}
