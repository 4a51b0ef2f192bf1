//! Cells for a test, made from a pilot run: a tree of splits at the medians of the pilot points, so that cells are
//! small where samples are dense and a lobe of width 1e-3 gets as many cells as the rest of the sphere. If the points
//! of a cell lie in a small part of it, the empty part is split off. The tested samples are not those of the pilot run,
//! so that the cells are fixed before the samples are counted.

/// The index of a chart of the domain and a point in the chart.
pub(crate) type Place = (usize, [f64; 2]);

/// A rectangle of one chart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub chart: usize,
    pub low: [f64; 2],
    pub high: [f64; 2],
}

enum Node {
    Leaf(usize),
    Split { axis: usize, at: f64, below: usize, above: usize },
}

/// Charts divided into cells.
pub(crate) struct Partition {
    nodes: Vec<Node>,
    roots: Vec<usize>,
    pub cells: Vec<Cell>,
}

impl Partition {
    /// Creates about `cells` cells with equal shares of `pilot`. No cell is larger than 16/`cells` of its chart, so
    /// that regions without samples are tested as well.
    pub fn new(charts: &[[[f64; 2]; 2]], pilot: &[Place], cells: usize) -> Self {
        let mut partition = Self { nodes: Vec::new(), roots: Vec::new(), cells: Vec::new() };
        let share = (pilot.len() / cells).max(1);
        for (chart, &[low, high]) in charts.iter().enumerate() {
            let mut points: Vec<[f64; 2]> = pilot.iter().filter(|p| p.0 == chart).map(|p| p.1).collect();
            let largest = area(low, high) * 16.0 / cells as f64;
            let root = partition.grow(Cell { chart, low, high }, &mut points, share, largest, 0);
            partition.roots.push(root);
        }
        partition
    }

    fn grow(
        &mut self,
        cell: Cell,
        points: &mut [[f64; 2]],
        share: usize,
        largest: f64,
        axis: usize,
    ) -> usize {
        let at =
            cut(&cell, points, share, largest, axis).map(|at| (axis, at)).or_else(|| edge(&cell, points));
        let Some((axis, at)) = at.filter(|&(axis, at)| cell.low[axis] < at && at < cell.high[axis]) else {
            self.cells.push(cell);
            self.nodes.push(Node::Leaf(self.cells.len() - 1));
            return self.nodes.len() - 1;
        };
        let (mut left, mut right) = (cell, cell);
        left.high[axis] = at;
        right.low[axis] = at;
        points.sort_by(|p, q| p[axis].total_cmp(&q[axis]));
        let (lower, upper) = points.split_at_mut(points.partition_point(|p| p[axis] < at));
        let below = self.grow(left, lower, share, largest, 1 - axis);
        let above = self.grow(right, upper, share, largest, 1 - axis);
        self.nodes.push(Node::Split { axis, at, below, above });
        self.nodes.len() - 1
    }

    /// Returns the cell of a place. Places outside of the chart belong to its border cells.
    pub fn locate(&self, (chart, p): Place) -> usize {
        let mut node = self.roots[chart];
        loop {
            match self.nodes[node] {
                Node::Leaf(cell) => return cell,
                Node::Split { axis, at, below, above } => node = if p[axis] < at { below } else { above },
            }
        }
    }
}

/// Returns the position of a split: the median while there are samples for two cells, or the middle while the cell is
/// too large.
fn cut(cell: &Cell, points: &mut [[f64; 2]], share: usize, largest: f64, axis: usize) -> Option<f64> {
    if points.len() >= 2 * share {
        let middle = points.len() / 2;
        let (_, median, _) = points.select_nth_unstable_by(middle, |p, q| p[axis].total_cmp(&q[axis]));
        return Some(median[axis]);
    }
    (area(cell.low, cell.high) > largest).then(|| 0.5 * (cell.low[axis] + cell.high[axis]))
}

/// Returns the axis and position of a split that separates an empty part from a cell whose points lie in a small part
/// of it. This is where a lobe ends, or where it becomes too narrow for the quadrature of a large cell.
fn edge(cell: &Cell, points: &[[f64; 2]]) -> Option<(usize, f64)> {
    if points.len() < 8 {
        return None;
    }
    (0..2).find_map(|axis| {
        let low = points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
        let width = high - low;
        if cell.high[axis] - high > 4.0 * width {
            Some((axis, high + width))
        } else {
            (low - cell.low[axis] > 4.0 * width).then_some((axis, low - width))
        }
    })
}

fn area(low: [f64; 2], high: [f64; 2]) -> f64 {
    (high[0] - low[0]) * (high[1] - low[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rng;

    #[test]
    fn cells_tile_the_charts_and_share_the_points() {
        let mut rng = Rng::new(1);
        let charts = [[[0.0, 0.0], [1.0, 1.0]], [[-1.0, 0.0], [1.0, 2.0]]];
        // All points are in the first chart and concentrated in its corner; the second chart is empty.
        let mut place = || (0, [rng.f64().powi(8), rng.f64().powi(8)]);
        let pilot: Vec<Place> = (0..6400).map(|_| place()).collect();
        let partition = Partition::new(&charts, &pilot, 100);
        for (chart, [low, high]) in charts.iter().enumerate() {
            let own: f64 =
                partition.cells.iter().filter(|c| c.chart == chart).map(|c| area(c.low, c.high)).sum();
            assert!((own - area(*low, *high)).abs() < 1e-12);
        }
        let mut counts = vec![0; partition.cells.len()];
        for _ in 0..64_000 {
            let (chart, p) = place();
            let cell = partition.locate((chart, p));
            let c = partition.cells[cell];
            assert!((0..2).all(|a| c.low[a] <= p[a] && p[a] <= c.high[a]));
            counts[cell] += 1;
        }
        assert!(*counts.iter().max().unwrap() < 64_000 / 25, "{counts:?}");
    }
}
