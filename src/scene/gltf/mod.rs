//! glTF 2.0, as JSON and as GLB, by the crate `gltf`. Triangles come in the order of the nodes, depth first, of their
//! meshes' primitives, and of the indices; each node's mesh is placed by the node and all above it, in f64. The default
//! scene is taken; without one, the roots of every scene; without a scene, the nodes that are no node's child. A mirrored
//! node turns its triangles' corners, so that fronts stay fronts. Skins, morph targets and textures are passed over.
//! The crate's JSON is used, and not its readers: they panic on buffers that are too short.

mod accessor;
mod buffers;
mod document;
mod nodes;

use std::path::Path;

use glam::{DMat4, DVec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use self::accessor::Elements;
use self::buffers::Buffers;
use super::mesh::{self, Place, Tally};
use super::siblings::Siblings;
use super::{MAX_TRIANGLES, Materials, Progress, Scene, SceneError, Warning, memory};

const DAMAGED: &str = "the file is damaged: get it again, or export it again";

/// Reads a glTF or a GLB: which one, its first bytes say.
///
/// # Errors
/// JSON that is no glTF 2.0, a required extension that isn't known, a buffer that can't be read or is too short, a node
/// with two parents, an index out of range: with its place in the document. No triangle, or more than 2^30.
pub(super) fn parse(
    path: &Path,
    bytes: &[u8],
    siblings: Siblings<'_>,
    progress: Progress,
) -> Result<Scene, SceneError> {
    let (root, blob) = document::read(path, bytes)?;
    let placed = nodes::placed(path, &root)?;
    let buffers = Buffers::load(path, &root, blob, siblings, progress)?;
    let mut file = File { path, root: &root, buffers, odd: Odd::default() };
    let mut shapes: Vec<Option<Vec<Shape>>> = vec![];
    shapes.resize_with(root.meshes.len(), || None);
    let bar = progress.count(format!("parsing {}", path.display()), placed.len() as u64);
    let mut total = 0;
    for mesh in placed.iter().map(|p| p.mesh) {
        if shapes[mesh].is_none() {
            shapes[mesh] = Some(file.shapes(mesh)?);
        }
        total += shapes[mesh].iter().flatten().map(|s| s.triangles.len() as u64).sum::<u64>();
        if total > MAX_TRIANGLES {
            return Err(file.too_large("its nodes show more than 2^30 triangles".to_owned()));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();

    let mut flat = Flat::default();
    let vertices = placed.iter().flat_map(|p| &shapes[p.mesh]).flatten().map(|s| s.positions.len()).sum();
    let bytes = 12 * (vertices as u64 + total);
    memory::must_hold(bytes).map_err(|why| file.too_large(format!("its {total} triangles {why}")))?;
    let room = flat.positions.try_reserve_exact(vertices);
    let room = room.and_then(|()| flat.triangles.try_reserve_exact(total as usize));
    room.map_err(|_| file.too_large(format!("its {total} triangles don't fit in memory")))?;
    for p in &placed {
        shapes[p.mesh].iter().flatten().for_each(|s| flat.add(s, &p.place));
        file.odd.see(&root, p.node);
    }
    let materials = flat.materials(&root);
    let scene = mesh::scene(path, flat.positions, flat.triangles, file.odd.warnings(&root))?;
    Ok(Scene { materials, ..scene })
}

/// A primitive in its own coordinates: the vertices that it uses.
struct Shape {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    material: u32,
}

/// A document with all it names.
struct File<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: Buffers,
    odd: Odd,
}

impl File<'_> {
    fn too_large(&self, what: String) -> SceneError {
        SceneError::TooLarge { name: self.path.display().to_string(), what }
    }

    /// The primitives of triangles of mesh `m`.
    fn shapes(&mut self, m: usize) -> Result<Vec<Shape>, SceneError> {
        let mut shapes = vec![];
        for (i, primitive) in self.root.meshes[m].primitives.iter().enumerate() {
            let place = Place { item: Some(("primitive", i as u64)), unit: "mesh", at: m as u64 };
            let Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) =
                primitive.mode
            else {
                self.odd.thin.add(place);
                continue;
            };
            let (positions, corners) = self
                .vertices(primitive)
                .map_err(|what| SceneError::invalid(self.path, place.to_string(), what, DAMAGED))?;
            if mode == Mode::Triangles && !corners.len().is_multiple_of(3) {
                self.odd.cut.add(place);
            }
            let material = primitive.material.map_or(Materials::NONE, |m| m.value() as u32);
            shapes.push(Shape { positions, triangles: triangles(mode, &corners), material });
        }
        Ok(shapes)
    }

    /// The vertices that a primitive uses, in the accessor's order, and the index among them of each corner.
    fn vertices(&self, primitive: &Primitive) -> Result<(Vec<[f32; 3]>, Vec<u32>), String> {
        let open = |index: &Index<_>| Elements::open(self.root, &self.buffers, index.value());
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let positions = open(positions.ok_or("it has no POSITION")?)?;
        positions.must_be_positions()?;
        let count = positions.count;
        let mut corners = match &primitive.indices {
            Some(index) => open(index)?.indices()?,
            None if count as u64 > 3 * MAX_TRIANGLES => {
                return Err(format!("its {count} vertices are too many"));
            }
            None => accessor::collect((0..count).map(|i| i as u32))?,
        };
        if let Some((i, v)) = corners.iter().enumerate().find(|(_, v)| **v as usize >= count) {
            return Err(format!("index {i} names vertex {v}, and there are {count}"));
        }
        // One accessor may serve many primitives: each takes what it uses.
        if count <= corners.len() {
            return Ok((accessor::collect((0..count).map(|i| positions.position(i)))?, corners));
        }
        let mut used = accessor::collect(corners.iter().copied())?;
        used.sort_unstable();
        used.dedup();
        for corner in &mut corners {
            *corner = used.partition_point(|u| u < corner) as u32;
        }
        Ok((accessor::collect(used.iter().map(|i| positions.position(*i as usize)))?, corners))
    }
}

/// The triangles of a list, strip or fan: glTF 2.0, 3.7.2.1. What doesn't fill a triangle is left out.
fn triangles(mode: Mode, v: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            (0..v.len().saturating_sub(2)).map(|i| [v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]]).collect()
        }
        Mode::TriangleFan => (1..v.len().saturating_sub(1)).map(|i| [v[i], v[i + 1], v[0]]).collect(),
        Mode::Triangles => v.as_chunks().0.to_vec(),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => vec![],
    }
}

/// All shapes so far, where their nodes place them.
#[derive(Default)]
struct Flat {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Runs of triangles of one material.
    materials: Vec<(u32, usize)>,
}

impl Flat {
    fn add(&mut self, shape: &Shape, place: &DMat4) {
        // Less than 3 × 2^30, for each vertex is some corner's.
        let first = self.positions.len() as u32;
        if *place == DMat4::IDENTITY {
            // To the bit: -0 and NaN too.
            self.positions.extend_from_slice(&shape.positions);
        } else {
            let moved = |p: &[f32; 3]| {
                place.transform_point3(DVec3::from_array(p.map(f64::from))).as_vec3().to_array()
            };
            self.positions.extend(shape.positions.iter().map(moved));
        }
        let mirrored = glam::DMat3::from_mat4(*place).determinant() < 0.0;
        let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        self.triangles.extend(shape.triangles.iter().map(|t| turned(t.map(|v| first + v))));
        self.materials.push((shape.material, shape.triangles.len()));
    }

    /// The base colours, if any triangle has a material.
    fn materials(&self, root: &Root) -> Materials {
        if self.materials.iter().all(|(m, _)| *m == Materials::NONE) {
            return Materials::default();
        }
        let color = |m: &gltf::json::Material| {
            let [r, g, b, _] = m.pbr_metallic_roughness.base_color_factor.0;
            [r, g, b].map(|x| x.clamp(0.0, 1.0))
        };
        let of_triangles = self.materials.iter().flat_map(|(m, n)| std::iter::repeat_n(*m, *n)).collect();
        Materials { colors: root.materials.iter().map(color).collect(), of_triangles }
    }
}

/// What was odd.
#[derive(Default)]
struct Odd {
    thin: Tally,
    cut: Tally,
    skinned: Tally,
    morphed: Tally,
}

impl Odd {
    /// Counts what node `n` asks for and doesn't get.
    fn see(&mut self, root: &Root, n: usize) {
        let (node, place) = (&root.nodes[n], Place { item: None, unit: "node", at: n as u64 });
        if node.skin.is_some() {
            self.skinned.add(place);
        }
        let weights =
            node.weights.as_ref().or(node.mesh.and_then(|m| root.meshes[m.value()].weights.as_ref()));
        if weights.is_some_and(|w| w.iter().any(|x| *x != 0.0)) {
            self.morphed.add(place);
        }
    }

    fn warnings(&self, root: &Root) -> Vec<Warning> {
        let instanced =
            root.extensions_used.iter().any(|e| e == "EXT_mesh_gpu_instancing").then(|| Warning {
                what: "extension EXT_mesh_gpu_instancing, which is not read: each mesh stands once"
                    .to_owned(),
                count: 1,
                first: "extensionsUsed".to_owned(),
            });
        [
            self.thin.warning("primitives of points or lines, left out"),
            self.cut.warning("primitives whose last triangle lacks a corner, which is left out"),
            self.skinned.warning("meshes with a skin, in the pose they are stored in"),
            self.morphed.warning("meshes with morph targets, as they are without"),
            instanced,
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}
