//! Twin of `glsl/sort/*.comp`, and of the choice between 30- and 63-bit codes in `bvh::sort`.

use super::morton;
use crate::abi::{Aabb, UNHITTABLE_KEY};
use crate::bvh::Morton;
use crate::scene::Scene;

/// Share of triangles with their predecessor's 30-bit code at which 63 bits pay.
const DUPLICATES_FOR_63: f64 = 0.95;

/// Places of `keys` in rising order; of equal keys the earlier comes first.
pub fn order(keys: &[u64]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.sort_by_key(|i| keys[*i as usize]);
    order
}

/// Keys that equal the one before them in rising order.
pub fn duplicates(keys: &[u64]) -> usize {
    let mut keys = keys.to_vec();
    keys.sort_unstable();
    keys.windows(2).filter(|pair| pair[0] == pair[1]).count()
}

/// Triangles in Morton order, without those that can't be hit, and their codes.
pub fn by_code(scene: &Scene, bounds: &Aabb, hittable: u32, morton: Morton) -> (Vec<u32>, Vec<u64>) {
    let mut keys = morton::encode(scene, bounds, morton);
    if morton == Morton::Auto {
        let hit: Vec<u64> = keys.iter().copied().filter(|key| *key != u64::from(UNHITTABLE_KEY)).collect();
        let share = duplicates(&hit) as f64 / f64::from(hittable.max(1));
        // Where no bit of the codes differs, more of them won't tell the centres apart either.
        if share > DUPLICATES_FOR_63 && hit.iter().any(|key| *key != hit[0]) {
            keys = morton::encode(scene, bounds, Morton::Bits63);
        }
    }
    let mut order = order(&keys);
    order.truncate(hittable as usize);
    let sorted = order.iter().map(|i| keys[*i as usize]).collect();
    (order, sorted)
}
