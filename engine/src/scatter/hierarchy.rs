//! A matrix between the nodes of a surface as a hierarchy of blocks, in f32.
//!
//! Nodes are sorted by halving boxes. Blocks between clusters that are apart have few independent rows: adaptive cross
//! approximation finds them one after the other from single rows and columns, until a cross no longer counts (M. Bebendorf,
//! Numerische Mathematik 86, 565, 2000). Other blocks are stored whole. For 10 000 nodes this takes a quarter of the memory of the
//! whole matrix and half the time.

use std::ops::Range;

use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::scatter::facets::{Facet, Wall};
use crate::scatter::pairs::{self, Many, OUTSIDE, One, Panel};
use crate::scatter::table::{Add, Dot, LANES, Sixteen, Sums, Table, by_sixteen, rounded};
use crate::simd::Isa;

/// Most nodes of a cluster that is not halved.
const LEAF: usize = 64;
/// Fewest nodes of clusters whose block is approximated.
const FEWEST: usize = 64;
/// Relative error (Frobenius) of approximated blocks.
const TOLERANCE: f32 = 1e-3;
/// Fewest vectors that are worth a product of sixteen.
const SEVERAL: usize = 4;

/// A node of the tree.
#[derive(Clone, Debug)]
struct Cluster {
    nodes: Range<usize>,
    /// m
    low: DVec3,
    high: DVec3,
    children: Option<[usize; 2]>,
}

impl Cluster {
    fn diameter(&self) -> f64 {
        (self.high - self.low).length()
    }

    fn distance(&self, other: &Self) -> f64 {
        (self.low - other.high).max(other.low - self.high).max(DVec3::ZERO).length()
    }
}

/// The tree of clusters, the whole first.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    clusters: Vec<Cluster>,
    /// Vertices in the sequence of the tree.
    pub order: Vec<u32>,
}

impl Tree {
    pub fn new(places: &[DVec3]) -> Self {
        let mut tree = Self { clusters: Vec::new(), order: (0..places.len() as u32).collect() };
        tree.halve(places, 0..places.len());
        tree
    }

    fn halve(&mut self, places: &[DVec3], nodes: Range<usize>) -> usize {
        let own = &mut self.order[nodes.clone()];
        let grow = |(low, high): (DVec3, DVec3), &node: &u32| {
            (low.min(places[node as usize]), high.max(places[node as usize]))
        };
        let (low, high) = own.iter().fold((DVec3::MAX, DVec3::MIN), grow);
        let index = self.clusters.len();
        self.clusters.push(Cluster { nodes: nodes.clone(), low, high, children: None });
        if nodes.len() > LEAF {
            let sides = (high - low).to_array();
            let axis = (0..3).fold(0, |best, axis| if sides[axis] > sides[best] { axis } else { best });
            let by_place = |&a: &u32, &b: &u32| {
                places[a as usize][axis].total_cmp(&places[b as usize][axis]).then(a.cmp(&b))
            };
            own.sort_unstable_by(by_place);
            let middle = nodes.start + nodes.len() / 2;
            let children = [self.halve(places, nodes.start..middle), self.halve(places, middle..nodes.end)];
            self.clusters[index].children = Some(children);
        }
        index
    }

    /// Nodes of the clusters that are not halved.
    pub fn leaves(&self) -> impl Iterator<Item = Range<usize>> {
        self.clusters.iter().filter(|cluster| cluster.children.is_none()).map(|cluster| cluster.nodes.clone())
    }
}

/// A block: whole, or a sum of crosses, Aᵀ B.
#[derive(Clone, Debug)]
enum Content {
    Whole(Table),
    Crosses { columns: Table, rows: Table },
}

#[derive(Clone, Debug)]
struct Block {
    rows: Range<usize>,
    columns: Range<usize>,
    content: Content,
}

impl Block {
    /// Nodes of the product and of the vector.
    fn sides(&self, is_transposed: bool) -> (Range<usize>, Range<usize>) {
        match is_transposed {
            false => (self.rows.clone(), self.columns.clone()),
            true => (self.columns.clone(), self.rows.clone()),
        }
    }

    /// The first step of crosses.
    fn by_crosses(&self, x: &[Sixteen], is_transposed: bool) -> Option<Vec<Sixteen>> {
        let Content::Crosses { columns, rows } = &self.content else { return None };
        let first = if is_transposed { columns } else { rows };
        let mut sums = vec![[[0.0; LANES]; 2]; first.rows];
        first.add_times(0..first.rows, x, &mut sums);
        Some(rounded(&sums))
    }

    fn times(&self, x: &[Complex32], is_transposed: bool) -> Vec<Complex32> {
        match (&self.content, is_transposed) {
            (Content::Whole(table), false) => table.times(x),
            (Content::Whole(table), true) => table.transposed_times(x),
            (Content::Crosses { columns, rows }, false) => columns.transposed_times(&rows.times(x)),
            (Content::Crosses { columns, rows }, true) => rows.transposed_times(&columns.times(x)),
        }
    }
}

/// The matrix of the rule of three points on all pairs of different triangles.
#[derive(Clone, Debug)]
pub(super) struct Hierarchy {
    count: usize,
    leaves: Vec<Range<usize>>,
    blocks: Vec<Block>,
}

/// What the entries are made of.
struct Source<'a> {
    wall: &'a Wall,
    tree: &'a Tree,
    ones: Vec<One>,
    /// Around each node in the sequence of the tree, with the node's corner.
    around: Vec<Vec<(u32, usize)>>,
    /// For each cluster.
    panels: Vec<Panel>,
}

impl Hierarchy {
    /// Entries between the nodes in the sequence of the tree.
    pub fn new(wall: &Wall, facets: &[Facet], tree: &Tree) -> Self {
        let source = Source::new(wall, facets, tree);
        let mut pairs = Vec::new();
        source.pairs((0, 0), &mut pairs);
        let blocks = pairs.into_par_iter().flat_map_iter(|pair| source.blocks(pair)).collect();
        Self { count: tree.order.len(), leaves: tree.leaves().collect(), blocks }
    }

    /// A x or Aᵀ x for several x.
    pub fn times(&self, vectors: &[Vec<Complex64>], is_transposed: bool) -> Vec<Vec<Complex64>> {
        if vectors.len() >= SEVERAL {
            return self.times_by_sixteen(vectors, is_transposed);
        }
        let short: Vec<Vec<_>> = vectors
            .iter()
            .map(|x| x.iter().map(|x| Complex32::new(x.re as f32, x.im as f32)).collect())
            .collect();
        let of_block = |block: &Block| {
            let (_, from) = block.sides(is_transposed);
            short.iter().map(|x| block.times(&x[from.clone()], is_transposed)).collect::<Vec<_>>()
        };
        let products: Vec<_> = self.blocks.par_iter().map(of_block).collect();
        let mut sums = vec![vec![Complex64::ZERO; self.count]; vectors.len()];
        for (block, products) in self.blocks.iter().zip(products) {
            let (to, _) = block.sides(is_transposed);
            for (sum, product) in sums.iter_mut().zip(products) {
                let pairs = sum[to.clone()].iter_mut().zip(product);
                pairs.for_each(|(sum, p)| *sum += Complex64::new(p.re.into(), p.im.into()));
            }
        }
        sums
    }

    fn times_by_sixteen(&self, vectors: &[Vec<Complex64>], is_transposed: bool) -> Vec<Vec<Complex64>> {
        let groups = by_sixteen(vectors);
        // Crosses in two steps, the second together with whole blocks for each leaf's part of the result.
        let between = |block: &Block| -> Vec<Vec<Sixteen>> {
            let (_, from) = block.sides(is_transposed);
            let of_group = |x: &Vec<Sixteen>| block.by_crosses(&x[from.clone()], is_transposed);
            groups.iter().filter_map(of_group).collect()
        };
        let between: Vec<_> = self.blocks.par_iter().map(between).collect();
        let mut of_leaf = vec![Vec::new(); self.leaves.len()];
        for (number, block) in self.blocks.iter().enumerate() {
            let (to, _) = block.sides(is_transposed);
            let first = self.leaves.partition_point(|leaf| leaf.end <= to.start);
            let leaves = self.leaves.iter().enumerate().skip(first);
            leaves
                .take_while(|(_, leaf)| leaf.start < to.end)
                .for_each(|(leaf, _)| of_leaf[leaf].push(number));
        }
        let sums = |(leaf, numbers): (&Range<usize>, &Vec<usize>)| -> Vec<Vec<Sums>> {
            let mut sums = vec![vec![[[0.0; LANES]; 2]; leaf.len()]; groups.len()];
            for &number in numbers {
                let block = &self.blocks[number];
                let (to, from) = block.sides(is_transposed);
                // A block's side holds a leaf, or is a part of it.
                let nodes = leaf.start.max(to.start)..leaf.end.min(to.end);
                for (group, x) in groups.iter().enumerate() {
                    let sums = &mut sums[group][nodes.start - leaf.start..nodes.end - leaf.start];
                    let own = nodes.start - to.start..nodes.end - to.start;
                    match (&block.content, is_transposed) {
                        (Content::Whole(table), false) => table.add_times(own, &x[from.clone()], sums),
                        (Content::Whole(table), true) => {
                            table.add_transposed_times(own, &x[from.clone()], sums);
                        }
                        (Content::Crosses { columns, .. }, false) => {
                            columns.add_transposed_times(own, &between[number][group], sums);
                        }
                        (Content::Crosses { rows, .. }, true) => {
                            rows.add_transposed_times(own, &between[number][group], sums);
                        }
                    }
                }
            }
            sums
        };
        let sums: Vec<_> = self.leaves.par_iter().zip(&of_leaf).map(sums).collect();
        let vector = |number: usize| {
            let (group, lane) = (number / LANES, number % LANES);
            let number = |sums: &Sums| Complex64::new(sums[0][lane], sums[1][lane]);
            sums.iter().flat_map(|leaf| leaf[group].iter().map(number)).collect()
        };
        (0..vectors.len()).into_par_iter().map(vector).collect()
    }

    /// The whole block between the nodes of a leaf, row by row.
    pub fn own(&self, leaf: &Range<usize>) -> Vec<Complex64> {
        let block = self.blocks.iter().find(|block| block.rows == *leaf && block.columns == *leaf);
        let Some(Block { content: Content::Whole(table), .. }) = block else { return Vec::new() };
        let row = |row: usize| {
            let [re, im] = table.row(row);
            re.iter().zip(im).map(|(re, im)| Complex64::new((*re).into(), (*im).into())).collect::<Vec<_>>()
        };
        (0..table.rows).flat_map(row).collect()
    }

    /// Bytes of all blocks.
    pub fn size(&self) -> usize {
        let size = |block: &Block| match &block.content {
            Content::Whole(table) => table.values.len() * 4,
            Content::Crosses { columns, rows } => (columns.values.len() + rows.values.len()) * 4,
        };
        self.blocks.iter().map(size).sum()
    }
}

impl<'a> Source<'a> {
    fn new(wall: &'a Wall, facets: &[Facet], tree: &'a Tree) -> Self {
        let mut places = vec![0; tree.order.len()];
        tree.order.iter().enumerate().for_each(|(place, &node)| places[node as usize] = place);
        let mut around = vec![Vec::new(); tree.order.len()];
        for (number, facet) in facets.iter().enumerate() {
            for (corner, &node) in facet.nodes.iter().enumerate() {
                around[places[node as usize]].push((number as u32, corner));
            }
        }
        let origin = tree.clusters[0].low.midpoint(tree.clusters[0].high);
        let panel = |cluster: &Cluster| {
            let mut triangles: Vec<u32> =
                cluster.nodes.clone().flat_map(|node| around[node].iter().map(|it| it.0)).collect();
            triangles.sort_unstable();
            triangles.dedup();
            let local = |node: u32| {
                let place = places[node as usize];
                if cluster.nodes.contains(&place) { (place - cluster.nodes.start) as u32 } else { OUTSIDE }
            };
            let corners = triangles.iter().map(|&t| facets[t as usize].nodes.map(local)).collect();
            Panel::new(facets, (triangles, corners), cluster.nodes.len(), origin)
        };
        let panels = tree.clusters.par_iter().map(panel).collect();
        Self { wall, tree, ones: One::all(facets, origin), around, panels }
    }

    /// The pairs of clusters that are worth an approximation, or cannot be halved.
    fn pairs(&self, (a, b): (usize, usize), pairs: &mut Vec<(usize, usize)>) {
        let (rows, columns) = (&self.tree.clusters[a], &self.tree.clusters[b]);
        if self.is_apart(rows, columns) {
            pairs.push((a, b));
            return;
        }
        match self.halves((a, b)) {
            Some(halves) => halves.into_iter().for_each(|pair| self.pairs(pair, pairs)),
            None => pairs.push((a, b)),
        }
    }

    fn is_apart(&self, rows: &Cluster, columns: &Cluster) -> bool {
        let nearest = rows.distance(columns);
        nearest > 0.0 && rows.diameter().max(columns.diameter()) <= 3.0 * nearest
    }

    /// The larger cluster halved, both if they are alike.
    fn halves(&self, (a, b): (usize, usize)) -> Option<Vec<(usize, usize)>> {
        let (rows, columns) = (&self.tree.clusters[a], &self.tree.clusters[b]);
        match (rows.children, columns.children) {
            (None, None) => None,
            (Some(of_a), None) => Some(of_a.iter().map(|&a| (a, b)).collect()),
            (None, Some(of_b)) => Some(of_b.iter().map(|&b| (a, b)).collect()),
            (Some(of_a), Some(of_b)) => {
                Some(of_a.iter().flat_map(|&a| of_b.iter().map(move |&b| (a, b))).collect())
            }
        }
    }

    /// The blocks of a pair: crosses if few suffice, otherwise those of its halves or the whole.
    fn blocks(&self, pair: (usize, usize)) -> Vec<Block> {
        let (rows, columns) = (&self.tree.clusters[pair.0], &self.tree.clusters[pair.1]);
        let block = |content| Block { rows: rows.nodes.clone(), columns: columns.nodes.clone(), content };
        if rows.nodes.len().min(columns.nodes.len()) >= FEWEST
            && self.is_apart(rows, columns)
            && let Some(crosses) = self.crosses(pair)
        {
            return vec![block(crosses)];
        }
        if rows.nodes.len().min(columns.nodes.len()) >= 2 * FEWEST
            && let Some(halves) = self.halves(pair)
        {
            return halves.into_iter().flat_map(|pair| self.blocks(pair)).collect();
        }
        // Whole blocks by leaves of rows, which stay in the second cache.
        let leaves: Vec<_> = self.leaves_of(pair.0);
        let part = |leaf: usize| Block {
            rows: self.tree.clusters[leaf].nodes.clone(),
            columns: columns.nodes.clone(),
            content: Content::Whole(self.whole((leaf, pair.1))),
        };
        leaves.into_iter().map(part).collect()
    }

    fn leaves_of(&self, cluster: usize) -> Vec<usize> {
        match self.tree.clusters[cluster].children {
            None => vec![cluster],
            Some(children) => children.iter().flat_map(|&child| self.leaves_of(child)).collect(),
        }
    }

    fn whole(&self, (a, b): (usize, usize)) -> Table {
        let (own, panel) = (&self.panels[a], &self.panels[b]);
        let singles: Vec<_> = own
            .triangles
            .iter()
            .zip(&own.corners)
            .map(|(&t, corners)| (&self.ones[t as usize], *corners))
            .collect();
        let count = own.nodes * panel.nodes;
        let (mut re, mut im) = (vec![0.0; count], vec![0.0; count]);
        pairs::add(self.wall, &singles, (panel, Many::Trial), [&mut re, &mut im]);
        let rows = re.chunks(panel.nodes).zip(im.chunks(panel.nodes));
        let values = rows.flat_map(|(re, im)| re.iter().chain(im).copied()).collect();
        Table { rows: own.nodes, columns: panel.nodes, values }
    }

    /// A row (its node of the tree, and the columns' cluster) or a column.
    fn line(&self, node: usize, cluster: usize, many: Many) -> [Vec<f32>; 2] {
        let panel = &self.panels[cluster];
        let corner = |own: usize| [0, 1, 2].map(|corner| if corner == own { 0 } else { OUTSIDE });
        let singles: Vec<_> =
            self.around[node].iter().map(|&(t, own)| (&self.ones[t as usize], corner(own))).collect();
        let (mut re, mut im) = (vec![0.0; panel.nodes], vec![0.0; panel.nodes]);
        pairs::add(self.wall, &singles, (panel, many), [&mut re, &mut im]);
        [re, im]
    }

    /// Crosses that make the block up to the tolerance, or none if they would take more than half its room.
    fn crosses(&self, (a, b): (usize, usize)) -> Option<Content> {
        let (rows, columns) = (&self.tree.clusters[a].nodes, &self.tree.clusters[b].nodes);
        let (count, width) = (rows.len(), columns.len());
        let most = count * width / (2 * (count + width));
        let (mut us, mut vs) = (Vec::<[Vec<f32>; 2]>::new(), Vec::<[Vec<f32>; 2]>::new());
        let mut is_used = vec![false; count];
        let (mut pivot, mut total, mut small) = (0, 0.0, 0);
        loop {
            is_used[pivot] = true;
            let mut v = self.line(rows.start + pivot, b, Many::Trial);
            for (u, earlier) in us.iter().zip(&vs) {
                deduct(&mut v, earlier, Complex32::new(u[0][pivot], u[1][pivot]));
            }
            let (column, largest) = largest(&v, |_| true);
            let mut size = 0.0;
            if largest > 0.0 {
                let scale = Complex32::ONE / Complex32::new(v[0][column], v[1][column]);
                let [re, im] = &mut v;
                for (re, im) in re.iter_mut().zip(im) {
                    let scaled = Complex32::new(*re, *im) * scale;
                    (*re, *im) = (scaled.re, scaled.im);
                }
                let mut u = self.line(columns.start + column, a, Many::Test);
                for (earlier, v) in us.iter().zip(&vs) {
                    deduct(&mut u, earlier, Complex32::new(v[0][column], v[1][column]));
                }
                let (u2, v2) = (square(&u), square(&v));
                size = u2 * v2;
                // The square of the sum's norm grows by this cross and its products with the earlier ones.
                let product = |(eu, ev): (&[Vec<f32>; 2], &[Vec<f32>; 2])| (inner(eu, &u) * inner(ev, &v)).re;
                total += size + 2.0 * us.iter().zip(&vs).map(product).sum::<f32>();
                us.push(u);
                vs.push(v);
            }
            // Two small crosses in a row: one alone may be by chance.
            small = if size <= TOLERANCE * TOLERANCE * total { small + 1 } else { 0 };
            if small == 2 {
                break;
            }
            if us.len() >= most {
                return None;
            }
            let next = match us.last() {
                Some(u) => largest_unused(u, &is_used),
                None => is_used.iter().position(|used| !used),
            };
            match next {
                Some(next) => pivot = next,
                None => break,
            }
        }
        Some(Content::Crosses { columns: Table::of(&us), rows: Table::of(&vs) })
    }
}

fn largest_unused(u: &[Vec<f32>; 2], is_used: &[bool]) -> Option<usize> {
    is_used.contains(&false).then(|| largest(u, |i| !is_used[i]).0)
}

fn largest(line: &[Vec<f32>; 2], counts: impl Fn(usize) -> bool) -> (usize, f32) {
    let mut best = (usize::MAX, -1.0);
    for (i, (re, im)) in line[0].iter().zip(&line[1]).enumerate() {
        let square = re * re + im * im;
        if square > best.1 && counts(i) {
            best = (i, square);
        }
    }
    best
}

/// to -= a x.
fn deduct(to: &mut [Vec<f32>; 2], a: &[Vec<f32>; 2], x: Complex32) {
    let [re, im] = to;
    Isa::best().run(Add { row: [&a[0], &a[1]], x: -x, to: [re, im] });
}

fn square(line: &[Vec<f32>; 2]) -> f32 {
    line.iter().flatten().map(|x| x * x).sum()
}

/// Σ conj(a) b.
fn inner(a: &[Vec<f32>; 2], b: &[Vec<f32>; 2]) -> Complex32 {
    let conjugate: Vec<f32> = a[1].iter().map(|x| -x).collect();
    Isa::best().run(Dot { row: [&a[0], &conjugate], x: [&b[0], &b[1]] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::scatter::facets;

    #[test]
    fn products_are_those_of_all_entries() {
        let mesh = shapes::capsule(DVec3::Z * -0.03, DVec3::Z * 0.03, 0.004, 1.4e-3);
        let (facets, tree) = (Facet::all(&mesh), Tree::new(&mesh.vertices));
        let wall = Wall { wavenumber: 732.0, admittance: 0.3 };
        let matrix = Hierarchy::new(&wall, &facets, &tree);
        let crosses = matrix.blocks.iter().filter(|block| matches!(block.content, Content::Crosses { .. }));
        assert!(crosses.count() > 10, "a body with distant parts");
        let count = mesh.vertices.len();
        assert!(matrix.size() < 8 * count * count, "{} bytes", matrix.size());
        let unit = |i: usize, step: f64| (i as f64 * step).fract() - 0.5;
        let x: Vec<_> = (0..count).map(|i| Complex64::new(unit(i, 0.618_034), unit(i, 0.754_878))).collect();
        let mut expected = [vec![Complex64::ZERO; count], vec![Complex64::ZERO; count]];
        for (a, first) in facets.iter().enumerate() {
            for second in &facets[..a] {
                let [forth, back] = facets::rough(&wall, first, second);
                for (entries, test, trial) in [(forth, first, second), (back, second, first)] {
                    for (row, entries) in test.nodes.iter().zip(entries) {
                        for (column, entry) in trial.nodes.iter().zip(entries) {
                            let (row, column) = (*row as usize, *column as usize);
                            expected[0][row] += entry * x[column];
                            expected[1][column] += entry * x[row];
                        }
                    }
                }
            }
        }
        let sorted: Vec<_> = tree.order.iter().map(|&node| x[node as usize]).collect();
        for (is_transposed, expected) in [(false, &expected[0]), (true, &expected[1])] {
            let all: f64 = expected.iter().map(Complex64::norm_sqr).sum();
            for several in [1, 18] {
                let vectors: Vec<Vec<_>> =
                    (1..=several).map(|n| sorted.iter().map(|x| x * f64::from(n)).collect()).collect();
                for (n, product) in (1..).zip(matrix.times(&vectors, is_transposed)) {
                    let pairs = tree.order.iter().zip(&product);
                    let off: f64 = pairs
                        .map(|(&node, own)| (own / f64::from(n) - expected[node as usize]).norm_sqr())
                        .sum();
                    assert!((off / all).sqrt() < 2e-3, "{is_transposed} {several}: {}", (off / all).sqrt());
                }
            }
        }
    }
}
