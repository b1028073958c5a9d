//! Measures of a region with the units in which people know them.

use super::page::significant;
use crate::hemodynamics::Place;
use crate::hemodynamics::summary::{Course, RegionSummary};

/// A measure.
pub struct Quantity {
    /// Its name with its unit.
    pub name: &'static str,
    /// Its value, as people read it.
    pub show: fn(&RegionSummary) -> String,
}

/// What stands for a value that there is not.
pub const UNKNOWN: &str = "–";

/// A place as people read it.
fn place(region: &RegionSummary, at: Place) -> String {
    region.told(at).replace('-', "\u{2212}")
}

fn four(value: f64) -> String {
    significant(value, 4)
}

/// The measures of the table of a run.
pub fn all() -> Vec<Quantity> {
    let quantity = |name, show| Quantity { name, show };
    vec![
        quantity("TAWSS, mean / Pa", |r| four(r.TAWSS_Pa.mean)),
        quantity("TAWSS, largest / Pa", |r| {
            format!(
                "{}<br>{}",
                four(r.TAWSS_Pa.max),
                place(r, r.TAWSS_Pa.max_at)
            )
        }),
        quantity("TAWSS, smallest / Pa", |r| four(r.TAWSS_Pa.min)),
        quantity("OSI, mean", |r| four(r.OSI.mean)),
        quantity("OSI, largest", |r| {
            format!("{}<br>{}", four(r.OSI.max), place(r, r.OSI.max_at))
        }),
        quantity("RRT, mean / (1/Pa)", |r| four(r.RRT_1_Pa.mean)),
        quantity("RRT, largest / (1/Pa)", |r| {
            format!(
                "{}<br>{}",
                four(r.RRT_1_Pa.max),
                place(r, r.RRT_1_Pa.max_at)
            )
        }),
        quantity("wall shear stress, largest in time and space / Pa", |r| {
            let peak = r.max_wall_shear_Pa;
            format!(
                "{}<br>t = {:.3} s<br>{}",
                four(peak.max),
                peak.time_s,
                place(r, peak.at)
            )
        }),
        quantity("von Mises stress, largest in time and space / kPa", |r| {
            let peak = r.max_von_mises_Pa;
            format!(
                "{}<br>t = {:.3} s<br>{}",
                four(1e-3 * peak.max),
                peak.time_s,
                place(r, peak.at)
            )
        }),
        quantity("displacement, largest / mm", |r| {
            four(1e3 * r.max_displacement_m.max)
        }),
        quantity("lumen volume, smallest to largest / ml", |r| {
            let shown = |volume: Course| {
                format!("{} to {}", four(1e6 * volume.min), four(1e6 * volume.max))
            };
            r.lumen_volume_m3.map_or(UNKNOWN.into(), shown)
        }),
    ]
}
