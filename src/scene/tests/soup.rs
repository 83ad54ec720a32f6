//! Any mesh, written in each format, plain and packed, comes back bit for bit, from us and from readers of a few lines.

use proptest::prelude::*;

use super::*;

type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn obj_of((vertices, triangles): &Mesh) -> Vec<u8> {
    let vertices = vertices.iter().map(|[x, y, z]| format!("v {x:e} {y} {z}\n"));
    let faces = triangles.iter().map(|t| format!("f {} {}//7 {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect::<String>().into_bytes()
}

fn ply_of((vertices, triangles): &Mesh, format: &str) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    )
    .into_bytes();
    if format == "ascii" {
        let lines = vertices.iter().map(|[x, y, z]| format!("{x} {y:e} {z}\n"));
        let lines = lines.chain(triangles.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n")));
        out.extend(lines.collect::<String>().bytes());
        return out;
    }
    let big = format == "binary_big_endian";
    let word = |w: u32| if big { w.to_be_bytes() } else { w.to_le_bytes() };
    out.extend(vertices.iter().flatten().flat_map(|x| word(x.to_bits())));
    for t in triangles {
        out.push(3);
        out.extend(t.iter().flat_map(|i| word(*i)));
    }
    out
}

/// A second reader: lines that start with v and f.
fn read_obj(bytes: &[u8]) -> Mesh {
    let mut mesh = Mesh::default();
    for line in std::str::from_utf8(bytes).unwrap().lines() {
        let words: Vec<&str> = line.split([' ', '/']).filter(|w| !w.is_empty()).collect();
        match words[..] {
            ["v", x, y, z] => mesh.0.push([x, y, z].map(|w| w.parse().unwrap())),
            ["f", a, b, _, c] => mesh.1.push([a, b, c].map(|w| w.parse::<u32>().unwrap() - 1)),
            _ => panic!("{line}"),
        }
    }
    mesh
}

/// A second reader: what [`ply_of`] writes, by counting.
fn read_ply(bytes: &[u8]) -> Mesh {
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let (header, mut body) = (std::str::from_utf8(&bytes[..end]).unwrap(), &bytes[end..]);
    let after = |word: &str| header.split(word).nth(1).unwrap().split_whitespace().next().unwrap();
    let counts: [usize; 2] = ["element vertex", "element face"].map(|w| after(w).parse().unwrap());
    let format = after("format");
    let mut mesh = Mesh::default();
    if format == "ascii" {
        let words: Vec<&str> = std::str::from_utf8(body).unwrap().split_whitespace().collect();
        let (vertices, faces) = words.split_at(3 * counts[0]);
        mesh.0 = vertices.chunks(3).map(|v| [0, 1, 2].map(|k| v[k].parse().unwrap())).collect();
        mesh.1 = faces.chunks(4).map(|f| [1, 2, 3].map(|k| f[k].parse().unwrap())).collect();
        return mesh;
    }
    let mut word = |skip: usize| {
        let bytes = body[skip..skip + 4].try_into().unwrap();
        body = &body[skip + 4..];
        if format == "binary_big_endian" { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    };
    for _ in 0..counts[0] {
        mesh.0.push([0; 3].map(|skip| f32::from_bits(word(skip))));
    }
    for _ in 0..counts[1] {
        mesh.1.push([1, 0, 0].map(&mut word));
    }
    mesh
}

/// A mesh as its corners: what any format keeps.
fn corners((vertices, triangles): &Mesh) -> stl::Soup {
    triangles.iter().map(|t| t.map(|v| vertices[v as usize])).collect()
}

fn mesh() -> impl Strategy<Value = Mesh> {
    let finite = any::<u32>().prop_map(f32::from_bits).prop_map(|x| if x.is_finite() { x } else { -0.0 });
    proptest::collection::vec(proptest::array::uniform3(finite), 1..12).prop_flat_map(|vertices| {
        let corner = 0..vertices.len() as u32;
        (Just(vertices), proptest::collection::vec(proptest::array::uniform3(corner), 1..12))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn every_format_keeps_every_bit(mesh in mesh()) {
        let soup = corners(&mesh);
        let (doc, bin) = gltf::plain(soup.as_flattened());
        let mut files = vec![
            ("obj", obj_of(&mesh), read_obj as fn(&[u8]) -> Mesh),
            ("tri", soup.iter().flatten().flatten().flat_map(|x| x.to_le_bytes()).collect(), read_tri),
            ("stl", stl::binary(b"", &soup), stl_mesh),
            ("stl", stl::ascii("any", &soup).into_bytes(), stl_mesh),
            ("glb", gltf::glb(&doc, &bin), gltf_mesh),
            ("gltf", gltf::embedded(&doc, &bin), gltf_mesh),
        ];
        files.extend(PLY_FORMATS.map(|format| ("ply", ply_of(&mesh, format), read_ply as fn(&[u8]) -> Mesh)));
        for (extension, file, second) in files {
            prop_assert_eq!(corners(&second(&file)), soup.clone(), "the second reader of {}", extension);
            for (ending, file) in [("", file.clone()), (".gz", packed::gzip(&file)), (".zst", packed::zstd(&file))] {
                let scene = read(&format!("{extension}{ending}"), &file).unwrap();
                prop_assert_eq!(stl::bits(&corners(&(scene.positions, scene.triangles))), stl::bits(&soup), "{}{}", extension, ending);
            }
        }
    }
}

fn of_soup(corners: Vec<[f32; 3]>) -> Mesh {
    let triangles = (0..corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    (corners, triangles)
}

fn read_tri(bytes: &[u8]) -> Mesh {
    let mut numbers = bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()));
    of_soup((0..bytes.len() / 12).map(|_| [0; 3].map(|_| numbers.next().unwrap())).collect())
}

fn stl_mesh(bytes: &[u8]) -> Mesh {
    of_soup(stl::read_simply(bytes).into_iter().flatten().collect())
}

/// Through f64 and back: every f32 is one.
fn gltf_mesh(bytes: &[u8]) -> Mesh {
    let (doc, bin) = gltf::split(bytes);
    let corners = gltf::walk::triangles(&doc, &[bin]).into_iter().flat_map(|(t, _)| t);
    of_soup(corners.map(|v| v.map(|x| x as f32)).collect())
}
