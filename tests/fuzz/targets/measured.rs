//! The CSV file of an experiment: what is accepted has finite numbers, and no more points than a run records where it
//! is used.
#![no_main]

use fsi_driver::case::measured::Measurements;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &[u8]| {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let file = folder.path().join("experiment.csv");
    std::fs::write(&file, text).unwrap();
    match Measurements::read(&file) {
        Ok(measured) => {
            let series = &measured.series;
            assert!(!series.is_empty() && series.iter().all(|it| !it.points.is_empty()));
            for point in series.iter().flat_map(|series| &series.points) {
                assert!(point.value.is_finite() && point.place.iter().all(|x| x.is_finite()));
            }
            let places = measured.places(true).len() + measured.places(false).len();
            assert!(places <= series.iter().map(|it| it.points.len()).sum());
        }
        Err(reason) => assert!(reason.contains("experiment.csv")),
    }
});
