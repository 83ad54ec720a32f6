// Where the walk of a far ray begins. Wants lib/double_single.glsl.
//
// Boxes are padded by a share of the distance that a walk covers (lib/ray.glsl), so a ray from a thousand scene sizes away
// would meet many that it passes by, and one from 10⁷ all. Its walk begins at a point of it near the scene instead,
// `ahead` lengths of the direction from its origin, and counts t from there; triangles are met from the ray's own origin.
// The point is the moved origin + ahead · d: of the exact sums and product what is lost is 11 u² R, R as in lib/ray.glsl,
// so that R of the walk has 2⁻²⁴ R added: PAD times that is 2⁻⁴³ R.

// A ray from nearer is as well off without. For one from farther than DISTANT too much would be lost: see lib/distant.glsl.
// To the fast test there is no such ray; from beyond 2¹⁰⁰ one might overflow.
const float NEAR = 32.0;
const float DISTANT = 4294967296.0;
const float FARTHEST = 1267650600228229401496703205376.0;

// How far along d the closest point to 0 is, less what leaves all of the scene ahead, whatever was rounded: where t is
// negative no child is known for the nearer one.
float ahead_of(vec3 moved, vec3 d, float reach) {
    precise vec3 along = moved * d, square = d * d;
    precise float closest = -(along.x + along.y + along.z) / (square.x + square.y + square.z);
    precise float ahead = closest - (2.0 + reach * (1.0 / 4194304.0));
    return ahead;
}

// o − anchor + ahead · d.
vec3 approached(vec3 o, vec3 anchor, vec3 d, float ahead) {
    Pairs moved = exact_sum(o, -anchor), way = exact_product(d, vec3(ahead));
    Pairs sum = exact_sum(moved.hi, way.hi);
    precise vec3 begin = sum.hi + (sum.lo + (moved.lo + way.lo));
    return begin;
}

// A limit of t as the walk counts, not within the range by what was rounded: t of a hit (2 u), and these sums.
float walk_limit(float t, float ahead, float outward) {
    if (ahead == 0.0) return t;
    precise float slack = min(abs(t) + abs(ahead), 3.4028235e38) * (1.0 / 2097152.0);
    precise float limit = (t - ahead) + outward * slack;
    return limit;
}
