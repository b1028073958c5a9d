//! A small moving channel for tests of the fluid: 6 mm wide, 30 mm long, the middle third is `wallFsi`.
#![allow(dead_code)] // each test file uses a part

use fsi_driver::Vec3;
use fsi_driver::case::{
    Blood, ConvectionScheme, FlowCurve, FluidTimeScheme, Inflow, Ramp, Time, TransportKind,
    Windkessel,
};
use fsi_driver::fluid::conversation::session::Terms;
use fsi_driver::fluid::openfoam::case_files::{CaseFiles, Openings, VesselOpenings};
use fsi_driver::fluid::openfoam::{OpenFoam, OpenFoamSettings, Programs, install};
use fsi_driver::fluid::{FluidEffort, FluidInterface, Wanted};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

pub const STEP: f64 = 0.002;
pub const DENSITY: f64 = 1050.0;

pub fn inflow() -> FlowCurve {
    FlowCurve::Pulse {
        inflow: Inflow::pulse(3.5e-6, 4.5e-6, 0.5, 0.8),
        period: 1.0,
    }
}

pub fn windkessel() -> Windkessel {
    Windkessel {
        resistance: 2.85e9,
        compliance: 1.2e-10,
        initial_pressure: 1.1e4,
        proximal: None,
    }
}

pub const RAMP: Ramp = Ramp { duration: 0.02 };

/// A case in a folder of its own, with its mesh.
pub struct Channel {
    pub folder: tempfile::TempDir,
    pub settings: OpenFoamSettings,
}

impl Channel {
    /// `tight` solves the linear systems to rounding, so that only the coupling can make a difference.
    pub fn new(tight: bool) -> Self {
        Self::refined(tight, 1)
    }

    /// With `cells` times as many cells in each direction.
    pub fn refined(tight: bool, cells: usize) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let case = folder.path().join("case");
        let templates = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/base");
        CaseFiles {
            walls: vec!["wallFsi"],
            templates: &templates,
            blood: &Blood::newtonian(DENSITY, 3.5e-3),
            openings: Openings::Vessel(VesselOpenings::flow_and_windkessel(
                inflow(),
                &windkessel(),
                fsi_driver::case::Start::Ramp,
            )),
            ramp: &RAMP,
            time: &Time {
                step: STEP,
                end: 1.0,
                period: 1.0,
                max_halvings: 0,
                until_periodic: None,
                scheme: FluidTimeScheme::ImplicitEuler,
            },
            convection: ConvectionScheme::default(),
            ranks: 2,
            non_orthogonality_deg: 0.0,
            diffusion_number: 0.0,
            blend: None,
        }
        .write(&case)
        .unwrap();
        if tight {
            let path = case.join("system/fvSolution");
            let text = std::fs::read_to_string(&path).unwrap();
            let text = text
                .replace("1e-10;", "1e-15;")
                .replace("relTol          0.02;", "relTol 1e-10;")
                .replace("relTol          0.01;", "relTol 1e-10;");
            std::fs::write(&path, text).unwrap();
        }
        let mesh = [4, 6].iter().fold(BLOCK_MESH.to_owned(), |mesh, n| {
            mesh.replace(
                &format!("({n} 5 5)"),
                &format!("({} {} {})", n * cells, 5 * cells, 5 * cells),
            )
        });
        std::fs::write(case.join("system/blockMeshDict"), mesh).unwrap();
        run_utility("blockMesh", &case);
        let settings = OpenFoamSettings {
            log: case.join("log.pimpleFoam"),
            case,
            ranks: 1,
            transport: TransportKind::Socket,
            answer_limit: Duration::from_secs(60),
            terms: Terms {
                start_time: 0.0,
                time_step: STEP,
                interface: None,
            },
            sampling: Default::default(),
            interrupt: Arc::new(AtomicBool::new(false)),
        };
        Self { folder, settings }
    }

    fn write(&self, file: &str, text: &str) {
        std::fs::write(self.case().join(file), text).unwrap();
    }

    pub fn replace(&self, file: &str, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.case().join(file)).unwrap();
        assert!(text.contains(from), "{file}: {from}");
        self.write(file, &text.replace(from, to));
    }

    /// Blood of Bird and Carreau, as a user's templates would choose it.
    pub fn use_bird_carreau(&self) {
        use_bird_carreau(self.case());
    }

    /// Menter's model of turbulence with wall functions, as a user's templates would choose it.
    pub fn use_k_omega_sst(&self) {
        self.replace(
            "constant/turbulenceProperties",
            "laminar;",
            "RAS;\nRAS { RASModel kOmegaSST; turbulence on; printCoeffs off; }",
        );
        self.replace(
            "system/fvSchemes",
            "div((nuEff",
            "div(phi,k) Gauss upwind;\n    div(phi,omega) Gauss upwind;\n    div((nuEff",
        );
        self.replace(
            "system/fvSchemes",
            "snGradSchemes",
            "wallDist { method meshWave; }\n\nsnGradSchemes",
        );
        self.replace(
            "system/fvSolution",
            "\"U.*\"",
            "\"(k|omega).*\" { solver PBiCGStab; preconditioner DILU; tolerance 1e-15; relTol 1e-10; }\n    \"U.*\"",
        );
        for (name, dimensions, inside, wall) in [
            ("k", "[0 2 -2 0 0 0 0]", "1e-4", "kqRWallFunction"),
            ("omega", "[0 0 -1 0 0 0 0]", "20", "omegaWallFunction"),
            ("nut", "[0 2 -1 0 0 0 0]", "5e-6", "nutkWallFunction"),
        ] {
            let inlet = match name {
                "nut" => "calculated",
                _ => "fixedValue",
            };
            let outlet = match name {
                "nut" => "type calculated;".to_owned(),
                _ => format!("type inletOutlet; inletValue uniform {inside};"),
            };
            self.write(
                &format!("0/{name}"),
                &format!(
                    "FoamFile {{ version 2.0; format ascii; class volScalarField; object {name}; }}\n\
                     dimensions {dimensions};\ninternalField uniform {inside};\nboundaryField\n{{\n\
                     inlet {{ type {inlet}; value uniform {inside}; }}\n\
                     outlet {{ {outlet} value uniform {inside}; }}\n\
                     \"wall.*\" {{ type {wall}; value uniform {inside}; }}\n}}\n"
                ),
            );
        }
    }

    pub fn start(&self) -> OpenFoam {
        OpenFoam::start(self.settings.clone()).unwrap()
    }

    pub fn case(&self) -> &Path {
        &self.settings.case
    }
}

/// Kinematic viscosity (m²/s) at rest and at high rates of shear, time constant (s) and exponent of
/// [`use_bird_carreau`].
pub const BIRD_CARREAU: [f64; 4] = [5.33e-5, 3.29e-6, 3.313, 0.3568];

/// Blood of Bird and Carreau in a case.
pub fn use_bird_carreau(case: &Path) {
    let [rest, high, time, n] = BIRD_CARREAU;
    let text = format!(
        "FoamFile {{ version 2.0; format ascii; class dictionary; object transportProperties; }}\n\
         transportModel BirdCarreau;\nBirdCarreauCoeffs {{ nu0 {rest}; nuInf {high}; k {time}; n {n}; }}\n"
    );
    std::fs::write(case.join("constant/transportProperties"), text).unwrap();
}

/// Runs a utility of OpenFOAM in a case.
pub fn run_utility(program: &str, case: &Path) {
    let library = install::check(1).unwrap();
    let output = Programs::new(case, &[&library])
        .command(program)
        .output()
        .unwrap_or_else(|error| panic!("{program}: {error}; run of-adapter/setup.sh first"));
    assert!(
        output.status.success(),
        "{program}: {}",
        String::from_utf8_lossy(&output.stdout)
    );
}

/// A bulge of the middle third, with a wave along it so that nothing is symmetric.
pub fn bulge(interface: &FluidInterface, amplitude: f64) -> Vec<Vec3> {
    interface
        .points
        .iter()
        .map(|x| {
            let s = (x[0] - 0.01) / 0.01;
            let shape = amplitude * (PI * s).sin() * (1.0 + 0.3 * (5.0 * s + 200.0 * x[1]).sin());
            let ends = if (0.0..=1.0).contains(&s) { shape } else { 0.0 };
            Vec3::new(0.1 * ends, ends * x[1] / 0.003, ends * x[2] / 0.003)
        })
        .collect()
}

/// Displacement of the wall at the end of step `n`.
pub fn prescribed(interface: &FluidInterface, n: usize) -> Vec<Vec3> {
    bulge(interface, 2e-4 * (1.0 - (0.4 * n as f64).cos()))
}

pub fn correctors(n: u32) -> FluidEffort {
    FluidEffort {
        max_sweeps: n,
        residual: 0.0,
        from_old_state: false,
    }
}

/// Whether the state after a step is to be kept.
pub fn keep(state: bool) -> Wanted {
    Wanted {
        state,
        field: false,
    }
}

/// Largest difference, relative to the largest value.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let size = b.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    a.iter()
        .zip(b)
        .fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()))
        / size
}

pub fn flat(vectors: &[Vec3]) -> Vec<f64> {
    vectors.iter().flat_map(|v| v.iter().copied()).collect()
}

/// All numbers of a binary list of OpenFOAM: the first `(` after the count, then the doubles.
pub fn read_internal_field(path: &Path) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let find = |from: usize, what: &[u8]| {
        bytes[from..]
            .windows(what.len())
            .position(|w| w == what)
            .map(|i| i + from)
    };
    let components = if find(0, b"List<vector>").is_some() || find(0, b"vectorField;").is_some() {
        3
    } else {
        1
    };
    let header_end = find(0, b"}").unwrap();
    let start = find(header_end, b"nonuniform").unwrap_or(header_end + 1);
    let open = find(start, b"\n(").or_else(|| find(start, b"(")).unwrap();
    let open = if bytes[open] == b'\n' { open + 1 } else { open };
    let digits_end = bytes[..open].iter().rposition(u8::is_ascii_digit).unwrap() + 1;
    let digits_start = bytes[..digits_end]
        .iter()
        .rposition(|b| !b.is_ascii_digit())
        .unwrap()
        + 1;
    let count: usize = std::str::from_utf8(&bytes[digits_start..digits_end])
        .unwrap()
        .parse()
        .unwrap();
    bytes[open + 1..]
        .chunks_exact(8)
        .take(count * components)
        .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap()))
        .collect()
}

const BLOCK_MESH: &str = include_str!("../../../of-adapter/check/blockMeshDict");
