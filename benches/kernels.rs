//! Pairs (sample times element) per second of every evaluator, with the f64 reference as the baseline, and whole maps.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sonoglyph::acoustics::Aperture;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Plan, Samples, Sources, cpu, map, reference};
use sonoglyph::scene::{ElementModel, Scene, Shape, Target, file};
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
        let sources = Sources::new(&aperture, &drive, &samples).expect("the default element fits f32");

        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        group.throughput(Throughput::Elements((samples.len() * sources.elements.len()) as u64));
        for isa in cpu::Isa::available() {
            group.bench_function(BenchmarkId::new("CPU", isa.name()), |bencher| {
                bencher.iter(|| cpu::pressure_with(isa, black_box(&sources), black_box(&samples)));
            });
        }
        if let Some(gpu) = &gpu {
            group.bench_function(BenchmarkId::new("GPU", &gpu.info().name), |bencher| {
                bencher.iter(|| {
                    gpu.pressure(black_box(&sources), black_box(&samples)).and_then(|field| field.read())
                });
            });
        }
        group.bench_function("reference", |bencher| {
            bencher
                .iter(|| reference::pressure(black_box(&aperture), black_box(&drive), black_box(&samples)));
        });
        group.finish();
    }
}

/// A whole map of 1024 x 1024 pixels, planned and measured: `exact` is the baseline of the tolerances.
fn maps(criterion: &mut Criterion) {
    let gpu = adapter::open_best(true).ok();
    let mut scene =
        file::parse(include_str!("../assets/scenes/hit.toml"), "hit.toml".as_ref()).expect("a scene");
    let drive = solver::solve(&scene).expect("it can be solved").drive;
    let aperture = Aperture::new(&scene);
    let mut group = criterion.benchmark_group("map");
    group.sample_size(10);
    for (name, tolerance) in [("exact", 0.0), ("1e-3", 1e-3), ("1e-5", 1e-5)] {
        scene.plane.tolerance = tolerance;
        let plan = || Plan::new(&aperture, &scene.plane, (1024, 1024), tolerance).expect("a plane");
        println!("{name}: error {:.1e} of the peak", map::by_cpu(plan(), &aperture, &drive, tolerance).error);
        group.bench_function(BenchmarkId::new("CPU", name), |bencher| {
            bencher.iter(|| map::by_cpu(plan(), &aperture, &drive, tolerance));
        });
        if let Some(gpu) = &gpu {
            group.bench_function(BenchmarkId::new("GPU", name), |bencher| {
                bencher.iter(|| {
                    map::by_gpu(gpu, &plan(), &aperture, &drive, tolerance).map(|map| map.is_some())
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, kernels, maps);
criterion_main!(benches);
