//! Constants under the same names on both sides: markers, bits, and the ids of specialization constants.

macro_rules! constants {
    ($( $(#[doc = $doc:literal])* $name:ident = $value:expr; )*) => {
        $( $(#[doc = $doc])* pub const $name: u32 = $value; )*
        /// Constants under the names that kernels use.
        pub const CONSTANTS: &[(&str, u32)] = &[ $( (stringify!($name), $name), )* ];
    };
}

constants! {
    /// No triangle, no node, no partner.
    INVALID = 0xffff_ffff;
    /// Set in a child reference: the rest names a leaf.
    LEAF_BIT = 0x8000_0000;
    /// Set in a reference to a raw node: the packed tree has this subtree as one leaf.
    COLLAPSED_BIT = 0x4000_0000;
    /// Set likewise: the packed node of its parent takes this node's children in its place.
    ABSORBED_BIT = 0x2000_0000;
    /// Bits of a reference to a raw node that name it.
    RAW_MASK = 0x0fff_ffff;
    /// Children of a packed node.
    WIDTH = 4;
    /// Set in a packed node's exponents: its boxes lie in its frame. So that a ray fetches no frame where there is none.
    ORIENTED_BIT = 0x0100_0000;
    /// Set in a reference to a node of a binary tree: it is in the array of those with oriented boxes.
    OBB_BIT = 0x4000_0000;
    /// Nodes of a binary tree: with axis-aligned boxes.
    LAYOUT_AABB = 0;
    /// With oriented boxes.
    LAYOUT_OBB = 1;
    /// With either.
    LAYOUT_MIXED = 2;
    /// Set in a raw node's choices: the packed tree keeps it.
    KEPT_BIT = 0x40;
    /// Words of a triangle in a packed tree: nine coordinates and the input index.
    TRIANGLE_WORDS = 10;
    /// Key of a triangle that can't be hit: sorts behind every Morton code.
    UNHITTABLE_KEY = 0x8000_0000;
    /// Key of a ray that can't be ordered: none is greater, or has other bits.
    UNORDERED_KEY = 0x00ff_ffff;
    /// Morton codes: ten bits an axis.
    CODE_30 = 0;
    /// 21 bits an axis.
    CODE_63 = 1;
    /// 16 bits an axis and 15 of size, one behind each three of place.
    CODE_EXT4 = 2;
    /// 18 bits an axis and 9 of size, one behind each six of place.
    CODE_EXT7 = 3;
    /// Clusters at and below which one workgroup runs PLOC's remaining rounds in one dispatch.
    TAIL_CLUSTERS = 2048;
    /// Workgroups in a grid's first dimension at most; the rest go to the second.
    GRID_WIDTH = 32768;
    /// Lights that shadow rays go to.
    LIGHTS = 4;
    /// Largest triangle count of a leaf.
    MAX_LEAF = 64;

    // Specialization constants: the id is the value. Every kernel gets its workgroup size as `WG`.
    /// Workgroup size, invocations.
    SPEC_WG = 0;
    /// Consecutive items that one invocation handles.
    SPEC_ITEMS = 1;
    /// PLOC search radius, clusters to either side.
    SPEC_RADIUS = 2;
    /// Bits of a radix sort digit.
    SPEC_DIGIT_BITS = 3;
    /// Entries of the traversal stack.
    SPEC_STACK = 4;
    /// Bits of a packed leaf reference that hold its triangle count less one.
    SPEC_LEAF_BITS = 5;
    /// 1: any-hit query.
    SPEC_ANY = 6;
    /// 1: count box and triangle tests.
    SPEC_COUNT = 7;
    /// 1: watertight triangle test with exact signs, 0: Möller–Trumbore.
    SPEC_ROBUST = 8;
    /// Fewer live rays than this many eighths of a subgroup are too few to go on with; 0: none.
    SPEC_FEW = 9;
    /// 1: rays are taken in an order of their own.
    SPEC_ORDERED = 10;
    /// 1: the tree has oriented nodes.
    SPEC_ORIENTED = 11;
    /// k: extremal points are taken along k / 2 directions and against them.
    SPEC_POINTS = 12;
    /// Bases whose boxes climb together.
    SPEC_BASES = 13;
    /// 1: extremal points are taken along directions from a buffer.
    SPEC_DIRECTIONS = 14;
    /// Layout of a binary tree's nodes.
    SPEC_LAYOUT = 15;
    /// 1: count the steps of subgroups.
    SPEC_STEPS = 16;
}
