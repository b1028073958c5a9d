//! What a machine can do at the moment, on one thread and on all: `cargo bench --bench yardstick`. Seconds of runs
//! compare only beside it: bytes read and written when an array that is far larger than any cache is copied (McCalpin's
//! STREAM counts them so), and operations of products of matrices that fit in the cache, in double precision.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;
use std::time::Instant;

/// Entries of the array: 256 MB.
const ENTRIES: usize = 1 << 25;
/// Rows and columns of a matrix.
const SIZE: usize = 1024;
/// The best of so many counts.
const TIMES: usize = 8;

/// The shortest time that it takes, s.
fn seconds(mut work: impl FnMut()) -> f64 {
    let mut once = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    once(0);
    (0..TIMES).map(once).fold(f64::INFINITY, f64::min)
}

fn main() {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (mut to, from) = (vec![0.0; ENTRIES], vec![1.0; ENTRIES]);
    let [p, q] = [1.0, 2.0].map(|x| Mat::from_fn(SIZE, SIZE, |i, j| x + (i * j % 7) as f64));
    let mut product = Mat::zeros(SIZE, SIZE);
    for threads in [1, threads] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        let copy = pool.install(|| {
            seconds(|| {
                let parts = to.par_chunks_mut(1 << 16).zip(from.par_chunks(1 << 16));
                parts.for_each(|(to, from)| to.copy_from_slice(from));
            })
        });
        let parallel = if threads == 1 {
            Par::Seq
        } else {
            Par::rayon(threads)
        };
        let products = pool
            .install(|| seconds(|| matmul(&mut product, Accum::Replace, &p, &q, 1.0, parallel)));
        println!(
            "{threads} threads: {:.1} GB/s, {:.0} GFlop/s",
            16e-9 * ENTRIES as f64 / copy,
            2e-9 * (SIZE as f64).powi(3) / products
        );
    }
}
