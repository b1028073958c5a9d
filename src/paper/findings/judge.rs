//! One function a finding: what the study found, and whether the paper found the same.

use super::{ALIKE, EXPONENTIAL, LINEAR, RESOLVED, Verdict};
use crate::analysis::{ARTERY, MID_ARTERY};
use crate::case::Extension;
use crate::hemodynamics::periodicity::PeriodDifference;
use crate::hemodynamics::summary::RegionSummary;
use crate::output::report::maps;
use crate::output::report::page::significant;
use crate::output::results::Results;
use crate::output::tables::{HistoryRow, whole_steps};
use crate::paper::models::{EXTENSIONS, letter, vessel};
use crate::paper::runs::{PaperStudy, influence};

/// What the study found; `None` if models are missing.
pub type Judged = Option<(String, Verdict)>;

/// The value of a region for each `d_max` (mm) of an extension.
pub fn series(
    study: &PaperStudy,
    extension: Extension,
    region: &str,
    value: impl Fn(&RegionSummary) -> f64,
) -> Vec<(f64, f64)> {
    let models = study.of(extension).into_iter();
    let point = |run: &Results| {
        let region = run.hemodynamics.region(region)?;
        Some((1e3 * vessel(run).model.d_max, value(region)))
    };
    models.filter_map(point).collect()
}

/// The extension that the paper shows, or one that is there with at least three models.
fn shown(study: &PaperStudy) -> Option<Extension> {
    let all = [Extension::Helix, Extension::Straight, Extension::Arc];
    all.into_iter()
        .find(|extension| study.of(*extension).len() >= 3)
}

/// Slope and coefficient of determination of the straight line that fits best.
fn fit(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let (xx, xy, yy) = (
        mean(&|p| (p.0 - x).powi(2)),
        mean(&|p| (p.0 - x) * (p.1 - y)),
        mean(&|p| (p.1 - y).powi(2)),
    );
    (xy / xx, if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 })
}

/// Largest minus least value, relative to the largest magnitude.
fn spread(points: &[(f64, f64)]) -> f64 {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = points
        .iter()
        .fold(ends, |(low, high), p| (low.min(p.1), high.max(p.1)));
    (high - low) / high.abs().max(low.abs())
}

fn list(points: &[(f64, f64)], digits: usize) -> String {
    let shown = points
        .iter()
        .map(|(d, value)| format!("{value:.digits$} at {d} mm"));
    shown.collect::<Vec<_>>().join(", ")
}

/// Parts of a period in which differences between periods are followed from beat to beat.
const PHASES: usize = 8;

/// How the difference between successive periods falls from period to period.
#[derive(Debug, Clone, Copy)]
struct Decay {
    /// What is left of it after a period.
    left: f64,
    /// Coefficient of determination of the logarithm over time, each phase of the beat with a constant of its own.
    r2: f64,
}

/// The decay of values (s, any unit) of a run whose smooth start ends at `ramp` (s); `None` if no phase of the beat has
/// two differences after it that are larger than `floor`.
fn decay(values: &[(f64, f64)], step: f64, period: f64, ramp: f64, floor: f64) -> Option<Decay> {
    let beat = (period / step).round() as usize;
    let part = period / PHASES as f64;
    // The largest difference in each part of each period, by the number of the part from t = 0.
    let mut largest: std::collections::BTreeMap<usize, f64> = Default::default();
    for (before, now) in values.iter().zip(values.iter().skip(beat)) {
        let number = ((now.0 - 0.5 * step) / part).floor();
        // Neither of the two beats may be in the smooth start.
        if number * part - period > ramp - 0.5 * step {
            let most = largest.entry(number as usize).or_default();
            *most = most.max((now.1 - before.1).abs());
        }
    }
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for phase in 0..PHASES {
        let numbers = largest
            .iter()
            .filter(|(n, most)| **n % PHASES == phase && **most > floor);
        let points = numbers.map(|(n, most)| ((n / PHASES) as f64, most.ln()));
        let points: Vec<(f64, f64)> = points.collect();
        let n = points.len() as f64;
        let middle = points
            .iter()
            .fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
        for (x, y) in points.iter().map(|p| (p.0 - middle.0, p.1 - middle.1)) {
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        }
    }
    (xx > 0.0).then(|| Decay {
        left: (xy / xx).exp(),
        r2: if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 },
    })
}

/// Error of an accepted displacement in tolerances of the coupling, as measured with the defaults (docs/coupling.md:
/// 1.9e-5 of the largest displacement for 1e-5).
const IN_TOLERANCES: f64 = 2.0;

/// Successive periods.
pub fn periodicity(study: &PaperStudy) -> Judged {
    let mut last: Option<f64> = None;
    let mut decays = Vec::new();
    for run in study.runs() {
        let (time, found) = (&run.case.time, &run.hemodynamics.periodicity);
        let rows = whole_steps(&run.history, time.step);
        // Of two beats, each with its own error.
        let tolerance = 2.0 * run.case.coupling.e_rel;
        let largest = |value: fn(&HistoryRow) -> f64| {
            rows.iter().map(|row| value(row).abs()).fold(0.0, f64::max)
        };
        // What the coupling leaves of the displacement is a volume, and a flow within a step (docs/coupling.md).
        let floor_of_flow = tolerance * largest(|r| r.lumen_volume_m3) / time.step;
        let floor_of_displacement = tolerance * IN_TOLERANCES * largest(|r| r.max_displacement_m);
        type Column<'a> = (&'a [PeriodDifference], fn(&HistoryRow) -> f64, f64);
        let columns: [Column; 2] = [
            (&found.outflow, |r| r.Q_out_m3_s, floor_of_flow),
            (
                &found.max_displacement,
                |r| r.max_displacement_m,
                floor_of_displacement,
            ),
        ];
        for (differences, value, floor) in columns {
            let values: Vec<(f64, f64)> = rows.iter().map(|row| (row.time_s, value(row))).collect();
            let ramp = run.case.ramp.duration;
            decays.extend(decay(&values, time.step, time.period, ramp, floor));
            if let Some(difference) = differences.last() {
                last = Some(last.map_or(difference.relative, |l| l.max(difference.relative)));
            }
        }
    }
    let last = last?;
    let ends = |value: fn(&Decay) -> f64| {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        decays
            .iter()
            .map(value)
            .fold(ends, |(a, b), v| (a.min(v), b.max(v)))
    };
    let small = format!(
        "last period against the one before: at most {} % of the largest value",
        significant(100.0 * last, 2)
    );
    if decays.is_empty() {
        let text = format!(
            "{small}; too few periods after the smooth start with differences above the coupling's tolerance to see how it decays"
        );
        return Some((text, Verdict::Unresolved));
    }
    let ((least, most), (r2, _)) = (ends(|d| d.left), ends(|d| d.r2));
    let text = format!(
        "{small}; over a period {} to {} of what is above the coupling's tolerance is left, exponential with R² ≥ {}",
        significant(least, 2),
        significant(most, 2),
        significant(r2, 3)
    );
    Some((
        text,
        Verdict::of(last <= 0.02 && most < 1.0 && r2 >= EXPONENTIAL),
    ))
}

/// Flows and the rate of change of the volume.
pub fn balance(study: &PaperStudy) -> Judged {
    let run = study.example()?;
    let history = &run.history;
    let window = run.hemodynamics.window;
    let step = run.case.time.step;
    let (mut gap, mut rate) = (0.0, 0.0);
    let (mut first, mut second) = ((0.0, 0.0), (0.0, 0.0));
    for rows in history.windows(3) {
        let [before, now, after] = rows else { continue };
        if !window.contains(now.time_s, step) {
            continue;
        }
        let derivative =
            (after.lumen_volume_m3 - before.lumen_volume_m3) / (after.time_s - before.time_s);
        // The flows belong to the steps before and after the time of the central difference.
        let flows = 0.5 * (now.Q_in_m3_s - now.Q_out_m3_s + after.Q_in_m3_s - after.Q_out_m3_s);
        gap += (flows - derivative).powi(2);
        rate += derivative.powi(2);
        if now.Q_in_m3_s > first.1 {
            first = (now.time_s, now.Q_in_m3_s);
        }
        if now.Q_out_m3_s > second.1 {
            second = (now.time_s, now.Q_out_m3_s);
        }
    }
    if rate == 0.0 {
        return None;
    }
    let (error, lag) = ((gap / rate).sqrt(), second.0 - first.0);
    let text = format!(
        "{}: the largest outflow comes {:.0} ms after the largest inflow; the difference of the flows is dV/dt within {} % (root mean square)",
        run.name(),
        1e3 * lag,
        significant(100.0 * error, 2)
    );
    Some((text, Verdict::of(lag > 0.0 && error < 0.1)))
}

/// A value of the artery over `d_max`, whose slope has this sign.
pub fn linear(
    study: &PaperStudy,
    value: fn(&RegionSummary) -> f64,
    sign: f64,
    what: &str,
) -> Judged {
    let extension = shown(study)?;
    let points = series(study, extension, ARTERY, value);
    if points.len() < 3 {
        return None;
    }
    let (slope, r2) = fit(&points);
    let verdict = if spread(&points) < RESOLVED {
        Verdict::Unresolved
    } else {
        Verdict::of(slope * sign > 0.0 && r2 >= LINEAR)
    };
    let change = 100.0 * slope * (points[points.len() - 1].0 - points[0].0) / points[0].1;
    let text = format!(
        "{}: {what} changes by {change:+.1} % from the smooth to the most deformed model, R² = {r2:.4}",
        letter(extension)
    );
    Some((text, verdict))
}

/// The largest displacement over `d_max`.
pub fn monotonic(study: &PaperStudy) -> Judged {
    let extension = shown(study)?;
    let points = series(study, extension, ARTERY, |r| 1e3 * r.max_displacement_m.max);
    if points.len() < 3 {
        return None;
    }
    let signs: Vec<bool> = points.windows(2).map(|p| p[1].1 > p[0].1).collect();
    let verdict = match spread(&points) < RESOLVED {
        true => Verdict::Unresolved,
        false => Verdict::of(signs.iter().all(|s| *s == signs[0])),
    };
    Some((
        format!("{} (mm): {}", letter(extension), list(&points, 4)),
        verdict,
    ))
}

/// Where the lowest largest wall shear stress is, in the middle of the artery, which is judged, and anywhere in it.
pub fn lowest_shear(study: &PaperStudy) -> Judged {
    let (mut texts, mut anywhere) = (Vec::new(), Vec::new());
    let (mut agree, mut resolved) = (true, true);
    for extension in EXTENSIONS {
        let text =
            |points: &[(f64, f64)]| format!("{} (Pa): {}", letter(extension), list(points, 3));
        let points = series(study, extension, MID_ARTERY, |r| r.max_wall_shear_Pa.max);
        if points.len() < 3 {
            continue;
        }
        let lowest = points.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        agree &= lowest.0 == points[points.len() - 1].0;
        resolved &= spread(&points) >= RESOLVED;
        texts.push(text(&points));
        anywhere.push(text(&series(study, extension, ARTERY, |r| {
            r.max_wall_shear_Pa.max
        })));
    }
    let verdict = if resolved {
        Verdict::of(agree)
    } else {
        Verdict::Unresolved
    };
    let [middle, anywhere] = [texts, anywhere].map(|texts| texts.join("; "));
    (!middle.is_empty()).then(|| {
        (
            format!("{middle}; anywhere in the artery, {anywhere}"),
            verdict,
        )
    })
}

/// The largest von Mises stress over `d_max`.
pub fn stress(study: &PaperStudy) -> Judged {
    let extension = shown(study)?;
    let points = series(study, extension, MID_ARTERY, |r| {
        1e-3 * r.max_von_mises_Pa.max
    });
    if points.len() < 3 {
        return None;
    }
    let grows = points[points.len() - 1].1 > points[0].1;
    let verdict = if spread(&points) < RESOLVED {
        Verdict::Unresolved
    } else {
        Verdict::of(grows)
    };
    Some((
        format!("{} (kPa): {}", letter(extension), list(&points, 1)),
        verdict,
    ))
}

/// Whether the load hardly changes at the time `t` (s): in the second half of the first period, as in the paper.
fn is_at_rest(t: f64, period: f64) -> bool {
    t >= 0.5 * period * (1.0 - 1e-9) && t <= period * (1.0 + 1e-9)
}

/// The same while the load hardly changes.
pub fn stress_at_rest(study: &PaperStudy) -> Judged {
    let extension = shown(study)?;
    let mean = |run: &Results| {
        let period = run.case.time.period;
        let rows = run
            .regions
            .iter()
            .filter(|r| r.region.as_str() == MID_ARTERY && is_at_rest(r.time_s, period));
        let stresses: Vec<f64> = rows.map(|row| 1e-3 * row.max_von_mises_Pa).collect();
        let mean = stresses.iter().sum::<f64>() / stresses.len() as f64;
        (!stresses.is_empty()).then_some((1e3 * vessel(run).model.d_max, mean))
    };
    let points: Vec<_> = study.of(extension).into_iter().filter_map(mean).collect();
    if points.len() < 3 {
        return None;
    }
    let highest = points.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let verdict = match spread(&points) < RESOLVED {
        true => Verdict::Unresolved,
        false => Verdict::of(highest.0 == points[0].0),
    };
    let text = format!(
        "{}, mean over the second half of the first period (kPa): {}",
        letter(extension),
        list(&points, 1)
    );
    Some((text, verdict))
}

/// Radius and oscillating shear index.
pub fn alike(study: &PaperStudy) -> Judged {
    let run = study
        .example()
        .filter(|run| vessel(run).model.d_max > 0.0)?;
    let [from, to] = maps::middle(run);
    let inside = run.faces.iter().filter(|f| (from..=to).contains(&f.x_m));
    let points: Vec<(f64, f64)> = inside.map(|f| (f.mean_radius_m, f.OSI)).collect();
    if points.len() < 10 {
        return None;
    }
    let (slope, r2) = fit(&points);
    let correlation = slope.signum() * r2.sqrt();
    let text = format!(
        "{}: correlation of radius and OSI over the middle of the artery {correlation:.2}",
        run.name()
    );
    // Qualitative likeness, not one-to-one, is what the paper claims.
    Some((text, Verdict::of(correlation > 0.3)))
}

/// Whether the largest index of each model lies within limits.
pub fn osi_range(study: &PaperStudy, region: &str, [low, high]: [f64; 2], curved: bool) -> Judged {
    let mut values = Vec::new();
    for extension in EXTENSIONS {
        if curved && extension == Extension::Straight {
            continue;
        }
        values.extend(
            series(study, extension, region, |r| r.OSI.max)
                .into_iter()
                .map(|p| p.1),
        );
    }
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (least, most) = values.iter().fold(ends, |(a, b), v| (a.min(*v), b.max(*v)));
    (!values.is_empty()).then(|| {
        let text = format!(
            "{} to {} over {} model(s)",
            significant(least, 2),
            significant(most, 2),
            values.len()
        );
        (text, Verdict::of(least >= low && most <= high))
    })
}

/// Whether the first two values of a series are nearly alike, and the others grow.
fn is_flat_and_then_grows(points: &[(f64, f64)]) -> bool {
    let values: Vec<f64> = points.iter().map(|p| p.1).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    (values[1] - values[0]).abs() <= ALIKE * largest
        && values[1..].windows(2).all(|pair| pair[1] > pair[0])
        && values[values.len() - 1] > values[0]
}

/// The largest index over `d_max`.
pub fn osi_order(study: &PaperStudy) -> Judged {
    let mut texts = Vec::new();
    let (mut agrees, mut resolved) = (true, true);
    for extension in EXTENSIONS {
        let points = series(study, extension, MID_ARTERY, |r| r.OSI.max);
        // "0 and 0.25 mm" can be told only where these are there.
        let begins = points.len() >= 3 && points[0].0 == 0.0 && (points[1].0 - 0.25).abs() < 1e-9;
        if !begins {
            continue;
        }
        agrees &= is_flat_and_then_grows(&points);
        resolved &= spread(&points) >= RESOLVED;
        let values: Vec<String> = points
            .iter()
            .map(|(d, v)| format!("{} at {d} mm", significant(*v, 2)))
            .collect();
        let largest = points.iter().map(|p| p.1).fold(0.0, f64::max);
        texts.push(format!(
            "{}: {} (the first two differ by {} % of the largest)",
            letter(extension),
            values.join(", "),
            significant(100.0 * (points[1].1 - points[0].1).abs() / largest, 2)
        ));
    }
    let verdict = if resolved {
        Verdict::of(agrees)
    } else {
        Verdict::Unresolved
    };
    (!texts.is_empty()).then(|| (texts.join("; "), verdict))
}

/// Share of the straight model's TAWSS below which the extension's influence counts as gone.
const GONE: f64 = 0.05;

/// How far the extension is felt.
pub fn distance(study: &PaperStudy) -> Judged {
    let mut texts = Vec::new();
    let mut farthest: f64 = 0.0;
    let straight = study.find(Extension::Straight, vessel(study.example()?).model.d_max)?;
    let diameter = 2.0 * vessel(straight).geometry.graft_inner_radius;
    for extension in [Extension::Helix, Extension::Arc] {
        let Some(run) = study.find(extension, vessel(straight).model.d_max) else {
            continue;
        };
        let differences = influence(straight, run, |f| f.TAWSS_Pa);
        let last = differences
            .iter()
            .rev()
            .find(|difference| difference.relative > GONE);
        let x = last.map_or(0.0, |difference| difference.x);
        farthest = farthest.max(x / diameter);
        texts.push(format!(
            "{}: TAWSS differs by more than {} % from the straight extension's up to x = {:.1} mm, {:.1} diameters",
            run.name(),
            100.0 * GONE,
            1e3 * x,
            x / diameter
        ));
    }
    (!texts.is_empty()).then(|| (texts.join("; "), Verdict::of(farthest <= 6.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exponential_decay_is_distinguished_from_others() {
        let step = 0.01;
        let of = |transient: fn(f64) -> f64, beats: i32| {
            let times = (1..=100 * beats).map(|n| f64::from(n) * step);
            let values = times.map(|t| (t, (std::f64::consts::TAU * t).cos() + transient(t)));
            decay(&values.collect::<Vec<_>>(), step, 1.0, 0.5, 0.0)
        };
        let found = of(|t| 0.1_f64.powf(t), 4).unwrap();
        assert!(
            (found.left - 0.1).abs() < 1e-9 && (found.r2 - 1.0).abs() < 1e-9,
            "{found:?}"
        );
        // Falls in every period, but not by the same share.
        let found = of(|t| 1.0 / t, 4).unwrap();
        assert!(
            (0.34..0.35).contains(&found.left) && (0.965..0.975).contains(&found.r2),
            "{found:?}"
        );
        // Comes and goes.
        let found = of(
            |t| {
                if t as i32 != 2 { 0.01 * t } else { 0.3 * t }
            },
            5,
        )
        .unwrap();
        assert!(found.r2 < EXPONENTIAL, "{found:?}");
        assert!(of(|t| 0.1_f64.powf(t), 2).is_none());
        // What has fallen to the floor says nothing: of 0.1 and 0.01 the latter does not count.
        let values: Vec<(f64, f64)> = (0..=300)
            .map(|n| 0.01 * f64::from(n))
            .map(|t| (t, 0.1_f64.powf(t)))
            .collect();
        assert!(decay(&values, 0.01, 1.0, 0.5, 0.0).is_some());
        assert!(decay(&values, 0.01, 1.0, 0.5, 0.1).is_none());
    }

    #[test]
    fn models_are_nearly_alike_only_if_they_are() {
        let on = |values: [f64; 4]| {
            let points: Vec<(f64, f64)> = [0.0, 0.25, 0.5, 0.75].into_iter().zip(values).collect();
            is_flat_and_then_grows(&points)
        };
        assert!(on([0.005, 0.006, 0.012, 0.025]));
        assert!(on([0.006, 0.005, 0.012, 0.025]));
        assert!(!on([0.005, 0.009, 0.012, 0.025]));
        assert!(!on([0.005, 0.006, 0.025, 0.020]));
    }

    #[test]
    fn at_rest_is_the_second_half_of_the_first_period() {
        let inside = [0.49, 0.5, 0.75, 1.0, 1.002].map(|t| is_at_rest(t, 1.0));
        assert_eq!(inside, [false, true, true, true, false]);
    }

    #[test]
    fn a_line_is_linear_and_a_parabola_is_not() {
        let on = |f: fn(f64) -> f64| [0.0, 0.25, 0.5, 0.75].map(|x| (x, f(x)));
        let (slope, r2) = fit(&on(|x| 3.0 - 2.0 * x));
        assert!((slope + 2.0).abs() < 1e-12 && (r2 - 1.0).abs() < 1e-12);
        assert!(fit(&on(|x| x * x * x)).1 < LINEAR);
        assert!((spread(&on(|x| 1.0 + x)) - 0.75 / 1.75).abs() < 1e-12);
    }
}
