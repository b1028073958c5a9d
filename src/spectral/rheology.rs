//! Viscosity by rate of shear.

/// No rate of shear is smaller, 1/s.
const LEAST_RATE: f64 = 1e-12;

/// Dynamic viscosity (Pa s) as a function of the rate of shear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rheology {
    /// The same at all rates.
    Newtonian {
        /// Viscosity, Pa s.
        viscosity: f64,
    },
    /// Carreau (1972), Yasuda (1979).
    CarreauYasuda {
        /// Viscosity at high rates, Pa s.
        high: f64,
        /// Viscosity without shear, Pa s.
        at_rest: f64,
        /// λ, s.
        time: f64,
        /// n.
        n: f64,
        /// a.
        a: f64,
    },
    /// Casson (1959).
    Casson {
        /// Viscosity at high rates, Pa s.
        high: f64,
        /// The largest viscosity, Pa s.
        at_rest: f64,
        /// Yield stress, Pa.
        yield_stress: f64,
    },
    /// Ostwald (1925), de Waele (1923).
    PowerLaw {
        /// The smallest viscosity of a fluid that thins, Pa s.
        high: f64,
        /// The largest one, Pa s.
        at_rest: f64,
        /// k, Pa sⁿ.
        k: f64,
        /// n.
        n: f64,
    },
}

impl Rheology {
    /// Dynamic viscosity (Pa s) at a rate of shear (1/s).
    pub fn viscosity(&self, rate: f64) -> f64 {
        let rate = rate.max(LEAST_RATE);
        match *self {
            Self::Newtonian { viscosity } => viscosity,
            Self::CarreauYasuda {
                high,
                at_rest,
                time,
                n,
                a,
            } => high + (at_rest - high) * (1.0 + (time * rate).powf(a)).powf((n - 1.0) / a),
            Self::Casson {
                high,
                at_rest,
                yield_stress,
            } => ((yield_stress / rate).sqrt() + high.sqrt())
                .powi(2)
                .clamp(high, at_rest),
            Self::PowerLaw {
                high,
                at_rest,
                k,
                n,
            } => (k * rate.powf(n - 1.0)).clamp(high, at_rest),
        }
    }

    /// The viscosity, if it is the same at all rates.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Newtonian { viscosity } => Some(*viscosity),
            _ => None,
        }
    }
}

/// Dynamic viscosity, Pa s.
pub enum ViscosityField {
    /// The same everywhere.
    Constant(f64),
    /// At the Gauss points.
    AtGauss(Vec<f64>),
}
