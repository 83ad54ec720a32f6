//! Twin of `glsl/scan/exclusive.comp`.

/// Each number becomes the sum of those before it. Returns the sum of all.
pub fn exclusive(sums: &mut [u32]) -> u32 {
    let mut sum = 0u32;
    for x in sums {
        let next = sum.wrapping_add(*x);
        *x = sum;
        sum = next;
    }
    sum
}
