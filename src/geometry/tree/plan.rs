//! The search for the best layout of a junction.

use super::error::TreeError;
use super::junction::{Junction, Parting, Site};
use super::layout::Layout;
use super::slicer::Slicer;
use crate::Vec3;
use crate::curve::CentreLine;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Distances of a junction's centre upstream of its apices that are tried, in radii of the parent.
const BACK: [f64; 9] = [0.3, 0.45, 0.6, 0.75, 0.9, 1.05, 1.2, 1.35, 1.5];
/// ... and those that are tried too where one of the branches is a sac, whose neck may be wide.
const BACK_OF_SAC: [f64; 4] = [1.7, 1.9, 2.2, 2.5];
/// Where the best one mostly is.
const MIDDLE: f64 = 0.95;
/// If the best one is no better than this, other layouts are searched for ...
pub(super) const GOOD: f64 = 0.3;
/// ... until one is better than this: what is more usual makes runs more accurate ...
const ENOUGH: f64 = 0.32;
/// ... in steps of this share of the longest ones, which are halved as long as they are at least the second ...
const FIRST: f64 = 0.5;
const SHORTEST: f64 = 0.2;
/// ... and at last from these distances on, beginning with the longest ones.
const STARTS: [f64; 2] = [1.05, 0.75];
/// A layout is better than another by more than this: in a tree that is turned, rounding then chooses no other one.
const SAME: f64 = 1e-6;

/// Where the half-discs of a junction lie, and how good that is.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Which of the ways to find apices.
    way: usize,
    layout: Layout,
    /// See [`Junction::worst`].
    pub worst: f64,
}

/// The layouts of a junction.
pub struct Search<'a> {
    site: Site<'a>,
    /// Found in each way that there is.
    apices: Vec<Result<Vec<Vec3>, TreeError>>,
}

impl Plan {
    /// The best plan for lines that part, searched for if it is not known yet: a case is meshed for each preset and
    /// fluid.
    ///
    /// # Errors
    /// If none fits.
    pub fn new(slicer: &Slicer, trunk: &CentreLine, parting: &Parting) -> Result<Self, TreeError> {
        static KNOWN: Mutex<BTreeMap<u64, Result<Plan, TreeError>>> = Mutex::new(BTreeMap::new());
        let all = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let asked = fingerprint(slicer, parting);
        let known = all().get(&asked).cloned();
        known.unwrap_or_else(|| {
            let found = Search::new(slicer, trunk, parting).any();
            all().insert(asked, found.clone());
            found
        })
    }
}

/// What decides the plan for lines that part.
fn fingerprint(slicer: &Slicer, parting: &Parting) -> u64 {
    let Slicer { lumen, grid, along } = slicer;
    let mut hasher = DefaultHasher::new();
    let mut add = |numbers: &[f64]| numbers.iter().for_each(|x| x.to_bits().hash(&mut hasher));
    for line in lumen.lines.iter().chain(lumen.lines_without_features()) {
        add(&line.radii);
        line.points.iter().for_each(|x| add(x.as_slice()));
    }
    if let Some(search) = &lumen.surface {
        (search.surface().points().iter()).for_each(|x| add(x.as_slice()));
    }
    for (line, s) in parting {
        add(&[*line as f64, *s]);
    }
    add(&grid.rings);
    add(&[grid.around() as f64, grid.degree() as f64, *along]);
    let is_closed = lumen.lines.iter().map(|line| line.is_closed);
    (is_closed.collect::<Vec<bool>>(), &lumen.left_out).hash(&mut hasher);
    hasher.finish()
}

impl<'a> Search<'a> {
    /// For lines that part in these cells or elements.
    pub fn new(slicer: &'a Slicer, trunk: &'a CentreLine, parting: &Parting) -> Self {
        let site = Site::new(slicer, trunk, parting);
        let apices = site.apices();
        Self { site, apices }
    }

    /// The junction that is planned for these cells or elements.
    ///
    /// # Errors
    /// See [`Site::junction`].
    pub fn junction(&self, plan: &Plan) -> Result<Junction, TreeError> {
        let apices = self.apices[plan.way].as_ref().map_err(Clone::clone)?;
        let mut junction = self.site.junction(apices, &plan.layout)?;
        junction.worst = plan.worst;
        Ok(junction)
    }

    /// What is planned for other cells or elements, changed a bit if it is not good in these.
    ///
    /// # Errors
    /// See [`Site::junction`].
    pub fn adapted(&self, plan: &Plan) -> Result<Plan, TreeError> {
        let plan = self.plan(plan.way, plan.layout, || f64::NEG_INFINITY)?;
        Ok(self.improved(plan, (Layout::NUMBERS, FIRST), GOOD))
    }

    /// The best of the usual layouts.
    ///
    /// # Errors
    /// See [`Site::junction`].
    pub fn usual(&self) -> Result<Plan, TreeError> {
        let lines = &self.site.slicer.lumen.lines;
        let is_sac = |(line, _): &(usize, f64)| lines[*line].is_closed;
        let further = match self.site.order.iter().any(is_sac) {
            true => &BACK_OF_SAC[..],
            false => &[],
        };
        let known = Mutex::new(f64::NEG_INFINITY);
        let best_known = || known.lock().unwrap_or_else(PoisonError::into_inner);
        let tried = |way: usize, back: f64| {
            let plan = self.plan(way, Layout::usual(back), || *best_known())?;
            let mut known = best_known();
            *known = known.max(plan.worst);
            Ok(plan)
        };
        let mut all: Vec<(usize, (usize, f64))> = (0..self.apices.len())
            .flat_map(|way| BACK.iter().chain(further).map(move |back| (way, *back)))
            .enumerate()
            .collect();
        // Those in the middle are mostly good: the others are then soon known to be worse.
        let off = |back: f64| (back - MIDDLE).abs();
        all.sort_by(|(_, (_, a)), (_, (_, b))| off(*a).total_cmp(&off(*b)));
        let all = all.into_par_iter();
        let mut all: Vec<(usize, Result<Plan, TreeError>)> = all
            .map(|(number, (way, back))| (number, tried(way, back)))
            .collect();
        all.sort_by_key(|(number, _)| *number);
        let all = all.into_iter().map(|(_, tried)| tried);
        let best = all.reduce(|best, tried| match (best, tried) {
            (Ok(best), Ok(tried)) if best.worst >= tried.worst => Ok(best),
            (Ok(best), Err(_)) => Ok(best),
            (_, tried) => tried,
        });
        best.expect("some are tried")
    }

    /// A better layout than the best of the usual ones: with half-discs through the apices if one of those is good.
    fn any(&self) -> Result<Plan, TreeError> {
        let usual = self.usual();
        let way = usual.as_ref().ok().map(|plan| plan.way);
        let Some(way) = way.or_else(|| self.apices.iter().position(Result::is_ok)) else {
            return usual;
        };
        let improved = |start, numbers, step| self.improved(start, (numbers, step), ENOUGH);
        let elsewhere = |back: &f64| {
            let layout = Layout::usual(*back);
            self.plan(way, layout, || f64::NEG_INFINITY).ok()
        };
        let first = usual.as_ref().ok();
        let mut best = first.map(|start| improved(*start, Layout::AT_APICES, FIRST));
        let others = STARTS.iter().filter_map(elsewhere);
        let starts = best.map(|start| (start, FIRST)).into_iter();
        for (start, step) in starts.chain(others.map(|start| (start, 1.0))) {
            if best.is_some_and(|best| best.worst > GOOD) {
                break;
            }
            let found = improved(start, Layout::NUMBERS, step);
            if best.is_none_or(|best| found.worst > best.worst) {
                best = Some(found);
            }
        }
        best.map_or(usual, Ok)
    }

    /// The best layout that steps lead to, in one number each, shorter ones where no longer one makes it better, until
    /// it is better than `enough` (compass search: Kolda, Lewis and Torczon, *Optimization by direct search*, SIAM
    /// Review 45, 2003).
    fn improved(&self, start: Plan, (numbers, mut step): (Range<usize>, f64), enough: f64) -> Plan {
        let mut best = start;
        while step >= SHORTEST && best.worst <= enough {
            let steps: Vec<(usize, f64)> = (numbers.clone())
                .flat_map(|number| [(number, -step), (number, step)])
                .collect();
            let better = |(number, step): &(usize, f64)| {
                let layout = best.layout.varied(*number, *step)?;
                let plan = self.plan(best.way, layout, || best.worst).ok()?;
                (plan.worst > best.worst + SAME).then_some(plan)
            };
            let all: Vec<Option<Plan>> = steps.par_iter().map(better).collect();
            // Of equal ones always the same one.
            let all = all.into_iter().flatten();
            let better = |a: Plan, b: Plan| match b.worst > a.worst + SAME {
                true => b,
                false => a,
            };
            match all.reduce(better) {
                Some(better) => best = better,
                None => step *= 0.5,
            }
        }
        best
    }

    /// This layout, and how good it is: exactly unless that is less than `least`.
    fn plan(&self, way: usize, layout: Layout, least: impl Fn() -> f64) -> Result<Plan, TreeError> {
        let apices = self.apices[way].as_ref().map_err(Clone::clone)?;
        let junction = self.site.junction(apices, &layout)?;
        let worst = junction.quality(&self.site, least)?;
        Ok(Plan { way, layout, worst })
    }
}
