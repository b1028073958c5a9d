//! What an experiment has measured at points, as a file: a run records the same there (`output.measured`), and
//! `fsi-driver validate` compares both.

use crate::files::{Fault, fault};
use crate::tabular::{Row, Sheet};
use csv::StringRecord;
use serde::Deserialize;
use std::path::Path;

/// Points of one kind, of the wall or in the blood, that a run records at most.
pub const MOST_POINTS: usize = 1000;

/// What was measured, by the name that it has in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum MeasuredQuantity {
    /// Velocity of the blood along x.
    #[serde(rename = "velocity_x_m_s")]
    VelocityX,
    /// Velocity of the blood along y.
    #[serde(rename = "velocity_y_m_s")]
    VelocityY,
    /// Velocity of the blood along z.
    #[serde(rename = "velocity_z_m_s")]
    VelocityZ,
    /// Magnitude of the blood's velocity.
    #[serde(rename = "speed_m_s")]
    Speed,
    /// Flow through the cross-section of the case (`[[output.section]]`) that has the name of the series, up to a
    /// colon.
    #[serde(rename = "flow_m3_s")]
    Flow,
    /// Mean pressure on the wall there.
    #[serde(rename = "section_pressure_Pa")]
    SectionPressure,
    /// Radius of a circle of the area there, less that at the first point of the series.
    #[serde(rename = "section_radius_difference_m")]
    SectionRadiusDifference,
    /// Pressure in the blood.
    #[serde(rename = "pressure_Pa")]
    Pressure,
    /// The same, less that at the first point of its series: for experiments that know their pressure but for a
    /// constant.
    #[serde(rename = "pressure_difference_Pa")]
    PressureDifference,
    /// Pressure of the blood on the wall.
    #[serde(rename = "wall_pressure_Pa")]
    WallPressure,
    /// The same, less that at the first point of its series.
    #[serde(rename = "wall_pressure_difference_Pa")]
    WallPressureDifference,
    /// Magnitude of the wall shear stress.
    #[serde(rename = "wall_shear_Pa")]
    WallShear,
    /// Displacement of the wall along x.
    #[serde(rename = "displacement_x_m")]
    DisplacementX,
    /// Displacement of the wall along y.
    #[serde(rename = "displacement_y_m")]
    DisplacementY,
    /// Displacement of the wall along z.
    #[serde(rename = "displacement_z_m")]
    DisplacementZ,
    /// Force of the fluid along x, on what the function object of OpenFOAM that has the name of the series, up to a
    /// colon, adds up.
    #[serde(rename = "force_x_N")]
    ForceX,
    /// The same along y.
    #[serde(rename = "force_y_N")]
    ForceY,
    /// The same along z.
    #[serde(rename = "force_z_N")]
    ForceZ,
}

/// What a value says of a quantity over time, from the time of its row to the end of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Statistic {
    /// Mean over time.
    Mean,
    /// Half of the sum of the largest and the least value.
    Middle,
    /// Half of the difference of the largest and the least value.
    Amplitude,
    /// The largest value: of the parabola through the largest sample and its neighbours.
    Largest,
    /// The least value, likewise.
    Least,
    /// When the largest value is reached.
    #[serde(rename = "time_of_largest_s")]
    TimeOfLargest,
    /// How often per second the middle is passed upwards.
    #[serde(rename = "frequency_1_s")]
    Frequency,
    /// The amplitude of what is periodic, without what jumps from step to step: of a Fourier series.
    PeriodicAmplitude,
    /// Root mean square of what that series leaves.
    Noise,
}

impl Statistic {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Middle => "middle",
            Self::Amplitude => "amplitude",
            Self::Largest => "largest",
            Self::Least => "least",
            Self::TimeOfLargest => "time of the largest",
            Self::Frequency => "frequency",
            Self::PeriodicAmplitude => "periodic amplitude",
            Self::Noise => "noise",
        }
    }

    /// Its unit, for a quantity with this unit.
    pub fn unit(self, of_quantity: &'static str) -> &'static str {
        match self {
            Self::Frequency => "Hz",
            Self::TimeOfLargest => "s",
            _ => of_quantity,
        }
    }
}

/// What records a quantity in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recorder {
    /// A point of the wall, `output.probes_m`.
    WallProbe,
    /// A point in the blood, `output.fluid_probes_m`.
    BloodProbe,
    /// A cross-section, `output.section`.
    Section,
    /// A function object of OpenFOAM, in the templates' `controlDict`.
    FunctionObject,
}

impl MeasuredQuantity {
    /// What records it in a run.
    pub fn recorder(self) -> Recorder {
        use MeasuredQuantity::*;
        match self {
            VelocityX | VelocityY | VelocityZ | Speed | Pressure | PressureDifference => {
                Recorder::BloodProbe
            }
            WallPressure | WallPressureDifference | WallShear => Recorder::WallProbe,
            DisplacementX | DisplacementY | DisplacementZ => Recorder::WallProbe,
            Flow | SectionPressure | SectionRadiusDifference => Recorder::Section,
            ForceX | ForceY | ForceZ => Recorder::FunctionObject,
        }
    }

    /// Whether values count from that at the first point of their series.
    pub fn is_difference(self) -> bool {
        matches!(
            self,
            MeasuredQuantity::PressureDifference
                | MeasuredQuantity::WallPressureDifference
                | MeasuredQuantity::SectionRadiusDifference
        )
    }

    /// What it is, with its unit, for the axis of a figure.
    pub fn label(self) -> String {
        use MeasuredQuantity::*;
        let name = match self {
            VelocityX => "velocity along x",
            VelocityY => "velocity along y",
            VelocityZ => "velocity along z",
            Speed => "speed",
            Flow => "flow",
            SectionPressure => "pressure",
            SectionRadiusDifference => "change of radius",
            Pressure => "pressure",
            PressureDifference => "pressure less the first",
            WallPressure => "pressure at the wall",
            WallPressureDifference => "pressure at the wall less the first",
            WallShear => "wall shear stress",
            DisplacementX => "displacement along x",
            DisplacementY => "displacement along y",
            DisplacementZ => "displacement along z",
            ForceX => "force along x",
            ForceY => "force along y",
            ForceZ => "force along z",
        };
        format!("{name} / {}", self.unit())
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        use MeasuredQuantity::*;
        match self {
            VelocityX | VelocityY | VelocityZ | Speed => "m/s",
            Flow => "m³/s",
            Pressure
            | PressureDifference
            | WallPressure
            | WallPressureDifference
            | WallShear
            | SectionPressure => "Pa",
            DisplacementX | DisplacementY | DisplacementZ | SectionRadiusDifference => "m",
            ForceX | ForceY | ForceZ => "N",
        }
    }
}

/// A row of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
struct MeasuredRow {
    series: String,
    quantity: MeasuredQuantity,
    statistic: Option<Statistic>,
    time_s: Option<f64>,
    x_m: f64,
    y_m: f64,
    z_m: f64,
    value: Option<f64>,
    sd: Option<f64>,
    lowest: Option<f64>,
    highest: Option<f64>,
}

/// A measured value.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredPoint {
    /// Where (m): of the unloaded wall, or fixed in space.
    pub place: [f64; 3],
    /// When (s); at the end of the run if the file does not say. A statistic counts from then on, or all of the run.
    pub time: Option<f64>,
    /// What the value says of the quantity over time, if it is not its value at one time.
    pub statistic: Option<Statistic>,
    /// The value, in the quantity's unit: the mean where it was measured more than once. Not a number if it is not
    /// known and only the statistic of runs is asked for.
    pub value: f64,
    /// Standard deviation of what was measured there.
    pub sd: Option<f64>,
    /// Lowest and highest value that was measured there.
    pub range: Option<[f64; 2]>,
}

/// Values of one quantity that belong together, such as a profile of the velocity.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredSeries {
    /// What the file calls it.
    pub name: String,
    /// What was measured.
    pub quantity: MeasuredQuantity,
    /// Where, and what was found; one at least.
    pub points: Vec<MeasuredPoint>,
}

impl MeasuredSeries {
    /// The cross-section or function object that records it, if one does: its name up to a colon.
    pub fn recorded_by(&self) -> &str {
        self.name.split(':').next().unwrap_or_default()
    }

    /// Whether its values are statistics over time; none or all are.
    pub fn is_over_time(&self) -> bool {
        self.points[0].statistic.is_some()
    }
}

/// All that a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurements {
    /// In the order of the file.
    pub series: Vec<MeasuredSeries>,
}

impl Measurements {
    /// Reads a table with the columns `series,quantity,x_m,y_m,z_m,value`, and where they are known
    /// `statistic,time_s,sd,lowest,highest`; see [`Sheet::of_words`].
    ///
    /// # Errors
    /// What is wrong with it, in words that name file and line.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let named = |reason: String| fault!("{}{reason}", path.display());
        const NUMBERS: [&str; 8] = [
            "x_m", "y_m", "z_m", "value", "time_s", "sd", "lowest", "highest",
        ];
        const NEEDED: [&str; 3] = ["x_m", "y_m", "z_m"];
        const EXPECTED: &str = "expected the columns series,quantity,x_m,y_m,z_m,value and, as you know them, \
                                statistic,time_s,sd,lowest,highest";
        let sheet = Sheet::of_words(path, "series").map_err(|fault| match fault.line {
            Some(line) => named(format!(":{line}: {}", fault.message)),
            None => named(format!(": cannot read it: {}; {EXPECTED}", fault.message)),
        })?;
        let names = sheet.columns.iter().map(|column| column.name.as_str());
        let heads = StringRecord::from_iter(names);
        let mut series: Vec<MeasuredSeries> = Vec::new();
        for Row { line, cells } in &sheet.rows {
            let numbers = heads
                .iter()
                .zip(cells)
                .filter(|(head, _)| NUMBERS.contains(head));
            for (head, cell) in numbers {
                let is_needed = NEEDED.contains(&head);
                if is_needed && cell.is_empty() {
                    return Err(named(format!(
                        ":{line}: {head}: found nothing, expected a number"
                    )));
                }
                if !cell.is_empty() && cell.parse::<f64>().is_err() {
                    return Err(named(format!(
                        ":{line}: {head}: found {cell:?}, expected a number"
                    )));
                }
            }
            let record = StringRecord::from_iter(cells);
            let row: MeasuredRow = (record.deserialize(Some(&heads)))
                .map_err(|e| named(format!(":{line}: {}; {EXPECTED}", reason(&e))))?;
            add(&mut series, row).map_err(|reason| named(format!(":{line}: {reason}")))?;
        }
        let measured = Self { series };
        if measured.series.is_empty() {
            return Err(named(": holds no measured value".into()));
        }
        Ok(measured)
    }

    /// Points (m) of the wall or of the blood at which something was measured, each once.
    pub fn places(&self, recorder: Recorder) -> Vec<[f64; 3]> {
        let mut places: Vec<[f64; 3]> = Vec::new();
        let series = self.series.iter();
        let series = series.filter(|it| it.quantity.recorder() == recorder);
        for point in series.flat_map(|series| &series.points) {
            if !places.contains(&point.place) {
                places.push(point.place);
            }
        }
        places
    }
}

/// What is wrong with a row, without the place, which counts lines otherwise.
fn reason(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => err.to_string(),
        _ => error.to_string(),
    }
}

/// Puts a row to the others of its series.
fn add(series: &mut Vec<MeasuredSeries>, row: MeasuredRow) -> Result<(), Fault> {
    let numbers = [row.x_m, row.y_m, row.z_m].into_iter();
    let others = [row.value, row.time_s, row.sd, row.lowest, row.highest];
    if let Some(number) = (numbers.chain(others.into_iter().flatten())).find(|x| !x.is_finite()) {
        return Err(fault!("found {number}, expected finite numbers"));
    }
    if let Some(sd) = row.sd.filter(|sd| *sd < 0.0) {
        return Err(fault!("sd: found {sd}, expected a number from 0"));
    }
    let value = match (row.value, row.statistic) {
        (Some(value), _) => value,
        (None, Some(_)) => f64::NAN,
        (None, None) => return Err("value: found nothing, expected a number".into()),
    };
    let range = match (row.lowest, row.highest) {
        (None, None) => None,
        (Some(lowest), Some(highest)) if lowest <= value && value <= highest => {
            Some([lowest, highest])
        }
        (lowest, highest) => {
            let show = |x: Option<f64>| x.map_or("nothing".to_owned(), |x| x.to_string());
            return Err(fault!(
                "lowest and highest: found {} and {}, expected neither, or both with the value {value} between them",
                show(lowest),
                show(highest)
            ));
        }
    };
    if row.series.is_empty() {
        return Err("series: found nothing, expected a name".into());
    }
    let point = MeasuredPoint {
        place: [row.x_m, row.y_m, row.z_m],
        time: row.time_s,
        statistic: row.statistic,
        value,
        sd: row.sd,
        range,
    };
    match series.iter_mut().find(|it| it.name == row.series) {
        Some(series) if series.quantity != row.quantity => Err(fault!(
            "the series {} began with another quantity; expected one quantity in a series",
            row.series
        )),
        Some(series) if series.is_over_time() != row.statistic.is_some() => Err(fault!(
            "statistic: the series {} has both values at one time and statistics; expected one of them in a series",
            row.series
        )),
        Some(series) => {
            series.points.push(point);
            Ok(())
        }
        None if row.quantity.is_difference() && row.statistic.is_some() => Err(fault!(
            "statistic: found one of a quantity that counts from the first point of its series; expected another quantity"
        )),
        None if row.quantity.is_difference() && value != 0.0 => Err(fault!(
            "value: found {value} at the first point of the series {}, from which its differences count: expected 0",
            row.series
        )),
        None => {
            series.push(MeasuredSeries {
                name: row.series,
                quantity: row.quantity,
                points: vec![point],
            });
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Measurements, Fault> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("measured.csv");
        std::fs::write(&path, text).unwrap();
        let folder = format!("{}/", folder.path().display());
        Measurements::read(&path).map_err(|fault| Fault::whole(fault.message.replace(&folder, "")))
    }

    #[test]
    fn series_keep_their_order_and_a_place_counts_once() {
        let measured = read(
            "# by hand\nseries,quantity,x_m,y_m,z_m,value,sd,lowest,highest\n\
             axis,velocity_x_m_s,0,0,0,0.7,0.02,0.68,0.72\n\
             drop,wall_pressure_difference_Pa,0,0.002,0,0,,,\n\
             axis,velocity_x_m_s,0.01,0,0,0.6,,,\n\
             radial,velocity_y_m_s,0.01,0,0,0.0,,,\n",
        )
        .unwrap();
        let names: Vec<&str> = measured.series.iter().map(|it| it.name.as_str()).collect();
        assert_eq!(names, ["axis", "drop", "radial"]);
        let axis = &measured.series[0];
        assert_eq!(axis.points.len(), 2);
        assert_eq!(axis.points[0].range, Some([0.68, 0.72]));
        assert_eq!(axis.points[1].sd, None);
        assert_eq!(
            measured.places(Recorder::BloodProbe),
            [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]],
            "shared by two series"
        );
        assert_eq!(measured.places(Recorder::WallProbe), [[0.0, 0.002, 0.0]]);
    }

    #[test]
    fn times_may_be_given_and_columns_may_stand_in_any_order() {
        let measured =
            read("value,quantity,time_s,z_m,y_m,x_m,series\n1e-4,displacement_y_m,0.5,3,2,1,a\n")
                .unwrap();
        let point = &measured.series[0].points[0];
        assert_eq!((point.place, point.time), ([1.0, 2.0, 3.0], Some(0.5)));
    }

    #[test]
    fn a_series_has_values_or_statistics() {
        const HEAD: &str = "series,quantity,statistic,x_m,y_m,z_m,value\n";
        let measured = read(&format!(
            "{HEAD}tip,displacement_y_m,amplitude,0.6,0.2,0,0.035\ntip,displacement_y_m,frequency_1_s,0.6,0.2,0,5.46\n\
             tip,displacement_y_m,mean,0.6,0.2,0,\n"
        ));
        let tip = &measured.unwrap().series[0];
        assert!(tip.is_over_time());
        assert_eq!(tip.points[0].statistic, Some(Statistic::Amplitude));
        assert_eq!(tip.points[1].statistic, Some(Statistic::Frequency));
        assert!(tip.points[2].value.is_nan(), "asked for, not known");
        for (row, expected) in [
            ("b,speed_m_s,,0,0,0,1", "b has both"),
            (
                "c,pressure_difference_Pa,mean,0,0,0,0",
                "found one of a quantity that counts",
            ),
            ("c,speed_m_s,median,0,0,0,1", "unknown variant `median`"),
        ] {
            let reason = read(&format!("{HEAD}b,speed_m_s,mean,0,0,0,1\n{row}\n")).unwrap_err();
            assert!(reason.message.contains(expected), "{row}: {reason}");
        }
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        const HEAD: &str = "series,quantity,x_m,y_m,z_m,value,sd,lowest,highest\n";
        #[rustfmt::skip]
        let rows = [
            ("a,velocity_m_s,0,0,0,1,,,", "unknown variant `velocity_m_s`"),
            ("a,speed_m_s,0,0,0,one,,,", "measured.csv:3: value: found \"one\""),
            ("a,speed_m_s,0,0,0,NaN,,,", "measured.csv:3: found NaN"),
            ("a,speed_m_s,0,0,0,1,-1,,", "measured.csv:3: sd: found -1"),
            ("a,speed_m_s,0,0,0,1,,2,3", "measured.csv:3: lowest and highest: found 2 and 3"),
            ("a,speed_m_s,0,0,0,1,,0,", "found 0 and nothing"),
            (",speed_m_s,0,0,0,1,,,", "measured.csv:3: series: found nothing"),
            ("b,pressure_Pa,0,0,0,1,,,", "measured.csv:3: the series b began with another"),
            ("a,pressure_difference_Pa,0,0,0,1,,,", "measured.csv:3: value: found 1 at the first"),
            ("a,speed_m_s,0,0,0", "measured.csv:3: value: found nothing"),
        ];
        for (row, expected) in rows {
            let reason = read(&format!("{HEAD}b,speed_m_s,0,0,0,1,,,\n{row}\n")).unwrap_err();
            assert!(reason.message.contains(expected), "{row}: {reason}");
        }
        assert!(
            read(HEAD)
                .unwrap_err()
                .message
                .contains("no measured value")
        );
        let reason = read("series,quantity,x,y_m,z_m,value\na,speed_m_s,0,0,0,1\n").unwrap_err();
        assert!(
            reason.message.contains("expected the columns series,"),
            "{reason}"
        );
    }
}
