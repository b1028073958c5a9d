//! The text of a proposed case.

use super::beat::fitting;
use super::files::{VesselSizes, rounded};
use super::{Figures, Like, PRESSURES, ProposalInput, STEP, THICKNESS, Windkessel};
use crate::analysis::tube_law;
use crate::case::{LengthUnit, ResolvedCase};
use crate::tabular::units::MMHG;
use fsi_numerics::twelve_digits;
use std::fmt::Write;
use std::path::Path;

/// Flow of a vessel of this radius (m) in the defaults, m³/s: base and amplitude. In arteries from the coronary ones to
/// the aorta velocities differ little, so that flow goes with the radius squared.
pub const FLOW: (f64, [f64; 2]) = (2.7e-3, [3.5e-6, 4.5e-6]);

/// What is chosen for a case.
#[derive(Debug, Clone)]
pub struct Numbers {
    pub radius: f64,
    pub length: f64,
    pub has_radius: bool,
    pub smoothing: Option<f64>,
    pub least_bend: Option<f64>,
    pub flow: [f64; 2],
    pub windkessel: Option<Windkessel>,
    /// Pressure at the beginning of a beat in the periodic state, with which the preset `fast` begins, Pa.
    pub fast_start: Option<f64>,
    pub rings: Option<(usize, f64)>,
    /// Duration of a beat and of a step, s.
    pub period: f64,
    pub step: f64,
}

impl Numbers {
    pub fn new(sizes: &VesselSizes, period: f64) -> Self {
        let radius = sizes.radius;
        let scale = (radius / FLOW.0).powi(2);
        Self {
            radius,
            length: sizes.length,
            has_radius: sizes.has_radius,
            smoothing: sizes.smoothing,
            least_bend: None,
            flow: FLOW.1.map(|flow| rounded(flow * scale)),
            windkessel: None,
            fast_start: None,
            rings: None,
            period,
            step: fitting(STEP, period),
        }
    }

    pub fn choose(&mut self, case: &ResolvedCase, figures: &Figures, input: &ProposalInput) {
        let own = tube_law::compliance(case, PRESSURES.map(|p| p * MMHG));
        let of_ramp = |ramp: f64| figures.windkessel(ramp, input.is_rcr, own);
        self.windkessel = of_ramp(case.ramp.duration);
        self.fast_start = of_ramp(0.0).map(|found| found.start);
        if let Some(vessel) = case.vessel() {
            let mesh = &vessel.fluid.mesh;
            let rings = figures.rings(mesh.radial, mesh.wall_grading);
            self.rings = (rings != (mesh.radial, mesh.wall_grading)).then_some(rings);
            self.step = fitting(figures.step(mesh, STEP), self.period);
        }
    }
}

pub fn name(path: &Path) -> String {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    toml::Value::from(name.unwrap_or_default()).to_string()
}

/// The whole file.
pub fn case(input: &ProposalInput, numbers: &Numbers) -> String {
    let mut text = String::from(
        "# A vessel of your own, as `fsi-driver new` proposes it. What is not here has the value of the defaults:\n\
         # `fsi-driver keys` lists all keys, docs/vessels.md explains those of [vessel].\n\
         extends = \"defaults\"\n\n[vessel]\n",
    );
    lumen(input, numbers, &mut text);
    sections(input, numbers, &mut text);
    text += MATERIALS;
    flow(input, numbers, &mut text);
    meshes(numbers, &mut text);
    text += WALL_IN_TIME;
    fast(input, numbers, &mut text);
    text
}

fn lumen(input: &ProposalInput, numbers: &Numbers, text: &mut String) {
    let (r, extension) = (numbers.radius, rounded(6.0 * numbers.radius));
    if let Some(path) = &input.line {
        let _ = writeln!(text, "centre_line = {}", name(path));
        let _ = writeln!(
            text,
            "unit = \"{}\" # of the files",
            input.unit.map_or("mm", LengthUnit::name)
        );
        if let Some(branch) = &input.branch {
            let _ = writeln!(text, "branch = {}", toml::Value::from(branch.as_str()));
        }
        if input.is_reversed {
            *text += "reverse = true # the blood flows from the end of the line to its beginning\n";
        }
        if let Some(length) = numbers.smoothing {
            let _ = writeln!(
                text,
                "smoothing_m = {length:e} # waves of this length are halved, of three times it keep 99 %; leave it out if the line \
                 does not scatter"
            );
        }
        if let Some(least) = numbers.least_bend {
            let _ = writeln!(
                text,
                "least_bend_m = {least:e} # sharper bends are rounded off: the wall could not follow them"
            );
        }
    }
    if let Some(path) = &input.lumen {
        let _ = writeln!(text, "lumen = {}", name(path));
        if let Some(unit) = input.lumen_unit {
            let _ = writeln!(text, "lumen_unit = \"{}\"", unit.name());
        }
        *text += "# lumen_smoothing_m = 1e-3 # the same on the surface; if absent, three times the length of a triangle\n";
    } else if !numbers.has_radius {
        let _ = writeln!(text, "radius_m = {r:e}");
    }
    let _ = writeln!(
        text,
        "upstream_extension_m = {extension:e} # straight rigid tubes, in which the flow develops and leaves"
    );
    let _ = writeln!(text, "downstream_extension_m = {extension:e}");
    if input.line.is_none() {
        let _ = writeln!(
            text,
            "\n[[vessel.piece]] # or centre_line = \"line.vtp\" (.csv, .swc) with unit = \"mm\""
        );
        let _ = writeln!(
            text,
            "piece = \"line\"\nlength_m = {:e}",
            rounded(numbers.length)
        );
    }
}

fn sections(input: &ProposalInput, numbers: &Numbers, text: &mut String) {
    let (r, length) = (numbers.radius, numbers.length);
    let thicknesses = match input.thickness {
        None => {
            let half = 0.5 * THICKNESS;
            format!(
                "thicknesses = [{half}, {half}]         # of the mean radius; or thicknesses_m, in metres"
            )
        }
        Some(thickness) => {
            let half = 0.5 * thickness;
            format!(
                "thicknesses_m = [{half:e}, {half:e}] # or thicknesses, as shares of the mean radius"
            )
        }
    };
    let artery = |name: &str, part: Option<f64>| {
        let part = part.map_or(String::new(), |part| format!("length_m = {part:e}\n"));
        format!(
            "\n[[vessel.section]]\nname = \"{name}\"\n{part}layers = [\"media\", \"adventitia\"] # from the inside out\n{thicknesses}\n"
        )
    };
    let third = rounded(length / 3.0);
    match input.like {
        Like::Graft => {
            *text += &artery("proximal", Some(third));
            let _ = write!(
                text,
                "\n[[vessel.section]]\nname = \"graft\"\nlength_m = {third:e}\nlayers = [\"ePTFE\"]\nthicknesses_m = [0.5e-3]\n"
            );
            *text += &artery("distal", None);
        }
        _ => *text += &artery("artery", None),
    }
    // A bump that fits into the vessel.
    let long = |radii: f64| rounded((radii * r).min(0.6 * length));
    let middle = rounded(0.5 * length);
    match input.like {
        Like::Stenosis => {
            let _ = write!(
                text,
                "\n[[vessel.feature]]\nfeature = \"stenosis\"\nat_m = {middle:e} # arc length of its middle\nlength_m = {:e}\n\
                 area_reduction = 0.5\neccentricity = 0.5\n",
                long(5.0)
            );
        }
        Like::Aneurysm => {
            let _ = write!(
                text,
                "\n[[vessel.feature]]\nfeature = \"aneurysm\"\nat_m = {middle:e} # arc length of its middle\nlength_m = {:e}\n\
                 growth_m = {:e} # of the radius\neccentricity = 0.3\n",
                long(8.0),
                rounded(0.7 * r)
            );
        }
        Like::Graft | Like::Uniform => {}
    }
    if input.like == Like::Graft {
        *text += "\n[[vessel.material]]\nname = \"ePTFE\"\nmaterial = \"neo_hooke\"\nmu_Pa = 3.33e5\nkappa_Pa = 1.67e9\n";
    }
}

/// The paper's artery.
const MATERIALS: &str = r#"
# Those of an artery (Radtke et al. 2017, table 1): put your own here.
[[vessel.material]]
name = "media"
material = "holzapfel_gasser_ogden"
mu_Pa = 5.4e4
kappa_Pa = 1.0e9
k1_Pa = 0.64e3
k2 = 3.54
fibre_angle_deg = 10.0 # from the circumferential direction

[[vessel.material]]
name = "adventitia"
material = "holzapfel_gasser_ogden"
mu_Pa = 5.4e3
kappa_Pa = 1.0e8
k1_Pa = 5.1e3
k2 = 15.4
fibre_angle_deg = 40.0
"#;

/// The keys of a flow from a file, whose names begin with `prefix`.
pub(super) fn flow_file(input: &ProposalInput, path: &Path, prefix: &str, text: &mut String) {
    let _ = writeln!(text, "{prefix}file = {}", name(path));
    if let Some(unit) = input.flow_unit {
        let _ = writeln!(text, "{prefix}unit = \"{}\"", unit.name());
    }
    if let Some(period) = input.flow_period {
        let _ = writeln!(text, "file_period_s = {period:?} # stretched to the beat");
    }
}

fn flow(input: &ProposalInput, numbers: &Numbers, text: &mut String) {
    *text += "\n[inflow]\n";
    match &input.flow {
        Some(path) => flow_file(input, path, "", text),
        None => {
            let [base, amplitude] = numbers.flow;
            let _ = writeln!(
                text,
                "base_m3_s = {base:e} # a pulse with the velocity of the defaults; or file = \"flow.csv\"\namplitude_m3_s = \
                 {amplitude:e}"
            );
        }
    }
    windkessel(input, numbers, text);
    time(numbers, text);
}

fn windkessel(input: &ProposalInput, numbers: &Numbers, text: &mut String) {
    if let Some(found) = &numbers.windkessel {
        let _ = write!(
            text,
            "\n[windkessel] # for 80 to 120 mmHg of this flow{}\nresistance_Pa_s_m3 = {:e}\ncompliance_m3_Pa = {:e}\n",
            found.of_vessel(),
            rounded(found.resistance),
            rounded(found.compliance)
        );
        if let Some(before) = found.proximal {
            let _ = writeln!(
                text,
                "proximal_resistance_Pa_s_m3 = {:e} # before these two: RCR",
                rounded(before)
            );
        }
        if input.loaded.is_none() {
            let [mean, start] = [found.mean, found.start].map(rounded);
            let _ = writeln!(
                text,
                "initial_pressure_Pa = {mean:e} # {:.0} mmHg, its mean, which the ramp scales: the first beats lead up to the periodic state\n\
                 # ({start:e} would lead there at once: {:.0} mmHg, which falls while the ramp rises)",
                mean / MMHG,
                start / MMHG
            );
        }
    }
    if let Some(pressure) = input.loaded {
        if numbers.windkessel.is_none() {
            *text += "\n[windkessel]\n";
        }
        let _ = write!(
            text,
            "initial_pressure_Pa = {pressure:?} # where it starts: under the pressure of the shape\n\n[initial]\nstart = \"equilibrium\"\n\
             shape = \"loaded\" # the unloaded shape is computed\npressure_Pa = {pressure:?} # {:.0} mmHg, under which the vessel has the \
             shape of this file\n",
            pressure / MMHG
        );
    }
    if input.has_tissue {
        *text += "\n[surroundings] # tissue around the wall, per area of its outside: put your own here\nspring_Pa_m = 1.0e7\n\
                  damping_Pa_s_m = 1.0e3\n";
        if input.loaded.is_some() {
            *text += "at_rest = \"loaded\" # the springs exert nothing in the shape of this file\n";
        }
    }
}

/// Steps of the preset `demo`, and of the interval of its files.
const DEMO: [f64; 2] = [50.0, 10.0];

fn time(numbers: &Numbers, text: &mut String) {
    let (period, step) = (numbers.period, numbers.step);
    if period == 1.0 && step == STEP {
        return;
    }
    *text += "\n[time]\n";
    if period != 1.0 {
        let _ = writeln!(
            text,
            "period_s = {period:?}\nend_s = {:?} # three beats",
            twelve_digits(3.0 * period)
        );
    }
    let reason = match step < fitting(STEP, period) {
        true => "; the fastest blood passes five cells at most",
        false => "",
    };
    let _ = writeln!(
        text,
        "step_s = {step:e} # {:.0} of them are a beat{reason}",
        period / step
    );
    let [end, interval] = DEMO.map(|steps| steps * step);
    let _ = write!(
        text,
        "\n[preset.demo] # {:.0} steps\ntime.end_s = {end:e}\noutput.fluid_interval_s = {interval:e}\n",
        DEMO[0]
    );
}

/// Steps of the beat before the preset `fast`, its ramp without one, and how long it goes on at most, in beats.
const FAST_BEFORE: usize = 40;
const FAST_RAMP: f64 = 0.05;
const FAST_BEATS: f64 = 10.0;

fn fast(input: &ProposalInput, numbers: &Numbers, text: &mut String) {
    let period = numbers.period;
    let _ = write!(
        text,
        "\n[preset.fast] # second order in time, until a beat ends as it began\ntime.step_s = {:e} # twice as long\ntime.end_s = {:?} # {FAST_BEATS:.0} \
         beats at most\n",
        fitting(2.0 * numbers.step, period),
        twelve_digits(FAST_BEATS * period),
    );
    let Some(start) = numbers.fast_start else {
        let _ = writeln!(text, "ramp.duration_s = {:?}", rounded(FAST_RAMP * period));
        return;
    };
    let _ = write!(
        text,
        "ramp.duration_s = 0.0\ninitial.steps_before = {FAST_BEFORE} # the blood flows from the beginning: 1.5 beats are usually enough\n\
         windkessel.initial_pressure_Pa = {:e} # {:.0} mmHg, the pressure at the beginning of a beat\n",
        rounded(start),
        start / MMHG
    );
    if input.loaded.is_none() {
        *text += "initial.start = \"equilibrium\"\n";
    }
}

/// What rings in the wall from step to step can grow from beat to beat without any damping in time (docs/coupling.md).
const WALL_IN_TIME: &str = "\n[structure]\ntime_scheme = \"bossak\" # of second order; with the paper's rule, the default, pressures alternate from step to step\n";

fn meshes(numbers: &Numbers, text: &mut String) {
    if let Some((rings, grading)) = numbers.rings {
        let _ = write!(
            text,
            "\n[fluid.mesh] # the cell at the wall is a quarter of the Stokes layer thick, sqrt(2 nu/omega)\nradial = {rings}\nwall_grading = \
             {grading:?}\n"
        );
    }
}
