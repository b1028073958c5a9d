//! Axes with their ticks.

/// How values become lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// As they are.
    Linear,
    /// By their logarithm.
    Logarithmic,
}

impl Scale {
    /// Whether it has a place for the value.
    pub fn shows(self, value: f64) -> bool {
        value.is_finite() && (self == Self::Linear || value > 0.0)
    }
}

/// A mark on an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// Where.
    pub value: f64,
    /// Whether its line stands out.
    pub major: bool,
    /// Its number, if it carries one.
    pub name: Option<String>,
}

/// An axis between two values, drawn between two pixels.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    scale: Scale,
    /// The ends, or their common logarithms.
    low: f64,
    high: f64,
    /// Pixels of the ends.
    pub from: f64,
    /// Of the upper one.
    pub to: f64,
}

impl Axis {
    /// The same with more room at its lower end: a decade, or a tenth.
    pub fn lengthened(self) -> Self {
        let low = match self.scale {
            Scale::Logarithmic => self.low - 1.0,
            Scale::Linear => self.low - 0.1 * (self.high - self.low),
        };
        Self { low, ..self }
    }

    /// An axis that shows all values; `whole`: up to the next decade, or with room at both ends.
    pub fn new(
        scale: Scale,
        values: impl Iterator<Item = f64>,
        whole: bool,
        from: f64,
        to: f64,
    ) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values {
            let value = match scale {
                Scale::Linear => value,
                Scale::Logarithmic => value.log10(),
            };
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        (low, high) = match (scale, whole) {
            (Scale::Logarithmic, true) => ((low - 0.05).floor(), (high + 0.05).ceil()),
            (Scale::Logarithmic, false) => (low - 0.08, high + 0.08),
            (Scale::Linear, _) if low == high => {
                let room = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
                (low - room, high + room)
            }
            (Scale::Linear, true) => {
                let room = 0.06 * (high - low);
                // Zero stays in sight if it is near.
                let near = low > 0.0 && low < 0.35 * high;
                (if near { 0.0 } else { low - room }, high + room)
            }
            // A course begins at zero, though its first step ends a little later.
            (Scale::Linear, false) if low > 0.0 && low < 0.02 * high => (0.0, high),
            (Scale::Linear, false) => (low, high),
        };
        Self {
            scale,
            low,
            high,
            from,
            to,
        }
    }

    /// The pixel of a value.
    pub fn at(&self, value: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.log10(),
        };
        let share = (value - self.low) / (self.high - self.low);
        self.from + share * (self.to - self.from)
    }

    /// Its ticks.
    pub fn ticks(&self) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.linear_ticks(),
            Scale::Logarithmic => self.logarithmic_ticks(),
        }
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let rough = (self.high - self.low) / 5.0;
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|digit| digit * decade)
            .into_iter()
            .find(|step| *step >= rough * (1.0 - 1e-9))
            .unwrap_or(10.0 * decade);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let first = (self.low / step - 1e-6).ceil() as i64;
        let last = (self.high / step + 1e-6).floor() as i64;
        // Many zeros do not fit next to the axis: all names share the power of ten of the largest. But digits do not
        // become fewer by that.
        let largest = (step * first.abs().max(last.abs()) as f64).log10().floor() as i32;
        let name = |value: f64| match decimals {
            _ if decimals <= 4 || largest >= -1 => format!("{value:.decimals$}"),
            _ if value == 0.0 => "0".to_owned(),
            _ => {
                let decimals = (decimals as i32 + largest).max(0) as usize;
                format!("{:.decimals$}e{largest}", value / 10f64.powi(largest))
            }
        };
        let tick = |n: i64| {
            let value = n as f64 * step;
            Tick {
                value,
                major: n == 0,
                name: Some(name(value).replace('-', "\u{2212}")),
            }
        };
        (first..=last).map(tick).collect()
    }

    fn logarithmic_ticks(&self) -> Vec<Tick> {
        let decades = self.high - self.low;
        let every = (decades / 8.0).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for exponent in self.low.floor() as i32..=self.high.ceil() as i32 {
            for digit in 1..10 {
                let value = f64::from(digit) * 10f64.powi(exponent);
                let inside = (self.low - 1e-9..=self.high + 1e-9).contains(&value.log10());
                let named = match digit {
                    1 => exponent.rem_euclid(every) == 0,
                    2 | 5 => decades < 1.6,
                    _ => false,
                };
                if inside && (digit == 1 || decades < 6.0) {
                    ticks.push(Tick {
                        value,
                        major: digit == 1,
                        name: named.then(|| number(value)),
                    });
                }
            }
        }
        ticks
    }
}

/// Powers of ten as such, others in full.
fn number(value: f64) -> String {
    let exponent = value.log10();
    if (exponent - exponent.round()).abs() < 1e-9 {
        format!("10^{{{}}}", exponent.round()).replace('-', "\u{2212}")
    } else {
        format!("{value}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_ticks_are_round_numbers_within_the_axis() {
        let names = |low: f64, high: f64| -> Vec<String> {
            let axis = Axis::new(Scale::Linear, [low, high].into_iter(), false, 0.0, 1.0);
            axis.ticks()
                .into_iter()
                .filter_map(|tick| tick.name)
                .collect()
        };
        assert_eq!(names(0.0, 3.0), ["0", "1", "2", "3"]);
        assert_eq!(names(-0.31, 0.4), ["\u{2212}0.2", "0.0", "0.2", "0.4"]);
        assert_eq!(names(33.75, 56.25), ["35", "40", "45", "50", "55"]);
        assert_eq!(
            names(0.0, 1.8e-4),
            ["0", "0.5e\u{2212}4", "1.0e\u{2212}4", "1.5e\u{2212}4"]
        );
        assert_eq!(
            names(0.84168, 0.84171),
            ["0.84168", "0.84169", "0.84170", "0.84171"]
        );
        assert_eq!(names(7.0, 7.0), ["6.5", "7.0", "7.5"]);
    }
}
