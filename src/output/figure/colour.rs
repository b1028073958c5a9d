//! Colour maps made for fields on a wall: equal steps of a value look equally large, and lightness alone orders them,
//! so that they are read in grey and by the colour-blind too. Colours are made in Ottosson's space Oklab.

use std::f64::consts::{PI, TAU};

/// A colour map from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Palette(Vec<[u8; 3]>);

/// Colours of a map.
const STEPS: usize = 256;

/// Those of Okabe and Ito, for print and the colour-blind.
const CLASSES: [[u8; 3]; 8] = [
    [0xe6, 0x9f, 0x00],
    [0x56, 0xb4, 0xe9],
    [0x00, 0x9e, 0x73],
    [0xf0, 0xe4, 0x42],
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0xcc, 0x79, 0xa7],
    [0x00, 0x00, 0x00],
];

/// `L, a, b`.
type Oklab = [f64; 3];

impl Palette {
    /// From pale yellow over red to deep blue, ever darker: for values from small to large.
    pub fn sequential() -> Self {
        Self::along(|t| {
            let hue = (100.0 - 185.0 * t.powf(0.9)).to_radians();
            polar(
                0.965 - 0.70 * t,
                0.045 + 0.115 * (PI * t).sin().powf(0.8),
                hue,
            )
        })
    }

    /// From blue over pale grey to red, as dark at both ends: for differences.
    pub fn diverging() -> Self {
        Self::along(|t| {
            let side = 2.0 * t - 1.0;
            let hue: f64 = if side < 0.0 { 250.0 } else { 35.0 };
            let lightness = 0.95 - 0.50 * side.abs();
            polar(lightness, 0.14 * side.abs(), hue.to_radians())
        })
    }

    /// Colours that stay apart, one for each of `count` classes.
    pub fn classes(count: usize) -> Self {
        let colour = |step: usize| CLASSES[step * count / STEPS % CLASSES.len()];
        Self((0..STEPS).map(colour).collect())
    }

    /// Equal steps along a curve of Oklab.
    fn along(curve: impl Fn(f64) -> Oklab) -> Self {
        const FINE: usize = 4096;
        let points: Vec<Oklab> = (0..=FINE).map(|i| curve(i as f64 / FINE as f64)).collect();
        let mut lengths = vec![0.0];
        for pair in points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + distance(pair[0], pair[1]));
        }
        let all = lengths[FINE];
        let colour = |step: usize| {
            let wanted = all * step as f64 / (STEPS - 1) as f64;
            to_srgb(points[lengths.partition_point(|l| *l < wanted).min(FINE)])
        };
        Self((0..STEPS).map(colour).collect())
    }

    /// The colour of a value; of the nearer end outside.
    pub fn at(&self, value: f64) -> [u8; 3] {
        let step = value.clamp(0.0, 1.0) * (STEPS - 1) as f64;
        self.0[step.round() as usize]
    }

    /// The colour of a value in a range; the first one if the range is empty.
    pub fn within(&self, [low, high]: [f64; 2], value: f64) -> [u8; 3] {
        self.at(if high > low {
            (value - low) / (high - low)
        } else {
            0.0
        })
    }

    /// All colours, from 0 to 1.
    pub fn colours(&self) -> &[[u8; 3]] {
        &self.0
    }
}

fn polar(lightness: f64, chroma: f64, hue: f64) -> Oklab {
    let hue = hue.rem_euclid(TAU);
    [lightness, chroma * hue.cos(), chroma * hue.sin()]
}

fn distance(a: Oklab, b: Oklab) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn to_linear([lightness, a, b]: Oklab) -> [f64; 3] {
    let l = (lightness + 0.3963377774 * a + 0.2158037573 * b).powi(3);
    let m = (lightness - 0.1055613458 * a - 0.0638541728 * b).powi(3);
    let s = (lightness - 0.0894841775 * a - 1.2914855480 * b).powi(3);
    [
        4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
        -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s,
    ]
}

fn to_srgb(colour: Oklab) -> [u8; 3] {
    to_linear(colour).map(|c| {
        let c = c.clamp(0.0, 1.0);
        let c = if c <= 0.0031308 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * c).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Back from the eight bits of a screen.
    fn oklab(colour: [u8; 3]) -> Oklab {
        let [r, g, b] = colour.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        });
        let l = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b).cbrt();
        let m = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b).cbrt();
        let s = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b).cbrt();
        [
            0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s,
        ]
    }

    /// Tenths of a map differ equally much, so no colour was cut off at the limits of the screen either.
    #[test]
    fn equal_steps_look_equal() {
        for palette in [Palette::sequential(), Palette::diverging()] {
            let tenths: Vec<Oklab> = (0..=10)
                .map(|i| oklab(palette.at(f64::from(i) / 10.0)))
                .collect();
            let lengths: Vec<f64> = tenths.windows(2).map(|p| distance(p[0], p[1])).collect();
            let mean = lengths.iter().sum::<f64>() / 10.0;
            for length in lengths {
                assert!((length / mean - 1.0).abs() < 0.06, "{length} of {mean}");
            }
        }
    }

    #[test]
    fn lightness_alone_orders_the_values() {
        let lightness = |palette: &Palette| -> Vec<f64> {
            palette.colours().iter().map(|c| oklab(*c)[0]).collect()
        };
        let falls = |l: &[f64]| l.windows(9).all(|l| l[8] < l[0]);
        assert!(falls(&lightness(&Palette::sequential())));
        let mut both = lightness(&Palette::diverging());
        assert!(falls(&both[128..]));
        both.reverse();
        assert!(falls(&both[128..]));
    }
}
