//! `render --volume`: the field at points in space, as VTK ImageData and as NPY.

use std::fs;
use std::path::Path;

use crate::process::{POINT, example, folder_with, refuse, succeed};

/// The numbers of an XML attribute.
fn numbers(head: &str, attribute: &str) -> Vec<f64> {
    let (_, rest) = head.split_once(&format!("{attribute}=\"")).unwrap();
    rest.split('"').next().unwrap().split(' ').map(|number| number.parse().unwrap()).collect()
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

/// Origin, spacing and values of a `.vti`.
fn vti(path: &Path) -> ([f64; 3], [f64; 3], Vec<f32>) {
    let bytes = fs::read(path).unwrap();
    let start = bytes.windows(2).position(|pair| pair == b"\n_").unwrap() + 2;
    let head = String::from_utf8(bytes[..start].to_vec()).unwrap();
    let size = u64::from_le_bytes(bytes[start..start + 8].try_into().unwrap()) as usize;
    assert!(bytes[start + 8 + size..].starts_with(b"\n</AppendedData>"));
    let three = |name| numbers(&head, name).try_into().unwrap();
    (three("Origin"), three("Spacing"), floats(&bytes[start + 8..start + 8 + size]))
}

#[test]
fn a_volume_agrees_with_probe_in_both_formats() {
    let folder = folder_with(&[]);
    let counts = [9, 8, 7];
    for scene in ["hit", "two-boards", "water-circle"] {
        let args = ["render", &example(scene), "--volume", "9,8,7", "-o"];
        succeed(folder.path(), &[&args[..], &["v.vti"]].concat());
        succeed(folder.path(), &[&args[..], &["v.npy"]].concat());
        let (origin, spacing, values) = vti(&folder.path().join("v.vti"));
        let npy = fs::read(folder.path().join("v.npy")).unwrap();
        let head = String::from_utf8_lossy(&npy[..npy.len() - values.len() * 4]).into_owned();
        assert!(head.contains("'shape': (7, 8, 9"), "{head}");
        assert_eq!(floats(&npy[npy.len() - values.len() * 4..]), values);
        let point = |i: usize| {
            let place = [i % counts[0], i / counts[0] % counts[1], i / counts[0] / counts[1]];
            [0, 1, 2].map(|axis| origin[axis] + spacing[axis] * place[axis] as f64)
        };
        let rows = (0..values.len()).map(point).map(|[x, y, z]| format!("{x},{y},{z}\n"));
        fs::write(folder.path().join("p.csv"), format!("x,y,z\n{}", rows.collect::<String>())).unwrap();
        let answer = succeed(folder.path(), &["probe", &example(scene), "--points", "p.csv"]);
        let peak = values.iter().copied().fold(0.0f32, f32::max);
        let mut lines = answer.lines();
        assert!(lines.next().unwrap().ends_with("rms"));
        for (line, value) in lines.zip(&values) {
            let rms: f32 = line.rsplit(',').next().unwrap().parse().unwrap();
            assert!((rms - value).abs() <= 1e-3 * peak, "{scene}: {line}: {value}");
        }
    }
}

#[test]
fn points_are_the_centres_of_cells_that_fill_the_box() {
    let folder = folder_with(&[("s.toml", POINT)]);
    let args =
        ["render", "s.toml", "--box", "0.04,0.03,0.02,0.01,0.02,0.1", "--volume", "4,3,2", "-o", "v.vti"];
    let said = succeed(folder.path(), &args);
    assert!(
        said.contains("4 x 3 x 2 points from (-5.0, 10.0, 95.0) mm, (10.0, 10.0, 10.0) mm apart"),
        "{said}"
    );
    let (origin, spacing, _) = vti(&folder.path().join("v.vti"));
    for (found, expected) in origin.into_iter().chain(spacing).zip([-0.005, 0.01, 0.095, 0.01, 0.01, 0.01]) {
        assert!((found - expected).abs() < 1e-12);
    }
    let silent = ["render", "s.toml", "--box", "0.04,0.03,0.02,0,0,-0.1", "--volume", "4,3,2", "-o", "v.vti"];
    assert!(succeed(folder.path(), &silent).contains("no sound reaches the box"));
}

#[test]
fn impossible_volumes_are_refused() {
    let folder = folder_with(&[("s.toml", POINT)]);
    for (args, message) in [
        (&["--volume", "4,4,4", "-o", "v.png"][..], "this is written as .vti or .npy"),
        (&["--volume", "4,4,4", "-o", "v"], "name the volume .vti"),
        (&["--volume", "4,4", "-o", "v.vti"], "three numbers of points"),
        (&["--volume", "4,0,4", "-o", "v.vti"], "each from 1 to 4096"),
        (&["--volume", "4096,4096,4096", "-o", "v.vti"], "at most 1073741824 in all"),
        (&["--volume", "4,4,4", "-o", "v.vti", "--box", "0,1,1,0,0,0"], "sides from 0.0001 to 10 m"),
        (&["--volume", "4,4,4", "-o", "v.vti", "--box", "1,1,1,0,0"], "six numbers in metres"),
        (&["--volume", "4,4,4", "-o", "v.vti", "--quantity", "depression"], "has no volume"),
        (&["--volume", "4,4,4", "-o", "v.vti", "--quantity", "sheet"], "are pages"),
    ] {
        let refused = refuse(folder.path(), &[&["render", "s.toml"], args].concat());
        assert!(refused.contains(message), "{args:?}: {refused}");
    }
}

#[test]
fn pictures_of_space_have_named_and_numeric_directions() {
    let folder = folder_with(&[("s.toml", POINT)]);
    let draw = |args: &[&str], name: &str| {
        let all = [&["render", "s.toml", "--view", "3d", "--size", "160x128", "-o", name], args].concat();
        let said = succeed(folder.path(), &all);
        let picture = image::open(folder.path().join(name)).unwrap().to_rgb8();
        assert_eq!((picture.width(), picture.height()), (160, 128));
        (said, picture)
    };
    let (said, iso) = draw(&["--backend", "cpu"], "iso.png");
    assert!(said.contains("Surface at −6.0 dB of the peak"), "{said}");
    let colours: std::collections::HashSet<_> = iso.pixels().map(|pixel| pixel.0).collect();
    assert!(colours.len() > 200, "{}", colours.len());
    let (_, same) = draw(&["--camera", "iso", "--iso", "-6", "--backend", "cpu"], "same.png");
    assert_eq!(iso, same);
    for args in [
        &["--camera", "top"][..],
        &["--camera", "-40,15", "--parallel"],
        &["--projection", "--light"],
        &["--slice", "z=0.1,x=0.01", "--iso", "-3"],
        &["--box", "0.05,0.05,0.05,0.01,0.02,0.1"],
    ] {
        assert_ne!(draw(args, "other.png").1, iso, "{args:?}");
    }
}

#[test]
fn invalid_3d_views_are_refused() {
    let folder = folder_with(&[("s.toml", POINT)]);
    for (args, message) in [
        (&["--camera", "top"][..], "--camera applies to 3D views: add --view 3d"),
        (&["--view", "3d", "--camera", "below"], "give iso, top, front, side"),
        (&["--view", "3d", "--iso", "3"], "from -60 to -0.1"),
        (&["--view", "3d", "--iso", "-3", "--projection"], "cannot be used with"),
        (&["--view", "3d", "--slice", "w=1"], "an axis and a place in metres"),
        (&["--view", "3d", "--quantity", "phase"], "shows the RMS pressure"),
        (&["--view", "3d", "--motion"], "is a still picture"),
        (&["--view", "3d", "--size", "100000"], "the limit is"),
        (&["--box", "1,1,1,0,0,0"], "add --volume or --view 3d"),
        (&["--light"], "add --figure or --view 3d"),
    ] {
        let refused = refuse(folder.path(), &[&["render", "s.toml", "-o", "p.png"], args].concat());
        assert!(refused.contains(message), "{args:?}: {refused}");
    }
}
