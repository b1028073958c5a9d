//! The nearest of many points, without looking at all of them.

use crate::Vec3;

/// Points in halves of halves: a k-d tree (Bentley: *Multidimensional binary search trees used for associative searching*,
/// 1975). A part of the list has its median in the middle, what is smaller in the direction of its cut before, the rest behind.
pub struct Nearest<'a> {
    points: &'a [Vec3],
    order: Vec<usize>,
    /// Direction in which the part with this middle is cut.
    cuts: Vec<u8>,
}

impl<'a> Nearest<'a> {
    /// Sorts the points.
    pub fn of(points: &'a [Vec3]) -> Self {
        let mut order: Vec<usize> = (0..points.len()).collect();
        let mut cuts = vec![0; points.len()];
        divide(points, &mut order, &mut cuts);
        Self {
            points,
            order,
            cuts,
        }
    }

    /// The nearest one, of several as near the first; none if there are no points.
    pub fn to(&self, target: &Vec3) -> Option<usize> {
        let mut best = (f64::INFINITY, usize::MAX);
        self.search(target, 0..self.order.len(), &mut best);
        (best.1 != usize::MAX).then_some(best.1)
    }

    fn search(&self, target: &Vec3, part: std::ops::Range<usize>, best: &mut (f64, usize)) {
        if part.is_empty() {
            return;
        }
        let middle = part.start + part.len() / 2;
        let point = self.order[middle];
        let gap = target - self.points[point];
        let found = (gap.norm_squared(), point);
        if found < *best {
            *best = found;
        }
        let beyond = gap[usize::from(self.cuts[middle])];
        let (before, behind) = (part.start..middle, middle + 1..part.end);
        let (near, far) = match beyond < 0.0 {
            true => (before, behind),
            false => (behind, before),
        };
        self.search(target, near, best);
        if beyond * beyond <= best.0 {
            self.search(target, far, best);
        }
    }
}

/// Cuts the list across the direction in which its points lie farthest apart, then each half.
fn divide(points: &[Vec3], order: &mut [usize], cuts: &mut [u8]) {
    let (Some(&first), middle) = (order.first(), order.len() / 2) else {
        return;
    };
    let ends = (points[first], points[first]);
    let (low, high) = (order.iter()).fold(ends, |(low, high), &i| {
        (low.inf(&points[i]), high.sup(&points[i]))
    });
    let axis = (high - low).imax();
    order.select_nth_unstable_by(middle, |&a, &b| points[a][axis].total_cmp(&points[b][axis]));
    cuts[middle] = axis as u8;
    let ((before, behind), (cuts_before, cuts_behind)) =
        (order.split_at_mut(middle), cuts.split_at_mut(middle));
    divide(points, before, cuts_before);
    divide(points, &mut behind[1..], &mut cuts_behind[1..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a lattice, where many are as near as others, and targets on it, between and outside.
    #[test]
    fn it_is_the_one_that_is_found_by_looking_at_all() {
        let place = |i: usize| Vec3::new((i % 7) as f64, (i * i % 5) as f64, (i % 3) as f64);
        let points: Vec<Vec3> = (0..200).map(place).collect();
        let nearest = Nearest::of(&points);
        for i in 0..500 {
            let target = 0.5 * place(3 * i + 1) - Vec3::repeat(0.25 * (i % 4) as f64);
            let distance = |p: &Vec3| (target - p).norm_squared();
            let all = (0..points.len())
                .min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b])));
            assert_eq!(nearest.to(&target), all, "{target}");
        }
        assert_eq!(Nearest::of(&[]).to(&Vec3::zeros()), None);
    }
}
