//! The elimination tree of the supernodes of a factor.
//!
//! A column of the factor changes only its ancestors in the elimination tree (Liu: *The role of elimination trees in
//! sparse factorization*, 1990), so disjoint subtrees go side by side. Which subtrees depends on the matrix alone, and
//! so does the result.

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use std::ops::Range;

/// The columns of a supernode.
pub fn columns(symbolic: &SymbolicSupernodalCholesky<usize>, s: usize) -> Range<usize> {
    symbolic.supernode_begin()[s]..symbolic.supernode_end()[s]
}

/// Children of each supernode.
#[derive(Debug)]
pub struct Tree {
    /// In ascending order.
    pub children: Vec<Vec<usize>>,
    /// Supernodes without a parent.
    pub roots: Vec<usize>,
}

/// Disjoint subtrees and what lies above them.
#[derive(Debug)]
pub struct Division {
    /// Roots of the subtrees.
    pub roots: Vec<usize>,
    /// The supernodes above them, in the order of elimination.
    pub top: Vec<usize>,
}

impl Tree {
    /// Of the supernodes of a factor.
    pub fn new(symbolic: &SymbolicSupernodalCholesky<usize>) -> Self {
        let count = symbolic.n_supernodes();
        let mut supernode_of = vec![0; symbolic.nrows()];
        for s in 0..count {
            supernode_of[columns(symbolic, s)].fill(s);
        }
        let (mut children, mut roots) = (vec![Vec::new(); count], Vec::new());
        for s in 0..count {
            match symbolic.supernode(s).pattern().first() {
                Some(&row) => children[supernode_of[row]].push(s),
                None => roots.push(s),
            }
        }
        Self { children, roots }
    }

    /// Divides the tree until no subtree has more than a `share` of the sum of the `weights` of all supernodes.
    pub fn divide(&self, weights: Vec<f64>, share: f64) -> Division {
        let (total, weights) = (weights.iter().sum::<f64>(), self.of_subtrees(weights));
        let (mut roots, mut top) = (self.roots.clone(), Vec::new());
        let weight = |roots: &[usize], place: usize| weights[roots[place]];
        while let Some(heaviest) =
            (0..roots.len()).max_by(|&a, &b| weight(&roots, a).total_cmp(&weight(&roots, b)))
            && weight(&roots, heaviest) > share * total
        {
            let root = roots.swap_remove(heaviest);
            roots.extend(&self.children[root]);
            top.push(root);
        }
        top.sort_unstable();
        Division { roots, top }
    }

    /// The supernode without which no part of the tree has more than half of the sum of the `weights` of all
    /// supernodes, unless there are several roots.
    pub fn centre(&self, weights: Vec<f64>) -> usize {
        let (total, weights) = (weights.iter().sum::<f64>(), self.of_subtrees(weights));
        let heaviest = |among: &[usize]| {
            let among = among.iter().copied();
            among.max_by(|&a, &b| weights[a].total_cmp(&weights[b]))
        };
        let mut centre = heaviest(&self.roots).unwrap_or_default();
        while let Some(child) = heaviest(&self.children[centre])
            && weights[child] > 0.5 * total
        {
            centre = child;
        }
        centre
    }

    /// Another order of the columns with the same entries of the factor, whose tree has this supernode as a root (Liu:
    /// *Equivalent sparse matrix reordering by elimination tree rotations*, 1988).
    ///
    /// The rows of a supernode depend on each other in the factor. Whatever part of the tree is left, a supernode on
    /// its edge has no rows but those it shares with the next one and its own, which may be eliminated without any new
    /// entry.
    pub fn rooted_at(
        &self,
        symbolic: &SymbolicSupernodalCholesky<usize>,
        root: usize,
    ) -> Vec<usize> {
        let mut next = self.children.clone();
        for (parent, children) in self.children.iter().enumerate() {
            children.iter().for_each(|&child| next[child].push(parent));
        }
        let mut backwards = Vec::with_capacity(symbolic.nrows());
        let mut is_listed = vec![false; symbolic.nrows()];
        let mut is_visited = vec![false; self.children.len()];
        for root in std::iter::once(root).chain(self.roots.iter().copied()) {
            let mut waiting = vec![root];
            while let Some(s) = waiting.pop() {
                if std::mem::replace(&mut is_visited[s], true) {
                    continue;
                }
                let below = symbolic.supernode(s).pattern().iter().copied();
                for row in columns(symbolic, s).chain(below) {
                    if !std::mem::replace(&mut is_listed[row], true) {
                        backwards.push(row);
                    }
                }
                waiting.extend(&next[s]);
            }
        }
        backwards.reverse();
        backwards
    }

    /// The sum of the weights of each subtree.
    fn of_subtrees(&self, mut weights: Vec<f64>) -> Vec<f64> {
        // Parents come after their children.
        for s in 0..weights.len() {
            weights[s] += self.children[s].iter().map(|&c| weights[c]).sum::<f64>();
        }
        weights
    }

    /// The supernodes of the subtree of a `root`, each right after those of its own subtree.
    pub fn postorder(&self, root: usize) -> Vec<usize> {
        // Parents before their children, the last child first; backwards, that is a postorder.
        let (mut order, mut waiting) = (Vec::new(), vec![root]);
        while let Some(s) = waiting.pop() {
            order.push(s);
            waiting.extend(&self.children[s]);
        }
        order.reverse();
        order
    }
}
