//! Speed of the inner loops: field evaluators (sample-element pairs per second), stages of a map, and 3D pictures.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use num_complex::{Complex32, Complex64};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::gpu::{SpacePainting, adapter};
use sonoglyph::field::interpolation::{Between, interpolate};
use sonoglyph::field::plan::Costs;
use sonoglyph::field::transfer::{Layout, Transfer};
use sonoglyph::field::volume::scenery::{Body, Shot};
use sonoglyph::field::volume::{Block, Camera, Fineness, Volume, march};
use sonoglyph::field::{Plan, Samples, Sources, Wave, cpu, reference};
use sonoglyph::scene::{ElementModel, Scene, Shape, Target};
use sonoglyph::simd::Isa;
use sonoglyph::solver;
use sonoglyph::studio::space::{Look, scenery};
use sonoglyph_engine::mesh::shapes;
use sonoglyph_engine::scatter::{Boundary, Emission};

fn kernels(criterion: &mut Criterion) {
    let gpu = adapter::open_best(true).ok();
    for (name, element, side) in
        [("piston", ElementModel::Piston, 256), ("exact-piston", ElementModel::ExactPiston, 64)]
    {
        let mut scene = Scene::default();
        scene.array.element = element;
        scene.targets = vec![Target::new(Shape::Point { at: scene.plane.centre })];
        let drive = solver::solve(&scene).expect("one point can be solved").drive;
        let aperture = Aperture::new(&scene);
        let samples = Samples::on_plane(&scene.plane, side, side).expect("the default plane is a plane");
        let sources = Sources::of_faces(&aperture, &drive, &samples).expect("the default element fits f32");

        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        group.throughput(Throughput::Elements((samples.len() * sources[0].elements.len()) as u64));
        for isa in Isa::available() {
            group.bench_function(BenchmarkId::new("CPU", isa.name()), |bencher| {
                bencher.iter(|| cpu::pressure_with(isa, black_box(&sources), samples.len()));
            });
        }
        if let Some(gpu) = &gpu {
            group.bench_function(BenchmarkId::new("GPU", &gpu.info().name), |bencher| {
                bencher.iter(|| gpu.pressure(black_box(&sources)));
            });
        }
        group.bench_function("reference", |bencher| {
            bencher
                .iter(|| reference::pressure(black_box(&aperture), black_box(&drive), black_box(&samples)));
        });
        group.finish();
    }
}

/// Other inner loops of the CPU: the product of a table with a drive, and interpolation.
fn stages(criterion: &mut Criterion) {
    let scene = Scene::default();
    let aperture = Aperture::new(&scene);
    let plan = Plan::new(&aperture, &scene.plane, Costs::CPU).expect("a plane");
    let grid = plan.grid.as_ref().expect("the default plane is interpolated");
    let (board, (_, shared)) = (&aperture.faces[0], grid.heard[0]);
    let wave =
        Wave::new(&aperture.element, &board.layout, &grid.samples).expect("the default element fits f32");
    let transfer = Transfer::new(board, &wave, Layout::new(board, &grid.samples, shared), None);
    let excitation = vec![Complex64::ONE; aperture.positions.len()];
    let mut samples = vec![Complex32::ZERO; grid.samples.len()];
    transfer.superpose(board, std::slice::from_ref(&excitation), std::slice::from_mut(&mut samples));

    let mut group = criterion.benchmark_group("superposition");
    for (name, drives) in [("one drive", 1), ("four drives", 4)] {
        let excitations = vec![excitation.clone(); drives];
        group.throughput(Throughput::Elements((drives * samples.len() * excitation.len()) as u64));
        group.bench_function(name, |bencher| {
            let mut fields = vec![samples.clone(); drives];
            bencher.iter(|| transfer.superpose(board, black_box(&excitations), &mut fields));
        });
    }
    group.finish();
    let mut group = criterion.benchmark_group("interpolation");
    for side in [256, 1024] {
        let place = |i: usize| 0.2 * ((i as f64 + 0.5) / side as f64 - 0.5);
        let [across, up] = [0, 1].map(|axis| grid.resampling(axis, (0..side).map(place)));
        let mut pixels = vec![Complex32::ZERO; side * side];
        let (mut between, columns) = (Between::default(), grid.samples.columns.len());
        group.throughput(Throughput::Elements(pixels.len() as u64));
        group.bench_function(BenchmarkId::new("pixels", side), |bencher| {
            bencher.iter(|| {
                interpolate(black_box(&samples), columns, &across, &up, &mut between, &mut pixels);
            });
        });
    }
    group.finish();
}

/// 3D pictures of a cube of 10 cm about a focus: sampled coarsely as in a drag or finely as at rest, with the pixels of
/// a draft or of the final picture.
fn space(criterion: &mut Criterion) {
    let mut scene = Scene::default();
    scene.targets = vec![Target::new(Shape::Point { at: scene.plane.centre })];
    let block = Block { centre: scene.plane.centre, size: DVec3::splat(0.1) };
    let aperture = Aperture::new(&scene);
    let drives = solver::solve(&scene).expect("one point can be solved").drives();
    let field = |drives: &[Drive], is_dragged: bool| {
        Arc::new(Volume::new(&aperture, drives, &block, Fineness::of(is_dragged)))
    };
    let scenery = |body: Body| {
        let look = Look { body, ..Look::default() };
        scenery(&scene, (&aperture, &drives[0]), &[], (&block, &block), &[], &look)
    };
    let camera = Camera::of(&block, [0.6, 0.36], 1.0, true);
    let shot =
        |volume: &Volume, body: Body, side: usize| Shot::new(&scenery(body), volume, &camera, (side, side));
    let mut group = criterion.benchmark_group("space");
    group.sample_size(20);
    let (coarse, fine) = (field(&drives, true), field(&drives, false));
    group.bench_function("drag frame", |bencher| {
        let mut moved = scene.clone();
        let mut step = 0.0;
        bencher.iter(|| {
            step = (step + 1e-4) % 0.02;
            moved.targets = vec![Target::new(Shape::Point { at: scene.plane.centre + DVec3::X * step })];
            let drives = solver::solve(&moved).expect("one point can be solved").drives();
            let volume = field(&drives, true);
            let body = Body::Surface(0.5);
            march::picture(&shot(&volume, body, 257), &volume, &scenery(body).table, false)
        });
    });
    for (name, is_dragged) in [("coarse", true), ("fine", false)] {
        group.bench_function(BenchmarkId::new("volume", name), |bencher| {
            bencher.iter(|| field(black_box(&drives), is_dragged));
        });
    }
    let gpu = adapter::open_best(true).ok();
    for (name, body) in [("surface", Body::Surface(0.5)), ("projection", Body::Projection)] {
        for (what, volume, side, is_smooth) in [
            ("draft, coarse", &coarse, 257, false),
            ("draft, fine", &fine, 257, false),
            ("at rest", &fine, 512, true),
        ] {
            let (shot, scenery) = (shot(volume, body, side), scenery(body));
            group.bench_function(BenchmarkId::new(name, what), |bencher| {
                bencher.iter(|| march::picture(black_box(&shot), volume, &scenery.table, is_smooth));
            });
            let Some(gpu) = &gpu else { continue };
            let mut painting = SpacePainting::default();
            group.bench_function(BenchmarkId::new(format!("{name}, {}", gpu.info().name), what), |bencher| {
                bencher.iter(|| {
                    painting.paint(gpu, (&shot, &scenery), volume, is_smooth).expect("a GPU that draws");
                    gpu.wait()
                });
            });
        }
    }
    group.finish();
}

/// The sound that a ball of 4 cm scatters to a plane: pairs of sources and points.
fn scattered(criterion: &mut Criterion) {
    let (k, edge) = (732.0, 0.0014);
    let body = Boundary::new(&shapes::sphere(0.02, edge), 1.0, k).expect("room for a small body");
    let nodal = |turn: f64| -> Vec<_> {
        body.mesh().vertices.iter().map(|at| Complex64::cis(turn - k * at.z)).collect()
    };
    let emissions: Vec<_> = (0..4).map(|drive| body.emission(&nodal(f64::from(drive)))).collect();
    let all: Vec<_> = emissions.iter().collect();
    let place = |n: usize| 0.1 * ((n as f64 + 0.5) / 64.0 - 0.5);
    let points: Vec<_> = (0..64 * 64).map(|n| DVec3::new(place(n % 64), place(n / 64), 0.03)).collect();

    let mut group = criterion.benchmark_group("scattered");
    group.sample_size(10);
    group.throughput(Throughput::Elements((emissions[0].sources.len() * points.len()) as u64));
    group.bench_function("pressures", |bencher| bencher.iter(|| emissions[0].pressures(black_box(&points))));
    group.bench_function("pressures of four drives", |bencher| {
        bencher.iter(|| Emission::pressures_of_all(&all, black_box(&points)));
    });
    group.bench_function("with slopes", |bencher| bencher.iter(|| emissions[0].sounds(black_box(&points))));
    group.bench_function("corrections", |bencher| {
        bencher.iter(|| body.corrections(&nodal(0.0), black_box(&points)));
    });
    if let Ok(gpu) = adapter::open_best(true) {
        group.bench_function(BenchmarkId::new("GPU", &gpu.info().name), |bencher| {
            bencher.iter(|| gpu.scattered(&emissions[..1], black_box(&points)));
        });
    }
    group.finish();
}

criterion_group!(benches, kernels, stages, space, scattered);
criterion_main!(benches);
