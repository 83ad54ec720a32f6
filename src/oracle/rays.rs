//! Twin of `trace::rays` and `glsl/rays/`: primary rays in f64, secondary rays in f32 step by step as the kernels, to
//! the same bits.

use crate::abi::{Hit, LIGHTS, Ray, Surface};
use crate::scene::Scene;
use crate::trace::rays::{Light, Sampler, Secondary, SecondaryKind, View};
use glam::{DVec3, Vec3};

/// One step of a 24-bit fraction.
const SHARE: f32 = 1.0 / 16_777_216.0;

/// Where a pixel stands among the primary rays: strips behind blocks, then by code or by rows or columns.
fn place(x: u32, y: u32, width: u32, height: u32) -> (u32, u64) {
    let (whole_x, whole_y) = (width / 8 * 8, height / 8 * 8);
    if y >= whole_y {
        (2, u64::from(x) * 8 + u64::from(y - whole_y))
    } else if x >= whole_x {
        (1, u64::from(y) * 8 + u64::from(x - whole_x))
    } else {
        (
            0,
            (0..32)
                .map(|bit| u64::from(x >> bit & 1) << (2 * bit) | u64::from(y >> bit & 1) << (2 * bit + 1))
                .sum(),
        )
    }
}

/// The pixel of each primary ray. One sort over all pixels: the Morton code of a pixel orders blocks and their insides
/// at once.
pub fn pixel_order(width: u32, height: u32) -> Vec<u32> {
    let mut pixels: Vec<u32> = (0..width * height).collect();
    pixels.sort_by_cached_key(|p| place(p % width, p / width, width, height));
    pixels
}

/// The primary rays of `view`.
pub fn primary(view: &View) -> Vec<Ray> {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let eye = wide(view.camera.eye);
    let forward = (wide(view.camera.target) - eye).normalize();
    let right = forward.cross(wide(view.camera.up)).normalize();
    let up = right.cross(forward);
    let half = (f64::from(view.camera.fov_y).to_radians() / 2.0).tan();
    let aspect = f64::from(view.width) / f64::from(view.height);
    let ray = |pixel: u32| {
        let x = (f64::from(pixel % view.width) + 0.5) / f64::from(view.width) * 2.0 - 1.0;
        let y = 1.0 - (f64::from(pixel / view.width) + 0.5) / f64::from(view.height) * 2.0;
        let direction = (forward + right * (x * half * aspect) + up * (y * half)).normalize();
        let direction = direction.as_vec3().to_array();
        Ray { origin: view.camera.eye, t_min: 0.0, direction, t_max: f32::INFINITY }
    };
    pixel_order(view.width, view.height).into_iter().map(ray).collect()
}

fn inverse_root(x: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_5a86 - (x.to_bits() >> 1));
    let h = 0.5 * x;
    for _ in 0..3 {
        y *= 1.5 - h * y * y;
    }
    y
}

fn inner(a: Vec3, b: Vec3) -> f32 {
    let p = a * b;
    p.x + p.y + p.z
}

pub(super) fn outer(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

fn largest(v: Vec3) -> f32 {
    v.abs().max_element()
}

fn level_of(v: Vec3) -> f32 {
    let exponent = (largest(v).to_bits() >> 23) as i32 - 127;
    f32::from_bits(((127 - exponent.clamp(-127, 126)) as u32) << 23)
}

pub(super) fn levelled(v: Vec3) -> Vec3 {
    v * level_of(v)
}

pub(super) fn unit(v: Vec3) -> Option<Vec3> {
    let l = levelled(v);
    let square = inner(l, l);
    (1.0..=64.0).contains(&square).then(|| l * inverse_root(square))
}

/// The surface under a primary.
pub fn surface_of(scene: &Scene, ray: &Ray, hit: &Hit, i: usize) -> Option<Surface> {
    if !hit.is_hit() {
        return None;
    }
    let [a, b, c] = scene.corners(hit.triangle as usize).map(Vec3::from_array);
    let (e1, e2) = (b - a, c - a);
    let across = outer(levelled(e1), levelled(e2));
    let mut normal = unit(across)?;
    if inner(normal, levelled(Vec3::from_array(ray.direction))) > 0.0 {
        normal = -normal;
    }
    let (first, second) = (hit.u * e1, hit.v * e2);
    let point = a + (first + second);

    let extent = largest(e1).max(largest(e2)).max(largest(c - b));
    let l = levelled(across);
    let over_area = level_of(across) * inverse_root(inner(l, l));
    let slenderness = (extent * level_of(e1)) * (extent * level_of(e2)) * over_area;
    let off = 4.0 * (first.abs() + second.abs()) + 2.5 * point.abs();
    let lift = SHARE * (inner(normal.abs(), off) + extent * (32.0 + 24.0 * slenderness.min(16.0)));
    let origin = point + normal * lift;
    Some(Surface { origin: origin.to_array(), normal: normal.to_array(), primary: i as u32, pad: 0 })
}

fn hash(x: u32) -> u32 {
    let x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    let x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// [0, 1) in 24-bit fixed point: the digits of `index` mirrored at the point, exactly where 24 bits hold it.
fn radical_inverse(index: u32, base: u32) -> u32 {
    let (mut share, mut place, mut rest) = (0.0, 1.0, index);
    while rest > 0 {
        place /= f64::from(base);
        share += f64::from(rest % base) * place;
        rest /= base;
    }
    // Sums of thirds fall short of what they stand for by a few 2⁻⁵³.
    ((share + 1e-14) * f64::from(1 << 24)) as u32
}

fn root(x: f32) -> f32 {
    x * inverse_root(x)
}

/// Cosine and sine of 2π · turn / 2²⁴.
pub fn turned(turn: u32) -> [f32; 2] {
    let from = turn + 0x20_0000;
    let x = ((from & 0x3f_ffff) as i32 - 0x20_0000) as f32 * 3.745_070_3e-7;
    let q = x * x;
    let s = x + x * q * (-0.166_666_67 + q * (0.008_333_333 + q * (-0.000_198_412_7 + q * 2.755_731_9e-6)));
    let c = 1.0 - q * (0.5 - q * (0.041_666_667 - q * (0.001_388_888_9 - q * 0.000_024_801_587)));
    match from >> 22 & 3 {
        0 => [c, s],
        1 => [-s, c],
        2 => [-c, -s],
        _ => [s, -c],
    }
}

/// Point `i` as primary `primary` has it.
fn point_of(sampler: Sampler, i: u32, primary: u32) -> [u32; 2] {
    let [x, y] = match sampler {
        Sampler::Halton(skipped) => [2, 3].map(|base| radical_inverse(skipped + i + 1, base)),
        // The host's own, which kernels only read.
        Sampler::Random(_) => sampler.point(i),
    };
    let turned = |x: u32, k: u32| (x + (hash(2 * primary + k) >> 8)) & 0xff_ffff;
    [turned(x, 0), turned(y, 1)]
}

/// Ray `sample` of those that leave `surface`.
fn leave(surface: &Surface, sample: u32, kind: &Secondary) -> Ray {
    let [u, v] = point_of(kind.sampler, sample, surface.primary);
    let r = root(u as f32 * SHARE);
    let z = root((16_777_216 - u) as f32 * SHARE);
    let [x, y] = turned(v).map(|t| t * r);
    let n = Vec3::from_array(surface.normal);
    let tangent = if n.x.abs() > n.z.abs() { Vec3::new(-n.y, n.x, 0.0) } else { Vec3::new(0.0, -n.z, n.y) };
    let tangent = unit(tangent).unwrap_or(Vec3::ZERO);
    let direction = tangent * x + outer(n, tangent) * y + n * z;
    Ray { origin: surface.origin, t_min: 0.0, direction: direction.to_array(), t_max: kind.length }
}

/// Ray `sample` of those from `surface` to `lights`; none where its light is behind.
fn ray_to_light(surface: &Surface, sample: u32, lights: &[Light], kind: &Secondary) -> Option<Ray> {
    let light = &lights[(sample % LIGHTS) as usize];
    let [u, v] = point_of(kind.sampler, sample / LIGHTS, surface.primary);
    let (u, w) = (u as f32 * SHARE, (16_777_216 - u) as f32 * SHARE);
    let r = 2.0 * root(u * w);
    let [x, y] = turned(v).map(|t| t * r);
    let point = Vec3::new(x, y, w - u);
    let direction =
        Vec3::from_array(light.position) + point * light.radius - Vec3::from_array(surface.origin);
    let facing = inner(Vec3::from_array(surface.normal), levelled(direction)) > 0.0;
    facing.then_some(Ray {
        origin: surface.origin,
        t_min: 0.0,
        direction: direction.to_array(),
        t_max: kind.length,
    })
}

/// Secondary rays from primary `start` on, no more than `capacity`, and how many primaries they come from.
pub fn secondary(
    scene: &Scene,
    rays: &[Ray],
    hits: &[Hit],
    kind: &Secondary,
    start: usize,
    capacity: usize,
) -> (usize, Vec<Ray>) {
    let mut out = vec![];
    let mut room = capacity / kind.samples as usize;
    for i in start..rays.len() {
        let Some(surface) = surface_of(scene, &rays[i], &hits[i], i) else { continue };
        if room == 0 {
            return (i - start, out);
        }
        room -= 1;
        let samples = 0..kind.samples;
        match kind.kind {
            SecondaryKind::Ao | SecondaryKind::Diffuse => {
                out.extend(samples.map(|s| leave(&surface, s, kind)));
            }
            SecondaryKind::Shadow(lights) => {
                out.extend(samples.filter_map(|s| ray_to_light(&surface, s, &lights, kind)));
            }
        }
    }
    (rays.len() - start, out)
}
