//! The node hierarchy: transforms of all nodes, static and animated.
//!
//! Transforms are read and composed in f64, with the rounding errors of translations kept (`Placement`). Each node
//! stores its translation, rotation and scale separately, with their tracks, so that its motion can be evaluated over
//! time.
use super::{
    animation::{self, Tracks},
    choose::Selected,
    document::{Document, label},
    options::Options,
};
use crate::{Placement, SceneError};
use dapple_camera::camera::axes;
use dapple_math::motion::{self, Chain, Channel, Trs};
use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};
use serde_json::Value;
use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

/// The nodes of the selected scene.
pub(super) struct Hierarchy {
    nodes: Vec<Node>,
    /// Visible nodes in depth-first order, parents before children.
    pub order: Vec<usize>,
}

struct Node {
    parent: Option<usize>,
    local: Local,
    tracks: Tracks,
}

/// Transform of a node to its parent.
#[derive(Clone, Copy, Debug)]
enum Local {
    Matrix(DAffine3),
    Trs { translation: DVec3, rotation: DQuat, scale: DVec3 },
}

impl Hierarchy {
    pub fn new(doc: &Document<'_>, selected: &Selected) -> Result<Self, SceneError> {
        let tracks = animation::tracks(doc, &selected.animations)?;
        let mut nodes = Vec::with_capacity(tracks.len());
        for (i, tracks) in tracks.into_iter().enumerate() {
            nodes.push(Node { parent: None, local: local(doc, i)?, tracks });
        }
        for (i, node) in doc.root.nodes.iter().enumerate() {
            let place = place(doc, i);
            for &child in node.children.iter().flatten() {
                doc.get(&doc.root.nodes, child, "node", &place)?;
                let parent = nodes[child.value()].parent.replace(i);
                if parent == Some(i) {
                    let child = self::place(doc, child.value());
                    doc.warn(format!(
                        "{child} is listed more than once as a child of {place}: it is shown once"
                    ));
                } else if let Some(other) = parent {
                    let what = format!(
                        "is a child of node {other} and of node {i}; a node may have only one parent"
                    );
                    return Err(doc.invalid(self::place(doc, child.value()), what));
                }
            }
        }
        let mut hierarchy = Self { nodes, order: Vec::new() };
        hierarchy.walk(doc, selected.scene)?;
        Ok(hierarchy)
    }

    /// Fills `order`, depth first. As nodes have at most one parent, no cycle is reachable from roots without parent. A
    /// root that is also a child is shown once: below its parent if that is in the scene, or else as a root.
    fn walk(&mut self, doc: &Document<'_>, scene: Option<usize>) -> Result<(), SceneError> {
        let mut seen = vec![false; self.nodes.len()];
        let (children, roots): (Vec<usize>, Vec<usize>) =
            self.roots(doc, scene)?.into_iter().partition(|i| self.nodes[*i].parent.is_some());
        for root in roots {
            self.descend(doc, root, &mut seen)?;
        }
        for root in children {
            let place = place(doc, root);
            if seen[root] {
                doc.warn(format!(
                    "{place} is both a root of the scene and a child: it is shown once, as the child"
                ));
            } else {
                doc.warn(format!(
                    "{place} is both a root of the scene and a child of a node outside it: it is shown as the root"
                ));
                self.nodes[root].parent = None;
                self.descend(doc, root, &mut seen)?;
            }
        }
        Ok(())
    }

    fn descend(&mut self, doc: &Document<'_>, root: usize, seen: &mut [bool]) -> Result<(), SceneError> {
        let mut stack = vec![root];
        while let Some(i) = stack.pop() {
            if std::mem::replace(&mut seen[i], true) {
                return Err(doc.invalid(place(doc, i), "is in the scene twice; remove one of its references"));
            }
            if is_hidden(doc, i) {
                continue;
            }
            self.order.push(i);
            stack.extend(children(doc, i).into_iter().rev());
        }
        Ok(())
    }

    /// Roots of the chosen scene without duplicates; in a file without scenes, all nodes without parent.
    fn roots(&self, doc: &Document<'_>, scene: Option<usize>) -> Result<Vec<usize>, SceneError> {
        let Some(scene) = scene.and_then(|scene| doc.root.scenes.get(scene)) else {
            return Ok((0..self.nodes.len()).filter(|&i| self.nodes[i].parent.is_none()).collect());
        };
        let (mut roots, mut known) = (Vec::new(), vec![false; self.nodes.len()]);
        for &root in &scene.nodes {
            doc.get(&doc.root.nodes, root, "node", "the scene")?;
            if std::mem::replace(&mut known[root.value()], true) {
                let place = place(doc, root.value());
                doc.warn(format!(
                    "{place} is listed more than once as a root of the scene: it is shown once"
                ));
            } else {
                roots.push(root.value());
            }
        }
        Ok(roots)
    }

    /// Placements of all nodes at a time in seconds; only those of nodes in `order` are meaningful.
    pub fn placements(&self, time: f64) -> Vec<Placement> {
        let mut out = vec![Placement::IDENTITY; self.nodes.len()];
        for &i in &self.order {
            let parent = self.nodes[i].parent.map_or(Placement::IDENTITY, |p| out[p]);
            out[i] = parent.child(&self.nodes[i].at(time));
        }
        out
    }

    /// Whether a visible node is animated, so that the scene depends on the time.
    pub fn is_animated(&self) -> bool {
        self.order.iter().any(|&i| !self.nodes[i].tracks.is_empty())
    }

    /// Whether each node or one of its ancestors moves between two times.
    pub fn moving(&self, open: f64, close: f64) -> Vec<bool> {
        let mut out = vec![false; self.nodes.len()];
        for &i in &self.order {
            let node = &self.nodes[i];
            out[i] = node.parent.is_some_and(|p| out[p]) || node.moves(open, close);
        }
        out
    }

    /// Placement of a node's camera at a time. The node's own scale is ignored; if the scales of its ancestors are
    /// singular, they are ignored for the orientation as well.
    pub fn camera(&self, index: usize, placements: &[Placement], time: f64) -> Placement {
        let node = &self.nodes[index];
        let parent = node.parent.map_or(Placement::IDENTITY, |p| placements[p]);
        let camera = parent.child(&node.unscaled(time));
        if !is_flat(&camera.linear) {
            return camera;
        }
        let up_to_root = std::iter::successors(Some(index), |&i| self.nodes[i].parent);
        let linear = up_to_root.fold(DMat3::IDENTITY, |below, i| self.nodes[i].rotation(time) * below);
        Placement { linear, ..camera }
    }

    /// The chain of nodes of a node's camera, from the root down to the node itself, whose own scale is ignored.
    /// `known` caches the chains of nodes.
    pub fn camera_chain(&self, index: usize, known: &mut HashMap<usize, Chain>) -> Chain {
        let node = &self.nodes[index];
        let above = node.parent.map_or_else(Chain::default, |parent| self.chain(parent, known));
        let mut own = node.in_time();
        if let motion::Node::Trs(own) = &mut own {
            own.scale = Channel::Constant(DVec3::ONE);
        }
        above.then(own)
    }

    /// The number of links in each node's chain after constant nodes are folded; 0 for nodes that do not move while the
    /// shutter is open.
    pub fn links(&self, options: &Options) -> Vec<u64> {
        let (at, shutter) = (options.at, options.shutter);
        let moving = self.moving(at + shutter.open, at + shutter.close);
        let mut tracked = vec![0; self.nodes.len()];
        for &i in &self.order {
            let above = self.nodes[i].parent.map_or(0, |p| tracked[p]);
            tracked[i] = above + u64::from(!self.nodes[i].tracks.is_empty());
        }
        tracked.iter().zip(moving).map(|(n, moves)| if moves { 2 * n + 2 } else { 0 }).collect()
    }

    /// The chain of nodes from the root down to a node. `known` caches the chains of nodes.
    pub fn chain(&self, index: usize, known: &mut HashMap<usize, Chain>) -> Chain {
        let mut below = Vec::new();
        let mut at = Some(index);
        while let Some(i) = at.filter(|i| !known.contains_key(i)) {
            below.push(i);
            at = self.nodes[i].parent;
        }
        let mut chain = at.map_or_else(Chain::default, |i| known[&i].clone());
        for i in below.into_iter().rev() {
            chain = chain.then(self.nodes[i].in_time());
            known.insert(i, chain.clone());
        }
        chain
    }
}

impl Node {
    /// Placement in the parent at a time. Tracks replace the node's own values; if there are any, a matrix is ignored.
    fn at(&self, time: f64) -> Placement {
        let tracks = &self.tracks;
        let (translation, rotation, scale) = match self.local {
            Local::Matrix(matrix) if tracks.is_empty() => return matrix.into(),
            local => local.parts(),
        };
        trs(
            tracks.translation.as_ref().map_or(translation, |t| t.at(time)),
            tracks.rotation.as_ref().map_or(rotation, |t| t.at(time)),
            tracks.scale.as_ref().map_or(scale, |t| t.at(time)),
        )
    }

    /// As [`Node::at`], without the scale. A matrix is kept unchanged.
    fn unscaled(&self, time: f64) -> Placement {
        let tracks = &self.tracks;
        let (translation, rotation, _) = match self.local {
            Local::Matrix(matrix) if tracks.is_empty() => return matrix.into(),
            local => local.parts(),
        };
        let translation = tracks.translation.as_ref().map_or(translation, |t| t.at(time));
        trs(translation, tracks.rotation.as_ref().map_or(rotation, |t| t.at(time)), DVec3::ONE)
    }

    /// The rotation alone; the identity if a matrix has a rank below two.
    fn rotation(&self, time: f64) -> DMat3 {
        let axes = axes(&self.unscaled(time).linear);
        axes.map_or(DMat3::IDENTITY, |(right, up, backward)| DMat3::from_cols(right, up, backward))
    }

    fn moves(&self, open: f64, close: f64) -> bool {
        let tracks = &self.tracks;
        close > open
            && (tracks.translation.as_ref().is_some_and(|t| !t.is_constant_within(open, close))
                || tracks.rotation.as_ref().is_some_and(|t| !t.is_constant_within(open, close))
                || tracks.scale.as_ref().is_some_and(|t| !t.is_constant_within(open, close)))
    }

    /// The node with its tracks, for a chain.
    fn in_time(&self) -> motion::Node {
        fn channel<T: motion::Value>(track: &Option<Arc<motion::Track<T>>>, constant: T) -> Channel<T> {
            track.as_ref().map_or(Channel::Constant(constant), |t| Channel::Track(t.clone()))
        }
        let tracks = &self.tracks;
        let (translation, rotation, scale) = match self.local {
            Local::Matrix(matrix) if tracks.is_empty() => return motion::Node::Fixed(matrix),
            local => local.parts(),
        };
        motion::Node::Trs(Trs {
            translation: channel(&tracks.translation, translation),
            rotation: channel(&tracks.rotation, rotation),
            scale: channel(&tracks.scale, scale),
        })
    }
}

impl Local {
    /// Translation, rotation and scale; those of the identity for a matrix, which is ignored if the node is animated.
    fn parts(self) -> (DVec3, DQuat, DVec3) {
        match self {
            Self::Matrix(_) => (DVec3::ZERO, DQuat::IDENTITY, DVec3::ONE),
            Self::Trs { translation, rotation, scale } => (translation, rotation, scale),
        }
    }
}

/// Whether a transform is singular.
pub(super) fn is_flat(m: &DMat3) -> bool {
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::normalize_or_zero);
    // The bound covers rounding. Axes that are not finite have become zero.
    x.dot(y.cross(z)).abs() <= 1e-12
}

/// Translation · rotation · scale.
pub(super) fn trs(translation: DVec3, rotation: DQuat, scale: DVec3) -> Placement {
    let r = DMat3::from_quat(rotation);
    let linear = DMat3::from_cols(r.x_axis * scale.x, r.y_axis * scale.y, r.z_axis * scale.z);
    DAffine3 { matrix3: linear, translation }.into()
}

/// The children of a node without duplicates.
fn children(doc: &Document<'_>, index: usize) -> Vec<usize> {
    let mut known = HashSet::new();
    let all = doc.root.nodes[index].children.iter().flatten().map(|child| child.value());
    all.filter(|child| known.insert(*child)).collect()
}

/// Name of a node in messages.
pub(super) fn place(doc: &Document<'_>, index: usize) -> String {
    label("node", index, doc.root.nodes[index].name.as_deref())
}

/// Whether a node is hidden by KHR_node_visibility, which also hides its descendants.
fn is_hidden(doc: &Document<'_>, index: usize) -> bool {
    let extensions = doc.root.nodes[index].extensions.as_ref();
    let visibility = extensions.and_then(|e| e.others.get("KHR_node_visibility"));
    visibility.and_then(|v| v.get("visible")).and_then(Value::as_bool) == Some(false)
}

/// A node's own transform, read from the plain JSON because the typed one is rounded to f32.
fn local(doc: &Document<'_>, index: usize) -> Result<Local, SceneError> {
    let node = &doc.value["nodes"][index];
    let bad =
        |what: &str| doc.invalid(place(doc, index), format!("its {what} must be a list of finite numbers"));
    if node.get("matrix").is_some() {
        let m: [f64; 16] = numbers(node, "matrix").ok_or_else(|| bad("matrix"))?;
        let column = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
        let linear = DMat3::from_cols(column(0), column(1), column(2));
        return Ok(Local::Matrix(DAffine3 { matrix3: linear, translation: column(3) }));
    }
    let or = |key: &str, default: DVec3| match node.get(key) {
        Some(_) => numbers(node, key).map(DVec3::from_array).ok_or_else(|| bad(key)),
        None => Ok(default),
    };
    let rotation = match node.get("rotation") {
        Some(_) => numbers(node, "rotation").map(DQuat::from_array).ok_or_else(|| bad("rotation"))?,
        None => DQuat::IDENTITY,
    };
    let Some(rotation) = DVec4::from(rotation).try_normalize().map(DQuat::from_vec4) else {
        return Err(doc.invalid(place(doc, index), "its rotation is zero; it must be a unit quaternion"));
    };
    Ok(Local::Trs { translation: or("translation", DVec3::ZERO)?, rotation, scale: or("scale", DVec3::ONE)? })
}

fn numbers<const N: usize>(node: &Value, key: &str) -> Option<[f64; N]> {
    let list = node.get(key)?.as_array().filter(|list| list.len() == N)?;
    let mut out = [0.0; N];
    for (out, value) in out.iter_mut().zip(list) {
        *out = value.as_f64().filter(|v| v.is_finite())?;
    }
    Some(out)
}
