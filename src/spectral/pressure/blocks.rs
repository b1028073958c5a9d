//! The inverses of the Schur complement within each element.

use super::super::contraction::LANES;
use super::super::divergence::{BlockScratch, block};
use super::super::spectral_elements::{CHUNK, SpectralElements};
use super::{NotPositive, add_sums};
use faer::Side;
use faer::linalg::solvers::DenseSolveCore;
use rayon::prelude::*;

/// Inverses within the elements. Of unknowns that `k` elements share each takes and gives the share `k^(-1/2)`.
pub(super) struct Blocks {
    /// Lower triangles row by row, of [`LANES`] elements side by side.
    triangles: Vec<f32>,
    /// `k^(-1/2)`.
    shares: Vec<f64>,
}

impl Blocks {
    pub fn new(
        space: &SpectralElements,
        of_elements: &[Vec<f64>],
        inverse_diagonal: &[f64],
    ) -> Result<Self, NotPositive> {
        let p3 = space.pressure_count();
        let triangle = p3 * (p3 + 1) / 2;
        let inverses: Vec<Vec<f32>> = (0..space.space.elements)
            .into_par_iter()
            .map_init(
                || BlockScratch::new(&space.space),
                |scratch, e| {
                    let block = block(&space.space, of_elements, inverse_diagonal, e, scratch);
                    let factor = block.llt(Side::Lower).map_err(|_| NotPositive)?;
                    let inverse = factor.inverse();
                    let rows = (0..p3).map(|i| (0..=i).map(move |j| (i, j)));
                    Ok(rows.flatten().map(|place| inverse[place] as f32).collect())
                },
            )
            .collect::<Result<_, _>>()?;
        let mut triangles = vec![0.0; space.groups() * triangle * LANES];
        (triangles.par_chunks_mut(triangle * LANES).enumerate()).for_each(|(group, out)| {
            for (lane, own) in inverses[group * LANES..].iter().take(LANES).enumerate() {
                let places = out.iter_mut().skip(lane).step_by(LANES);
                places.zip(own).for_each(|(out, value)| *out = *value);
            }
        });
        let starts = space.space.pressure_starts.windows(2);
        Ok(Self {
            triangles,
            shares: starts
                .map(|ends| f64::from(ends[1] - ends[0]).sqrt().recip())
                .collect(),
        })
    }

    /// Adds their sum for a residual `r`, `scale` times, to `x`; `local` is memory for the results of the elements.
    pub fn add(
        &self,
        space: &SpectralElements,
        r: &[f64],
        scale: f64,
        local: &mut [f64],
        x: &mut [f64],
    ) {
        let p3 = space.pressure_count();
        let weighted: Vec<f64> = (r.par_iter().zip(&self.shares).with_min_len(CHUNK))
            .map(|(r, share)| r * share * scale)
            .collect();
        local.par_chunks_mut(p3 * LANES).enumerate().for_each_init(
            || (vec![[0.0; LANES]; p3], vec![[0.0; LANES]; p3]),
            |(input, output), (group, local)| {
                space.gather_pressures(group, &weighted, local);
                for (input, local) in input.iter_mut().zip(local.chunks_exact(LANES)) {
                    *input = std::array::from_fn(|lane| local[lane] as f32);
                }
                let size = p3 * (p3 + 1) / 2 * LANES;
                let triangle = &self.triangles[size * group..size * (group + 1)];
                multiply(triangle, input, output);
                for (output, local) in output.iter().zip(local.chunks_exact_mut(LANES)) {
                    (0..LANES).for_each(|lane| local[lane] = f64::from(output[lane]));
                }
            },
        );
        add_sums(space, local, &self.shares, x);
    }
}

/// Products of symmetric matrices, of which there are lower triangles row by row, and vectors side by side.
fn multiply(triangle: &[f32], input: &[[f32; LANES]], output: &mut [[f32; LANES]]) {
    output.fill([0.0; LANES]);
    let (values, _) = triangle.as_chunks::<LANES>();
    let mut first = 0;
    for (i, x) in input.iter().enumerate() {
        let (row, diagonal) = (&values[first..first + i], &values[first + i]);
        let (above, rest) = output.split_at_mut(i);
        let mut sum: [f32; LANES] = std::array::from_fn(|lane| diagonal[lane] * x[lane]);
        for ((a, x_j), y_j) in row.iter().zip(input).zip(above) {
            for lane in 0..LANES {
                sum[lane] += a[lane] * x_j[lane];
                y_j[lane] += a[lane] * x[lane];
            }
        }
        rest[0] = sum;
        first += i + 1;
    }
}
