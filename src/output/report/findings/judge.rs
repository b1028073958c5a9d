//! One function a finding: what the study found, and whether the paper found the same.

use super::{LINEAR, RESOLVED, Verdict};
use crate::case::Extension;
use crate::hemodynamics::RegionName::{self, Artery, MidArtery};
use crate::hemodynamics::summary::RegionSummary;
use crate::output::report::study::{Study, influence};
use crate::output::report::{letter, maps, name_of};
use crate::output::results::Results;

/// What the study found; `None` if models are missing.
type Judged = Option<(String, Verdict)>;

/// The value of a region for each `d_max` (mm) of an extension.
pub fn series(
    study: &Study,
    extension: Extension,
    region: RegionName,
    value: impl Fn(&RegionSummary) -> f64,
) -> Vec<(f64, f64)> {
    let models = study.of(extension).into_iter();
    let point = |run: &Results| {
        let region = run.hemodynamics.region(region)?;
        Some((1e3 * run.case.model.d_max, value(region)))
    };
    models.filter_map(point).collect()
}

/// The extension that the paper shows, or one that is there with at least three models.
fn shown(study: &Study) -> Option<Extension> {
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

/// Successive periods.
pub fn periodicity(study: &Study) -> Judged {
    let mut worst: (f64, f64) = (0.0, 0.0);
    let mut models = 0;
    for run in study.runs() {
        let found = &run.hemodynamics.periodicity;
        for differences in [&found.outflow, &found.max_displacement] {
            let [.., before, last] = differences.as_slice() else {
                continue;
            };
            worst.0 = worst.0.max(last.relative);
            worst.1 = worst.1.max(last.largest / before.largest);
            models += 1;
        }
    }
    (models > 0).then(|| {
        let text = format!(
            "last period against the one before: at most {:.2} % of the largest value; the difference fell to at most {:.3} of the one a period earlier",
            100.0 * worst.0,
            worst.1
        );
        (text, Verdict::of(worst.0 <= 0.02 && worst.1 < 1.0))
    })
}

/// Flows and the rate of change of the volume.
pub fn balance(study: &Study) -> Judged {
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
        "{}: the largest outflow comes {:.0} ms after the largest inflow; the difference of the flows is dV/dt within {:.1} % (root mean square)",
        name_of(run),
        1e3 * lag,
        100.0 * error
    );
    Some((text, Verdict::of(lag > 0.0 && error < 0.1)))
}

/// A value of the artery over `d_max`, whose slope has this sign.
pub fn linear(study: &Study, value: fn(&RegionSummary) -> f64, sign: f64, what: &str) -> Judged {
    let extension = shown(study)?;
    let points = series(study, extension, Artery, value);
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
pub fn monotonic(study: &Study) -> Judged {
    let extension = shown(study)?;
    let points = series(study, extension, Artery, |r| 1e3 * r.max_displacement_m.max);
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

/// Where the lowest largest wall shear stress is.
pub fn lowest_shear(study: &Study) -> Judged {
    let mut texts = Vec::new();
    let (mut agree, mut resolved) = (true, true);
    for extension in Study::EXTENSIONS {
        let points = series(study, extension, MidArtery, |r| r.max_wall_shear_Pa.max);
        if points.len() < 3 {
            continue;
        }
        let lowest = points.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        agree &= lowest.0 == points[points.len() - 1].0;
        resolved &= spread(&points) >= RESOLVED;
        texts.push(format!("{} (Pa): {}", letter(extension), list(&points, 3)));
    }
    let verdict = if resolved {
        Verdict::of(agree)
    } else {
        Verdict::Unresolved
    };
    (!texts.is_empty()).then(|| (texts.join("; "), verdict))
}

/// The largest von Mises stress over `d_max`.
pub fn stress(study: &Study) -> Judged {
    let extension = shown(study)?;
    let points = series(study, extension, MidArtery, |r| {
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

/// The same while the load hardly changes.
pub fn stress_at_rest(study: &Study) -> Judged {
    let extension = shown(study)?;
    let mean = |run: &Results| {
        let period = run.case.time.period;
        let resting = |t: f64| t > 0.75 * period && t <= period;
        let rows = run
            .regions
            .iter()
            .filter(|r| r.region == MidArtery && resting(r.time_s));
        let stresses: Vec<f64> = rows.map(|row| 1e-3 * row.max_von_mises_Pa).collect();
        let mean = stresses.iter().sum::<f64>() / stresses.len() as f64;
        (!stresses.is_empty()).then_some((1e3 * run.case.model.d_max, mean))
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
        "{}, mean over the last quarter of the first period (kPa): {}",
        letter(extension),
        list(&points, 1)
    );
    Some((text, verdict))
}

/// Radius and oscillating shear index.
pub fn alike(study: &Study) -> Judged {
    let run = study.example().filter(|run| run.case.model.d_max > 0.0)?;
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
        name_of(run)
    );
    // Qualitative likeness, not one-to-one, is what the paper claims.
    Some((text, Verdict::of(correlation > 0.3)))
}

/// Whether the largest index of each model lies within limits.
pub fn osi_range(study: &Study, region: RegionName, [low, high]: [f64; 2], curved: bool) -> Judged {
    let mut values = Vec::new();
    for extension in Study::EXTENSIONS {
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
        let text = format!("{least:.4} to {most:.4} over {} model(s)", values.len());
        (text, Verdict::of(least >= low && most <= high))
    })
}

/// The largest index over `d_max`.
pub fn osi_order(study: &Study) -> Judged {
    let mut texts = Vec::new();
    let (mut grows, mut resolved) = (true, true);
    for extension in Study::EXTENSIONS {
        let points = series(study, extension, Artery, |r| r.OSI.max);
        if points.len() < 3 {
            continue;
        }
        // From the second model on: the first two are nearly alike.
        grows &= points.windows(2).skip(1).all(|p| p[1].1 > p[0].1)
            && points[points.len() - 1].1 > points[0].1;
        resolved &= spread(&points) >= RESOLVED;
        texts.push(format!("{}: {}", letter(extension), list(&points, 4)));
    }
    let verdict = if resolved {
        Verdict::of(grows)
    } else {
        Verdict::Unresolved
    };
    (!texts.is_empty()).then(|| (texts.join("; "), verdict))
}

/// Share of the straight model's TAWSS below which the extension's influence counts as gone.
const GONE: f64 = 0.05;

/// How far the extension is felt.
pub fn distance(study: &Study) -> Judged {
    let mut texts = Vec::new();
    let mut farthest: f64 = 0.0;
    let straight = study.find(Extension::Straight, study.example()?.case.model.d_max)?;
    let diameter = 2.0 * straight.case.geometry.graft_inner_radius;
    for extension in [Extension::Helix, Extension::Arc] {
        let Some(run) = study.find(extension, straight.case.model.d_max) else {
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
            name_of(run),
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
    fn a_line_is_linear_and_a_parabola_is_not() {
        let on = |f: fn(f64) -> f64| [0.0, 0.25, 0.5, 0.75].map(|x| (x, f(x)));
        let (slope, r2) = fit(&on(|x| 3.0 - 2.0 * x));
        assert!((slope + 2.0).abs() < 1e-12 && (r2 - 1.0).abs() < 1e-12);
        assert!(fit(&on(|x| x * x * x)).1 < LINEAR);
        assert!((spread(&on(|x| 1.0 + x)) - 0.75 / 1.75).abs() < 1e-12);
    }
}
