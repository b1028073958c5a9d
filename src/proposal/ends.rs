//! The ends of a tree's lines: their names, radii, and shares of the flow.

use super::{ProposalError, ProposalInput, files, told};
use crate::case::{LengthUnit, TreeKeys, TreeLine};
use fsi_numerics::twelve_digits;
use std::path::{Path, PathBuf};

/// Flow goes with this power of the radius (Murray 1926).
pub(super) const MURRAY: f64 = 3.0;
/// Sums of shares that say how all of the flow divides, and how far off rounded shares may be.
const WHOLE: [f64; 2] = [1.0, 100.0];
const ROUNDED: f64 = 0.01;
/// The radius at an end is the median over this share of its line.
const END: f64 = 0.2;
/// A radius jumps if it is so many times the one before or less than that part of it ...
const JUMP: f64 = 1.25;
/// ... and radii scatter if this share of them jumps up, and as many down: a vessel that tapers does not, and a
/// narrowing is a few points.
const SCATTER: f64 = 0.1;

/// What is known of the lines, m.
pub(super) struct Ends {
    /// Openings, the inlet first.
    pub names: Vec<String>,
    /// Ends in the order of the file, with those that are left out.
    pub in_file: Vec<String>,
    /// Radius at each.
    pub radii: Vec<f64>,
    /// Smallest and mean radius of all points.
    pub range: [f64; 2],
    /// How many radii jump, and of how many, if they scatter.
    pub scatter: Option<[usize; 2]>,
    /// Length of the longest line.
    pub length: f64,
    /// Share of the flow of each outlet.
    pub shares: Vec<f64>,
    /// Of each line that is kept, in the order of the file: its name, its share, and the radius at its end.
    pub lines: Vec<(String, f64, f64)>,
}

impl Ends {
    /// Of the lines of a file that are kept.
    ///
    /// # Errors
    /// If the file cannot be read, or the input does not fit it.
    pub fn of(input: &ProposalInput, unit: LengthUnit) -> Result<Self, ProposalError> {
        let mut keys = input.tree_keys(unit);
        keys.read().map_err(|(key, reason)| match key.as_str() {
            "tree.least_radius_m" => format!("--least-radius: {reason}"),
            _ => format!("--from {}", told::in_options(&reason)),
        })?;
        let mut names = names(input, &keys)?;
        let lines = keys.line.unwrap_or_default();
        let in_file = names[1..].to_vec();
        for (option, given) in [
            ("--leave-out", &input.leave_out),
            ("--closed", &input.closed),
        ] {
            if let Some(unknown) = given.iter().find(|name| !in_file.contains(name)) {
                return Err(ProposalError::Input(format!(
                    "{option} {unknown}: no line ends there; they end at {}",
                    in_file.join(", ")
                )));
            }
        }
        let is_kept = |name: &String| !input.leave_out.contains(name);
        let is_open = |name: &String| !input.closed.contains(name);
        names.retain(|name| is_kept(name) && is_open(name));
        let kept = in_file.iter().cloned().zip(lines);
        let lines: Vec<_> = kept.filter(|(name, _)| is_kept(name)).collect();
        if lines.len() < 2 {
            let option = match (input.leave_out.is_empty(), input.least_radius) {
                (true, Some(_)) => "--least-radius",
                (true, None) => "--from",
                (false, _) => "--leave-out",
            };
            let reason = "a tree has two ends at least: --branch takes one line alone";
            return Err(ProposalError::Input(format!("{option}: {reason}")));
        }
        if names.len() < 2 {
            return Err("--closed: one end at least must be an outlet".into());
        }
        let ends: Vec<(String, f64)> = (lines.iter())
            .map(|(name, line)| (name.clone(), at_end(&line.radii)))
            .collect();
        let open: Vec<_> = lines.iter().filter(|(name, _)| is_open(name)).collect();
        let lines: Vec<&TreeLine> = open.iter().map(|(_, line)| line).collect();
        let first = &lines[0].radii;
        let last = lines.iter().map(|line| at_end(&line.radii));
        let radii: Vec<f64> = std::iter::once(median(&first[..part(first)]))
            .chain(last)
            .collect();
        let all = || lines.iter().flat_map(|line| line.radii.iter().copied());
        let length = lines.iter().map(|line| {
            let pairs = line.points.windows(2);
            let steps = pairs.map(|p| (0..3).map(|c| (p[1][c] - p[0][c]).powi(2)).sum::<f64>());
            steps.map(f64::sqrt).sum::<f64>()
        });
        let length = length.fold(0.0, f64::max);
        let range = [
            all().fold(f64::INFINITY, f64::min),
            all().sum::<f64>() / all().count() as f64,
        ];
        let scatter = scatter(lines.iter().map(|line| &line.radii[..]));
        files::check_unit(unit, length, radii[0], true)?;
        let mut outlets = format!("for {} in this order", names[1..].join(", "));
        if !input.closed.is_empty() {
            // Those that lie in a sac were closed without being asked for
            outlets += &format!(" (no openings: {})", input.closed.join(", "));
        }
        let shares = shares(&radii[1..], &input.split, input.murray, &outlets)?;
        // No flow leaves through a sac.
        let share = |name: &String| {
            let outlet = names[1..].iter().position(|other| other == name);
            outlet.map_or(0.0, |outlet| shares[outlet])
        };
        let kept = ends.into_iter();
        Ok(Self {
            lines: kept
                .map(|(name, radius)| {
                    let share = share(&name);
                    (name, share, radius)
                })
                .collect(),
            names,
            in_file,
            shares,
            radii,
            range,
            scatter,
            length,
        })
    }

    /// Keys of the lines with these names, without those that are left out.
    pub fn keys(&self, input: &ProposalInput, unit: LengthUnit) -> TreeKeys {
        TreeKeys {
            inlet: Some(self.names[0].clone()),
            outlets: self.in_file.clone(),
            leave_out: input.leave_out.clone(),
            closed: input.closed.clone(),
            ..input.tree_keys(unit)
        }
    }
}

impl ProposalInput {
    /// Keys of all lines that are thick enough.
    pub(super) fn tree_keys(&self, unit: LengthUnit) -> TreeKeys {
        let line = |path: &PathBuf| TreeLine {
            name: Some(branch_name(path)),
            file: Some(path.clone()),
            ..TreeLine::default()
        };
        let all = self.line.iter().chain(&self.branches);
        let is_one = self.branches.is_empty();
        TreeKeys {
            least_radius: self.least_radius,
            lines: self.line.clone().filter(|_| is_one),
            line: (!is_one).then(|| all.map(line).collect()),
            unit: Some(unit),
            ..TreeKeys::default()
        }
    }

    /// The files of the lines in a message.
    pub(super) fn shown_lines(&self) -> String {
        let all = self.line.iter().chain(&self.branches);
        let all: Vec<String> = all.map(|path| path.display().to_string()).collect();
        all.join(" --from ")
    }
}

/// How many radii of these lines jump, and of how many, if they scatter, as those do that are measured in voxels.
fn scatter<'a>(lines: impl Iterator<Item = &'a [f64]>) -> Option<[usize; 2]> {
    let [mut up, mut down, mut all] = [0; 3];
    for pair in lines.flat_map(|radii| radii.windows(2)) {
        up += usize::from(pair[1] > JUMP * pair[0]);
        down += usize::from(pair[0] > JUMP * pair[1]);
        all += 1;
    }
    (up.min(down) as f64 > SCATTER * all as f64).then_some([up + down, all])
}

/// What the branch in a file of its own is called.
pub(super) fn branch_name(path: &Path) -> String {
    let name = path.file_stem().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Names of the openings of lines that have been read, the inlet first.
pub(super) fn names(input: &ProposalInput, keys: &TreeKeys) -> Result<Vec<String>, ProposalError> {
    if input.names.is_empty() {
        return Ok(keys.names());
    }
    if let Some(empty) = input.names.iter().position(|name| name.is_empty()) {
        return Err(ProposalError::Input(format!(
            "--names {}: name {} is empty: expected names such as inlet,left,right",
            input.names.join(","),
            empty + 1
        )));
    }
    let ends = keys.line.as_ref().map_or(0, Vec::len);
    if input.names.len() != ends + 1 {
        return Err(ProposalError::Input(format!(
            "--names: expected {}, that of the inlet and then those of the {ends} ends in the order of the file, found {}",
            ends + 1,
            input.names.len()
        )));
    }
    Ok(input.names.clone())
}

/// Radii (m) at the ends of a case's tree.
pub fn end_radii(tree: &TreeKeys) -> Vec<f64> {
    let names = tree.names();
    let lines = tree.line.iter().flatten().zip(&names[1..]);
    let open = lines.filter(|(_, name)| !tree.closed.contains(name));
    open.map(|(line, _)| at_end(&line.radii)).collect()
}

/// The radius at the end of a line.
fn at_end(radii: &[f64]) -> f64 {
    median(&radii[radii.len() - part(radii)..])
}

/// How many points at an end of a line count.
fn part(radii: &[f64]) -> usize {
    ((END * radii.len() as f64) as usize).clamp(1, radii.len())
}

fn median(radii: &[f64]) -> f64 {
    let mut radii = radii.to_vec();
    radii.sort_by(f64::total_cmp);
    radii[radii.len() / 2]
}

/// As [`shares`], of the outlets of a case's tree.
///
/// # Errors
/// If they do not fit.
pub fn tree_shares(
    tree: &TreeKeys,
    given: &[f64],
    exponent: Option<f64>,
) -> Result<Vec<f64>, ProposalError> {
    let outlets = "one for each outlet in the order of the file";
    shares(&end_radii(tree), given, exponent, outlets)
}

/// Shares of the flow of outlets with these radii (m), which a refusal calls `outlets`: those that are given, or by the
/// radius to the power of an exponent.
///
/// # Errors
/// If they do not fit.
fn shares(
    radii: &[f64],
    given: &[f64],
    exponent: Option<f64>,
    outlets: &str,
) -> Result<Vec<f64>, ProposalError> {
    if given.is_empty() {
        let exponent = exponent.unwrap_or(MURRAY);
        if !(0.0..=6.0).contains(&exponent) {
            return Err(ProposalError::Input(format!(
                "--murray {exponent}: expected an exponent from 0 to 6"
            )));
        }
        let all: Vec<f64> = radii.iter().map(|r| r.powf(exponent)).collect();
        let sum: f64 = all.iter().sum();
        return Ok(all.into_iter().map(|share| share / sum).collect());
    }
    if exponent.is_some() {
        return Err("--split says the shares already: leave out --murray".into());
    }
    if given.len() != radii.len() {
        return Err(ProposalError::Input(format!(
            "--split: expected {} shares, {outlets}, found {}",
            radii.len(),
            given.len()
        )));
    }
    if let Some(share) = given
        .iter()
        .find(|share| !(**share > 0.0 && share.is_finite()))
    {
        return Err(ProposalError::Input(format!(
            "--split {share}: expected shares above 0, such as 0.65,0.35"
        )));
    }
    let sum: f64 = given.iter().sum();
    if WHOLE
        .iter()
        .all(|whole| (sum / whole - 1.0).abs() > ROUNDED)
    {
        return Err(ProposalError::Input(format!(
            "--split: the shares add up to {}: expected 1, or 100 if they are in percent",
            twelve_digits(sum)
        )));
    }
    Ok(given.iter().map(|share| share / sum).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radii in voxels jump up and down; a taper between few points and a narrowing do not.
    #[test]
    fn radii_in_voxels_scatter() {
        let voxels = [0.62, 0.31, 0.62, 0.31, 0.31, 0.62, 0.93, 0.62, 0.62, 0.31];
        assert_eq!(scatter([&voxels[..]].into_iter()), Some([7, 9]));
        let taper = [3.0, 2.0, 1.2];
        let mut narrowing = [1.0; 21];
        (narrowing[9], narrowing[10]) = (0.5, 0.5);
        assert_eq!(scatter([&taper[..], &narrowing].into_iter()), None);
    }
}
