//! Delaunay meshes of the unit square, to a given size at every place.
//!
//! Nodes are scattered at random, no two nearer to each other than the size allows (Bridson's
//! algorithm with a radius that varies), and then moved towards the centroids of the triangles about
//! them, while the triangulation (spade) follows: edges become nearly equal. What angle is too small
//! after that is refined away. The same seed gives the same mesh, bit for bit.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, DelaunayTriangulation, RefinementParameters,
    Triangulation as _,
};

use super::hilbert::along_curve;
use super::mesh::sort_by_nodes;
use super::moving_triangulation::MovingTriangulation;
use super::quadtree::Quadtree;
use super::{FemError, Mesh};
use crate::geometry::{Point, Vector, doubled_area, length};
use crate::scene::MeshSize;

/// The radius of the scattered nodes over the wanted length of an edge: with it the mean length comes
/// out as wanted, for scattered nodes are less dense than the densest.
const RADIUS: f64 = 0.78;

/// Tries to place a node about another one, before that one is given up.
const TRIES: usize = 40;

/// Nodes keep this distance from the wall, over the wanted length of an edge.
const FROM_WALL: f64 = 0.6;

/// Rounds of moving.
const ROUNDS: usize = 24;

/// Rounds of moving after a mesh was adapted.
const ADAPTING_ROUNDS: usize = 6;

/// About a node whose edges are longer than the wanted ones by this factor, nodes are scattered where a mesh is adapted.
const SPARSER: f64 = 1.2;

/// Angles below this, in degrees, are refined away.
const LEAST_ANGLE: f64 = 28.0;

/// Cells along a side of the table of sizes.
const TABLE: usize = 192;

/// After so many nodes that others were placed about, it is asked whether to go on.
const ASKED_EVERY: usize = 1024;

/// The mesh with edges of about the wanted length at every place. `leave` is asked now and then
/// whether to give up.
///
/// # Errors
/// `Ended` if it was left; `Triangulation` where the library refuses, which it should not.
pub(super) fn delaunay(
    size: &MeshSize,
    seed: u64,
    leave: &mut dyn FnMut() -> bool,
) -> Result<Mesh, FemError> {
    let table = Table::new(size);
    let mut nodes = wall(&table);
    let fixed = nodes.len();
    let mut sites = Sites::new(&nodes);
    sites.active.extend(0..fixed as u32);
    scatter(&table, seed, &mut nodes, sites, leave)?;
    let triangulation = triangulate(&nodes)?;
    let is_free: Vec<bool> = (0..nodes.len()).map(|node| node >= fixed).collect();
    moved(
        &table,
        (nodes, fixed),
        triangulation,
        &is_free,
        ROUNDS,
        leave,
    )
}

/// The mesh of these nodes after `rounds` rounds in which the free ones move; the first `fixed` nodes are the wall's.
fn moved(
    table: &Table,
    (mut nodes, fixed): (Vec<Point>, usize),
    mut triangulation: MovingTriangulation,
    is_free: &[bool],
    rounds: usize,
    leave: &mut dyn FnMut() -> bool,
) -> Result<Mesh, FemError> {
    for _ in 0..rounds {
        go_on(leave)?;
        relax(table, triangulation.triangles(), &mut nodes, is_free);
        if !triangulation.restore(&nodes) {
            triangulation = triangulate(&nodes)?;
        }
    }
    go_on(leave)?;
    let (nodes, triangles) = refined(nodes, fixed)?;
    go_on(leave)?;
    numbered(&nodes, &triangles)
}

/// A mesh of another size, made from one whose size was another: some of its nodes go, some come, and all are moved. (Where
/// those that are dense enough stay in place the error of case 3 at 2,150 nodes is 1.5e-2 in place of 1.1e-2.)
///
/// # Errors
/// `Triangulation` where the library refuses, which it should not.
pub(super) fn adapted(before: &Mesh, size: &MeshSize, seed: u64) -> Result<Mesh, FemError> {
    let table = Table::new(size);
    let mut nodes = wall(&table);
    let fixed = nodes.len();
    let mut sites = Sites::new(&nodes);
    let old = || before.nodes().iter().zip(before.on_boundary());
    for ((at, on_wall), edge) in old().zip(mean_edges(before)) {
        let wanted = table.at(*at);
        let fits = !on_wall && is_inside(*at, wanted);
        if fits && !sites.tree.is_near(*at, RADIUS * wanted) {
            if edge > SPARSER * wanted {
                sites.active.push(nodes.len() as u32);
            }
            sites.tree.insert(*at);
            nodes.push(*at);
        }
    }
    scatter(&table, seed, &mut nodes, sites, &mut || false)?;
    let triangulation = triangulate(&nodes)?;
    let mut is_free = vec![true; nodes.len()];
    is_free[..fixed].fill(false);
    let rounds = ADAPTING_ROUNDS;
    moved(
        &table,
        (nodes, fixed),
        triangulation,
        &is_free,
        rounds,
        &mut || false,
    )
}

/// The mean length of the edges at each node.
fn mean_edges(mesh: &Mesh) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); mesh.nodes().len()];
    for &[a, b, c] in mesh.triangles() {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let edge = length(mesh.nodes()[to as usize] - mesh.nodes()[from as usize]);
            for node in [from, to] {
                let (sum, count) = &mut sums[node as usize];
                *sum += edge;
                *count += 1.0;
            }
        }
    }
    sums.iter().map(|(sum, count)| sum / count).collect()
}

/// Whether an inner node may be at a place.
fn is_inside(at: Point, wanted: f64) -> bool {
    let margin = FROM_WALL * wanted;
    at.iter().all(|x| (margin..=1.0 - margin).contains(x))
}

fn go_on(leave: &mut dyn FnMut() -> bool) -> Result<(), FemError> {
    if leave() {
        return Err(FemError::Ended);
    }
    Ok(())
}

/// The wanted size on a grid of places, which is quicker to read than to compute. In cells where the
/// grid is too coarse for it, it is computed.
struct Table<'a> {
    size: &'a MeshSize,
    values: Vec<f64>,
    /// For each cell whether the values at its corners tell all of it.
    is_even: Vec<bool>,
}

impl<'a> Table<'a> {
    fn new(size: &'a MeshSize) -> Self {
        let places = |count: usize, shift: f64| {
            let at = move |index: usize| (index as f64 + shift) / TABLE as f64;
            (0..count)
                .flat_map(move |row| (0..count).map(move |column| Point::new(at(column), at(row))))
        };
        let corners = places(TABLE + 1, 0.0);
        let centers = places(TABLE, 0.5);
        Self {
            size,
            values: corners.map(|corner| size.at(corner)).collect(),
            is_even: centers
                .map(|center| size.is_even(center, 1.0 / TABLE as f64))
                .collect(),
        }
    }

    fn at(&self, place: Point) -> f64 {
        let [(column, right), (row, up)] = [place.x, place.y].map(|at| {
            let cells = (at * TABLE as f64).clamp(0.0, TABLE as f64);
            let cell = (cells as usize).min(TABLE - 1);
            (cell, cells - cell as f64)
        });
        if !self.is_even[row * TABLE + column] {
            return self.size.at(place);
        }
        let value = |row: usize, column: usize| self.values[row * (TABLE + 1) + column];
        let lower = (1.0 - right) * value(row, column) + right * value(row, column + 1);
        let upper = (1.0 - right) * value(row + 1, column) + right * value(row + 1, column + 1);
        (1.0 - up) * lower + up * upper
    }
}

/// The nodes along the wall, one after the other from the origin, counter-clockwise.
fn wall(table: &Table) -> Vec<Point> {
    let mut nodes = Vec::new();
    for (from, along) in [
        (Point::new(0.0, 0.0), Vector::x()),
        (Point::new(1.0, 0.0), Vector::y()),
        (Point::new(1.0, 1.0), -Vector::x()),
        (Point::new(0.0, 1.0), -Vector::y()),
    ] {
        // As many edges as lengths fit, each where its share of the side is reached.
        let steps = (8.0 / table.size.smallest()).ceil() as usize;
        let place = |step: usize, half: f64| {
            let share = (step as f64 + half) / steps as f64;
            from + share * along
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

/// Nodes, found by place, and the numbers of those about which there may be room for others.
struct Sites {
    tree: Quadtree,
    active: Vec<u32>,
}

impl Sites {
    fn new(nodes: &[Point]) -> Self {
        let mut tree = Quadtree::new();
        nodes.iter().for_each(|node| tree.insert(*node));
        Self {
            tree,
            active: Vec::new(),
        }
    }
}

/// Scatters nodes about those that are there.
fn scatter(
    table: &Table,
    seed: u64,
    nodes: &mut Vec<Point>,
    Sites {
        mut tree,
        mut active,
    }: Sites,
    leave: &mut dyn FnMut() -> bool,
) -> Result<(), FemError> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut asked = 0;
    while !active.is_empty() {
        asked += 1;
        if asked % ASKED_EVERY == 0 {
            go_on(leave)?;
        }
        let chosen = generator.random_range(0..active.len());
        let about = nodes[active[chosen] as usize];
        let own = table.at(about);
        let mut placed = false;
        for _ in 0..TRIES {
            let angle = std::f64::consts::TAU * generator.random::<f64>();
            let distance = RADIUS * own * (1.0 + generator.random::<f64>());
            let (sine, cosine) = angle.sin_cos();
            let at = about + distance * Vector::new(cosine, sine);
            let wanted = table.at(at);
            if !is_inside(at, wanted) {
                continue;
            }
            if !tree.is_near(at, RADIUS * wanted) {
                active.push(nodes.len() as u32);
                nodes.push(at);
                tree.insert(at);
                placed = true;
                break;
            }
        }
        if !placed {
            active.swap_remove(chosen);
        }
    }
    Ok(())
}

fn points(nodes: &[Point]) -> Vec<spade::Point2<f64>> {
    nodes
        .iter()
        .map(|node| spade::Point2::new(node.x, node.y))
        .collect()
}

/// The Delaunay triangulation of nodes.
fn triangulate(nodes: &[Point]) -> Result<MovingTriangulation, FemError> {
    let triangulation =
        DelaunayTriangulation::<spade::Point2<f64>>::bulk_load_stable(points(nodes))
            .map_err(|error| refused(nodes.len(), &error))?;
    let faces = triangulation.inner_faces();
    let corners = faces.map(|face| face.vertices().map(|vertex| vertex.fix().index() as u32));
    Ok(MovingTriangulation::new(corners.collect()))
}

fn refused(nodes: usize, error: &dyn std::fmt::Display) -> FemError {
    FemError::Triangulation {
        nodes,
        reason: error.to_string(),
    }
}

/// Moves each free node to the centroid of the triangles about it, those weighted more where edges are to be
/// shorter.
fn relax(table: &Table, triangles: &[[u32; 3]], nodes: &mut [Point], is_free: &[bool]) {
    let mut sums = vec![(Vector::zeros(), 0.0); nodes.len()];
    let moves = |triangle: &&[u32; 3]| triangle.iter().any(|node| is_free[*node as usize]);
    for triangle in triangles.iter().filter(moves) {
        let [a, b, c] = triangle.map(|node| nodes[node as usize]);
        let middle = (a.coords + b.coords + c.coords) / 3.0;
        // The density whose centroidal cells have the wanted size, in the plane.
        let weight = doubled_area([a, b, c]) / table.at(middle.into()).powi(4);
        for &node in triangle {
            let (moment, mass) = &mut sums[node as usize];
            *moment += weight * middle;
            *mass += weight;
        }
    }
    for ((node, (moment, mass)), is_free) in nodes.iter_mut().zip(sums).zip(is_free) {
        if *is_free && mass > 0.0 {
            *node = (moment / mass).into();
        }
    }
}

/// Nodes and triangles.
type Plain = (Vec<Point>, Vec<[u32; 3]>);

/// Refines what angles are too small, the wall's edges divided where they must be.
fn refined(nodes: Vec<Point>, fixed: usize) -> Result<Plain, FemError> {
    let count = nodes.len();
    let wall = (0..fixed).map(|node| [node, (node + 1) % fixed]).collect();
    let mut triangulation =
        ConstrainedDelaunayTriangulation::<spade::Point2<f64>>::bulk_load_cdt(points(&nodes), wall)
            .map_err(|error| refused(count, &error))?;
    let parameters = RefinementParameters::<f64>::new()
        .with_angle_limit(AngleLimit::from_deg(LEAST_ANGLE))
        .with_max_additional_vertices(count);
    triangulation.refine(parameters);
    let nodes = triangulation.vertices().map(|vertex| {
        let at = vertex.position();
        Point::new(at.x, at.y)
    });
    let triangles = triangulation
        .inner_faces()
        .map(|face| face.vertices().map(|vertex| vertex.fix().index() as u32));
    Ok((nodes.collect(), triangles.collect()))
}

/// The mesh, numbered along a curve.
fn numbered(nodes: &[Point], triangles: &[[u32; 3]]) -> Result<Mesh, FemError> {
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
    use super::super::{MeshQuality, Wall};
    use super::*;
    use crate::scene::{Curve, Outline, Refinement, Shape};

    /// The size `largest`, or refined about a circle.
    fn wanted(largest: f64, refine: Option<Refinement>) -> MeshSize {
        let circle = Outline {
            curve: Curve::Circle { radius: 0.2 },
            center: [0.5, 0.4],
            angle: 0.0,
        };
        MeshSize::new(largest, refine, &Shape::Outlines(vec![circle]))
    }

    fn made(size: &MeshSize, seed: u64) -> Mesh {
        delaunay(size, seed, &mut || false).expect("a mesh")
    }

    fn quality(mesh: &Mesh) -> MeshQuality {
        assert!((mesh.areas().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let quality = MeshQuality::of(mesh);
        assert!(quality.least_angle >= 25.0, "{quality:?}");
        quality
    }

    #[test]
    fn edges_are_as_long_as_wanted_and_angles_not_small() {
        for (size, seed) in [(0.25, 1), (0.1, 2), (0.03, 3), (0.03, 4), (0.0171, 5)] {
            let mesh = made(&wanted(size, None), seed);
            let [shortest, mean, longest] = quality(&mesh).edges;
            // On the coarsest ones the wall's edges decide.
            let margin = if size > 0.05 { 0.15 } else { 0.08 };
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
            let refine = Refinement {
                band: 0.03,
                size: 0.006,
            };
            // The few large triangles far from the ring, beside the wall, are the least exact.
            follows(&wanted(0.08, Some(refine)), seed, [0.4, 3.3]);
        }
    }

    /// A band much thinner than the cells of the table, and edges of 1e-3 to 0.1.
    #[test]
    fn thin_bands_are_followed_too() {
        let refine = Refinement {
            band: 1e-4,
            size: 1e-3,
        };
        follows(&wanted(0.1, Some(refine)), 1, [0.35, 4.0]);
    }

    /// Whether edges over their wanted lengths are 1 in the mean, and all in a range.
    fn follows(wanted: &MeshSize, seed: u64, [low, high]: [f64; 2]) {
        let mesh = made(wanted, seed);
        quality(&mesh);
        let mut ratios = Vec::new();
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|node| mesh.nodes()[node as usize]);
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let middle = nalgebra::center(&from, &to);
                ratios.push(length(to - from) / wanted.at(middle));
            }
        }
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!((mean - 1.0).abs() < 0.08, "{mean}");
        let extremes = ratios
            .iter()
            .fold([f64::INFINITY, 0.0], |[low, high], ratio: &f64| {
                [low.min(*ratio), high.max(*ratio)]
            });
        assert!(extremes[0] > low && extremes[1] < high, "{extremes:?}");
    }

    /// A mesh that follows a circle on its way: as good as a new one, of as many nodes, and the same each time.
    #[test]
    fn meshes_are_adapted_to_another_size() {
        let refinement = Refinement {
            band: 0.05,
            size: 0.012,
        };
        let about = |x: f64| {
            let at = |n: i32| {
                let angle = f64::from(n) * std::f64::consts::TAU / 200.0;
                Point::new(x + 0.2 * angle.cos(), 0.5 + 0.2 * angle.sin())
            };
            let circle: Vec<_> = (0..200).map(|n| [at(n), at(n + 1)]).collect();
            MeshSize::about(0.1, refinement, &circle)
        };
        let size = about(0.3);
        let first = made(&size, 1);
        let mut mesh = first.clone();
        for step in 0..12 {
            let size = about(0.3 + 0.02 * f64::from(step));
            mesh = adapted(&mesh, &size, step as u64).expect("a mesh");
            quality(&mesh);
            let count = mesh.nodes().len() as f64 / first.nodes().len() as f64;
            assert!((0.85..1.2).contains(&count), "{step}: {count}");
        }
        let again = adapted(&first, &about(0.32), 5).expect("a mesh");
        let same = adapted(&first, &about(0.32), 5).expect("a mesh");
        assert_eq!(
            (again.nodes(), again.triangles()),
            (same.nodes(), same.triangles())
        );
    }

    #[test]
    fn the_making_ends_when_it_is_asked_to() {
        let mut asked = 0;
        let mut leave = || {
            asked += 1;
            asked == 3
        };
        let ended = delaunay(&wanted(0.02, None), 1, &mut leave);
        assert_eq!(ended.map(|_| ()), Err(FemError::Ended));
        assert_eq!(asked, 3);
    }

    #[test]
    fn the_seed_decides() {
        let mesh = |seed| made(&wanted(0.06, None), seed);
        let (one, same, other) = (mesh(7), mesh(7), mesh(8));
        assert_eq!(
            (one.nodes(), one.triangles()),
            (same.nodes(), same.triangles())
        );
        assert_ne!(one.nodes(), other.nodes());
        // The corners are there, and all of the wall lies on the square's sides.
        for at in Wall::of(&one).edges().iter().flatten() {
            assert!([0.0, 1.0].contains(&at.x) || [0.0, 1.0].contains(&at.y));
        }
    }
}
