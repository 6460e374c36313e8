//! Whether nodes and triangles are a mesh: one that covers a connected domain once.
//!
//! Triangles cover their domain once if every edge has one triangle on either side or is on the
//! boundary, the triangles about every node are one fan that goes round at most once, all hang together,
//! and no two edges of the boundary cross. (The number of triangles over a place then changes at the
//! boundary alone. The turning numbers of its closed curves, which do not cross, add up to the Euler
//! characteristic of the surface: so one of them goes round all others.)

use std::collections::HashMap;

use super::Triangulation;
use super::error::{MeshFileError, MeshFileProblem, MeshPlace};
use super::fans::check_fans;
use super::pieces::{PieceFault, check_pieces};
use super::plane;
use super::read::{Content, FileNode, FileTriangle};
use crate::geometry::{
    BoundingBox, Point, Segment, SegmentGrid, doubled_area, first_crossing, length,
    segment_distance,
};

/// Places nearer to each other than this, over the extent of the mesh, are one place.
const SAME: f64 = 1e-10;

/// A triangle's area over the square of its longest edge is at least this.
const FLATTEST: f64 = 1e-12;

/// The mesh of a file's content.
pub(super) fn checked(content: Content) -> Result<Triangulation, MeshFileError> {
    let Content {
        nodes: file_nodes,
        triangles: mut file_triangles,
        end,
        ..
    } = content;
    if file_triangles.is_empty() {
        let end = end.unwrap_or(MeshPlace::Line(1));
        return Err(MeshFileProblem::NoTriangles.at(end));
    }
    once_for_all_groups(&mut file_triangles);
    let (used, places) = number(&file_nodes, &file_triangles)?;
    plane::check(&used)?;
    let nodes: Vec<Point> = used.iter().map(|node| node.at.xy()).collect();
    let extent = BoundingBox::around(&nodes).extent().max();
    let numbers: HashMap<u64, u32> = used
        .iter()
        .enumerate()
        .map(|(place, node)| (node.number, place as u32))
        .collect();
    let mut mesh = Checked {
        corners: file_triangles
            .iter()
            .map(|triangle| triangle.nodes.map(|node| numbers[&node]))
            .collect(),
        used,
        nodes,
        elements: file_triangles,
        tolerance: SAME * extent,
    };
    mesh.no_place_twice()?;
    let turned = mesh.orient()?;
    let boundary = mesh.match_edges()?;
    mesh.nothing_hangs(&boundary)?;
    mesh.fans_are_simple(&boundary)?;
    mesh.nothing_crosses(&boundary)?;
    mesh.one_piece(&boundary)?;
    Ok(Triangulation {
        nodes: mesh.nodes,
        triangles: mesh.corners,
        places,
        turned,
    })
}

/// MSH 2.2 has a triangle once for each of its physical groups: takes the first.
fn once_for_all_groups(triangles: &mut Vec<FileTriangle>) {
    let Some(first) = triangles.first().map(|triangle| triangle.group) else {
        return;
    };
    if triangles.iter().all(|triangle| triangle.group == first) {
        return;
    }
    let mut groups: HashMap<[u64; 3], i64> = HashMap::with_capacity(triangles.len());
    triangles.retain(|triangle| {
        let mut nodes = triangle.nodes;
        nodes.sort_unstable();
        *groups.entry(nodes).or_insert(triangle.group) == triangle.group
    });
}

/// The nodes that triangles use, in the file's order, and where each of the file's is among them.
fn number(
    nodes: &[FileNode],
    triangles: &[FileTriangle],
) -> Result<(Vec<FileNode>, Vec<Option<u32>>), MeshFileError> {
    let mut by_number = HashMap::with_capacity(nodes.len());
    for (index, node) in nodes.iter().enumerate() {
        if by_number.insert(node.number, index).is_some() {
            let number = node.number;
            return Err(MeshFileProblem::NodeTwice { node: number }.at(node.place));
        }
    }
    let mut is_used = vec![false; nodes.len()];
    for triangle in triangles {
        for node in triangle.nodes {
            let Some(index) = by_number.get(&node) else {
                let element = triangle.number;
                return Err(MeshFileProblem::NoNode { element, node }.at(triangle.place));
            };
            is_used[*index] = true;
        }
    }
    let mut used = Vec::new();
    let places = nodes.iter().zip(&is_used).map(|(node, is_used)| {
        is_used.then(|| {
            used.push(*node);
            used.len() as u32 - 1
        })
    });
    let places = places.collect();
    Ok((used, places))
}

/// An edge of one triangle only: its nodes, and the triangle.
struct BoundaryEdge {
    nodes: [u32; 2],
    triangle: usize,
}

struct Checked {
    used: Vec<FileNode>,
    nodes: Vec<Point>,
    elements: Vec<FileTriangle>,
    corners: Vec<[u32; 3]>,
    tolerance: f64,
}

impl Checked {
    fn number(&self, node: u32) -> u64 {
        self.used[node as usize].number
    }

    fn place(&self, triangle: usize) -> MeshPlace {
        self.elements[triangle].place
    }

    fn no_place_twice(&self) -> Result<(), MeshFileError> {
        let size = 2.0 * self.tolerance.max(f64::MIN_POSITIVE);
        let cell = |at: Point| [at.x, at.y].map(|x| (x / size).floor() as i64);
        let mut cells: HashMap<[i64; 2], u32> = HashMap::with_capacity(self.nodes.len());
        for (node, &at) in self.nodes.iter().enumerate() {
            let [column, row] = cell(at);
            let around = (-1..=1).flat_map(|i: i64| (-1..=1).map(move |j: i64| [i, j]));
            for [i, j] in around {
                let key = [column.saturating_add(i), row.saturating_add(j)];
                let Some(&other) = cells.get(&key) else {
                    continue;
                };
                if length(self.nodes[other as usize] - at) <= self.tolerance {
                    let (first, second) = (self.number(other), self.number(node as u32));
                    return Err(
                        MeshFileProblem::SamePlace { first, second, at }.at(self.used[node].place)
                    );
                }
            }
            cells.insert([column, row], node as u32);
        }
        Ok(())
    }

    /// Turns triangles round that are clockwise; returns how many.
    fn orient(&mut self) -> Result<usize, MeshFileError> {
        let mut turned = 0;
        for (triangle, corners) in self.corners.iter_mut().enumerate() {
            let [a, b, c] = corners.map(|node| self.nodes[node as usize]);
            let doubled = doubled_area([a, b, c]);
            let square = |p: Point, q: Point| (q - p).norm_squared();
            let longest = square(a, b).max(square(b, c)).max(square(c, a));
            if doubled.abs() <= FLATTEST * longest {
                let element = self.elements[triangle];
                let (number, nodes) = (element.number, element.nodes);
                return Err(MeshFileProblem::Flat {
                    element: number,
                    nodes,
                }
                .at(element.place));
            }
            if doubled < 0.0 {
                corners.swap(1, 2);
                turned += 1;
            }
        }
        Ok(turned)
    }

    /// Every edge has one triangle on either side, or is on the boundary.
    fn match_edges(&self) -> Result<Vec<BoundaryEdge>, MeshFileError> {
        let mut sorted: Vec<([u32; 3], usize)> = self
            .corners
            .iter()
            .enumerate()
            .map(|(triangle, corners)| {
                let mut nodes = *corners;
                nodes.sort_unstable();
                (nodes, triangle)
            })
            .collect();
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let [first, second] = [pair[0].1, pair[1].1].map(|it| self.elements[it].number);
            return Err(MeshFileProblem::SameTriangle { first, second }.at(self.place(pair[1].1)));
        }
        // (the lesser node, the greater one, whether it runs from the greater one, the triangle)
        let mut edges: Vec<(u32, u32, bool, usize)> = Vec::with_capacity(3 * self.corners.len());
        for (triangle, &[a, b, c]) in self.corners.iter().enumerate() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                edges.push((from.min(to), from.max(to), from > to, triangle));
            }
        }
        edges.sort_unstable();
        let mut boundary = Vec::new();
        for same in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            match *same {
                [(a, b, _, triangle)] => boundary.push(BoundaryEdge {
                    nodes: [a, b],
                    triangle,
                }),
                [(.., false, _), (.., true, _)] => {}
                _ => {
                    let side = same.windows(2).find(|pair| pair[0].2 == pair[1].2);
                    let (one, other) = side.map_or((0, 1), |pair| (pair[0].3, pair[1].3));
                    let [first, second] = [one, other].map(|it| self.elements[it].number);
                    let nodes = [same[0].0, same[0].1].map(|node| self.number(node));
                    let [a, b] = [same[0].0, same[0].1].map(|node| self.nodes[node as usize]);
                    return Err(MeshFileProblem::Overlap {
                        first,
                        second,
                        nodes,
                        at: nalgebra::center(&a, &b),
                    }
                    .at(self.place(other)));
                }
            }
        }
        Ok(boundary)
    }

    /// No node of the boundary lies within an edge of the boundary.
    fn nothing_hangs(&self, boundary: &[BoundaryEdge]) -> Result<(), MeshFileError> {
        let places = |edge: &BoundaryEdge| edge.nodes.map(|node| self.nodes[node as usize]);
        let segments: Vec<Segment> = boundary.iter().map(places).collect();
        let grid = SegmentGrid::new(segments.clone(), self.tolerance);
        for node in boundary.iter().flat_map(|edge| edge.nodes) {
            let at = self.nodes[node as usize];
            let mut near = grid.near(at).map(|number| (number, &boundary[number]));
            let hit = near.find(|(number, edge)| {
                !edge.nodes.contains(&node)
                    && segment_distance(at, segments[*number]) <= self.tolerance
            });
            if let Some((_, edge)) = hit {
                return Err(MeshFileProblem::Hanging {
                    node: self.number(node),
                    element: self.elements[edge.triangle].number,
                    nodes: edge.nodes.map(|node| self.number(node)),
                }
                .at(self.used[node as usize].place));
            }
        }
        Ok(())
    }

    /// The triangles about a node are one fan, that goes round once at most.
    fn fans_are_simple(&self, boundary: &[BoundaryEdge]) -> Result<(), MeshFileError> {
        let edges: Vec<[u32; 2]> = boundary.iter().map(|edge| edge.nodes).collect();
        let Some(fault) = check_fans(&self.nodes, &self.corners, &edges) else {
            return Ok(());
        };
        let [first, second] = fault.triangles.map(|it| self.elements[it].number);
        let (node, at) = (self.number(fault.node), self.nodes[fault.node as usize]);
        let problem = match fault.overlap {
            true => MeshFileProblem::OverlapAtNode {
                first,
                second,
                node,
                at,
            },
            false => MeshFileProblem::CornerOnly {
                first,
                second,
                node,
                at,
            },
        };
        Err(problem.at(self.place(fault.triangles[1])))
    }

    /// No two edges of the boundary cross.
    fn nothing_crosses(&self, boundary: &[BoundaryEdge]) -> Result<(), MeshFileError> {
        let places = |edge: &BoundaryEdge| edge.nodes.map(|node| self.nodes[node as usize]);
        let segments: Vec<Segment> = boundary.iter().map(places).collect();
        let Some((pair, at)) = first_crossing(&segments) else {
            return Ok(());
        };
        let triangles = pair.map(|edge| boundary[edge].triangle);
        let [first, second] = triangles.map(|it| self.elements[it].number);
        Err(MeshFileProblem::Crossing { first, second, at }.at(self.place(triangles[1])))
    }

    /// All triangles hang together.
    fn one_piece(&self, boundary: &[BoundaryEdge]) -> Result<(), MeshFileError> {
        let edges: Vec<[u32; 2]> = boundary.iter().map(|edge| edge.nodes).collect();
        let number = |triangle: usize| self.elements[triangle].number;
        match check_pieces(&self.nodes, &self.corners, &edges, self.tolerance) {
            None => Ok(()),
            Some(PieceFault::Apart { triangle }) => {
                let element = number(triangle);
                Err(MeshFileProblem::Pieces { element }.at(self.place(triangle)))
            }
            Some(PieceFault::Over { triangle, edge }) => {
                let (other, node) = (boundary[edge].triangle, boundary[edge].nodes[0]);
                let problem = MeshFileProblem::NodeWithin {
                    first: number(triangle),
                    second: number(other),
                    node: self.number(node),
                    at: self.nodes[node as usize].into(),
                };
                Err(problem.at(self.place(other)))
            }
        }
    }
}
