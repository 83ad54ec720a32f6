//! The nodes of the scene, flattened: which mesh stands where.

use std::path::Path;

use glam::{DMat4, DQuat, DVec3};
use gltf::json::scene::Node;
use gltf::json::{Index, Root};

use super::DAMAGED;
use crate::scene::SceneError;

/// A mesh where a node places it.
pub(super) struct Placed {
    pub(super) mesh: usize,
    pub(super) node: usize,
    /// From the mesh's coordinates to the scene's.
    pub(super) place: DMat4,
}

/// Every mesh of the scene, depth first.
///
/// # Errors
/// A node that is reached twice: the nodes are no tree. A rotation that is none.
pub(super) fn placed(path: &Path, root: &Root) -> Result<Vec<Placed>, SceneError> {
    let invalid = |node: usize, what: &str| SceneError::invalid(path, format!("node {node}"), what, DAMAGED);
    let mut reached = vec![false; root.nodes.len()];
    let mut placed = vec![];
    // No recursion: a file may nest as deep as it likes.
    let mut open: Vec<_> = roots(root).into_iter().rev().map(|n| (n, DMat4::IDENTITY)).collect();
    while let Some((n, above)) = open.pop() {
        if std::mem::replace(&mut reached[n], true) {
            return Err(invalid(n, "it is reached twice: nodes form a ring, or this one has two parents"));
        }
        let node = &root.nodes[n];
        let local = local(node).ok_or_else(|| invalid(n, "its rotation is no quaternion"))?;
        let place = if local == DMat4::IDENTITY { above } else { above * local };
        if let Some(mesh) = node.mesh {
            placed.push(Placed { mesh: mesh.value(), node: n, place });
        }
        open.extend(indices(&node.children).rev().map(|c| (c, place)));
    }
    Ok(placed)
}

fn indices(nodes: &Option<Vec<Index<Node>>>) -> impl DoubleEndedIterator<Item = usize> {
    nodes.iter().flatten().map(|n| n.value())
}

/// Where to start, each node once.
fn roots(root: &Root) -> Vec<usize> {
    let mut left_out = vec![false; root.nodes.len()];
    let scenes = match root.scene {
        Some(scene) => std::slice::from_ref(&root.scenes[scene.value()]),
        None => &root.scenes,
    };
    if scenes.is_empty() {
        root.nodes.iter().flat_map(|n| indices(&n.children)).for_each(|child| left_out[child] = true);
        return (0..root.nodes.len()).filter(|n| !left_out[*n]).collect();
    }
    let nodes = scenes.iter().flat_map(|s| &s.nodes).map(|n| n.value());
    nodes.filter(|n| !std::mem::replace(&mut left_out[*n], true)).collect()
}

/// From a node's coordinates to those above.
fn local(node: &Node) -> Option<DMat4> {
    if let Some(m) = node.matrix {
        return Some(DMat4::from_cols_array(&m.map(f64::from)));
    }
    let vector = |v: Option<[f32; 3]>, or: DVec3| v.map_or(or, |v| DVec3::from_array(v.map(f64::from)));
    // Of unit length only up to the rounding of f32.
    let rotation = match node.rotation {
        Some(r) => DQuat::from_array(r.0.map(f64::from)),
        None => DQuat::IDENTITY,
    };
    let length = rotation.length();
    (length.is_finite() && length > 0.0).then(|| {
        DMat4::from_scale_rotation_translation(
            vector(node.scale, DVec3::ONE),
            rotation / length,
            vector(node.translation, DVec3::ZERO),
        )
    })
}
