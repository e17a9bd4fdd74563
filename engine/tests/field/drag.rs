//! Dragging a target: pictures stay on the GPU, figures come back, and no call blocks.

use sonoglyph::drive::Drive;
use sonoglyph::field::{By, Colouring, Evaluator, Map, Quantity, Request, Stages, Work};
use sonoglyph::picture::ColourMap;

use crate::texels::painted;
use crate::{STEP, fast_evaluators, gpu, own, scattered, three_foci};

/// Quantities that a GPU forms, of one drive.
const ON_GPU: [Quantity; 5] =
    [Quantity::Rms, Quantity::Phase, Quantity::Instantaneous, Quantity::Intensity, Quantity::Velocity];

/// Polls until the map is ready, and counts the polls before.
fn polled(stages: &mut Stages, request: &Request) -> (Map, u64) {
    let mut before = 0;
    loop {
        if let Some(map) = stages.poll(request).unwrap() {
            return (map.clone(), before);
        }
        before += 1;
        std::thread::yield_now();
    }
}

#[test]
fn polling_does_not_block_and_ends_with_the_same_map() {
    let (scene, drives) = three_foci();
    for evaluator in fast_evaluators() {
        let own = own(&evaluator);
        let mut stages = Stages::new(evaluator);
        for quantity in Quantity::ALL {
            let request = Request::new(&scene, drives[..1].to_vec(), quantity, (400, 300));
            let (map, before) = polled(&mut stages, &request);
            let sampled = [Quantity::Harmonic, Quantity::Gorkov, Quantity::Force];
            let is_on_gpu = ON_GPU.contains(&quantity) || sampled.contains(&quantity);
            assert_eq!(map.by == By::Gpu, own == By::Gpu && is_on_gpu, "{quantity:?}");
            assert!(before == 0 || map.by == By::Gpu, "{quantity:?}: {before} polls by {:?}", map.by);
            let done = stages.work();
            assert!(stages.poll(&request).unwrap() == Some(&map), "{quantity:?}");
            assert!(stages.map(&request).unwrap() == &map, "{quantity:?}");
            assert_eq!(stages.work(), done, "{quantity:?} is cached");
            stages.forget();
            assert!(stages.map(&request).unwrap() == &map, "{quantity:?}");
        }
    }
}

#[test]
fn a_poll_returns_before_the_gpu_has_finished_a_large_map() {
    /// A busy machine may run the driver's thread first, but hardly every time.
    const ATTEMPTS: u32 = 100;
    let Some(gpu) = gpu() else { return };
    let (scene, _) = three_foci();
    let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
    let is_polled_early = (0..ATTEMPTS).any(|attempt| {
        let drives = vec![scattered(256, STEP + 1e-4 * f64::from(attempt))];
        let request = Request::new(&scene, drives, Quantity::Rms, (1600, 1200));
        polled(&mut stages, &request).1 > 0
    });
    assert!(is_polled_early, "every poll blocked until its map was ready");
}

#[test]
fn a_pending_map_is_not_returned_for_the_next_request() {
    let Some(gpu) = gpu() else { return };
    let (scene, drives) = three_foci();
    let request = |drive: &Drive| Request::new(&scene, vec![drive.clone()], Quantity::Rms, (200, 150));
    let requests: Vec<_> = drives.iter().map(request).collect();
    let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
    let expected: Vec<_> = requests.iter().map(|request| stages.map(request).unwrap().clone()).collect();
    assert!(expected[0].values != expected[1].values);
    for round in 0..5 {
        for (request, expected) in requests.iter().zip(&expected) {
            let earlier = &requests[round % 3];
            stages.poll(earlier).unwrap();
            assert!(polled(&mut stages, request).0 == *expected, "polled, cycle {round}");
            stages.poll(earlier).unwrap();
            assert!(stages.map(request).unwrap() == expected, "blocking, cycle {round}");
        }
    }
    // Figures, too, belong to the latest request.
    let colouring = Colouring::new(Quantity::Rms, ColourMap::Grey.table());
    for (request, expected) in requests.iter().zip(&expected) {
        stages.picture(request, &colouring).unwrap();
        assert_eq!(figures(&mut stages, request).peak, expected.peak);
    }
    stages.picture(&requests[0], &colouring).unwrap();
    assert_eq!(figures(&mut stages, &requests[1]).peak, expected[1].peak);
}

fn figures(stages: &mut Stages, request: &Request) -> Map {
    loop {
        if let Some((map, _)) = stages.figures(request).unwrap() {
            return map;
        }
        std::thread::yield_now();
    }
}

#[test]
fn a_drag_reads_back_only_figures_and_allocates_nothing() {
    const DRIVES: u64 = 40;
    const SIZE: (usize, usize) = (120, 90);
    let (scene, _) = three_foci();
    for quantity in ON_GPU {
        let Some(gpu) = gpu() else { return };
        let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
        let mut request = Request::new(&scene, vec![scattered(256, STEP)], quantity, SIZE);
        let colouring = Colouring::new(quantity, ColourMap::Grey.table());
        stages.picture(&request, &colouring).unwrap();
        figures(&mut stages, &request);
        let first = stages.work();
        for number in 1..=DRIVES {
            request.drives = [scattered(256, STEP + 1e-4 * number as f64)].into();
            stages.picture(&request, &colouring).unwrap();
            stages.figures(&request).unwrap();
        }
        let last = figures(&mut stages, &request);
        let work = stages.work().since(first);
        assert!(work.read_back <= 4096 * DRIVES, "{quantity:?}: {} bytes", work.read_back);
        let of_drives = Work {
            superposition: DRIVES,
            interpolation: DRIVES,
            forming: DRIVES,
            picture: DRIVES,
            ..Work::default()
        };
        assert_eq!(Work { read_back: 0, ..work }, of_drives, "{quantity:?}");

        let mut on_cpu = Stages::new(Evaluator::Cpu);
        let expected = on_cpu.colours(&request, &colouring).unwrap().to_vec();
        let peak = on_cpu.map(&request).unwrap().peak;
        assert!((last.peak - peak).abs() < 2e-3 * peak, "{quantity:?}: {} is not {peak}", last.peak);
        assert!(last.error < scene.plane.tolerance && last.by == By::Gpu && last.values.is_empty());
        let loud = loudness(&mut on_cpu, &request);
        let texels = painted(&mut stages, &request, &colouring);
        assert_eq!(texels.len(), expected.len());
        for ((got, expected), loud) in texels.iter().zip(&expected).zip(loud) {
            for (got, expected) in got.iter().zip(expected) {
                let apart = got.abs_diff(*expected);
                // Near silence the phase is arbitrary, and the table of a cyclic quantity ends where it starts.
                let is_same = if quantity == Quantity::Phase {
                    loud < 0.1 || apart.min(255 - apart) <= 3
                } else {
                    apart <= 3
                };
                assert!(is_same, "{quantity:?}: {got}, not {expected}");
            }
        }
    }
}

/// |P| at every pixel, relative to its maximum.
fn loudness(stages: &mut Stages, request: &Request) -> Vec<f32> {
    let map = stages.map(&Request { quantity: Quantity::Rms, ..request.clone() }).unwrap();
    map.values.iter().map(|value| value / map.peak).collect()
}

#[test]
fn the_time_of_a_map_is_known_where_the_gpu_has_a_clock() {
    let Some(gpu) = gpu() else { return };
    let has_clock = gpu.device().features().contains(wgpu::Features::TIMESTAMP_QUERY);
    let mut scene = three_foci().0;
    (scene.array.rows, scene.array.columns) = (4, 4);
    let request = Request::new(&scene, vec![scattered(16, STEP)], Quantity::Rms, (90, 70));
    let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
    let (_, seconds) = loop {
        if let Some(figures) = stages.figures(&request).unwrap() {
            break figures;
        }
        std::thread::yield_now();
    };
    // A GPU without one, or one that was never asked, has no time, or none that has passed.
    assert_eq!(seconds.is_some_and(|seconds| seconds > 0.0), has_clock, "{seconds:?}");
}
