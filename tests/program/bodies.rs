//! Bodies in scene files: refused with their lines, and read from meshes that the scene names.

use std::fs;
use std::path::Path;

use sonoglyph::field::HATCH;
use sonoglyph::mesh::{Mesh, shapes};
use sonoglyph::studio::opening;
use sonoglyph::ui::document::Document;

use crate::process::{folder_with, refuse, succeed};

const POINT: &str = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n";
const MESH: &str = "\
format = 1

[[target]]
at = [0, 0, 0.1]

# Of the lathe.
[[body]] # a part
kind = \"mesh\"
file = \"part.stl\" # mm
scale = 0.001
at = [0, 0, 0.13]
";

fn as_obj(mesh: &Mesh) -> String {
    let vertices = mesh.vertices.iter().map(|at| format!("v {} {} {}\n", at.x, at.y, at.z));
    let faces = mesh.triangles.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    vertices.chain(faces).collect()
}

fn as_stl(mesh: &Mesh) -> String {
    let mut text = "solid part\n".to_owned();
    for triangle in 0..mesh.triangles.len() {
        text += "facet normal 0 0 0\nouter loop\n";
        for at in mesh.corners(triangle) {
            text += &format!("vertex {} {} {}\n", at.x, at.y, at.z);
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid part\n"
}

#[test]
fn keys_of_bodies_are_refused_with_their_lines() {
    let folder = folder_with(&[]);
    for (body, line, said) in [
        ("radius = 0", 5, "body[1].radius = 0: must be a number from 0.00001 to 1 m"),
        ("kind = \"ball\"", 5, "body[1].kind: unknown"),
        ("fingers = [0, 0, 0, 0, 0]", 5, "a body of kind `sphere` has no such key; its own are `radius`"),
        ("kind = \"palm\"\nradius = 0.01", 6, "body[1].radius = 0.01: a body of kind `palm` has no such key"),
        ("file = \"a.stl\"", 5, "body[1].file = \"a.stl\": a body of kind `sphere` has no such key"),
        ("kind = \"mesh\"", 4, "body[1].file: `kind = \"mesh\"` needs the name of an STL or OBJ file"),
        ("kind = \"capsule\"\nlength = 0.01", 6, "from 0.02 to 2 m, from end to end: twice the radius"),
        ("kind = \"palm\"\nsize = [0.1, 0, 0.02]", 6, "body[1].size = [0.1, 0, 0.02]: across: must be"),
        ("kind = \"palm\"\nx_axis = [0, 0, 1]", 6, "body[1].x_axis = [0, 0, 1]: runs along `normal`"),
        ("kind = \"palm\"\nnormal = [0, 0, 0]", 6, "body[1].normal = [0, 0, 0]: must be a direction"),
        (
            "kind = \"hand\"\nfingers = [0, 0, 120, 0, 0]",
            6,
            "body[1].fingers[3] = 120: middle: must be a number from 0 to 110",
        ),
        ("coefficient = -1", 5, "body[1].coefficient = -1: must be a number above -1 and at most 1"),
        ("edge = 1e-5", 5, "body[1].edge = 1e-5: must be a length above"),
        ("edge = 5e-5", 5, "triangles, more than 200000: give at least 1.3e-4 m"),
        ("at = [0, 0, 0.005]", 5, "body[1].at = [0, 0, 0.005]: the body reaches on or behind the array"),
        ("kind = \"palm\"\nat = [0, 0, 0.01]\nnormal = [0, 0, 1]", 6, "reaches on or behind the array"),
        ("kind = \"palm\"\nat = [0, 0, 0.01]\nnormal = [1, 0, -0.2]", 6, "reaches on or behind the array"),
        ("[[body]]\nat = [0.01, 0, 0.13]", 6, "body[2].at = [0.01, 0, 0.13]: the body overlaps body 1"),
        ("[[body]]\nkind = \"palm\"\nat = [0, 0, 0.129]", 7, "the body overlaps body 1"),
        (
            "at = [0, 0, 0.11]\n[[board]]\n[[board]]\nat = [0, 0, 0.115]\nnormal = [0, 0, -1]",
            5,
            "element 375 of the array is inside",
        ),
        ("at = [0, 0, 0.195]\n[[reflector]]", 5, "the body reaches behind reflector 1"),
    ] {
        fs::write(folder.path().join("a.toml"), format!("{POINT}[[body]]\n{body}\n")).unwrap();
        let refused = refuse(folder.path(), &["solve", "a.toml"]);
        assert!(refused.contains(&format!("a.toml:{line}: ")) && refused.contains(said), "{body}: {refused}");
    }
    let many = "[[body]]\n".repeat(17);
    fs::write(folder.path().join("a.toml"), format!("{POINT}{many}")).unwrap();
    assert!(refuse(folder.path(), &["solve", "a.toml"]).contains("body: 17 are more than the 16"));
}

#[test]
fn bodies_may_touch() {
    for bodies in [
        "[[body]]\n[[body]]\nat = [0.02, 0, 0.12]",
        "[[body]]\n[[body]]\nkind = \"palm\"\nat = [0, 0, 0.13]",
        "[[body]]\nkind = \"capsule\"\nx_axis = [0, 0, 1]\nat = [0, 0, 0.09]\n[[body]]\nkind = \"capsule\"\nat = [0, 0.01, 0.12]",
        "[[body]]\nkind = \"palm\"\n[[body]]\nkind = \"palm\"\nat = [0, 0, 0.145]",
        "[[body]]\nat = [0, 0, 0.19]\n[[reflector]]",
    ] {
        let scene = opening::parse(&format!("{POINT}{bodies}\n"), Path::new("a.toml"));
        assert!(scene.is_ok(), "{bodies}: {scene:?}");
    }
}

#[test]
fn faulty_meshes_are_refused_with_a_remedy() {
    let ball = shapes::geodesic(12.0, 3);
    let mut open = ball.clone();
    open.triangles.pop();
    let folder = folder_with(&[
        ("part.stl", &as_stl(&ball)),
        ("open.obj", &as_obj(&open)),
        ("word.obj", "v 0 0 zero\n"),
        ("empty.obj", ""),
        ("part.ply", "ply\n"),
        ("ring.obj", &as_obj(&ball.mapped(|at| at + 30.0 * glam::DVec3::X))),
    ]);
    fs::create_dir(folder.path().join("folder.stl")).unwrap();
    for (keys, line, said) in [
        ("file = \"none.stl\"", 6, "none.stl: no such file"),
        ("file = \"folder.stl\"", 6, "folder.stl: "),
        ("file = \"open.obj\"", 6, "3 of its edges are on one triangle only"),
        ("file = \"open.obj\"", 6, "a body needs a closed surface: repair the mesh"),
        ("file = \"word.obj\"", 6, "word.obj:1: v 0 0 zero: expected three numbers"),
        ("file = \"empty.obj\"", 6, "empty.obj: the surface has no triangles"),
        ("file = \"part.ply\"", 6, "ends neither in .stl nor in .obj"),
        ("file = \"part.stl\"", 4, " m, more than 1 m; if its file is in millimetres, write scale = 0.001"),
        ("file = \"part.stl\"\nscale = 1e-8", 7, "body[1].scale = 1e-8: the body spans 2.4e-7 m"),
        ("file = \"part.stl\"\nscale = 0.001\nat = [0, 0, 0.01]", 8, "reaches on or behind the array"),
        ("file = \"part.stl\"\nscale = 0.001\nedge = 2e-5", 8, "triangles, more than 200000"),
        ("file = \"part.stl\"\nscale = 0.001\n[[body]]\nat = [0, 0.02, 0.12]", 9, "overlaps body 1"),
    ] {
        fs::write(folder.path().join("a.toml"), format!("{POINT}[[body]]\nkind = \"mesh\"\n{keys}\n"))
            .unwrap();
        let refused = refuse(folder.path(), &["solve", "a.toml"]);
        assert!(refused.contains(&format!("a.toml:{line}: ")) && refused.contains(said), "{keys}: {refused}");
    }
    let beside = "file = \"ring.obj\"\nscale = 0.001\n[[body]]\nat = [0, 0, 0.12]";
    fs::write(folder.path().join("a.toml"), format!("{POINT}[[body]]\nkind = \"mesh\"\n{beside}\n")).unwrap();
    opening::open(&folder.path().join("a.toml")).unwrap();
}

#[test]
fn numbers_within_bodies_are_none_and_pictures_hatched() {
    let text = "\
format = 1
array = { rows = 6, columns = 6 }
plane = { centre = [0, 0, 0.06], size = [0.04, 0.04] }
[[target]]
at = [0, 0, 0.06]
[[body]]
at = [0.006, 0, 0.06]
radius = 0.004
";
    let folder = folder_with(&[("a.toml", text), ("points.csv", "x,y,z\n0.006,0,0.06\n0,0,0.06\n")]);
    let path = folder.path();
    let line = succeed(path, &["render", "a.toml", "-o", "a.png", "--data", "a.npy", "--size", "80"]);
    assert!(
        line.contains("hatched: bodies") && line.contains("bodies: scattered sound by exact series"),
        "{line}"
    );
    let bytes = fs::read(path.join("a.npy")).unwrap();
    let values: Vec<_> =
        bytes[bytes.len() - 80 * 80 * 4..].as_chunks().0.iter().map(|it| f32::from_le_bytes(*it)).collect();
    // Eight pixels are the radius.
    let within = values.iter().filter(|value| value.is_nan()).count();
    assert!((185..218).contains(&within), "{within}");
    let picture = image::open(path.join("a.png")).unwrap().to_rgba8();
    let hatched = picture.pixels().filter(|pixel| HATCH.contains(&pixel.0)).count();
    assert_eq!(hatched, within);
    let probed = succeed(path, &["probe", "a.toml", "--points", "points.csv"]);
    let rows: Vec<_> = probed.lines().skip(1).collect();
    assert!(rows[0].ends_with("NaN,NaN,NaN") && !rows[1].contains("NaN"), "{probed}");
    let solved: serde_json::Value =
        serde_json::from_str(&succeed(path, &["solve", "a.toml", "--json"])).unwrap();
    let force = &solved["bodies"][0]["force"];
    assert!(force[0].as_f64().unwrap().abs() > 1e-7 && solved["harmonic"].is_null(), "{solved}");
    let refused = refuse(path, &["render", "a.toml", "--quantity", "harmonic", "-o", "b.png"]);
    assert!(refused.contains("bodies in the field are not modelled"), "{refused}");
}

#[test]
fn a_scene_saved_elsewhere_finds_its_mesh() {
    let folder = folder_with(&[("a.toml", MESH), ("part.stl", &as_stl(&shapes::geodesic(12.0, 3)))]);
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).unwrap();
    let mut document = Document::read(&folder.path().join("a.toml")).unwrap();
    let body = &document.scene.bodies[0];
    let volume = body.solid(0.005).unwrap().volume();
    assert!((volume / (4.0 / 3.0 * std::f64::consts::PI * 0.012f64.powi(3)) - 1.0).abs() < 0.05, "{volume}");
    document.scene.bodies[0].at.z = 0.15;
    let path = inner.join("b.toml");
    let placed = document.placed(&path);
    fs::write(&path, document.text_of(&placed.scene)).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    for kept in
        ["# Of the lathe.\n[[body]] # a part\n", "# mm\nscale = 0.001\nat = [0.0, 0.0, 0.15]\n", "part.stl\""]
    {
        assert!(text.contains(kept), "{kept} in {text}");
    }
    let again = opening::open(&path).unwrap();
    assert_eq!(again.bodies[0].surface.get(), document.scene.bodies[0].surface.get());
    assert_eq!(again.bodies[0].at.z, 0.15);
    // In a scene beside it the name stays short.
    let beside = document.placed(&folder.path().join("c.toml"));
    assert_eq!(beside.scene.bodies[0].file.as_deref(), Some("part.stl"));
    succeed(&inner, &["solve", "b.toml"]);
}
