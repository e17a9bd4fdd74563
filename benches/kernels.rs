//! Pairs (sample times element) per second of every evaluator, with the f64 reference as the baseline, and the stages that
//! take turns with them. `sonoglyph bench field` measures whole maps.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use num_complex::{Complex32, Complex64};
use sonoglyph::acoustics::Aperture;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::interpolation::{Between, interpolate};
use sonoglyph::field::plan::Costs;
use sonoglyph::field::transfer::{Layout, Transfer};
use sonoglyph::field::{Plan, Samples, Sources, Wave, cpu, reference};
use sonoglyph::scene::{ElementModel, Scene, Shape, Target};
use sonoglyph::simd::Isa;
use sonoglyph::solver;

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

/// The CPU's other inner loops: a table's product with a drive, and interpolation.
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

criterion_group!(benches, kernels, stages);
criterion_main!(benches);
