//! The nearest of many points, without looking at all of them.

use crate::Vec3;
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Points in an R*-tree, with their numbers.
pub struct Nearest(RTree<GeomWithData<[f64; 3], usize>>);

impl Nearest {
    /// Sorts the points.
    pub fn of(points: &[Vec3]) -> Self {
        let numbered = points.iter().enumerate();
        let numbered = numbered.map(|(i, point)| GeomWithData::new((*point).into(), i));
        Self(RTree::bulk_load(numbered.collect()))
    }

    /// The nearest one that `counts`, of several as near the first; none if there is none.
    pub fn to(&self, target: &Vec3, counts: impl Fn(usize) -> bool) -> Option<usize> {
        let found = self
            .0
            .nearest_neighbor_iter_with_distance_2((*target).into());
        let mut found = found.filter(|(point, _)| counts(point.data));
        let (first, nearest) = found.next()?;
        let as_near = found.take_while(|(_, distance)| *distance == nearest);
        let others = as_near.map(|(point, _)| point.data);
        others.chain([first.data]).min()
    }
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
            assert_eq!(nearest.to(&target, |_| true), all, "{target}");
            let odd = (1..points.len()).step_by(2);
            let odd = odd.min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b])));
            assert_eq!(nearest.to(&target, |point| point % 2 == 1), odd, "{target}");
        }
        assert_eq!(Nearest::of(&[]).to(&Vec3::zeros(), |_| true), None);
    }
}
