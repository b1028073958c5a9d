//! Pressure and velocity at chosen points, as OpenFOAM's own function object `probes` samples them from the fields of
//! each finished step. `system/fsiConnection` brings it, above the adapter in `controlDict`, so that its row is on the
//! disk before the step is reported.

use crate::Vec3;
use crate::files::named;
use crate::fluid::{FluidError, FluidProbe};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

/// Where the blood is sampled.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sampling {
    /// Positions, m.
    pub points: Vec<[f64; 3]>,
    /// Density, kg/m³: OpenFOAM's pressure is divided by it.
    pub density: f64,
}

/// Name of the function object, and of its folder of results.
const NAME: &str = "fsiProbes";
/// What OpenFOAM writes of a point in no cell is below this.
const NOWHERE: f64 = -1e200;

/// `system/fsiProbes`, which `system/fsiConnection` includes among the functions: the points (m), or nothing.
pub fn dictionary(points: &[[f64; 3]]) -> String {
    let mut text = String::from("// Points in the blood; written by fsi-driver, do not edit\n");
    if points.is_empty() {
        return text;
    }
    let _ = write!(
        text,
        "{NAME}\n{{\n    type            probes;\n    libs            (sampling);\n    \
         writeControl    timeStep;\n    writeInterval   1;\n    fields          (p U);\n    interpolationScheme cellPoint;\n    probeLocations\n    (\n"
    );
    for [x, y, z] in points {
        let _ = writeln!(text, "        ({x:e} {y:e} {z:e})");
    }
    text + "    );\n}\n"
}

/// The rows that a running solver has written so far.
pub struct ProbeFiles {
    sampling: Sampling,
    pressure: Rows,
    velocity: Rows,
}

impl ProbeFiles {
    /// Prepares the folder `case` for a solver that starts there. What an earlier one has left is removed.
    pub fn new(case: &Path, sampling: &Sampling) -> io::Result<Self> {
        let wanted = case.join("system").join(NAME);
        std::fs::write(&wanted, dictionary(&sampling.points)).map_err(named(&wanted))?;
        let folder = case.join("postProcessing").join(NAME);
        match std::fs::remove_dir_all(&folder) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(named(&folder)(error));
            }
            _ => {}
        }
        let rows = |field| Rows {
            folder: folder.clone(),
            field,
            file: None,
        };
        Ok(Self {
            sampling: sampling.clone(),
            pressure: rows("p"),
            velocity: rows("U"),
        })
    }

    /// What was sampled at the end of the step at `time` (s), in the order of the points; NaN where a point is not in
    /// the blood.
    pub fn read(&mut self, time: f64) -> Result<Vec<FluidProbe>, FluidError> {
        let count = self.sampling.points.len();
        if count == 0 {
            return Ok(Vec::new());
        }
        let pressure = self.pressure.at(time, count)?;
        let velocity = self.velocity.at(time, 3 * count)?;
        let number = |value: &f64| if *value < NOWHERE { f64::NAN } else { *value };
        let probe = |(p, u): (&f64, &[f64])| FluidProbe {
            pressure: self.sampling.density * number(p),
            velocity: Vec3::from_fn(|i, _| number(&u[i])),
        };
        let pairs = pressure.iter().zip(velocity.chunks_exact(3));
        Ok(pairs.map(probe).collect())
    }
}

/// A file that grows by one row per step, in a folder that bears the name of the solver's start time.
struct Rows {
    folder: PathBuf,
    field: &'static str,
    file: Option<BufReader<File>>,
}

impl Rows {
    fn open(&self) -> io::Result<BufReader<File>> {
        let start = std::fs::read_dir(&self.folder)?.next();
        let start = start.ok_or_else(|| io::Error::other("it is empty"))??;
        Ok(BufReader::new(File::open(start.path().join(self.field))?))
    }

    /// The `count` numbers of the row of the time `time` (s), which has just been written.
    fn at(&mut self, time: f64, count: usize) -> Result<Vec<f64>, FluidError> {
        let failed = |what: &dyn std::fmt::Display| {
            FluidError::Storage(format!(
                "cannot read {} of output.fluid_probes_m in {}: {what}; the controlDict of \
                 fluid.templates must include system/fsiConnection above its functions, and OpenFOAM's library \
                 `sampling` must be installed",
                self.field,
                self.folder.display()
            ))
        };
        let mut file = match self.file.take() {
            Some(file) => file,
            None => self.open().map_err(|e| failed(&e))?,
        };
        let mut line = String::new();
        while file.read_line(&mut line).map_err(|e| failed(&e))? > 0 {
            let spelt = line.replace(['(', ')'], " ");
            let numbers: Result<Vec<f64>, _> = spelt.split_whitespace().map(str::parse).collect();
            match numbers.as_deref() {
                Ok([at, values @ ..])
                    if (at - time).abs() <= 1e-9 * time && values.len() == count =>
                {
                    let values = values.to_vec();
                    self.file = Some(file);
                    return Ok(values);
                }
                _ => line.clear(), // a comment, or an earlier step
            }
        }
        Err(failed(&format!("there is no whole row of t = {time} s")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_as_written_and_points_outside_are_undefined() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("system")).unwrap();
        let sampling = Sampling {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0]],
            density: 1000.0,
        };
        let mut probes = ProbeFiles::new(folder.path(), &sampling).unwrap();
        let written = std::fs::read_to_string(folder.path().join("system/fsiProbes")).unwrap();
        assert!(written.contains("(1e0 0e0 0e0)"), "{written}");
        let rows = folder.path().join("postProcessing/fsiProbes/0.004");
        std::fs::create_dir_all(&rows).unwrap();
        let write = |field: &str, text: &str| std::fs::write(rows.join(field), text).unwrap();
        let head = "# Probe 0 (0 0 0)\n# Probe 1 (1 0 0)  # Not Found\n#  Probe 0 1\n#  Time\n";
        write(
            "p",
            &format!("{head} 0.006  1.5  -1e+300\n 0.008  2.5  0.5\n"),
        );
        let vectors = "(-1e+300 -1e+300 -1e+300)";
        write(
            "U",
            &format!("{head} 0.006  (1 2 3) {vectors}\n 0.008  (4 5 6) (7 8 9)\n"),
        );
        let found = probes.read(0.006).unwrap();
        assert_eq!(found[0].pressure, 1500.0);
        assert_eq!(found[0].velocity, Vec3::new(1.0, 2.0, 3.0));
        assert!(found[1].pressure.is_nan() && found[1].velocity.iter().all(|u| u.is_nan()));
        assert_eq!(
            probes.read(0.008).unwrap()[1].velocity,
            Vec3::new(7.0, 8.0, 9.0)
        );
        let missing = probes.read(0.01).unwrap_err().to_string();
        assert!(missing.contains("no whole row of t = 0.01 s"), "{missing}");
    }
}
