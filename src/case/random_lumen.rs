//! The keys of a lumen whose radius is a Gaussian random field: the table `[random_lumen]`.

use super::schema::{ValueKind, above, from, whole};
use super::{Case, Problem};
use crate::uncertainty::{Covariance, RandomField};
use crate::{table, words};

/// Most modes of a field.
const MOST_MODES: usize = 100;

table! {
    /// The lumen's radius is larger by a Gaussian random field, of which this case has one realization: amplitudes of
    /// its modes (Karhunen-Loève), which are independent standard normal variables.
    pub struct RandomLumen {
        deviation: f64 = "standard_deviation_m", above(0.0, 0.1), "standard deviation of the radius, where nothing fades";
        along: f64 = "length_along_m", above(0.0, 10.0), "correlation length along the vessel: over it, the correlation falls to 1/e";
        around_deg: Option<f64> = "angle_around_deg", above(0.0, 180.0), "correlation angle around", absent "none: cross-sections stay as round as they are";
        from: f64 = "from_m", from(-10.0, 10.0), "arc length s where the field begins";
        to: f64 = "to_m", from(-10.0, 10.0), "arc length s where it ends";
        /// By half a cosine at either end.
        fade: Option<f64> = "fade_m", above(0.0, 10.0), "length over which the field fades to zero at its ends",
            absent "length_along_m, at most a quarter of the part";
        modes: usize = "modes", whole(1, MOST_MODES as i64), "how many modes are kept, those with the largest variance";
        amplitudes: Vec<f64> = "amplitudes", ValueKind::Amplitudes(MOST_MODES), "amplitudes of the modes, in standard deviations; those that are left out are 0",
            absent "0 of all modes";
        wall: Option<RandomWall> = "wall", ValueKind::Word(RandomWall::WORDS), "what the wall does", absent "thickens";
    }
}

words! {
    /// What the wall does where the lumen's radius is random.
    #[derive(Default)]
    pub enum RandomWall {
        /// Its outer surface stays: it is thicker where the lumen is narrower, as in an imperfection or a stenosis.
        Thickens = "thickens" (default),
        /// It moves with the lumen, and keeps its thickness.
        Moves = "moves",
    }
}

impl Case {
    /// Gives all modes of a random lumen an amplitude.
    pub(super) fn fill_amplitudes(&mut self) {
        if let Problem::Vessel(vessel) = &mut self.problem
            && let Some(keys) = &mut vessel.random_lumen
        {
            let all = keys.modes.max(keys.amplitudes.len());
            keys.amplitudes.resize(all, 0.0);
        }
    }
}

impl RandomLumen {
    /// Length (m) over which the field fades at either end.
    pub fn fade(&self) -> f64 {
        let usual = self.along.min(0.25 * (self.to - self.from));
        self.fade.unwrap_or(usual)
    }

    /// How the radius varies, in m and rad.
    pub fn covariance(&self) -> Covariance {
        Covariance {
            deviation: self.deviation,
            range: [self.from, self.to],
            fade: self.fade(),
            along: self.along,
            around: self.around_deg.map(f64::to_radians),
        }
    }

    /// Its modes; `None` if the correlation length is too short for the part.
    pub fn field(&self) -> Option<RandomField> {
        RandomField::new(self.covariance(), self.modes)
    }
}
