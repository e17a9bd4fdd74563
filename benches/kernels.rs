//! Pairs (sample times element) per second of every evaluator, with the f64 reference as the baseline.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sonoglyph::acoustics::Aperture;
use sonoglyph::field::gpu::adapter;
use sonoglyph::field::{Samples, Sources, cpu, reference};
use sonoglyph::scene::{ElementModel, Scene, Shape, Target};
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

criterion_group!(benches, kernels);
criterion_main!(benches);
