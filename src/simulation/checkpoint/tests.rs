use super::*;
use crate::coupling::acceleration::SecantPair;
use crate::coupling::acceptance::Balance;
use crate::pfem::SurfaceLoad;
use crate::pfem::solution::quasi_newton::QuasiNewtonPairs;
use crate::pfem::solution::structure::{self, Linearization, State};
use crate::simulation::subdivision::StepSubdivision;
use nalgebra::DVector;
use proptest::prelude::*;

type Example = Checkpoint<structure::StructureMemory, (u64, Vec<String>)>;

pub fn example(step: usize) -> Example {
    let column = SecantPair::new(
        DVector::from_vec(vec![0.1, 0.2, 0.3]),
        DVector::from_vec(vec![1.0, -2.0, 0.5]),
        1.0,
    );
    let d = vec![1e-5, -2e-5, 1.0 / 3.0];
    Checkpoint {
        case: CaseIdentity {
            values: "[time]\nstep_s = 0.002\n".into(),
            files: Vec::new(),
        },
        files: Vec::new(),
        clock: ClockReading {
            steps: step,
            subdivision: StepSubdivision::default(),
        },
        totals: Totals::default(),
        fluid: FluidMemory {
            state: vec![1, 2, 3],
            files: vec!["openfoam/0.02/U".into()],
        },
        structure: structure::StructureMemory {
            time: 0.25,
            state: State {
                d: d.clone(),
                v: d.clone(),
                a: d.clone(),
            },
            tangent: Some((linearization(d.clone()), QuasiNewtonPairs::default())),
            renewal: Some((linearization(d.clone()), 3)),
        },
        balance: Balance::default(),
        coupling: fixed_point::FixedPointMemory {
            displacements: vec![d, vec![0.0; 3]],
            predictor_errors: vec![f64::INFINITY, 0.1],
            acceleration: crate::coupling::acceleration::AccelerationMemory {
                factor: Some(0.1),
                fits: vec![Vec::new(), column.into_iter().collect()],
                surrogate: Default::default(),
            },
        },
        observer: (7, vec!["structure/00000.vtu".into()]),
    }
}

#[test]
fn what_was_written_is_read_again() {
    assert_eq!(Example::decode(&example(3).encode()), Ok(example(3)));
}

#[test]
fn every_truncation_and_every_changed_byte_is_noticed() {
    let bytes = example(3).encode();
    for n in 0..bytes.len() {
        assert!(Example::decode(&bytes[..n]).is_err(), "{n} bytes");
        let mut changed = bytes.clone();
        changed[n] ^= 1 << (n % 8);
        assert!(Example::decode(&changed).is_err(), "byte {n}");
    }
    let mut longer = bytes;
    longer.push(0);
    assert!(matches!(
        Example::decode(&longer),
        Err(DecodeError::Length { .. })
    ));
}

proptest! {
    #[test]
    fn no_bytes_bring_the_reader_down(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = Example::decode(&bytes);
        let _ = Example::decode(&with_head(&bytes));
    }

    #[test]
    fn no_change_under_a_right_checksum_crashes_the_reader(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut payload = example(3).encode().split_off(HEAD);
        for (at, byte) in changes {
            let n = payload.len();
            payload[at.index(n)] = byte;
        }
        let _ = Example::decode(&with_head(&payload));
        payload.truncate(cut.index(payload.len()));
        let _ = Example::decode(&with_head(&payload));
    }
}

/// The last two checkpoints are kept.
#[test]
fn the_older_checkpoint_serves_if_the_newer_is_damaged() {
    let run = tempfile::tempdir().unwrap();
    let store = Store::new(run.path());
    assert!(matches!(newest(&store), Err(StoreError::None(_))));
    for step in [0, 5, 10] {
        store.write(&example(step)).unwrap();
        store.tidy(step).unwrap();
    }
    assert_eq!(store.steps().unwrap(), [10, 5]);
    assert_eq!(newest(&store).unwrap().checkpoint.step(), 10);

    let bytes = std::fs::read(store.path(10)).unwrap();
    std::fs::write(store.path(10), &bytes[..bytes.len() / 2]).unwrap();
    let found = newest(&store).unwrap();
    assert_eq!(found.checkpoint.step(), 5);
    assert!(
        found.damaged[0].contains("00000010.checkpoint: it has"),
        "{:?}",
        found.damaged
    );
    std::fs::write(store.path(5), "").unwrap();
    assert!(matches!(newest(&store), Err(StoreError::Damaged(all)) if all.len() == 2));
}

#[test]
fn a_checkpoint_whose_files_have_changed_is_passed_over() {
    let run = tempfile::tempdir().unwrap();
    let store = Store::new(run.path());
    store.write(&example(1)).unwrap();
    let file = run.path().join("history.csv");
    std::fs::write(&file, "a row\n").unwrap();
    let mut newer = example(2);
    newer.files = vec![FileFingerprint::of(run.path(), "history.csv".as_ref(), None).unwrap()];
    store.write(&newer).unwrap();
    std::fs::write(&file, "a row\nand another\n").unwrap();
    assert_eq!(newest(&store).unwrap().checkpoint.step(), 2);
    for content in ["b row\n", "a r"] {
        std::fs::write(&file, content).unwrap();
        assert_eq!(newest(&store).unwrap().checkpoint.step(), 1);
    }
}

fn newest(
    store: &Store,
) -> Result<Found<structure::StructureMemory, (u64, Vec<String>)>, StoreError> {
    store.newest()
}

fn linearization(d: Vec<f64>) -> Linearization {
    Linearization {
        d,
        linearized_at: None,
        v: None,
        load: SurfaceLoad {
            pressure: vec![1e4],
            shear: vec![crate::Vec3::new(0.1, 0.2, 0.3)],
        },
        dt: 0.002,
    }
}
