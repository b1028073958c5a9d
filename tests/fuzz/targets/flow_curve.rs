//! The CSV file of the inflow: what is accepted gives finite flows at all times.
#![no_main]

use fsi_driver::case::{FlowCurve, Inflow};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &[u8]| {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let file = folder.path().join("flow.csv");
    std::fs::write(&file, text).unwrap();
    let inflow = Inflow {
        base: 0.0,
        amplitude: 0.0,
        systole: 0.5,
        exponent: 1.0,
        file: Some(file),
        unit: None,
        file_period: None,
        mean: None,
    };
    match FlowCurve::new(&inflow, 1.0) {
        Ok(curve) => {
            for t in [0.0, 0.123, 0.999_999, 1.0, 7.5] {
                assert!(curve.flow(t).is_finite(), "flow at {t} s");
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
