//! boxwood: bounding volume hierarchies built and traced by Vulkan compute shaders, and measured honestly.
//!
//! # Flow
//! `scene → bvh::{morton → sort → ploc → collapse → layout} → trace → bench → report`
//! (`odop`, `lbvh` or `binned` may stand in for `ploc`; `recut` may come before `collapse`, `odopfit` and `dito → orient`
//! may follow `layout`)
//!
//! A [`scene::Scene`] is read, fetched or generated on the host and uploaded as [`bvh::SceneBuffers`];
//! [`bvh::build`] records the stages of a build, [`trace::trace`] sends rays through the packed tree, and
//! [`oracle`] says whether tree and hits are right.
//!
//! # Rooms
//! | room | what it knows |
//! |---|---|
//! | [`abi`] | every struct and constant that host and kernels share; `build.rs` makes the GLSL side of it |
//! | [`kernels`] | one constant a `glsl/<stage>/<verb>.comp` |
//! | [`output`] | files that appear whole or not at all |
//! | [`scene`] | meshes: files, fetched ones, generators, cameras |
//! | [`device`] | Vulkan: selection, buffers, pipelines, recorded passes, times; knows no trees |
//! | [`bvh`] | records a build; knows no files |
//! | [`saved`] | built trees as files |
//! | [`trace`] | rays and their hits |
//! | [`ray_query`] | the driver's own structures and their traversal, to compare with |
//! | [`oracle`] | CPU twins of the kernels, and an f64 reference that they and the device answer to |
//! | [`picture`] | pictures of scenes, and of what their rays cost |
//! | [`bench`](mod@bench) | warm-up, repeats, medians, rows |
//! | [`profile`](mod@profile) | time, bytes and active lanes by kernel; a timeline |
//! | [`stress`] | scenes and rays that try to break all of it |
//! | [`report`] | the rows of a benchmark as a page; knows no device |
//! | [`cli`] | the command line; knows everything, nothing knows it |
//!
//! How to add a builder stands in [`bvh`], how to read what is measured in [`bench`](mod@bench).
//!
//! A stage has one name in four places: `src/bvh/ploc.rs` records it, `glsl/ploc/*.comp` compute it,
//! `src/oracle/ploc.rs` defines it, `tests/it/ploc.rs` compares. Kernel `ploc/search` is its file, its constant
//! [`kernels::PLOC_SEARCH`], its arguments [`abi::PlocSearchArgs`], its label, its row in a report and its name in an
//! error.
//!
//! # Glossary
//! - **leaf, inner node**: of the packed tree; a *raw* node is one of the binary tree before collapse.
//! - **basis, ODOP**: a rotation fixed before the build; an oriented discrete orientation polytope, what the boxes of the
//!   same triangles in all bases have in common, whose area is taken to be that of the least box.
//! - **own bases** of a scene: those that most of its triangles share.
//! - **frame**: a rotation that an oriented packed node's children's boxes share; an axis-aligned node has none.
//! - **slot**: a child of a packed node, or the root: what extremal points, ranges and frames are kept for.
//! - **collapse**: cutting the binary tree into packed nodes of up to four children and leaves of several triangles, so
//!   that `c_N Σ_node A + c_I Σ_leaf A n` is least; a raw node becomes a packed one (it is *kept*), goes up into the one
//!   above (*absorbed*), or becomes a leaf (*collapsed*) \[YLITIE17\].
//! - **SAH cost**: of the binary tree above the leaves, `[c_T Σ_inner A + c_I Σ_leaf A n] / A_scene`, A half surface
//!   areas, n triangles \[WALD07\].
//! - **EPO**, end-point overlap: cost, expected at a point of the surface, of the nodes whose boxes hold the point and
//!   which don't hold its triangle \[AILA13\].
//! - **LCV**, leaf-count variability: standard deviation of the number of leaves that a ray meets \[AILA13\].
//! - **wide SAH cost**: the SAH cost of the packed tree, `c_T / 2` for each child of a node.
//! - **Morton rank**: a triangle's place in Morton order.
//! - **unit space**: scene coordinates scaled by a power of two so that the longest edge lies in ½…1, less an anchor.
//! - **robust, fast**: the watertight triangle test with exact signs; Möller–Trumbore.
//! - **bound**: how far a hit's t, u and v may be off at worst, derived in [`oracle::bounds`]; of a secondary ray's origin, in
//!   `glsl/rays/surface.glsl`.
//! - **stable ray**: one whose copies, changed by what rounding may change, agree, so that a difference there is a fault:
//!   [`oracle::compare`].
//! - **device shape**: how many items an invocation takes, how large a workgroup is. Results never depend on it.
//!
//! # Bibliography
//! - \[AILA09\] Aila, Laine: Understanding the efficiency of ray traversal on GPUs. HPG 2009.
//! - \[AILA13\] Aila, Karras, Laine: On quality metrics of bounding volume hierarchies. HPG 2013.
//! - \[APETREI14\] Apetrei: Fast and simple agglomerative LBVH construction. CGVC 2014.
//! - \[DEKKER71\] Dekker: A floating-point technique for extending the available precision. Numerische Mathematik 18, 1971.
//! - \[DOBB25\] Kern, Galvan, Oldcorn, Skinner, Mehalwal, Reyes Lozano, Chajdas: DOBB-BVH: efficient ray traversal by
//!   transforming wide BVHs into oriented bounding box trees using discrete rotations. CGF 44, 2025.
//! - \[GOLDSMITH87\] Goldsmith, Salmon: Automatic creation of object hierarchies for ray tracing. CG&A 7(5), 1987.
//! - \[HIGHAM02\] Higham: Accuracy and stability of numerical algorithms. Second edition, SIAM, 2002.
//! - \[KARRAS12\] Karras: Maximizing parallelism in the construction of BVHs, octrees and k-d trees. HPG 2012.
//! - \[LARSSON11\] Larsson, Källberg: Fast computation of tight-fitting oriented bounding boxes. Game Engine Gems 2, 2011.
//! - \[MCGILL78\] McGill, Tukey, Larsen: Variations of box plots. The American Statistician 32(1), 1978.
//! - \[MERRILL10\] Merrill, Grimshaw: Revisiting sorting for GPGPU stream architectures. PACT 2010.
//! - \[MOLLER97\] Möller, Trumbore: Fast, minimum storage ray/triangle intersection. JGT 2(1), 1997.
//! - \[MORTON66\] Morton: A computer oriented geodetic data base. IBM, 1966.
//! - \[PLOC18\] Meister, Bittner: Parallel locally-ordered clustering for BVH construction. TVCG 24(3), 2018.
//! - \[SHEWCHUK97\] Shewchuk: Adaptive precision floating-point arithmetic and fast robust predicates. DCG 18, 1997.
//! - \[VEVERKOVA24\] Veverková: Tight bounding volumes for BVHs. CTU in Prague, 2024: ray protocol and metrics.
//! - \[VINKLER17\] Vinkler, Bittner, Havran: Extended Morton codes for high performance bounding volume hierarchy
//!   construction. HPG 2017.
//! - \[WALD07\] Wald: On fast construction of SAH-based bounding volume hierarchies. RT 2007.
//! - \[WOOP13\] Woop, Benthin, Wald: Watertight ray/triangle intersection. JCGT 2(1), 2013.
//! - \[YLITIE17\] Ylitie, Karras, Laine: Efficient incoherent ray traversal on GPUs through compressed wide BVHs. HPG 2017.

pub mod abi;
pub mod bench;
pub mod bvh;
pub mod cli;
pub mod device;
pub mod kernels;
pub mod oracle;
pub mod output;
pub mod picture;
pub mod profile;
pub mod ray_query;
pub mod report;
pub mod saved;
pub mod scene;
pub mod stress;
pub mod trace;
