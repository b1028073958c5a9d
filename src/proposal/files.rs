//! What is known of the files before a case is made from them.

use super::{ProposalError, ProposalInput, RADII, RADIUS};
use crate::case::{LengthUnit, LineReading, LineSurvey};
use crate::files::Fault;
use crate::polydata::{PolyData, Surface};
use std::f64::consts::TAU;

/// Lengths and radii of vessels, m, as a case allows them.
const LENGTHS: [f64; 2] = [1e-4, 5.0];
const RADII_OF_VESSELS: [f64; 2] = [1e-5, 0.05];

/// Those of most.
const USUAL_LENGTHS: [f64; 2] = [2e-3, 1.5];
const USUAL_RADII: [f64; 2] = [1e-4, 0.025];

/// Sizes of the vessel, m.
pub struct VesselSizes {
    /// Median radius of the lumen.
    pub radius: f64,
    /// Smallest and largest one that the file knows, or else that one.
    pub radii: [f64; 2],
    /// Length of the smooth centre-line.
    pub length: f64,
    /// Length of the waves that are halved in it.
    pub smoothing: Option<f64>,
    /// The centre-line's file.
    pub line: Option<LineSurvey>,
    /// Whether files give the radius.
    pub has_radius: bool,
}

/// # Errors
/// What is missing or wrong, in a sentence.
pub fn sizes(input: &ProposalInput) -> Result<VesselSizes, ProposalError> {
    let Some(path) = &input.line else {
        if input.lumen.is_some() {
            return Err("--lumen needs its centre-line, --from: VMTK makes one (vmtkcenterlines), as do 3D Slicer and SimVascular".into());
        }
        let radius = input.radius.unwrap_or(RADIUS);
        return Ok(VesselSizes {
            radius,
            radii: [radius; 2],
            length: RADII * radius,
            smoothing: None,
            line: None,
            has_radius: false,
        });
    };
    let Some(unit) = input.unit else {
        return Err("--from needs the unit of its lengths: --unit mm, m, cm or um".into());
    };
    let line = LineSurvey::read(path, input.branch.as_deref(), unit)
        .map_err(|e| format!("--from {}: {e}", path.display()))?;
    let surface = (input.lumen.as_ref())
        .map(|path| {
            let wrong = |e: Fault| format!("--lumen {}: {e}", path.display());
            let data = PolyData::read(path).map_err(wrong)?;
            let metres = input.lumen_unit.unwrap_or(unit).metres();
            let surface = Surface::new(&data, metres).map_err(wrong)?;
            Ok::<_, ProposalError>(surface.area() / (TAU * line.polygon()))
        })
        .transpose()?;
    if input.radius.is_some() && surface.is_some() {
        return Err(
            "--radius: the radius comes from --lumen already; leave out one of the two".into(),
        );
    }
    let has_radius = input.radius.is_none() && (surface.is_some() || line.radius().is_some());
    let Some(radius) = input.radius.or(line.radius()).or(surface) else {
        let seen = LineReading::of(path, input.branch.as_deref());
        let seen = seen.map_or(String::new(), |seen| format!(" ({})", seen.understood));
        return Err(ProposalError::Input(format!(
            "--from {}: the file has no radii{seen}: give --lumen, the surface, or --radius, such as --radius 3mm",
            path.display()
        )));
    };
    let smoothing = input
        .smoothing
        .unwrap_or_else(|| rounded(line.smoothing(radius)));
    let length = line.length(smoothing);
    check_unit(unit, length, radius, has_radius)?;
    let known = line.radii().iter().filter(|_| input.radius.is_none());
    let radii = known.fold([radius; 2], |[low, high], r| [low.min(*r), high.max(*r)]);
    Ok(VesselSizes {
        radius,
        radii,
        length,
        smoothing: (smoothing > 0.0).then_some(smoothing),
        line: Some(line),
        has_radius,
    })
}

/// Whether length and radius (m) are those of a vessel in this unit; the radius has another one if it is given by
/// itself.
pub fn check_unit(
    unit: LengthUnit,
    length: f64,
    radius: f64,
    has_radius: bool,
) -> Result<(), ProposalError> {
    let ([short, long], [thin, wide]) = (LENGTHS, RADII_OF_VESSELS);
    if (short..=long).contains(&length) && (thin..=wide).contains(&radius) {
        return Ok(());
    }
    let would_fit = |other: &LengthUnit| {
        let factor = other.metres() / unit.metres();
        let of_file = if has_radius { factor } else { 1.0 };
        (USUAL_LENGTHS[0]..=USUAL_LENGTHS[1]).contains(&(factor * length))
            && (USUAL_RADII[0]..=USUAL_RADII[1]).contains(&(of_file * radius))
    };
    let advice = match LengthUnit::ALL.into_iter().find(would_fit) {
        Some(other) => format!("--unit {} would fit", other.name()),
        None => "no unit fits both: are points and radii in different ones?".to_owned(),
    };
    Err(ProposalError::Input(format!(
        "--unit {}: with it the centre-line is {length:.3e} m long and the lumen {radius:.3e} m in radius; vessels are {short} to {long} \
         m long and {thin:e} to {wide} m in radius; {advice}",
        unit.name()
    )))
}

/// To three digits.
pub fn rounded(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}
