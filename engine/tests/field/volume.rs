//! Volumes and their pictures: sampled values against f64, surfaces against closed forms, the GPU against the CPU.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use glam::{DVec2, DVec3, UVec3, Vec3, Vec4};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::SpacePainting;
use sonoglyph::field::volume::scenery::{Body, Item, Shot};
use sonoglyph::field::volume::{Block, Camera, Fineness, Lattice, Scenery, Volume, march};
use sonoglyph::field::{Samples, reference};
use sonoglyph::mesh::shapes;
use sonoglyph::picture::ColourMap;
use sonoglyph::scene::{Board, Reflector, Scene};

use crate::gpu;

/// Irregular drives, which do not cancel anywhere.
fn scattered(aperture: &Aperture, seed: f64) -> Drive {
    let count = aperture.positions.len();
    let part = |i: usize| ((i as f64 + seed) * 0.618_034).fract();
    Drive {
        amplitudes: (0..count).map(|i| 0.3 + 0.7 * part(3 * i)).collect(),
        phases: (0..count).map(|i| TAU * part(i)).collect(),
    }
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let with_boards = |boards: Vec<Board>| Scene { boards, ..Scene::default() };
    let board = |at: DVec3, normal: DVec3, x_axis: DVec3| Board { at, normal, x_axis };
    let up = board(DVec3::ZERO, DVec3::Z, DVec3::X);
    let mirror = Reflector { point: DVec3::new(0.0, 0.0, 0.21), ..Reflector::default() };
    let mut masked = Scene::default();
    masked.array.off = (0..40).collect();
    vec![
        ("one board", Scene::default()),
        ("elements that are off", masked),
        ("facing boards", with_boards(vec![up.clone(), board(DVec3::Z * 0.2, DVec3::NEG_Z, DVec3::Y)])),
        ("a board from aside", with_boards(vec![board(DVec3::new(-0.2, 0.0, 0.1), DVec3::X, DVec3::Y)])),
        ("a tilted board", with_boards(vec![board(DVec3::ZERO, DVec3::new(0.2, 0.1, 1.0), DVec3::X)])),
        ("a reflector", Scene { reflectors: vec![mirror], ..Scene::default() }),
    ]
}

#[test]
fn sampled_pressures_are_those_of_the_f64_reference() {
    let block = Block { centre: DVec3::new(0.004, -0.003, 0.1), size: DVec3::new(0.07, 0.05, 0.06) };
    for (name, scene) in scenes() {
        let aperture = Aperture::new(&scene);
        let drives = [scattered(&aperture, 0.2), scattered(&aperture, 7.9)];
        for is_dragged in [true, false] {
            let volume = Volume::new(&aperture, &drives, &block, Fineness::of(is_dragged));
            let Lattice { first, step, counts } = volume.lattice;
            let point = |i: usize| {
                let (x, y) = (counts.x as usize, counts.y as usize);
                first + step * UVec3::new((i % x) as u32, (i / x % y) as u32, (i / x / y) as u32).as_dvec3()
            };
            let chosen: Vec<_> = (0..volume.values.len()).step_by(volume.values.len() / 150).collect();
            let samples = Samples::at(chosen.iter().map(|&i| point(i)).collect());
            let fields = drives.each_ref().map(|drive| reference::pressure(&aperture, drive, &samples));
            for (k, &i) in chosen.iter().enumerate() {
                let square: f64 = fields.iter().map(|field| field[k].norm_sqr()).sum();
                let off = ((square / 4.0).sqrt() - f64::from(volume.values[i])).abs();
                assert!(off < 2e-5 * f64::from(volume.peak), "{name}: {off} at {}", point(i));
            }
        }
    }
}

#[test]
fn volumes_of_any_size_are_small_enough_for_a_drag() {
    let aperture = Aperture::new(&Scene::default());
    let drives = [scattered(&aperture, 0.5)];
    for size in [DVec3::splat(10.0), DVec3::new(0.0001, 10.0, 0.3), DVec3::splat(1e-4), DVec3::splat(0.4)] {
        let block = Block { centre: DVec3::new(0.0, 0.0, 0.2), size };
        let volume = Volume::new(&aperture, &drives, &block, Fineness::of(true));
        assert!(volume.lattice.counts.min_element() >= 2 && volume.values.len() < 1 << 21, "{size}");
        assert!(volume.values.iter().all(|value| value.is_finite()));
    }
}

/// A Gaussian field with these widths (m) about a point: its isosurfaces are ellipsoids.
fn gaussian(block: &Block, centre: DVec3, widths: DVec3, step: f64) -> Volume {
    let lattice = Lattice::covering(block, DVec3::splat(step));
    let UVec3 { x, y, .. } = lattice.counts;
    let value = |i: usize| {
        let i = i as u32;
        let place = lattice.first + lattice.step * UVec3::new(i % x, i / x % y, i / x / y).as_dvec3();
        (1000.0 * (-0.5 * ((place - centre) / widths).length_squared()).exp()) as f32
    };
    Volume::of(lattice, (0..lattice.len()).map(value).collect())
}

fn scenery(clip: Block, body: Body) -> Scenery {
    let ground = [Vec3::splat(0.05), Vec3::splat(0.02)];
    Scenery {
        items: Vec::new(),
        body,
        clip,
        surface: Vec3::new(0.9, 0.4, 0.15),
        table: ColourMap::Inferno.table(),
        ground,
    }
}

const BLOCK: Block = Block { centre: DVec3::new(0.01, 0.0, 0.1), size: DVec3::new(0.06, 0.05, 0.08) };
const CENTRE: DVec3 = DVec3::new(0.012, -0.004, 0.103);
const WIDTHS: DVec3 = DVec3::new(0.004, 0.005, 0.011);

/// Whether a ray meets the ellipsoid at this fraction of the Gaussian's peak; `None` for near-tangents.
fn meets(start: DVec3, direction: DVec3, part: f64) -> Option<bool> {
    let radius = (-2.0 * part.ln()).sqrt();
    let (start, direction) = ((start - CENTRE) / WIDTHS, direction / WIDTHS);
    let nearest = start - direction * (start.dot(direction) / direction.length_squared());
    let distance = nearest.length() / radius;
    ((distance - 1.0).abs() > 0.03).then_some(distance < 1.0)
}

#[test]
fn the_surface_of_a_gaussian_is_its_ellipsoid_from_every_side() {
    let volume = gaussian(&BLOCK, CENTRE, WIDTHS, 0.001);
    let size = (90, 80);
    for part in [0.5, 0.2] {
        for direction in [[0.6, 0.36], [0.0, 0.0], [2.0, 1.57], [4.0, -0.7]] {
            for is_perspective in [true, false] {
                let camera = Camera::of(&BLOCK, direction, 90.0 / 80.0, is_perspective);
                let scenery = scenery(BLOCK, Body::Surface(part as f32));
                let shot = Shot::new(&scenery, &volume, &camera, size);
                let rgba = march::picture(&shot, &volume, &scenery.table, false);
                let projection = camera.projection(DVec2::new(90.0, 80.0));
                let mut met = 0;
                for (i, pixel) in rgba.as_chunks::<4>().0.iter().enumerate() {
                    let at = DVec2::new((i % 90) as f64 + 0.5, (i / 90) as f64 + 0.5);
                    let (start, towards) = projection.ray(at);
                    let is_seen = pixel[0] > 60;
                    if let Some(expected) = meets(start, towards, part) {
                        assert_eq!(is_seen, expected, "{part} {direction:?} {is_perspective} at {at}");
                    }
                    met += usize::from(is_seen);
                }
                assert!(met > 30, "{met} pixels");
            }
        }
    }
}

#[test]
fn a_projection_shows_the_largest_value_along_the_ray() {
    let volume = gaussian(&BLOCK, CENTRE, WIDTHS, 0.001);
    let scenery = scenery(BLOCK, Body::Projection);
    let camera = Camera::of(&BLOCK, [0.0, 0.0], 1.0, false);
    let shot = Shot::new(&scenery, &volume, &camera, (80, 80));
    let rgba = march::picture(&shot, &volume, &scenery.table, false);
    let projection = camera.projection(DVec2::splat(80.0));
    let mut seen = 0;
    for (i, pixel) in rgba.as_chunks::<4>().0.iter().enumerate() {
        let (start, _) = projection.ray(DVec2::new((i % 80) as f64 + 0.5, (i / 80) as f64 + 0.5));
        let off = (start - CENTRE) / WIDTHS;
        let part = (-0.5 * (off.x * off.x + off.z * off.z)).exp();
        // Opaque values have the table's colour.
        if part > 0.65 {
            let step = (part * 1000.0 / f64::from(volume.peak) * 255.0).round() as usize;
            let is_near = |expected: &[u8; 4]| (0..3).all(|c| pixel[c].abs_diff(expected[c]) <= 2);
            let near = &scenery.table[step.saturating_sub(5)..=(step + 2).min(255)];
            assert!(near.iter().any(is_near), "{pixel:?} {near:?} at {start}");
            seen += 1;
        }
    }
    assert!(seen > 40, "{seen}");
}

#[test]
fn a_clipped_box_shows_the_field_on_its_cut() {
    let volume = gaussian(&BLOCK, CENTRE, WIDTHS, 0.001);
    // The front half is cut away through the Gaussian's centre, so the cut shows the peak.
    let clip = Block::between(DVec3::new(-0.02, CENTRE.y, 0.06), BLOCK.high());
    let camera = Camera { target: CENTRE, ..Camera::of(&BLOCK, [0.0, 0.0], 1.0, false) };
    let scenery = scenery(clip, Body::Surface(0.5));
    let shot = Shot::new(&scenery, &volume, &camera, (81, 81));
    let rgba = march::picture(&shot, &volume, &scenery.table, false);
    let middle = &rgba[(40 * 81 + 40) * 4..][..3];
    let peak = scenery.table[255];
    assert!((0..3).all(|c| middle[c].abs_diff(peak[c]) < 10), "{middle:?} {peak:?}");
}

/// A ball with a pressure (Pa) on it that falls along x, or none.
fn ball(middle: DVec3, radius: f64, pressure: Option<f32>) -> Vec<Item> {
    let mesh = shapes::sphere(radius, radius / 3.0);
    let of = |triangle: usize| {
        let corners = mesh.corners(triangle);
        let at = |corner: DVec3| move |pressure: f32| pressure * (0.5 - 0.5 * (corner.x / radius) as f32);
        Item::Facet {
            corners: corners.map(|corner| middle + corner),
            normals: corners.map(|corner| corner.normalize_or_zero().as_vec3()),
            pressures: pressure.map(|pressure| corners.map(|corner| at(corner)(pressure))),
        }
    };
    (0..mesh.triangles.len()).map(of).collect()
}

#[test]
fn a_ball_of_facets_covers_its_disc_without_gaps() {
    for is_perspective in [true, false] {
        let camera = Camera::of(&BLOCK, [0.6, 0.4], 1.0, is_perspective);
        let projection = camera.projection(DVec2::splat(120.0));
        let radius = 0.018;
        let (_, depth) = projection.screen(BLOCK.centre).unwrap();
        let pixels = drawn(ball(BLOCK.centre, radius, None), &camera);
        let expected = PI * (radius / projection.per_pixel(depth)).powi(2);
        let part = pixels.len() as f64 / expected;
        assert!((0.95..1.03).contains(&part), "{part} of the disc");
        assert!(pixels.iter().all(|[r, g, b, _]| r == g && g == b && (60..170).contains(r)), "grey");
        let coloured = drawn(ball(BLOCK.centre, radius, Some(1000.0)), &camera);
        let reds: Vec<_> = coloured.iter().map(|pixel| pixel[0]).collect();
        assert_eq!(coloured.len(), pixels.len());
        assert!(reds.iter().max() > reds.iter().min().map(|least| least + 90).as_ref(), "the pressure falls");
    }
}

/// A scene with all kinds of scenery.
fn everything(clip: Block, body: Body) -> Scenery {
    let colour = Vec4::new(0.2, 0.7, 0.9, 0.8);
    let mut items = vec![
        Item::Dot { at: CENTRE, radius: 5.0, colour, shine: 0.5 },
        Item::Panel {
            centre: BLOCK.centre,
            half: [DVec3::X * 0.04, DVec3::new(0.0, 0.02, 0.02)],
            colour: Vec4::new(0.1, 0.3, 0.9, 0.3),
        },
        Item::Slice { centre: CENTRE, half: [DVec3::X * 0.03, DVec3::Y * 0.025], opacity: 0.9 },
        Item::Line { ends: [BLOCK.low(), BLOCK.high()], width: 2.0, colour, shine: 0.0 },
    ];
    for (number, middle) in [CENTRE, BLOCK.centre - DVec3::X * 0.015].into_iter().enumerate() {
        items.extend(ball(middle, 0.006, (number == 0).then_some(700.0)));
    }
    for i in 0..60 {
        let at = DVec3::new(f64::from(i % 10) * 0.006 - 0.02, f64::from(i / 10) * 0.006 - 0.02, 0.055);
        items.push(Item::Disc {
            centre: at,
            normal: DVec3::Z,
            radius: 0.0025,
            colour: Vec4::new(0.9, 0.5, 0.3, 1.0),
        });
    }
    Scenery { items, ..scenery(clip, body) }
}

#[test]
fn every_object_is_drawn_at_its_place() {
    let volume = gaussian(&BLOCK, CENTRE, WIDTHS, 0.002);
    let (size, at) = ((160, 120), BLOCK.centre + DVec3::new(0.012, -0.01, 0.02));
    let camera = Camera::of(&BLOCK, [0.6, 0.5], 1.2, false);
    let (expected, _) = camera.projection(DVec2::new(160.0, 120.0)).screen(at).unwrap();
    let colour = Vec4::new(0.2, 0.9, 0.6, 1.0);
    let half = [DVec3::X * 0.006, DVec3::Y * 0.004];
    let picture = |items: Vec<Item>| {
        let scenery = Scenery { items, ..scenery(BLOCK, Body::Hidden) };
        march::picture(&Shot::new(&scenery, &volume, &camera, size), &volume, &scenery.table, false)
    };
    let empty = picture(Vec::new());
    for item in [
        Item::Dot { at, radius: 6.0, colour, shine: 0.0 },
        Item::Disc { centre: at, normal: DVec3::Z, radius: 0.005, colour },
        Item::Panel { centre: at, half, colour },
        Item::Slice { centre: at, half, opacity: 1.0 },
        Item::Line { ends: [at - half[0], at + half[0]], width: 4.0, colour, shine: 0.0 },
    ] {
        let drawn = picture(vec![item]);
        let pairs = drawn.as_chunks::<4>().0.iter().zip(empty.as_chunks::<4>().0);
        let changed = pairs
            .enumerate()
            .filter(|(_, (own, ground))| own != ground)
            .map(|(i, _)| DVec2::new((i % size.0) as f64 + 0.5, (i / size.0) as f64 + 0.5));
        let changed: Vec<_> = changed.collect();
        let middle = changed.iter().sum::<DVec2>() / changed.len() as f64;
        assert!(changed.len() > 20, "{item:?}: {} pixels", changed.len());
        assert!(middle.distance(expected) < 1.0, "{item:?}: at {middle}, not {expected}");
    }
}

#[test]
fn a_view_of_a_box_has_the_same_margin_around_its_farthest_corner() {
    let size = DVec2::new(130.0, 100.0);
    let farthest = |camera: &Camera| {
        let projection = camera.projection(size);
        let corners = (0..8).map(|i| {
            let side = |bit: i32| if i & bit == 0 { -0.5 } else { 0.5 };
            let at = BLOCK.centre + BLOCK.size * DVec3::new(side(1), side(2), side(4));
            (projection.screen(at).unwrap().0 / size - 0.5).abs().max_element()
        });
        2.0 * corners.fold(0.0, f64::max)
    };
    let usual = farthest(&Camera::of(&BLOCK, [0.0, 0.0], 1.3, false));
    assert!((0.8..1.0).contains(&usual), "{usual}");
    for direction in [[0.6, 0.36], [0.0, 0.0], [2.0, 1.57], [4.0, -0.7], [1.0, -1.5]] {
        for is_perspective in [true, false] {
            let camera = Camera::of(&BLOCK, direction, 1.3, is_perspective);
            let without = farthest(&Camera { span: camera.span * usual, ..camera });
            assert!((without - 1.0).abs() < 1e-9, "{direction:?} {is_perspective}: {without}");
        }
    }
}

/// The pixels that differ from an empty picture.
fn drawn(items: Vec<Item>, camera: &Camera) -> Vec<[u8; 4]> {
    let volume = gaussian(&BLOCK, CENTRE, WIDTHS, 0.004);
    let picture = |items: Vec<Item>| {
        let scenery = Scenery { items, ..scenery(BLOCK, Body::Hidden) };
        march::picture(&Shot::new(&scenery, &volume, camera, (120, 120)), &volume, &scenery.table, false)
    };
    let (own, ground) = (picture(items), picture(Vec::new()));
    let pairs = own.as_chunks::<4>().0.iter().zip(ground.as_chunks::<4>().0);
    pairs.filter(|(own, ground)| own != ground).map(|(own, _)| *own).collect()
}

#[test]
fn objects_have_their_size_and_no_panel_hides_a_line_on_it() {
    let at = BLOCK.centre;
    let [blue, red] = [Vec4::new(0.0, 0.0, 1.0, 1.0), Vec4::new(1.0, 0.0, 0.0, 1.0)];
    let half = [DVec3::X * 0.022, DVec3::Y * 0.016];
    for direction in [[0.0, FRAC_PI_2], [0.6, 0.8], [2.5, 0.9], [4.0, 0.7], [5.5, 0.6]] {
        for is_perspective in [true, false] {
            let camera = Camera::of(&BLOCK, direction, 1.0, is_perspective);
            let projection = camera.projection(DVec2::splat(120.0));
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| projection.screen(at + half[0] * x + half[1] * y).unwrap().0);
            let edges = || corners.into_iter().zip(corners.into_iter().cycle().skip(1));
            let area: f64 = edges().map(|(from, to)| from.perp_dot(to)).sum::<f64>().abs() / 2.0;
            let around: f64 = edges().map(|(from, to)| from.distance(to)).sum();
            let dot = Item::Dot { at, radius: 6.0, colour: blue, shine: 0.0 };
            let panel = Item::Panel { centre: at, half, colour: blue };
            let slice = Item::Slice { centre: at, half, opacity: 1.0 };
            let disc = PI * 36.0;
            let ends = [at - half[0], at + half[0]];
            let line = Item::Line { ends, width: 4.0, colour: red, shine: 0.0 };
            let [from, to] = ends.map(|end| projection.screen(end).unwrap().0);
            let length = from.distance(to);
            for (item, area, around) in [
                (dot, disc, 12.0 * PI),
                (panel, area, around),
                (slice, area, around),
                // Half a pixel more on all sides, with round ends.
                (line, 5.0 * length + 6.25 * PI, 2.0 * length + 5.0 * PI),
            ] {
                let name = format!("{item:?}, {direction:?}, {is_perspective}");
                let pixels = drawn(vec![item], &camera).len() as f64;
                assert!((pixels - area).abs() < 0.6 * around, "{name}: {pixels} pixels, not {area}");
            }
            let red = |items: Vec<Item>| drawn(items, &camera).iter().filter(|rgba| rgba[0] > 150).count();
            let alone = red(vec![line]);
            for items in [vec![line, panel], vec![panel, line]] {
                let seen = red(items);
                assert!(2 * seen > alone, "{direction:?}, {is_perspective}: {seen} of {alone} pixels");
            }
        }
    }
}

#[test]
fn only_what_shines_is_seen_through_the_surface() {
    let volume = gaussian(&BLOCK, CENTRE, WIDTHS, 0.001);
    let colour = Vec4::new(0.1, 1.0, 0.1, 1.0);
    let camera = Camera { target: CENTRE, ..Camera::of(&BLOCK, [0.6, 0.4], 1.0, true) };
    let middle = |items: Vec<Item>| {
        let scenery = Scenery { items, ..scenery(BLOCK, Body::Surface(0.3)) };
        let shot = Shot::new(&scenery, &volume, &camera, (81, 81));
        let rgba = march::picture(&shot, &volume, &scenery.table, false);
        rgba.as_chunks::<4>().0[40 * 81 + 40]
    };
    let half = [DVec3::Y * 0.001, DVec3::X * 0.001];
    let dot = |shine: f32| Item::Dot { at: CENTRE, radius: 4.0, colour, shine };
    let bare = middle(Vec::new());
    assert_eq!(middle(vec![dot(0.0)]), bare);
    assert_eq!(middle(vec![Item::Panel { centre: CENTRE, half, colour }]), bare);
    assert_eq!(middle(vec![Item::Disc { centre: CENTRE, normal: DVec3::Z, radius: 0.001, colour }]), bare);
    let [faint, bright] = [0.4, 0.8].map(|shine| middle(vec![dot(shine)]));
    assert!(bare[1] < faint[1] && faint[1] < bright[1], "{bare:?}, {faint:?}, {bright:?}");
}

#[test]
fn the_gpu_draws_what_the_cpu_draws() {
    let Some(gpu) = gpu() else { return };
    let volume = Arc::new(gaussian(&BLOCK, CENTRE, WIDTHS, 0.0013));
    let mut painting = SpacePainting::default();
    let clip = Block::between(BLOCK.low() + DVec3::new(0.01, 0.0, 0.0), BLOCK.high());
    for body in [Body::Surface(0.5), Body::Projection, Body::Hidden] {
        for (is_smooth, is_perspective) in [(true, true), (false, true), (false, false)] {
            let scenery = everything(clip, body);
            let size = (133, 101);
            let camera = Camera::of(&BLOCK, [0.7, 0.4], 1.3, is_perspective);
            let shot = Shot::new(&scenery, &volume, &camera, size);
            let cpu = march::picture(&shot, &volume, &scenery.table, is_smooth);
            painting.paint(&gpu, (&shot, &scenery), &volume, is_smooth).unwrap();
            let gpu = painting.read(&gpu).unwrap();
            assert_eq!(gpu.len(), cpu.len());
            let far = cpu.iter().zip(&gpu).filter(|(a, b)| a.abs_diff(**b) > 3).count();
            // Rays that graze an edge may hit either side.
            assert!(far * 250 < cpu.len(), "{body:?} {is_smooth} {is_perspective}: {far} of {}", cpu.len());
            assert!(cpu.as_chunks::<4>().0.iter().filter(|pixel| pixel[0] > 100).count() > 300);
        }
    }
}

#[test]
fn a_picture_too_large_for_the_gpu_is_refused() {
    let Some(gpu) = gpu() else { return };
    let volume = Arc::new(gaussian(&BLOCK, CENTRE, WIDTHS, 0.004));
    let (scenery, camera) = (scenery(BLOCK, Body::Hidden), Camera::of(&BLOCK, [0.7, 0.4], 1.0, true));
    for size in [(1 << 20, 2), (2, 1 << 20)] {
        let shot = Shot::new(&scenery, &volume, &camera, size);
        let refused = SpacePainting::default().paint(&gpu, (&shot, &scenery), &volume, false);
        assert!(refused.unwrap_err().to_string().contains("too large"), "{size:?}");
    }
}
