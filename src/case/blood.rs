//! The keys of the blood, and its viscosity by rate of shear.

use super::schema::{ValueKind, above, from};
use crate::{table, words};
pub use fsi_spectral::Rheology;

table! {
    /// The blood.
    pub struct Blood {
        density: f64 = "density_kg_m3", above(0.0, 1e5), "density of the blood";
        /// At high rates of shear, if it depends on them.
        viscosity: f64 = "viscosity_Pa_s", above(0.0, 1e3), "dynamic viscosity of the blood", only NOT_OWN;
        model: Option<BloodModel> = "model", ValueKind::Word(BloodModel::WORDS), "how its viscosity depends on the rate of shear",
            absent "newtonian", only NOT_OWN;
        /// The largest one, of any model that thins with shear.
        at_rest: Option<f64> = "zero_shear_viscosity_Pa_s", above(0.0, 1e5),
            "viscosity at zero shear rate, of carreau_yasuda; largest viscosity of the others", absent "100 times blood.viscosity_Pa_s";
        relaxation_time: Option<f64> = "relaxation_time_s", above(0.0, 1e5), "time lambda of carreau_yasuda", absent "none";
        exponent: Option<f64> = "exponent", from(0.05, 2.0), "exponent n of carreau_yasuda and power_law", absent "none";
        yasuda: Option<f64> = "yasuda_exponent", from(0.1, 20.0), "exponent a of carreau_yasuda", absent "2: Carreau's";
        yield_stress: Option<f64> = "yield_stress_Pa", from(0.0, 1e4), "yield stress of casson", absent "none";
        consistency: Option<f64> = "consistency_Pa_sn", above(0.0, 1e5), "consistency k of power_law", absent "none";
    }
}

words! {
    /// How the viscosity depends on the rate of shear `γ = sqrt(2 D:D)`.
    #[derive(Default)]
    pub enum BloodModel {
        /// Constant viscosity.
        Newtonian = "newtonian" (default),
        /// Carreau's and Yasuda's: `mu + (mu0 - mu) (1 + (λ γ)^a)^((n - 1)/a)`.
        CarreauYasuda = "carreau_yasuda",
        /// Casson's: `(sqrt(yield stress/γ) + sqrt(mu))²`, at most the one without shear.
        Casson = "casson",
        /// `k γ^(n - 1)`, between that at high rates and the one without shear.
        PowerLaw = "power_law",
    }
}

/// The viscosity without shear relative to that at high rates, by default.
const AT_REST: f64 = 100.0;

impl Blood {
    /// Blood of one density (kg/m³) and viscosity (Pa s).
    pub const fn newtonian(density: f64, viscosity: f64) -> Self {
        Self {
            density,
            viscosity,
            model: None,
            at_rest: None,
            relaxation_time: None,
            exponent: None,
            yasuda: None,
            yield_stress: None,
            consistency: None,
        }
    }

    /// Its viscosity by rate of shear. What a model needs and has not is refused before.
    pub fn rheology(&self) -> Rheology {
        let high = self.viscosity;
        let at_rest = self.at_rest.unwrap_or(AT_REST * high);
        match self.model.unwrap_or_default() {
            BloodModel::Newtonian => Rheology::Newtonian { viscosity: high },
            BloodModel::CarreauYasuda => Rheology::CarreauYasuda {
                high,
                at_rest,
                time: self.relaxation_time.unwrap_or(1.0),
                n: self.exponent.unwrap_or(1.0),
                a: self.yasuda.unwrap_or(2.0),
            },
            BloodModel::Casson => Rheology::Casson {
                high,
                at_rest,
                yield_stress: self.yield_stress.unwrap_or(0.0),
            },
            BloodModel::PowerLaw => Rheology::PowerLaw {
                high,
                at_rest,
                k: self.consistency.unwrap_or(high),
                n: self.exponent.unwrap_or(1.0),
            },
        }
    }
}
