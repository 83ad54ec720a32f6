//! A second reader of glTF: plain JSON values, matrices as arrays, one number at a time.

use serde_json::Value;

type Matrix = [[f64; 4]; 4];

fn n(v: &Value) -> usize {
    v.as_u64().unwrap_or(0) as usize
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().map(|a| a.iter().map(|x| x.as_f64().unwrap()).collect()).unwrap_or_default()
}

/// `a` after `b`; rows of columns: m[row][column].
fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..4).map(|k| a[r][k] * b[k][c]).sum()))
}

fn local(node: &Value) -> Matrix {
    let m = numbers(&node["matrix"]);
    if !m.is_empty() {
        return std::array::from_fn(|r| std::array::from_fn(|c| m[4 * c + r]));
    }
    let or = |name: &str, or: &[f64]| if node[name].is_array() { numbers(&node[name]) } else { or.to_vec() };
    let (t, s) = (or("translation", &[0.0; 3]), or("scale", &[1.0; 3]));
    let q = or("rotation", &[0.0, 0.0, 0.0, 1.0]);
    let (x, y, z, w) = (q[0], q[1], q[2], q[3]);
    [
        [
            s[0] * (1.0 - 2.0 * (y * y + z * z)),
            s[1] * 2.0 * (x * y - z * w),
            s[2] * 2.0 * (x * z + y * w),
            t[0],
        ],
        [
            s[0] * 2.0 * (x * y + z * w),
            s[1] * (1.0 - 2.0 * (x * x + z * z)),
            s[2] * 2.0 * (y * z - x * w),
            t[1],
        ],
        [
            s[0] * 2.0 * (x * z - y * w),
            s[1] * 2.0 * (y * z + x * w),
            s[2] * (1.0 - 2.0 * (x * x + y * y)),
            t[2],
        ],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn component(bytes: &[u8], kind: usize, normalized: bool) -> f64 {
    let scale = |c: f64, most: f64| if normalized { (c / most).max(-1.0) } else { c };
    match kind {
        5120 => scale(f64::from(bytes[0] as i8), 127.0),
        5121 => scale(f64::from(bytes[0]), 255.0),
        5122 => scale(f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        5123 => scale(f64::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        5125 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        _ => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
    }
}

fn size(kind: usize) -> usize {
    match kind {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        _ => 4,
    }
}

/// Components of an accessor, one after another.
fn accessor(doc: &Value, buffers: &[Vec<u8>], index: usize) -> Vec<f64> {
    let a = &doc["accessors"][index];
    let width = if a["type"] == "VEC3" { 3 } else { 1 };
    let kind = n(&a["componentType"]);
    let normalized = a["normalized"] == true;
    let mut all = vec![0.0; n(&a["count"]) * width];
    let read = |part: &Value, kind: usize, width: usize, i: usize, k: usize, normalized: bool| {
        let view = &doc["bufferViews"][n(&part["bufferView"])];
        let stride = if view["byteStride"].is_u64() { n(&view["byteStride"]) } else { width * size(kind) };
        let at = n(&view["byteOffset"]) + n(&part["byteOffset"]) + i * stride + k * size(kind);
        component(&buffers[n(&view["buffer"])][at..], kind, normalized)
    };
    for i in 0..n(&a["count"]) {
        for k in 0..width {
            if a["bufferView"].is_u64() {
                all[i * width + k] = read(a, kind, width, i, k, normalized);
            }
        }
    }
    let sparse = &a["sparse"];
    for i in 0..n(&sparse["count"]) {
        let at = read(&sparse["indices"], n(&sparse["indices"]["componentType"]), 1, i, 0, false) as usize;
        for k in 0..width {
            all[at * width + k] = read(&sparse["values"], kind, width, i, k, normalized);
        }
    }
    all
}

/// Triangles of the document's first scene, and each one's material.
pub(in crate::scene::tests) fn triangles(
    doc: &Value,
    buffers: &[Vec<u8>],
) -> Vec<([[f64; 3]; 3], Option<usize>)> {
    let identity = local(&Value::Null);
    let mut all = vec![];
    for node in doc["scenes"][0]["nodes"].as_array().unwrap() {
        walk(doc, buffers, n(node), &identity, &mut all);
    }
    all
}

fn walk(
    doc: &Value,
    buffers: &[Vec<u8>],
    node: usize,
    above: &Matrix,
    all: &mut Vec<([[f64; 3]; 3], Option<usize>)>,
) {
    let node = &doc["nodes"][node];
    let m = times(above, &local(node));
    if node["mesh"].is_u64() {
        for primitive in doc["meshes"][n(&node["mesh"])]["primitives"].as_array().unwrap() {
            let flat = accessor(doc, buffers, n(&primitive["attributes"]["POSITION"]));
            let point = |v: usize| -> [f64; 3] {
                std::array::from_fn(|r| (0..3).map(|c| m[r][c] * flat[3 * v + c]).sum::<f64>() + m[r][3])
            };
            let order: Vec<usize> = if primitive["indices"].is_u64() {
                accessor(doc, buffers, n(&primitive["indices"])).into_iter().map(|x| x as usize).collect()
            } else {
                (0..flat.len() / 3).collect()
            };
            let mode = primitive["mode"].as_u64().unwrap_or(4);
            let mirrored = {
                let [a, b, c] = [m[0], m[1], m[2]];
                a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])
                    < 0.0
            };
            let mut i = 0;
            while mode >= 4 && i + 2 < order.len() {
                let mut t = match (mode, i % 2) {
                    (4, _) | (5, 0) => [order[i], order[i + 1], order[i + 2]],
                    (5, _) => [order[i], order[i + 2], order[i + 1]],
                    _ => [order[i + 1], order[i + 2], order[0]],
                };
                if mirrored {
                    t.swap(1, 2);
                }
                all.push((t.map(point), primitive["material"].as_u64().map(|m| m as usize)));
                i += if mode == 4 { 3 } else { 1 };
            }
        }
    }
    for child in node["children"].as_array().into_iter().flatten() {
        walk(doc, buffers, n(child), &m, all);
    }
}
