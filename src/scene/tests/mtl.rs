//! Colours of OBJ files and of glTF materials.

use super::*;

/// Opens an OBJ beside files.
fn beside(obj: &[u8], files: &[(&str, &[u8])]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let path = folder.path().join("in/mesh.obj");
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, obj).unwrap();
    open(path.to_str().unwrap(), &QUIET).unwrap()
}

fn colors(s: &Scene) -> Vec<Option<[f32; 3]>> {
    (0..s.triangles.len()).map(|i| s.materials.color(i)).collect()
}

const MTL: &[u8] =
    b"# caf\xe9\nnewmtl red wine\r\n  Ka 1 1 1\n\tKd 0.5 0.125 0\nNs odd\nnewmtl caf\xe9\nKd 0.25\n\
    newmtl none\nmap_Kd a.png\nnewmtl loud\nKd 3 -1 nan\nKd 7 -1 0.5\n";

#[test]
fn faces_take_the_colour_in_use() {
    let obj = b"mtllib a b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nusemtl red wine\nf 1 2 4 3\nusemtl caf\xe9\n\
        f 1 2 3\nusemtl none\nf 1 2 3\nusemtl loud\nf 1 2 3\nusemtl red wine\nf 1 2 3\nusemtl unknown\nf 1 2 3\n";
    let (red, grey) = (Some([0.5, 0.125, 0.0]), Some([0.25; 3]));
    let expected = [None, red, red, grey, None, Some([1.0, 0.0, 0.5]), red, None];
    let s = beside(obj, &[("in/a b.mtl", MTL)]);
    assert_eq!(colors(&s), expected);
    assert!(s.warnings.is_empty(), "{:?}", s.warnings);
    // Two files instead of one with a blank in its name.
    let s = beside(obj, &[("in/a", b""), ("in/b.mtl", MTL)]);
    assert_eq!(colors(&s), expected);
}

#[test]
fn files_that_cannot_be_read_are_warned_of() {
    let obj =
        |library: &str| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nmtllib {library}\nusemtl red wine\nf 1 2 3\n");
    for library in ["none.mtl", "../out.mtl", "sub/../../out.mtl", "."] {
        let s = beside(obj(library).as_bytes(), &[("out.mtl", MTL), ("in/sub/c.mtl", MTL)]);
        assert_eq!(colors(&s), [None], "{library}");
        let warned: Vec<_> = s.warnings.iter().map(|w| (w.count, w.first.as_str())).collect();
        assert_eq!(warned, [(1, "line 4")], "{library}: {:?}", s.warnings);
        assert!(s.warnings[0].what.starts_with("material files that can't be read"), "{:?}", s.warnings);
    }
    assert_eq!(
        colors(&beside(obj("sub/c.mtl").as_bytes(), &[("in/sub/c.mtl", MTL)])),
        [Some([0.5, 0.125, 0.0])]
    );
}

#[test]
fn what_has_no_material_has_no_colour() {
    for (extension, file) in samples() {
        let s = read(extension, &file).unwrap();
        assert!(s.materials.of_triangles.is_empty() && s.materials.colors.is_empty(), "{extension}");
    }
}
