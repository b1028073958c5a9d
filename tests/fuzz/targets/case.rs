//! `case.toml`: whatever it holds, it is read, or refused in words.
#![no_main]

use fsi_driver::case::{Case, FlowCurve, Preset};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &[u8]| {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    std::fs::write(folder.path().join("case.toml"), text).unwrap();
    match Case::load(folder.path(), Preset::Demo, &[]) {
        Ok(resolved) => {
            let case = &resolved.case;
            if let Some(vessel) = case.vessel()
                && let Ok(curve) = FlowCurve::new(&vessel.inflow, case.time.period)
            {
                assert!(curve.flow(0.1).is_finite());
            }
        }
        Err(errors) => assert!(!errors.to_string().is_empty()),
    }
});
