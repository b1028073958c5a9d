//! Stations along a tube: from displacements of wall points to radial displacements of cross-sections, and from
//! pressures of cross-sections to the wall.

use crate::Vec3;
use crate::curve::SpaceCurve;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// A tube that is held at both ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Its centre-line; it begins at the arc length 0.
    pub line: SpaceCurve,
    /// Its length along that, m.
    pub length: f64,
}

/// The wall points do not make a cross-section between the ends.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the wall has no ring of at least {LEAST_POINTS} points between its ends")]
pub struct NoRings;

/// A cross-section has at least so many points.
const LEAST_POINTS: usize = 3;
/// Waves around the circumference that are shorter than so many points are none to the fluid.
const POINTS_A_PERIOD: usize = 4;
/// Points of a ring lie at the same arc length up to this share of the distance to the next ring.
const RAGGED: f64 = 0.05;

/// What the fluid makes of the points of its wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurrogateWall {
    /// Faces between rings, as finite volumes have them: each moves as its points do on average, and each point is
    /// loaded by the average of the faces around it.
    Faces,
    /// Polynomials of this degree along the tube, through so many rings and one more each.
    Elements(usize),
}

/// Distances are as large as each other up to this share of the tube's length.
const NEARER: f64 = 1e-6;

/// How finely a displacement is resolved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StationOptions {
    /// Whose wall it is.
    pub shape: SurrogateWall,
    /// Most stations between the ends.
    pub most: usize,
    /// Most periods around the circumference.
    pub around: usize,
}

/// A place in a tube: looked for once, and used for all stations and waves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TubePlace {
    /// Arc length, m.
    arc: f64,
    /// Angle in the cross-section.
    angle: f64,
}

/// A wall point that belongs to a station.
#[derive(Debug, Clone, PartialEq)]
struct StationPoint {
    index: usize,
    /// Its share in the station.
    weight: f64,
    /// Radial direction.
    radial: Vec3,
    /// Angle in the cross-section.
    angle: f64,
    /// The values of all waves there.
    waves: Vec<f64>,
    /// Distance from the axis, m.
    radius: f64,
}

/// A cross-section between the ends.
#[derive(Debug, Clone, PartialEq)]
struct Station {
    points: Vec<StationPoint>,
    /// From the sums of radial displacement times [`wave`] over the points to the amplitudes of the waves.
    amplitudes: DMatrix<f64>,
}

/// Cross-sections of a tube at rings of wall points; between them a field is a polynomial of a degree in each piece, at
/// both ends of the tube it is zero. Around the circumference it is made of waves: 1, cos θ, sin θ, cos 2θ, sin 2θ, …
#[derive(Debug, Clone, PartialEq)]
pub struct Stations {
    axis: Axis,
    /// Arc lengths of all stations, both ends included, m.
    arcs: Vec<f64>,
    degree: usize,
    smoothing: f64,
    waves: usize,
    inner: Vec<Station>,
    /// Arc length of each point, m.
    places: Vec<f64>,
}

/// Periods around the circumference of a wave.
fn periods(wave: usize) -> usize {
    wave.div_ceil(2)
}

/// Wave 0 is 1, then cos θ, sin θ, cos 2θ, sin 2θ, …
fn wave(wave: usize, angle: f64) -> f64 {
    let (sin, cos) = (periods(wave) as f64 * angle).sin_cos();
    if wave > 0 && wave.is_multiple_of(2) {
        sin
    } else {
        cos
    }
}

impl Stations {
    /// Stations of the tube around `axis` whose wall consists of `points` (reference positions, m).
    pub fn new(points: &[Vec3], axis: Axis, options: StationOptions) -> Result<Self, NoRings> {
        let mut placed: Vec<(f64, StationPoint)> = (points.iter().enumerate())
            .map(|(index, x)| {
                let nearest = axis.line.nearest(x);
                let across = x - nearest.frame.origin;
                let point = StationPoint {
                    index,
                    weight: 1.0,
                    radial: across.normalize(),
                    angle: nearest.across[1].atan2(nearest.across[0]),
                    waves: Vec::new(),
                    radius: across.norm(),
                };
                (nearest.s, point)
            })
            .collect();
        let places = placed.iter().map(|(s, _)| *s).collect();
        placed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let arcs: Vec<f64> = placed.iter().map(|(s, _)| *s).collect();
        let Placement {
            arcs,
            degree,
            smoothing,
            members,
        } = match rings(&arcs, axis.length) {
            Some(rings) => at_rings(&arcs, rings, axis.length, options),
            None => evenly(&arcs, axis.length, options),
        };
        let count = |station: &Vec<(usize, f64)>| station.len();
        let fewest = members.iter().map(count).min().unwrap_or(0);
        if fewest < LEAST_POINTS {
            return Err(NoRings);
        }
        let waves = 2 * options.around.min(fewest / POINTS_A_PERIOD) + 1;
        let station = |members: Vec<(usize, f64)>| {
            let point = |(place, weight): (usize, f64)| {
                let point = placed[place].1.clone();
                StationPoint {
                    weight,
                    waves: (0..waves).map(|k| wave(k, point.angle)).collect(),
                    ..point
                }
            };
            let points: Vec<StationPoint> = members.into_iter().map(point).collect();
            let product = |i, j| {
                let at = |p: &StationPoint| p.weight * p.waves[i] * p.waves[j];
                points.iter().map(at).sum()
            };
            let gram = DMatrix::from_fn(waves, waves, product);
            Some(Station {
                amplitudes: gram.try_inverse()?,
                points,
            })
        };
        let inner: Option<Vec<Station>> = members.into_iter().map(station).collect();
        Ok(Self {
            inner: inner.ok_or(NoRings)?,
            axis,
            arcs,
            degree,
            smoothing,
            waves,
            places,
        })
    }

    /// The same with waves of at most so many periods around the circumference.
    #[must_use]
    pub fn with_periods(mut self, most: usize) -> Self {
        self.waves = self.waves.min(2 * most + 1);
        self
    }

    /// Number of stations between the ends.
    pub fn count(&self) -> usize {
        self.inner.len()
    }

    /// Number of waves around the circumference.
    pub fn waves(&self) -> usize {
        self.waves
    }

    /// Most periods of these around it.
    pub fn periods(&self) -> usize {
        periods(self.waves - 1)
    }

    /// Length of the tube, m.
    pub fn length(&self) -> f64 {
        self.axis.length
    }

    /// What the blood sees of a displacement with these amplitudes at the stations: the matrix that averages over the
    /// faces around each point; of waves that are long compared with them almost everything.
    pub fn smoothing(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.count(), self.count(), |i, j| match i.abs_diff(j) {
            0 => 1.0 - 2.0 * self.smoothing,
            1 => self.smoothing,
            _ => 0.0,
        })
    }

    /// Arc lengths (m) of the stations of each piece, those that it shares with its neighbours included, and the number
    /// of the first of them; 0 is the tube's beginning.
    pub fn pieces(&self) -> impl Iterator<Item = (usize, &[f64])> {
        let last = self.arcs.len() - 1;
        let starts = (0..last).step_by(self.degree);
        starts.map(move |first| (first, &self.arcs[first..=(first + self.degree).min(last)]))
    }

    /// Mean radius of each station in the reference configuration, m.
    pub fn reference_radius(&self) -> Vec<f64> {
        let mean = |station: &Station| {
            let points = station.points.iter();
            let (sum, weights) = points.fold((0.0, 0.0), |(sum, weights), point| {
                (sum + point.weight * point.radius, weights + point.weight)
            });
            sum / weights
        };
        self.inner.iter().map(mean).collect()
    }

    /// The radial displacement (m) of each station that fits the displacement `d` of all points (x0 y0 z0 x1 …) best in
    /// the sense of least squares: a row of amplitudes for each station, a column for each wave.
    pub fn amplitudes(&self, d: &DVector<f64>) -> DMatrix<f64> {
        let mut amplitudes = DMatrix::zeros(self.count(), self.waves);
        for (i, station) in self.inner.iter().enumerate() {
            let mut sums = DVector::zeros(station.amplitudes.nrows());
            for point in &station.points {
                let vector = Vec3::from_column_slice(&d.as_slice()[3 * point.index..][..3]);
                let radial = point.weight * vector.dot(&point.radial);
                for (sum, wave) in sums.iter_mut().zip(&point.waves) {
                    *sum += radial * wave;
                }
            }
            let fitted = &station.amplitudes * sums;
            for k in 0..self.waves {
                amplitudes[(i, k)] = fitted[k];
            }
        }
        amplitudes
    }

    /// Where in the tube `x` (m) is.
    pub fn place(&self, x: &Vec3) -> TubePlace {
        let nearest = self.axis.line.nearest(x);
        let [first, second] = nearest.across;
        TubePlace {
            arc: nearest.s,
            angle: second.atan2(first),
        }
    }

    /// The value at a place of the field that is 1 at a station, 0 at all others, and linear between.
    pub fn share(&self, station: usize, place: TubePlace) -> f64 {
        let [previous, at, next] = [0, 1, 2].map(|i| self.arcs[station + i]);
        hat(place.arc, previous, at, next)
    }

    /// The value at a place of the wave of a `number` that is the same all along the tube.
    pub fn uniform(&self, number: usize, place: TubePlace) -> f64 {
        wave(number, place.angle)
    }

    /// For each point the nearest of the stations `first`, `first + step`, `first + 2 step`, …
    pub fn nearest(&self, first: usize, step: usize) -> Vec<usize> {
        // Of two that are as near the first, whatever the rounding errors.
        let nearer = NEARER * self.axis.length;
        let distance = |station: usize, s: f64| (self.arcs[station + 1] - s).abs();
        let nearest = |s: &f64| {
            let stations = (first..self.count()).step_by(step);
            stations.fold(first, |best, station| {
                match distance(station, *s) < distance(best, *s) - nearer {
                    true => station,
                    false => best,
                }
            })
        };
        self.places.iter().map(nearest).collect()
    }
}

/// The function that is 1 at `at`, 0 from `previous` back and from `next` on, and linear between.
fn hat(s: f64, previous: f64, at: f64, next: f64) -> f64 {
    let slope = if s < at {
        (s - previous) / (at - previous)
    } else {
        (next - s) / (next - at)
    };
    slope.max(0.0)
}

/// The places of each ring in ascending arc lengths, if they are rings.
fn rings(arcs: &[f64], length: f64) -> Option<Vec<Range<usize>>> {
    // Rings are apart by more than this if there are as few points in each as there may be.
    let apart = RAGGED * length * LEAST_POINTS as f64 / arcs.len() as f64;
    let mut rings: Vec<Range<usize>> = Vec::new();
    for (i, s) in arcs.iter().enumerate() {
        match rings.last_mut() {
            Some(ring) if s - arcs[ring.end - 1] < apart => ring.end = i + 1,
            _ => rings.push(i..i + 1),
        }
    }
    let gap = |pair: &[Range<usize>]| {
        let [previous, next] = [&pair[0], &pair[1]];
        let ragged = |ring: &Range<usize>| arcs[ring.end - 1] - arcs[ring.start];
        let room = arcs[next.start] - arcs[previous.end - 1];
        ragged(previous).max(ragged(next)) < RAGGED * room
    };
    let are_rings = rings.iter().all(|ring| ring.len() >= LEAST_POINTS);
    (rings.len() > 1 && are_rings && rings.windows(2).all(gap)).then_some(rings)
}

/// Where stations are.
struct Placement {
    /// Arc lengths, m.
    arcs: Vec<f64>,
    /// Degree between them.
    degree: usize,
    /// Share that each of its neighbours has in what the blood sees of a station.
    smoothing: f64,
    /// Places of the points of each station between the ends, with their weights.
    members: Vec<Vec<(usize, f64)>>,
}

/// Stations at rings; at every second or third one where there are too many.
fn at_rings(
    arcs: &[f64],
    rings: Vec<Range<usize>>,
    length: f64,
    options: StationOptions,
) -> Placement {
    let middle = |ring: &Range<usize>| arcs[ring.clone()].iter().sum::<f64>() / ring.len() as f64;
    let near = RAGGED * length / rings.len() as f64;
    let inner: Vec<(f64, Range<usize>)> = (rings.into_iter())
        .map(|ring| (middle(&ring), ring))
        .filter(|(s, _)| *s > near && *s < length - near)
        .collect();
    let pieces = inner.len() + 1;
    let degree = match options.shape {
        SurrogateWall::Elements(degree) if pieces.is_multiple_of(degree) => degree,
        _ => 1,
    };
    let fits = |step: &usize| {
        pieces.div_ceil(*step) <= options.most + 1
            && (degree.is_multiple_of(*step) || step.is_multiple_of(degree))
    };
    let step = (1..=pieces).find(fits).unwrap_or(pieces);
    let kept: Vec<_> = (inner.into_iter()).skip(step - 1).step_by(step).collect();
    let all = kept.iter().map(|(s, _)| *s);
    let arcs = [0.0].into_iter().chain(all).chain([length]).collect();
    let members = kept
        .into_iter()
        .map(|(_, ring)| ring.map(|place| (place, 1.0)).collect());
    Placement {
        arcs,
        degree: (degree / step).max(1),
        // cos²(kh/2) of a wave of wave number k on faces of length h, for long waves
        smoothing: match options.shape {
            SurrogateWall::Faces => 0.25 / (step * step) as f64,
            SurrogateWall::Elements(_) => 0.0,
        },
        members: members.collect(),
    }
}

/// Stations at equal distances, to which points belong the more the nearer they are.
fn evenly(arcs: &[f64], length: f64, options: StationOptions) -> Placement {
    let mut count = options.most.min(arcs.len() / LEAST_POINTS).max(1);
    loop {
        let distance = length / (count + 1) as f64;
        let stations: Vec<f64> = (0..=count + 1).map(|i| i as f64 * distance).collect();
        let members = |station: &[f64]| -> Vec<(usize, f64)> {
            let weight = |s: f64| hat(s, station[0], station[1], station[2]);
            let weights = arcs.iter().map(|s| weight(*s)).enumerate();
            weights.filter(|(_, weight)| *weight > 0.0).collect()
        };
        let members: Vec<_> = stations.windows(3).map(members).collect();
        let enough = 2 * (2 * options.around + 1);
        if count == 1 || members.iter().all(|members| members.len() >= enough) {
            return Placement {
                arcs: stations,
                degree: 1,
                smoothing: 0.0,
                members,
            };
        }
        count = count.div_ceil(2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RING: u32 = 12;

    /// Rings of points 1 mm apart.
    fn tube() -> Vec<Vec3> {
        let ring = |i: u32| {
            (0..RING).map(move |k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / f64::from(RING)).sin_cos();
                Vec3::new(0.01 + f64::from(i) * 1e-3, 2e-3 * cos, 2e-3 * sin)
            })
        };
        (0..31).flat_map(ring).collect()
    }

    fn axis() -> Axis {
        Axis {
            line: SpaceCurve::x_axis(0.01, 0.04).counted_from(0.01),
            length: 0.03,
        }
    }

    fn stations(degree: usize, most: usize) -> Stations {
        let options = StationOptions {
            shape: SurrogateWall::Elements(degree),
            most,
            around: 3,
        };
        Stations::new(&tube(), axis(), options).unwrap()
    }

    #[test]
    fn stations_lie_at_rings_or_at_every_other_one() {
        for (degree, most, count, pieces) in [
            (1, 40, 29, 30),
            (3, 29, 29, 10),
            (3, 20, 9, 10),
            (6, 20, 14, 5),
            (4, 40, 29, 30),
            (1, 15, 14, 15),
            (1, 1, 1, 2),
        ] {
            let stations = stations(degree, most);
            assert_eq!(stations.count(), count, "{degree} {most}");
            assert_eq!(stations.pieces().count(), pieces, "{degree} {most}");
            let ends = stations.pieces().map(|(_, arcs)| arcs.len());
            assert_eq!(ends.sum::<usize>(), count + 1 + pieces);
            let radius = stations.reference_radius();
            assert!(radius.iter().all(|r| (r - 2e-3).abs() < 1e-15));
        }
    }

    #[test]
    fn points_belong_to_the_nearest_of_some_stations() {
        let nearest = stations(1, 40).nearest(2, 4); // at 3, 7, … 27 mm
        for (i, station) in nearest.iter().enumerate() {
            let ring = (i / 12) as f64;
            let expected = 4.0 * ((ring - 3.0) / 4.0).clamp(0.0, 6.0);
            let found = *station as f64 - 2.0;
            assert!((found - expected).abs() <= 2.0, "{ring} {station}");
        }
    }

    #[test]
    fn waves_are_distinguished() {
        let stations = stations(1, 40);
        assert_eq!(stations.waves(), 7);
        for number in 0..7 {
            let d = tube().into_iter().flat_map(|x| {
                let radial = Vec3::new(0.0, x.y, x.z).normalize();
                let size = stations.uniform(number, stations.place(&x)) * x.x;
                (size * radial).data.0[0]
            });
            let amplitudes = stations.amplitudes(&DVector::from_iterator(3 * 31 * 12, d));
            for i in 0..29 {
                for k in 0..7 {
                    let expected = if k == number {
                        0.011 + 1e-3 * i as f64
                    } else {
                        0.0
                    };
                    assert!((amplitudes[(i, k)] - expected).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn moving_the_tube_is_a_wave_of_one_period_not_a_widening() {
        let d = DVector::from_fn(3 * 31 * 12, |i, _| [0.3, -0.2, 0.1][i % 3]);
        let amplitudes = stations(1, 7).amplitudes(&d);
        for row in amplitudes.row_iter() {
            for (k, expected) in [0.0, -0.2, 0.1, 0.0, 0.0, 0.0, 0.0].into_iter().enumerate() {
                assert!((row[k] - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn faces_see_less_of_short_waves() {
        for (most, step) in [(40, 1), (15, 2)] {
            let options = StationOptions {
                shape: SurrogateWall::Faces,
                most,
                around: 0,
            };
            let stations = Stations::new(&tube(), axis(), options).unwrap();
            let (n, smoothing) = (stations.count(), stations.smoothing());
            // Three half waves along the tube
            let k = 3.0 * std::f64::consts::PI / 0.03;
            let wave = |i: usize| (k * 1e-3 * (step * (i + 1)) as f64).sin();
            let seen = smoothing * DVector::from_fn(n, |i, _| wave(i));
            let share = (0.5e-3 * k).cos().powi(2);
            for i in 1..n - 1 {
                assert!((seen[i] - share * wave(i)).abs() < 2e-3, "{step} {i}");
            }
        }
    }

    #[test]
    fn points_without_rings_are_shared() {
        let mut points = tube();
        for (i, x) in points.iter_mut().enumerate() {
            x.x += 1e-3 * (0.37 * i as f64).fract() - 0.5e-3;
        }
        let options = StationOptions {
            shape: SurrogateWall::Elements(4),
            most: 20,
            around: 1,
        };
        let stations = Stations::new(&points, axis(), options).unwrap();
        assert_eq!((stations.count(), stations.waves()), (20, 3));
        let widened = points.iter().flat_map(|x| {
            let radial = Vec3::new(0.0, x.y, x.z).normalize();
            radial.data.0[0]
        });
        let amplitudes = stations.amplitudes(&DVector::from_iterator(3 * 31 * 12, widened));
        assert!(amplitudes.column(0).iter().all(|a| (a - 1.0).abs() < 1e-12));
    }

    #[test]
    fn a_wall_without_rings_between_the_ends_is_refused() {
        let ends: Vec<Vec3> = tube()
            .into_iter()
            .filter(|x| (x.x - 0.025).abs() > 0.0149)
            .collect();
        let options = StationOptions {
            shape: SurrogateWall::Faces,
            most: 20,
            around: 0,
        };
        assert_eq!(Stations::new(&ends, axis(), options), Err(NoRings));
    }
}
