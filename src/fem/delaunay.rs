//! Delaunay meshes of the unit square, to a given size at every place.
//!
//! Nodes are scattered at random, no two nearer to each other than the size allows (Bridson's
//! algorithm with a radius that varies), and then moved towards the centroids of the triangles about
//! them, while the triangulation follows (spade): edges become nearly equal. What angle is too small
//! after that is refined away. The same seed gives the same mesh, bit for bit.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, DelaunayTriangulation, Point2,
    RefinementParameters, Triangulation as _,
};

use super::mesh::sort_by_nodes;
use super::numbering::along_curve;
use super::{FemError, Mesh};

/// The radius of the scattered nodes over the wanted length of an edge: with it the mean length comes
/// out as wanted, for scattered nodes are less dense than the densest.
const RADIUS: f64 = 0.78;

/// Tries to place a node about another one, before that one is given up.
const TRIES: usize = 40;

/// Nodes keep this distance from the wall, over the wanted length of an edge.
const FROM_WALL: f64 = 0.6;

/// Rounds of moving.
const ROUNDS: usize = 24;

/// Angles below this, in degrees, are refined away.
const LEAST_ANGLE: f64 = 28.0;

/// Cells along a side of the table of sizes.
const TABLE: usize = 192;

/// The mesh with edges of about the length `size` at every place; `smallest` is a lower bound of it.
///
/// # Errors
/// `Triangulation` where the library refuses, which it should not.
pub(super) fn delaunay(
    size: &dyn Fn([f64; 2]) -> f64,
    smallest: f64,
    seed: u64,
) -> Result<Mesh, FemError> {
    let table = Table::new(size, smallest);
    let mut nodes = wall(&table);
    let fixed = nodes.len();
    scatter(&table, seed, &mut nodes);
    for _ in 0..ROUNDS {
        let triangles = triangulate(&nodes)?;
        relax(&table, &triangles, &mut nodes, fixed);
    }
    let (nodes, triangles) = refined(nodes, fixed)?;
    numbered(&nodes, &triangles)
}

/// The wanted size on a grid of places, which is quicker to read than to compute.
struct Table {
    values: Vec<f64>,
    smallest: f64,
}

impl Table {
    fn new(size: &dyn Fn([f64; 2]) -> f64, smallest: f64) -> Self {
        let at = |index: usize| index as f64 / TABLE as f64;
        let places = (0..=TABLE).flat_map(|row| (0..=TABLE).map(move |column| [column, row]));
        Self {
            values: places.map(|place| size(place.map(at))).collect(),
            smallest,
        }
    }

    fn at(&self, place: [f64; 2]) -> f64 {
        let [(column, right), (row, up)] = place.map(|at| {
            let cells = (at * TABLE as f64).clamp(0.0, TABLE as f64);
            let cell = (cells as usize).min(TABLE - 1);
            (cell, cells - cell as f64)
        });
        let value = |row: usize, column: usize| self.values[row * (TABLE + 1) + column];
        let lower = (1.0 - right) * value(row, column) + right * value(row, column + 1);
        let upper = (1.0 - right) * value(row + 1, column) + right * value(row + 1, column + 1);
        (1.0 - up) * lower + up * upper
    }
}

/// The nodes along the wall, one after the other from the origin, counter-clockwise.
fn wall(table: &Table) -> Vec<[f64; 2]> {
    let mut nodes = Vec::new();
    for (from, along) in [
        ([0.0, 0.0], [1.0, 0.0]),
        ([1.0, 0.0], [0.0, 1.0]),
        ([1.0, 1.0], [-1.0, 0.0]),
        ([0.0, 1.0], [0.0, -1.0]),
    ] {
        // As many edges as lengths fit, each where its share of the side is reached.
        let steps = (8.0 / table.smallest).ceil() as usize;
        let place = |step: usize, half: f64| {
            let share = (step as f64 + half) / steps as f64;
            [0, 1].map(|axis: usize| from[axis] + share * along[axis])
        };
        let lengths: Vec<f64> = (0..steps)
            .map(|step| 1.0 / (steps as f64 * table.at(place(step, 0.5))))
            .collect();
        let total: f64 = lengths.iter().sum();
        let edges = total.round().max(1.0);
        let mut reached = 0.0;
        let mut next = 0.0;
        for (step, length) in lengths.iter().enumerate() {
            while next <= reached + length && next < total * (1.0 - 0.5 / edges) {
                let part = (next - reached) / length;
                nodes.push(if next == 0.0 { from } else { place(step, part) });
                next += total / edges;
            }
            reached += length;
        }
    }
    nodes
}

/// Scatters nodes between those of the wall.
fn scatter(table: &Table, seed: u64, nodes: &mut Vec<[f64; 2]>) {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    // Any two nodes in one cell would be too close.
    let cell = RADIUS * table.smallest / std::f64::consts::SQRT_2;
    let cells = (1.0 / cell).ceil() as usize + 1;
    let mut heads = vec![u32::MAX; cells * cells];
    // The node that follows each one in its cell.
    let mut next = Vec::new();
    let index = |[x, y]: [f64; 2]| [(x / cell) as usize, (y / cell) as usize];
    let enter = |node: u32, at: [f64; 2], heads: &mut Vec<u32>| {
        let [column, row] = index(at);
        std::mem::replace(&mut heads[row * cells + column], node)
    };
    for (node, at) in nodes.iter().enumerate() {
        next.push(enter(node as u32, *at, &mut heads));
    }
    let mut active: Vec<u32> = (0..nodes.len() as u32).collect();
    while !active.is_empty() {
        let chosen = generator.random_range(0..active.len());
        let about = nodes[active[chosen] as usize];
        let own = table.at(about);
        let mut placed = false;
        for _ in 0..TRIES {
            let angle = std::f64::consts::TAU * generator.random::<f64>();
            let distance = RADIUS * own * (1.0 + generator.random::<f64>());
            let (sine, cosine) = angle.sin_cos();
            let at = [about[0] + distance * cosine, about[1] + distance * sine];
            let wanted = table.at(at);
            let margin = FROM_WALL * wanted;
            if !at.iter().all(|x| (margin..=1.0 - margin).contains(x)) {
                continue;
            }
            let radius = RADIUS * wanted;
            let reach = (radius / cell).ceil() as usize;
            let [column, row] = index(at);
            let near =
                |middle: usize| middle.saturating_sub(reach)..=(middle + reach).min(cells - 1);
            let is_free = near(row).all(|row| {
                near(column).all(|column| {
                    let mut node = heads[row * cells + column];
                    while node != u32::MAX {
                        let [x, y] = nodes[node as usize];
                        if (x - at[0]).hypot(y - at[1]) < radius {
                            return false;
                        }
                        node = next[node as usize];
                    }
                    true
                })
            });
            if is_free {
                let node = nodes.len() as u32;
                nodes.push(at);
                next.push(enter(node, at, &mut heads));
                active.push(node);
                placed = true;
                break;
            }
        }
        if !placed {
            active.swap_remove(chosen);
        }
    }
}

fn points(nodes: &[[f64; 2]]) -> Vec<Point2<f64>> {
    nodes.iter().map(|[x, y]| Point2::new(*x, *y)).collect()
}

/// The Delaunay triangles of nodes, counter-clockwise.
fn triangulate(nodes: &[[f64; 2]]) -> Result<Vec<[usize; 3]>, FemError> {
    let triangulation = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(points(nodes))
        .map_err(|error| refused(nodes.len(), &error))?;
    let faces = triangulation.inner_faces();
    Ok(faces
        .map(|face| face.vertices().map(|vertex| vertex.fix().index()))
        .collect())
}

fn refused(nodes: usize, error: &dyn std::fmt::Display) -> FemError {
    FemError::Triangulation {
        nodes,
        reason: error.to_string(),
    }
}

/// Moves each node to the centroid of the triangles about it, those weighted more where edges are to be
/// shorter.
fn relax(table: &Table, triangles: &[[usize; 3]], nodes: &mut [[f64; 2]], fixed: usize) {
    let mut sums = vec![[0.0; 3]; nodes.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|node| nodes[node]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let middle = [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
        // The density whose centroidal cells have the wanted size, in the plane.
        let weight = area / table.at(middle).powi(4);
        for &node in triangle {
            let [x, y, sum] = &mut sums[node];
            *x += weight * middle[0];
            *y += weight * middle[1];
            *sum += weight;
        }
    }
    for (node, [x, y, sum]) in nodes.iter_mut().zip(sums).skip(fixed) {
        if sum > 0.0 {
            *node = [x / sum, y / sum];
        }
    }
}

/// Nodes and triangles.
type Plain = (Vec<[f64; 2]>, Vec<[u32; 3]>);

/// Refines what angles are too small, the wall's edges divided where they must be.
fn refined(nodes: Vec<[f64; 2]>, fixed: usize) -> Result<Plain, FemError> {
    let count = nodes.len();
    let wall = (0..fixed).map(|node| [node, (node + 1) % fixed]).collect();
    let mut triangulation =
        ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(points(&nodes), wall)
            .map_err(|error| refused(count, &error))?;
    let parameters = RefinementParameters::<f64>::new()
        .with_angle_limit(AngleLimit::from_deg(LEAST_ANGLE))
        .with_max_additional_vertices(count);
    triangulation.refine(parameters);
    let nodes = triangulation.vertices().map(|vertex| {
        let at = vertex.position();
        [at.x, at.y]
    });
    let triangles = triangulation
        .inner_faces()
        .map(|face| face.vertices().map(|vertex| vertex.fix().index() as u32));
    Ok((nodes.collect(), triangles.collect()))
}

/// The mesh, numbered along a curve.
fn numbered(nodes: &[[f64; 2]], triangles: &[[u32; 3]]) -> Result<Mesh, FemError> {
    let order = along_curve(nodes);
    let mut places = vec![0; nodes.len()];
    for (place, node) in order.iter().enumerate() {
        places[*node as usize] = place as u32;
    }
    let sorted = order.iter().map(|node| nodes[*node as usize]).collect();
    let mut triangles: Vec<[u32; 3]> = triangles
        .iter()
        .map(|corners| corners.map(|node| places[node as usize]))
        .collect();
    sort_by_nodes(&mut triangles);
    Mesh::new(sorted, triangles)
}

#[cfg(test)]
mod tests {
    use super::super::{Quality, Wall};
    use super::*;

    fn quality(mesh: &Mesh) -> Quality {
        assert!((mesh.areas().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let quality = Quality::of(mesh);
        assert!(quality.least_angle >= 25.0, "{quality:?}");
        quality
    }

    #[test]
    fn edges_are_as_long_as_wanted_and_angles_not_small() {
        for (size, seed) in [(0.25, 1), (0.1, 2), (0.03, 3), (0.03, 4), (0.0171, 5)] {
            let mesh = delaunay(&|_| size, size, seed).expect("a mesh");
            let [shortest, mean, longest] = quality(&mesh).edges;
            // On the coarsest ones the wall's edges decide.
            let margin = if size > 0.05 { 0.15 } else { 0.06 };
            assert!((mean / size - 1.0).abs() < margin, "{size}: {mean}");
            assert!(
                shortest > 0.4 * size && longest < 1.8 * size,
                "{shortest} {longest}"
            );
        }
    }

    #[test]
    fn graded_meshes_follow_their_size() {
        for seed in 1..=4 {
            let wanted = |[x, y]: [f64; 2]| {
                let beyond = ((x - 0.5).hypot(y - 0.4) - 0.2).abs() - 0.03;
                (0.006 + 0.3 * beyond.max(0.0)).min(0.08)
            };
            let mesh = delaunay(&wanted, 0.006, seed).expect("a mesh");
            quality(&mesh);
            let mut ratios = Vec::new();
            for triangle in mesh.triangles() {
                let [a, b, c] = triangle.map(|node| mesh.nodes()[node as usize]);
                for [from, to] in [[a, b], [b, c], [c, a]] {
                    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
                    let middle = [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]));
                    ratios.push(length / wanted(middle));
                }
            }
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            assert!((mean - 1.0).abs() < 0.08, "{mean}");
            let extremes = ratios
                .iter()
                .fold([f64::INFINITY, 0.0], |[low, high], ratio: &f64| {
                    [low.min(*ratio), high.max(*ratio)]
                });
            assert!(extremes[0] > 0.4 && extremes[1] < 2.5, "{extremes:?}");
        }
    }

    #[test]
    fn the_seed_decides() {
        let mesh = |seed| delaunay(&|_| 0.06, 0.06, seed).expect("a mesh");
        let (one, same, other) = (mesh(7), mesh(7), mesh(8));
        assert_eq!(
            (one.nodes(), one.triangles()),
            (same.nodes(), same.triangles())
        );
        assert_ne!(one.nodes(), other.nodes());
        // The corners are there, and all of the wall lies on the square's sides.
        for [x, y] in Wall::of(&one).edges().iter().flatten() {
            assert!([0.0, 1.0].contains(x) || [0.0, 1.0].contains(y));
        }
    }
}
