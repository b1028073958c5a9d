//! How far the vessel of a case is from the files that it was made from.

use super::files::VesselSizes;
use super::{ProposalError, ProposalInput};
use crate::case::{BloodVessel, Shape, VesselDescription};
use crate::files::Fault;
use crate::polydata::{PolyData, Surface};
use std::f64::consts::TAU;

/// Changes above this share are pointed out.
const NOTABLE: f64 = 0.02;
/// Points that are moved by more than this share of the radius make another vessel.
const MOST: f64 = 0.5;
/// Cross-sections and rays in which a surface is compared with the lumen.
const SECTIONS: usize = 200;
const RAYS: usize = 72;
/// At both ends of the line, so many radii are not compared with the surface, which may be closed there.
const ENDS: f64 = 1.5;
/// What closes a surface stands across the vessel: cosine of its normal and the centre-line.
const CLOSING: f64 = 0.9;

/// The largest changes.
pub struct Changes {
    /// Lengths (m) of the polygon through the points of the file and of the centre-line of the case.
    pub lengths: [f64; 2],
    /// How far a point of the file lies from the centre-line: in metres, and as a share of the radius there.
    pub moved: [f64; 2],
    /// Length (m) of the waves that are halved.
    pub smoothing: f64,
    /// Of the radius, as a share of that of the file: the radius there (m) in the file and in the case.
    pub radius: Option<(f64, [f64; 2])>,
}

impl Changes {
    /// Those of a vessel from files; `None` without.
    ///
    /// # Errors
    /// If the surface cannot be read.
    pub fn of(
        keys: &BloodVessel,
        sizes: &VesselSizes,
        input: &ProposalInput,
    ) -> Result<Option<Self>, ProposalError> {
        let (Some(line), Shape::Vessel(vessel)) = (&sizes.line, &keys.shape) else {
            return Ok(None);
        };
        let curve = vessel.curve();
        let law = vessel.radius_law(&curve);
        let [start, end] = curve.ends();
        let (mut moved, mut radius) = ([0.0f64; 2], None::<(f64, [f64; 2])>);
        let compare = |radius: &mut Option<(f64, [f64; 2])>, before: f64, now: f64| {
            let share = (now / before - 1.0).abs();
            if radius.is_none_or(|(most, _)| share > most) {
                *radius = Some((share, [before, now]));
            }
        };
        let counts = input.radius.is_none() && input.lumen.is_none();
        for (i, point) in line.points().enumerate() {
            let nearest = curve.nearest(&point);
            let over = (start - nearest.s).max(nearest.s - end).max(0.0);
            let away = nearest.across[0].hypot(nearest.across[1]).hypot(over);
            let here = law.at(nearest.s.clamp(start, end));
            moved = [moved[0].max(away), moved[1].max(away / here)];
            if let Some(before) = line.radii().get(i).filter(|_| counts) {
                compare(&mut radius, *before, here);
            }
        }
        if let Some(path) = &input.lumen {
            let wrong = |e: Fault| format!("--lumen {}: {e}", path.display());
            let unit = input.lumen_unit.or(input.unit);
            let unit = unit.map_or(1.0, |unit| unit.metres());
            let data = PolyData::read(path).map_err(wrong)?;
            let surface = Surface::new(&data, unit).map_err(wrong)?;
            for [before, now] in on_rays(vessel, keys, &surface, sizes.radius) {
                compare(&mut radius, before, now);
            }
        }
        Ok(Some(Self {
            lengths: [line.polygon(), end - start],
            moved,
            smoothing: sizes.smoothing.unwrap_or(0.0),
            radius,
        }))
    }

    /// Whether it is another vessel.
    pub fn is_another(&self) -> bool {
        self.moved[1] > MOST
    }

    /// What a user should know.
    pub fn remarks(&self) -> Vec<String> {
        let [before, now] = self.lengths;
        let longer = now / before - 1.0;
        let radius = self.radius.map_or(String::new(), |(share, [before, now])| {
            format!(
                ", radius by up to {:.1} % ({:.3} to {:.3} mm)",
                100.0 * share,
                1e3 * before,
                1e3 * now
            )
        });
        let mut remarks = vec![format!(
            "changed   length from {:.2} (polygon of the points) to {:.2} mm ({:+.1} %), points by up to {:.3} mm ({:.1} % of the \
             radius){radius}",
            1e3 * before,
            1e3 * now,
            100.0 * longer,
            1e3 * self.moved[0],
            100.0 * self.moved[1]
        )];
        let all = [
            ("the length", longer.abs()),
            ("the place of points", self.moved[1]),
            ("the radius", self.radius.map_or(0.0, |(share, _)| share)),
        ];
        let notable: Vec<&str> = all
            .iter()
            .filter(|(_, share)| *share > NOTABLE)
            .map(|(name, _)| *name)
            .collect();
        if !notable.is_empty() {
            remarks.push(format!(
                "warning: smoothing changes {} by more than {:.0} %; is that scatter of the files, or shape? --smoothing sets \
                 its length",
                notable.join(" and "),
                100.0 * NOTABLE
            ));
        }
        remarks
    }
}

/// Radii of the surface and of the lumen along rays from the centre-line.
fn on_rays<'a>(
    vessel: &'a VesselDescription,
    keys: &BloodVessel,
    surface: &'a Surface,
    radius: f64,
) -> impl Iterator<Item = [f64; 2]> + 'a {
    // As the case has it, without what it puts onto its lumen.
    let mut plain = keys.clone();
    if let Shape::Vessel(vessel) = &mut plain.shape {
        vessel.feature = None;
    }
    let lumen = crate::geometry::Vessel::new(&plain);
    let curve = vessel.curve();
    let [start, end] = curve.ends();
    let ends = ENDS * radius;
    (0..=SECTIONS).flat_map(move |i| {
        let share = i as f64 / SECTIONS as f64;
        let s = start + ends + share * (end - start - 2.0 * ends).max(0.0);
        let frame = curve.frame(s);
        let rays = surface.rays(&frame.origin, [&frame.first, &frame.second], RAYS);
        let found = rays.into_iter().enumerate().filter_map(|(j, crossing)| {
            let crossing = crossing.filter(|c| c.slant < CLOSING)?;
            let phi = TAU * j as f64 / RAYS as f64;
            Some([crossing.radius, lumen.lumen_radius(s - start, phi)])
        });
        found.collect::<Vec<_>>()
    })
}
