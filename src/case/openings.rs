//! The tables of where the blood enters and leaves a vessel of two openings, which are another way to write the list of
//! `opening.rs`; curves of pressure, and units.

use super::schema::{ValueKind, above, from};
use super::{Case, PeriodicTable, TableError};
use crate::tabular::units::{self, Unit};
use crate::{table, words};
use std::path::PathBuf;

table! {
    /// Flow at the inlet: `base + amplitude sin²(pi (t/systole)^exponent)` for t < systole within a period, then
    /// `base`; or a curve from a file with a column of times and one of flows over one period.
    pub struct Inflow {
        base: f64 = "base_m3_s", from(-1.0, 1.0), "flow outside systole", only FORMULA;
        amplitude: f64 = "amplitude_m3_s", from(-1.0, 1.0), "height of the pulse above the base", only FORMULA;
        systole: f64 = "systole_s", above(0.0, 100.0), "duration of the pulse", only PULSE;
        exponent: f64 = "exponent", from(0.1, 10.0), "exponent that makes the rise faster than the fall", only PULSE;
        file: Option<PathBuf> = "file", ValueKind::Path, "CSV file of the flow over one period, or a .flow of SimVascular",
            absent "the formula of the other keys";
        unit: Option<FlowUnit> = "unit", ValueKind::Word(FlowUnit::WORDS), "unit of the flows in that file",
            absent "that in its header, such as flow_m3_s; of a .flow cm3/s";
        file_period: Option<f64> = "file_period_s", above(0.0, 1e3),
            "period of the curve in that file, which is stretched to time.period_s", absent "time.period_s";
        mean: Option<f64> = "mean_m3_s", from(-1.0, 1.0), "mean flow over a period, to which the curve is scaled",
            absent "the curve as it is";
    }
}

table! {
    /// What drives the blood at the inlet.
    #[derive(Default)]
    pub struct Inlet {
        condition: Option<InletCondition> = "condition", ValueKind::Word(InletCondition::WORDS),
            "what is prescribed at the inlet", absent "flow";
        profile: Option<InletProfile> = "profile", ValueKind::Word(InletProfile::WORDS),
            "how a prescribed flow is spread over the inlet", absent "plug";
        pressure: Option<f64> = "pressure_Pa", from(-1e6, 1e6), "prescribed pressure, constant", absent "inlet.file";
        file: Option<PathBuf> = "file", ValueKind::Path, "CSV file of the prescribed pressure over one period",
            absent "inlet.pressure_Pa";
        unit: Option<PressureUnit> = "unit", ValueKind::Word(PressureUnit::WORDS), "unit of the pressures in that file",
            absent "that in its header, such as pressure_Pa";
        file_period: Option<f64> = "file_period_s", above(0.0, 1e3),
            "period of the curve in that file, which is stretched to time.period_s", absent "time.period_s";
    }
}

words! {
    /// What is prescribed at the inlet.
    #[derive(Default)]
    pub enum InletCondition {
        /// The flow of `[inflow]`.
        Flow = "flow" (default),
        /// The static pressure, `inlet.pressure_Pa` or `inlet.file`; the flow follows.
        Pressure = "pressure",
    }
}

words! {
    /// How a prescribed flow is spread over the inlet.
    #[derive(Default)]
    pub enum InletProfile {
        /// The same velocity everywhere.
        Plug = "plug" (default),
        /// Poiseuille's parabola at all times.
        Parabolic = "parabolic",
        /// Womersley's profile for each harmonic of the curve: that of a long rigid tube.
        Womersley = "womersley",
    }
}

table! {
    /// What the blood finds at the outlet.
    #[derive(Default)]
    pub struct Outlet {
        condition: Option<OutletCondition> = "condition", ValueKind::Word(OutletCondition::WORDS),
            "what is prescribed at the outlet", absent "windkessel";
        resistance: Option<f64> = "resistance_Pa_s_m3", above(0.0, 1e15), "resistance R of a pure resistance", absent "none";
        pressure: Option<f64> = "pressure_Pa", from(-1e6, 1e6),
            "constant prescribed pressure; downstream of a resistance the venous one", absent "0 downstream of a resistance; otherwise outlet.file";
        file: Option<PathBuf> = "file", ValueKind::Path, "CSV file of the prescribed pressure over one period",
            absent "outlet.pressure_Pa";
        unit: Option<PressureUnit> = "unit", ValueKind::Word(PressureUnit::WORDS), "unit of the pressures in that file",
            absent "that in its header, such as pressure_Pa";
        file_period: Option<f64> = "file_period_s", above(0.0, 1e3),
            "period of the curve in that file, which is stretched to time.period_s", absent "time.period_s";
    }
}

words! {
    /// What is prescribed at the outlet.
    #[derive(Default)]
    pub enum OutletCondition {
        /// The windkessel of `[windkessel]`, of two elements or three.
        Windkessel = "windkessel" (default),
        /// A pressure that is proportional to the flow, `p = outlet.pressure_Pa + R Q`.
        Resistance = "resistance",
        /// A pressure, `outlet.pressure_Pa` or `outlet.file`.
        Pressure = "pressure",
    }
}

table! {
    /// `C dp/dt + p/R = Q` at the outlet, where the pressure is `p + R_p Q`.
    pub struct Windkessel {
        resistance: f64 = "resistance_Pa_s_m3", above(0.0, 1e15), "resistance R of the windkessel";
        compliance: f64 = "compliance_m3_Pa", above(0.0, 1.0), "compliance C of the windkessel";
        /// Before the ramp.
        initial_pressure: f64 = "initial_pressure_Pa", from(-1e6, 1e6), "pressure of the windkessel at t = 0";
        /// Three elements: RCR.
        proximal: Option<f64> = "proximal_resistance_Pa_s_m3", from(0.0, 1e15),
            "proximal resistance, the third element of the windkessel", absent "0";
    }
}

words! {
    /// A unit of flow.
    pub enum FlowUnit {
        /// Cubic metres per second.
        CubicMetreSecond = "m3/s",
        /// Cubic centimetres per second.
        CubicCentimetreSecond = "cm3/s",
        /// Cubic millimetres per second.
        CubicMillimetreSecond = "mm3/s",
        /// Millilitres per second.
        MillilitreSecond = "ml/s",
        /// Millilitres per minute.
        MillilitreMinute = "ml/min",
        /// Litres per second.
        LitreSecond = "l/s",
        /// Litres per minute.
        LitreMinute = "l/min",
    }
}

impl Inflow {
    /// A pulse of the formula: flows in m³/s, the duration of the systole in s.
    pub fn pulse(base: f64, amplitude: f64, systole: f64, exponent: f64) -> Self {
        Self {
            base,
            amplitude,
            systole,
            exponent,
            file: None,
            unit: None,
            file_period: None,
            mean: None,
        }
    }

    /// The curve of a file, in the unit that the file says.
    pub fn of_file(file: PathBuf) -> Self {
        Self {
            file: Some(file),
            ..Self::pulse(0.0, 0.0, 1.0, 1.0)
        }
    }
}

impl FlowUnit {
    /// The unit in any usual spelling, such as `mL/sec` or `cm³ s⁻¹`.
    pub fn spelled(word: &str) -> Option<Self> {
        let unit = Unit::parse(word).filter(|unit| unit.dimension == units::FLOW)?;
        let is = |known: &Self| (known.si() / unit.size - 1.0).abs() < 1e-9;
        (Self::ALL.into_iter().find(|known| known.name() == word))
            .or_else(|| Self::ALL.into_iter().find(is))
    }

    /// In m³/s.
    pub fn si(self) -> f64 {
        Unit::known(self.name()).size
    }
}

words! {
    /// A unit of pressure.
    pub enum PressureUnit {
        /// Pascal.
        Pascal = "Pa",
        /// Kilopascal.
        Kilopascal = "kPa",
        /// Millimetres of mercury.
        MillimetreMercury = "mmHg",
        /// Dynes per square centimetre.
        DyneSquareCentimetre = "dyn/cm2",
        /// Centimetres of water.
        CentimetreWater = "cmH2O",
    }
}

impl PressureUnit {
    /// In Pa.
    pub fn si(self) -> f64 {
        Unit::known(self.name()).size
    }
}

/// A prescribed pressure over time, before any ramp.
#[derive(Debug, Clone, PartialEq)]
pub enum PressureCurve {
    /// The same at all times, Pa.
    Constant(f64),
    /// A periodic curve, Pa.
    Table(PeriodicTable),
}

impl PressureCurve {
    /// Of the keys of an opening.
    pub(super) fn new(
        file: Option<&PathBuf>,
        unit: Option<PressureUnit>,
        file_period: Option<f64>,
        constant: Option<f64>,
        period: f64,
    ) -> Result<Self, TableError> {
        match file {
            None => Ok(Self::Constant(constant.unwrap_or(0.0))),
            Some(path) => {
                PeriodicTable::of_pressure(path, unit, file_period, period).map(Self::Table)
            }
        }
    }

    /// Pressure (Pa) at the time `t` (s).
    pub fn pressure(&self, t: f64) -> f64 {
        match self {
            Self::Constant(pressure) => *pressure,
            Self::Table(table) => table.value(t),
        }
    }

    /// One period as pairs of time (s) and pressure (Pa) to interpolate linearly; see [`PeriodicTable::samples`].
    pub fn samples(&self, step: f64, period: f64) -> Vec<[f64; 2]> {
        match self {
            Self::Constant(pressure) => vec![[0.0, *pressure], [period, *pressure]],
            Self::Table(table) => table.samples(step).collect(),
        }
    }
}

impl Case {
    /// Whether nothing that drives the blood of a vessel changes after the ramp.
    pub fn is_driven_steadily(&self) -> bool {
        let openings = self
            .vessel()
            .map(|vessel| vessel.openings(self.time.period));
        let Some(Ok(openings)) = openings else {
            return false;
        };
        (openings.iter()).all(|opening| opening.condition.is_constant(self.time.step))
    }
}
