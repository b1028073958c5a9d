//! Whether the values of a vessel's case are those of vessels, and which unit was probably meant where they are not.
//!
//! Ranges are wide: what people have, with some room for benchmarks. A value outside makes no run impossible; it is
//! told with the unit that would bring it into its range.

use super::case_figures::CaseFigures;
use super::windkessel::STEPS;
use crate::case::schema::Key;
use crate::case::{
    Case, Condition, Opening, PressureModel, ResolvedCase, Start, TreeKeys, TreeOpening, VesselSide,
};
use crate::tabular::units;

/// A unit that is written by mistake: its name, and its size in the SI unit.
type Slip = (&'static str, f64);
/// How a quantity is shown: the unit and its size in the SI unit; without a name in the SI unit itself.
type Shown = (&'static str, f64);

const SI: Shown = ("", 1.0);
const MMHG: Shown = ("mmHg", units::MMHG);
const KPA: Shown = ("kPa", 1e3);
const MM: Shown = ("mm", 1e-3);
const VELOCITY: Shown = ("m/s", 1.0);

/// A value so near its range, in powers of e, is as good as within.
const NEAR: f64 = 1.1;
/// How much nearer, in powers of e, what a unit gives has to be than what the one before it in its list gives.
const RARER: f64 = 0.8;

/// Units, the usual ones first, by the SI unit that the name of a key ends with. Stiffness stands apart from pressure:
/// nobody has it in mmHg.
#[rustfmt::skip]
const SLIPS: [(&str, &[Slip]); 11] = [
    ("Pa", &[MMHG, KPA, ("dyn/cm2", 0.1)]),
    ("Pa of stiffness", &[KPA, ("MPa", 1e6), ("GPa", 1e9), ("dyn/cm2", 0.1)]),
    ("m", &[MM, ("cm", 1e-2), ("um", 1e-6)]),
    ("s", &[("ms", 1e-3), ("min", 60.0)]),
    ("kg/m³", &[("g/cm3", 1e3)]),
    ("Pa s", &[("cP", 1e-3), ("P", 0.1)]),
    ("m³/s", &[("ml/s", 1e-6), ("ml/min", 1e-6 / 60.0), ("l/min", 1e-3 / 60.0), ("l/s", 1e-3), ("mm3/s", 1e-9)]),
    ("Pa s/m³", &[("dyn s/cm5", 1e5), ("mmHg s/ml", 1e6 * units::MMHG), ("mmHg min/l", 7.99932e6), ("Pa s/ml", 1e6), ("kPa s/ml", 1e9)]),
    ("m³/Pa", &[("cm5/dyn", 1e-5), ("ml/mmHg", 7.50064e-9), ("ml/Pa", 1e-6), ("ml/kPa", 1e-9), ("mm3/Pa", 1e-9)]),
    ("Pa/m", &[("kPa/m", 1e3), ("dyn/cm3", 10.0), ("kPa/mm", 1e6), ("MPa/m", 1e6), ("N/mm3", 1e9)]),
    ("Pa s/m", &[("kPa s/m", 1e3), ("dyn s/cm3", 10.0), ("Pa s/mm", 1e3)]),
];

/// Names of keys (or how their paths end) with what they mean, how they are shown, their usual range in SI units, and
/// the value to expect.
type Usual = (&'static [&'static str], &'static str, Shown, [f64; 2], f64);
/// What is usual. A value of 0 is none, and as usual.
#[rustfmt::skip]
const KEYS: [Usual; 13] = [
    (&["blood.density_kg_m3"], "the density of blood", SI, [900.0, 1200.0], 1050.0),
    (&["blood.viscosity_Pa_s"], "the viscosity of blood", SI, [8e-4, 0.015], 3.5e-3),
    (&["wall.density_kg_m3"], "the density of walls", SI, [800.0, 2500.0], 1100.0),
    (&["inner_radius_m", "vessel.radius_m", "vessel.end_radius_m", "radii_m", "section[].radius_m"], "the radius of vessels", MM, [2e-4, 0.025], 3e-3),
    (&[".mu_Pa"], "the shear modulus of walls and grafts", KPA, [500.0, 1e7], 5e4),
    (&[".kappa_Pa"], "the bulk modulus of walls and grafts", KPA, [2e4, 1e11], 1e8),
    (&[".k1_Pa"], "the stiffness of fibres", KPA, [50.0, 5e6], 5e3),
    // A wall that is as good as rigid is meant: no upper limit.
    (&[".youngs_modulus_Pa"], "Young's modulus of walls and grafts", KPA, [2e3, f64::INFINITY], 5e5),
    (&["surroundings.spring_Pa_m"], "the stiffness of tissue around vessels", SI, [1e5, 1e10], 1e7),
    (&["surroundings.damping_Pa_s_m"], "the damping of tissue around vessels", SI, [10.0, 1e7], 1e4),
    (&["ends.spring_Pa_m"], "the stiffness of springs at an end", SI, [1e5, 1e13], 1e8),
    (&["surroundings.pressure_Pa"], "the pressure around vessels", MMHG, [130.0, 1e4], 700.0),
    (&["inlet.pressure_Pa", "outlet.pressure_Pa", "initial.pressure_Pa"], "a pressure in vessels", MMHG, [130.0, 3e4], 1.1e4),
];

/// A value with its range, and the keys that it follows from.
struct Judged<'a> {
    /// What it is, if it is not the value of the one key.
    what: String,
    value: f64,
    usual: [f64; 2],
    /// The value to expect.
    typical: f64,
    shown: Shown,
    /// What of such things is usual; empty with `what`.
    about: &'a str,
    /// The keys to look at; it is proportional to this power of the first one, and all have one unit of [`SLIPS`].
    keys: Vec<String>,
    unit: &'a str,
    power: f64,
    /// A value of those keys for an example.
    example: Option<f64>,
    /// How further keys end that it follows from: where one of them was reported already, it adds nothing.
    depends: &'static [&'static str],
}

/// Everything about a vessel's case that is not usual in vessels, a sentence each.
pub fn warnings(case: &ResolvedCase) -> Vec<String> {
    let figures = CaseFigures::of(case);
    let derived = match (&figures, case.tree()) {
        (Some(figures), _) => derived(case, figures),
        (None, Some(tree)) => of_tree(case, tree),
        (None, None) => return Vec::new(),
    };
    let mut told: Vec<String> = Vec::new();
    let mut sentences = Vec::new();
    let flow = figures.as_ref().and_then(|figures| figures.flow);
    if let Some(flow) = flow.filter(|flow| flow.mean < -0.01 * flow.peak) {
        sentences.push(format!(
            "the mean flow at the inlet is {} ml/min, out of the vessel: is its sign that of an outflow?",
            digits(6e7 * flow.mean)
        ));
    }
    for judged in of_keys(case).into_iter().chain(derived) {
        // What follows from a value that was reported already adds nothing.
        let is_told = told.iter().any(|key| {
            judged.keys.contains(key) || judged.depends.iter().any(|end| key.ends_with(end))
        });
        if !is_told && let Some(sentence) = judged.sentence(case) {
            told.extend(judged.keys);
            sentences.push(sentence);
        }
    }
    let is_known = |key: &String| OF_WAVES.iter().any(|end| key.ends_with(end));
    let bursting = figures.as_ref().and_then(bursting);
    sentences.extend(bursting.filter(|_| !told.iter().any(is_known)));
    sentences
}

/// What follows from the lines of a tree, and from what is prescribed at its openings.
fn of_tree(case: &ResolvedCase, tree: &TreeKeys) -> Vec<Judged<'static>> {
    let radii = tree.line.iter().flatten().flat_map(|line| &line.radii);
    let widest = radii.fold(0.0f64, |most, radius| most.max(*radius));
    let what = "the largest radius of the centre-lines";
    let widest = following(what, widest, [2e-4, 0.025], 3e-3, MM);
    let key = match case.origins.contains_key("tree.unit") {
        true => "tree.unit",
        false => "tree.line[0].radii_m",
    };
    let mut found = vec![widest.from(&[key], "", None)];
    let given: Vec<&TreeOpening> = tree.opening.iter().flatten().collect();
    let key = |opening: &Opening, name: &str| {
        let place = given.iter().position(|keys| keys.name == opening.name);
        format!("tree.opening[{}].{name}", place.unwrap_or(0))
    };
    let start = match case.initial_wall() {
        Some(_) => Start::Equilibrium,
        None => Start::Ramp,
    };
    let openings = tree.openings(case.time.period).unwrap_or_default();
    let (mut flow, mut conductance) = (Some(0.0), 0.0);
    let mut least = (f64::INFINITY, String::new());
    let mut of_openings = Vec::new();
    for opening in &openings {
        match &opening.condition {
            Condition::Flow(curve, _) => {
                let times = (0..STEPS).map(|i| curve.period() * i as f64 / STEPS as f64);
                let mean = times.map(|t| curve.flow(t)).sum::<f64>() / STEPS as f64;
                flow = flow.map(|flow| flow + mean);
            }
            Condition::Pressure(
                model @ PressureModel {
                    proximal,
                    distal: Some((distal, _)),
                    ..
                },
            ) => {
                conductance += 1.0 / (proximal + distal);
                if *distal < least.0 {
                    least = (*distal, key(opening, "resistance_Pa_s_m3"));
                }
                let key = |name: &str| key(opening, name);
                of_windkessel(case, model, start, key, &mut of_openings);
            }
            // What the pressure is there is prescribed, or unknown.
            _ => flow = None,
        }
    }
    if let Some(flow) = flow.filter(|flow| *flow > 0.0 && conductance > 0.0) {
        let what = "the expected mean pressure, all resistances together times the mean flow,";
        let mean = following(what, flow / conductance, [1.3e3, 2.7e4], 1.25e4, MMHG);
        found.push(mean.from(&[&least.1], "Pa s/m³", Some(least.0)));
    }
    found.extend(of_openings);
    found
}

/// Values of keys by themselves, without the radii of a tree: these are judged together.
fn of_keys(case: &Case) -> Vec<Judged<'static>> {
    let mut found = Vec::new();
    let all = case.values().into_iter();
    for (path, key, value) in all.filter(|(path, ..)| !path.starts_with("tree.line[")) {
        let row = (KEYS.iter()).find(|(ends, ..)| ends.iter().any(|end| key.path.ends_with(end)));
        let Some(&(_, about, shown, usual, typical)) = row else {
            continue;
        };
        let values = match &value {
            toml::Value::Array(values) => values.iter().filter_map(toml::Value::as_float).collect(),
            value => Vec::from_iter(value.as_float()),
        };
        let worst = (values.into_iter()).max_by(|a, b| off(*a, usual).total_cmp(&off(*b, usual)));
        found.extend(worst.map(|worst| Judged {
            what: String::new(),
            value: worst,
            usual,
            typical,
            shown,
            about,
            keys: vec![path],
            unit: unit_of(key),
            power: 1.0,
            example: Some(worst),
            depends: &[],
        }));
    }
    found
}

/// The unit of a key, as [`SLIPS`] has it.
fn unit_of(key: &Key) -> &'static str {
    match key.unit().unwrap_or_default() {
        "Pa" if !key.path.ends_with("pressure_Pa") => "Pa of stiffness",
        unit => unit,
    }
}

/// What follows from several values.
fn derived(case: &ResolvedCase, figures: &CaseFigures) -> Vec<Judged<'static>> {
    let mut found = Vec::new();
    of_times(case, figures, &mut found);
    of_flow(case, figures, &mut found);
    of_outlet(case, figures, &mut found);
    of_walls(case, figures, &mut found);
    found
}

/// A value that follows from others.
fn following(
    what: impl Into<String>,
    value: f64,
    usual: [f64; 2],
    typical: f64,
    shown: Shown,
) -> Judged<'static> {
    Judged {
        what: what.into(),
        value,
        usual,
        typical,
        shown,
        about: "",
        keys: Vec::new(),
        unit: "",
        power: 1.0,
        example: None,
        depends: &[],
    }
}

impl Judged<'static> {
    /// The same from keys of this unit.
    fn from(self, keys: &[&str], unit: &'static str, example: Option<f64>) -> Self {
        let keys = keys.iter().map(|key| (*key).to_owned()).collect();
        Self {
            keys,
            unit,
            example,
            ..self
        }
    }
}

fn of_flow(case: &ResolvedCase, figures: &CaseFigures, found: &mut Vec<Judged<'static>>) {
    let (Some(flow), Some(vessel)) = (figures.flow.filter(|flow| flow.peak > 0.0), case.vessel())
    else {
        return;
    };
    let inlet = vessel.condition_at(VesselSide::Start);
    let Some(inflow) = inlet.inflow(case.time.period) else {
        return;
    };
    let (names, example): (&[&str], _) = match (&inflow.file, inflow.base) {
        (Some(_), _) => (&["flow_file"], None),
        (None, 0.0) => (&["amplitude_m3_s"], Some(inflow.amplitude)),
        (None, base) => (&["base_m3_s", "amplitude_m3_s"], Some(base)),
    };
    let key = |name: &&str| vessel.opening_key(VesselSide::Start, name);
    let keys: Vec<String> = names.iter().map(key).collect();
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    let what = "the highest velocity of the blood, on average over a cross-section,";
    let velocity = following(what, flow.velocity[1], [2e-3, 4.0], 0.4, VELOCITY);
    found.push(velocity.from(&keys, "m³/s", example));
}

fn of_outlet(case: &ResolvedCase, figures: &CaseFigures, found: &mut Vec<Judged<'static>>) {
    let Some(vessel) = case.vessel() else {
        return;
    };
    let outlet = vessel.prescribed_at(VesselSide::End, case.time.period);
    let Ok(Condition::Pressure(elements)) = outlet else {
        return;
    };
    let mean_flow = figures.flow.map_or(0.0, |flow| flow.mean);
    let resistance = (elements.distal).map_or(elements.proximal, |(resistance, _)| resistance);
    let key = |name: &str| vessel.opening_key(VesselSide::End, name);
    if let (Some(pressures), true) = (figures.pressures, mean_flow != 0.0 && resistance > 0.0) {
        let what = "the expected mean pressure, all resistances times the mean flow,";
        let mean = following(what, pressures.mean, [1.3e3, 2.7e4], 1.25e4, MMHG);
        found.push(Judged {
            depends: &["inflow.file", "inflow.base_m3_s", "inflow.amplitude_m3_s"],
            ..mean.from(&[&key("resistance_Pa_s_m3")], "Pa s/m³", Some(resistance))
        });
    }
    of_windkessel(case, &elements, vessel.start(), key, found);
}

/// What a windkessel begins with, how its resistance divides, and its time constant.
fn of_windkessel(
    case: &Case,
    elements: &PressureModel,
    start: Start,
    key: impl Fn(&str) -> String,
    found: &mut Vec<Judged<'static>>,
) {
    let Some((resistance, compliance)) = elements.distal else {
        return;
    };
    let high = match start {
        Start::Equilibrium => 2.7e4,
        // A ramp scales it, and draws on it: it may be far above what follows.
        Start::Ramp => 1e5,
    };
    let start = following("", elements.initial, [1.3e3, high], 1.1e4, MMHG).from(
        &[&key("initial_pressure_Pa")],
        "Pa",
        Some(elements.initial),
    );
    found.push(Judged {
        about: "the pressure with which a windkessel begins",
        ..start
    });
    let share = following(
        "the proximal share of the resistance",
        elements.proximal / resistance,
        [1e-3, 3.0],
        0.1,
        SI,
    );
    let keys = ["proximal_resistance_Pa_s_m3", "resistance_Pa_s_m3"].map(&key);
    let keys = [&*keys[0], &*keys[1]];
    found.push(share.from(&keys, "Pa s/m³", Some(elements.proximal)));
    let beats = resistance * compliance / case.time.period;
    let beats = following(
        "the windkessel's time constant R C, in beats,",
        beats,
        [0.01, 100.0],
        1.0,
        SI,
    );
    let keys = ["compliance_m3_Pa", "resistance_Pa_s_m3"].map(&key);
    let keys = [&*keys[0], &*keys[1]];
    found.push(Judged {
        depends: &["time.period_s"],
        ..beats.from(&keys, "m³/Pa", Some(compliance))
    });
}

/// Thickness and stiffness of the walls.
fn of_walls(case: &ResolvedCase, figures: &CaseFigures, found: &mut Vec<Judged<'static>>) {
    let values = case.values();
    let is_of = |name: &str, path: &str| {
        let section = values.iter().find_map(|(path, key, value)| {
            let is_it = key.path == "vessel.section[].name" && value.as_str() == Some(name);
            is_it.then(|| path.trim_end_matches("name"))
        });
        match (section, name) {
            (Some(section), _) => path.starts_with(section) && path.contains(".thicknesses"),
            (None, "graft") => path == "geometry.graft_thickness_m",
            (None, _) => {
                path == "geometry.media_thickness_m" || path == "geometry.adventitia_thickness_m"
            }
        }
    };
    for wall in &figures.walls {
        let keys: Vec<_> = values
            .iter()
            .filter(|(path, ..)| is_of(&wall.name, path))
            .collect();
        let example = keys
            .first()
            .and_then(|(.., value)| value.as_float().or(value.as_array()?.first()?.as_float()));
        let unit = if keys.iter().all(|(path, ..)| path.ends_with("_m")) {
            "m"
        } else {
            ""
        };
        let paths: Vec<&str> = keys.iter().map(|(path, ..)| path.as_str()).collect();
        let what = format!(
            "the thickness of the wall relative to the radius of the lumen in the section {}",
            wall.name
        );
        found.push(
            following(what, wall.thickness_ratio, [0.01, 0.8], 0.15, SI)
                .from(&paths, unit, example),
        );
        let what = format!("the speed of pulse waves in the section {}", wall.name);
        // A wall with faster ones than 200 m/s is meant to be rigid.
        if let Some(speed) = wall.wave_speed.filter(|speed| *speed < 200.0) {
            let speed = following(what, speed, [1.0, 60.0], 7.0, VELOCITY);
            found.push(Judged {
                depends: OF_WAVES,
                ..speed
            });
        }
    }
}

/// What the speed of waves, and whether a wall carries its pressure, follow from.
const OF_WAVES: &[&str] = &[
    "density_kg_m3",
    "mu_Pa",
    "kappa_Pa",
    "k1_Pa",
    "youngs_modulus_Pa",
    "thickness_m",
    "thicknesses_m",
    "thicknesses",
    "resistance_Pa_s_m3",
    "pressure_Pa",
    "m3_s",
    "file",
];

/// Sections whose wall does not carry the pressures that are to be expected, if these are those of vessels.
fn bursting(figures: &CaseFigures) -> Option<String> {
    let highest = figures.pressures?.highest;
    let walls = figures
        .walls
        .iter()
        .filter(|wall| wall.highest_radius.is_none());
    let names: Vec<&str> = walls.map(|wall| wall.name.as_str()).collect();
    (!names.is_empty() && (0.0..4e4).contains(&highest)).then(|| {
        format!(
            "the wall of {}, taken as a long tube, cannot carry the expected {} mmHg: its materials are too soft, or it is too thin",
            names.join(", "),
            digits(highest / MMHG.1)
        )
    })
}

/// Beat, steps and end of a pulsating flow.
fn of_times(case: &Case, figures: &CaseFigures, found: &mut Vec<Judged<'static>>) {
    let time = &case.time;
    let pulses =
        |flow: super::case_figures::FlowFigures| flow.range[1] - flow.range[0] > 1e-3 * flow.peak;
    if !figures.flow.is_some_and(pulses) {
        return;
    }
    let beat = following("", time.period, [0.25, 4.0], 0.9, SI).from(
        &["time.period_s"],
        "s",
        Some(time.period),
    );
    found.push(Judged {
        about: "the duration of a beat",
        ..beat
    });
    let steps = following(
        "the number of steps in a beat",
        time.period / time.step,
        [20.0, 1e5],
        1e3,
        SI,
    );
    found.push(Judged {
        power: -1.0,
        ..steps.from(&["time.step_s", "time.period_s"], "s", Some(time.step))
    });
    let beats = following(
        "the number of beats",
        time.end / time.period,
        [0.0, 200.0],
        3.0,
        SI,
    );
    found.push(beats.from(&["time.end_s", "time.period_s"], "s", Some(time.end)));
}

/// How far a value is from its range, in powers of e; 0 of none.
fn off(value: f64, [low, high]: [f64; 2]) -> f64 {
    match value.abs() {
        0.0 => 0.0,
        value if value < low => (low / value).ln(),
        value if value > high => (value / high).ln(),
        _ => 0.0,
    }
}

impl Judged<'_> {
    /// The unit that was probably meant: one that brings the value near its range, the nearer to what is to be expected
    /// the better, and rather one that many use.
    fn slip(&self) -> Option<Slip> {
        let now = off(self.value, self.usual);
        // Of what is only a little off no unit is to blame.
        if now < if self.what.is_empty() { 0.6 } else { 1.6 } {
            return None;
        }
        let meant = |slip: &Slip| self.value * slip.1.powf(self.power);
        let all = SLIPS.iter().find(|(unit, _)| *unit == self.unit)?.1.iter();
        let near = all
            .enumerate()
            .filter(|(_, slip)| off(meant(slip), self.usual) < NEAR.min(0.5 * now));
        let rank = |(place, slip): &(usize, &Slip)| {
            RARER * *place as f64 + (meant(slip) / self.typical).abs().ln().abs()
        };
        near.min_by(|a, b| rank(a).total_cmp(&rank(b)))
            .map(|(_, slip)| *slip)
    }

    /// What is to be told, if the value is out of its range.
    fn sentence(&self, case: &ResolvedCase) -> Option<String> {
        if off(self.value, self.usual) == 0.0 {
            return None;
        }
        let si = self.unit.split(" of ").next().unwrap_or_default();
        let (unit, size) = match (self.shown, self.what.is_empty()) {
            (("", size), true) => (si, size),
            (shown, _) => shown,
        };
        let in_unit = |value: f64| {
            format!("{} {unit}", digits(value / size))
                .trim_end()
                .to_owned()
        };
        let usual = match self.usual {
            [0.0, high] => format!("at most {}", in_unit(high)),
            [low, f64::INFINITY] => format!("at least {}", in_unit(low)),
            [low, high] => format!("{} to {}", digits(low / size), in_unit(high)),
        };
        let keys = self.keys.iter().map(|key| {
            let place = case
                .origins
                .get(key)
                .map_or(String::new(), |place| format!(" ({place})"));
            format!("{key}{place}")
        });
        let keys = keys.collect::<Vec<_>>().join(", ");
        let mut text = match (self.what.is_empty(), unit == si) {
            (true, true) => format!(
                "{keys} is {}; {} is {usual} as a rule",
                in_unit(self.value),
                self.about
            ),
            (true, false) => format!(
                "{keys}: {} {si} is {}; {} is {usual} as a rule",
                digits(self.value),
                in_unit(self.value),
                self.about
            ),
            (false, _) => format!(
                "{} is {}, not {usual} as usual",
                self.what,
                in_unit(self.value)
            ),
        };
        if !self.what.is_empty() && !keys.is_empty() {
            text += &format!(": look at {keys}");
        }
        if let Some((slip, factor)) = self.slip() {
            text += &match self.example {
                Some(given) => format!(
                    "; {} {slip} is {} {si}",
                    digits(given),
                    digits(given * factor)
                ),
                None => format!("; is it in {slip}?"),
            };
        }
        Some(text)
    }
}

/// A number with five digits at most.
pub(super) fn digits(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.3e}");
        let (mantissa, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!(
            "{}e{power}",
            mantissa.trim_end_matches('0').trim_end_matches('.')
        );
    }
    let decimals = match size {
        0.0 => 0,
        s if s >= 100.0 => 0,
        s if s >= 1.0 => 2,
        s => (2.0 - s.log10().floor()) as usize,
    };
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}
