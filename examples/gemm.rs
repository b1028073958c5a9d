use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
fn main() {
    for (m, k, n) in [
        (3750, 24, 25),
        (14406, 32, 49),
        (150, 6, 25),
        (294, 8, 49),
        (25, 6, 216),
        (49, 8, 384),
        (50, 375, 50),
        (105, 1029, 105),
        (4096 * 6 / 16, 16, 16),
        (500, 500, 500),
    ] {
        let a = vec![1.0; m * k];
        let b = vec![1.0; k * n];
        let mut c = vec![0.0; m * n];
        let t0 = std::time::Instant::now();
        let reps = (1e9 / (2.0 * (m * k * n) as f64)).max(1.0) as usize;
        let mut best = f64::INFINITY;
        for _ in 0..20 {
            let t0 = std::time::Instant::now();
            for _ in 0..(reps / 20).max(1) {
                matmul(
                    MatMut::from_column_major_slice_mut(&mut c, m, n),
                    Accum::Replace,
                    MatRef::from_column_major_slice(&a, m, k),
                    MatRef::from_column_major_slice(&b, n, k).transpose(),
                    1.0,
                    Par::Seq,
                );
            }
            best = best.min(t0.elapsed().as_secs_f64() / (reps / 20).max(1) as f64);
        }
        let _ = t0;
        println!(
            "{m} {k} {n}: {:.2} us {:.1} GF",
            best * 1e6,
            2.0 * (m * k * n) as f64 / best * 1e-9
        );
    }
}
