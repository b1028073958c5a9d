//! Whether a random lumen can be one, whatever the vessel.

use super::Report;
use crate::RandomLumen;

pub(super) fn check(keys: &RandomLumen, report: &mut Report<'_>) {
    const KEYS: [&str; 3] = [
        "random_lumen.to_m",
        "random_lumen.from_m",
        "random_lumen.fade_m",
    ];
    let length = keys.to - keys.from;
    report(
        &KEYS[..2],
        length <= 0.0,
        format!("it must be above random_lumen.from_m = {:?}", keys.from),
    );
    if length <= 0.0 {
        return;
    }
    report(
        &[KEYS[2], KEYS[0], KEYS[1]],
        keys.fade() > 0.5 * length,
        format!(
            "both ends fade, so it is at most half of the part, {:?} m",
            0.5 * length
        ),
    );
    let (given, modes) = (keys.amplitudes.len(), keys.modes);
    report(
        &["random_lumen.amplitudes", "random_lumen.modes"],
        given > modes,
        format!(
            "{given} amplitudes for random_lumen.modes = {modes}: leave the last ones out, or keep more modes"
        ),
    );
    if keys.fade() > 0.5 * length {
        return;
    }
    match keys.field() {
        None => report(
            &["random_lumen.length_along_m", KEYS[0], KEYS[1]],
            true,
            format!(
                "the part is {:.0} times as long, and at most about 50 times can be resolved: take a longer correlation \
                 length, or a shorter part",
                length / keys.along
            ),
        ),
        Some(field) => report(
            &["random_lumen.modes"],
            field.all() < modes,
            format!(
                "the field has only {} modes that can be told from rounding errors: keep at most so many",
                field.all()
            ),
        ),
    }
}
