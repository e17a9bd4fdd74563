//! The window drawn by wgpu: maps stay on the device that draws the window.

use std::sync::Arc;

use eframe::egui_wgpu::{WgpuSetup, WgpuSetupCreateNew};
use eframe::wgpu;
use egui_kittest::wgpu::{WgpuTestRenderer, default_wgpu_setup};
use sonoglyph::app::Window;
use sonoglyph::field::gpu::{adapter, device_descriptor};
use sonoglyph::field::{Evaluator, Work};
use sonoglyph::ui::Editor;
use sonoglyph::ui::document::Document;

use crate::requirement::found;
use crate::*;

const ONE_FOCUS: &str = "format = 1\n[[target]]\nkind = \"point\"\nat = [0.0, 0.0, 0.1]\n";
/// Limit of bytes read back per frame.
const MOST_BYTES: u64 = 4096;

fn renderer() -> WgpuTestRenderer {
    let WgpuSetup::CreateNew(setup) = default_wgpu_setup() else { panic!("an existing device") };
    let device_descriptor = Arc::new(|adapter: &wgpu::Adapter| device_descriptor(adapter));
    WgpuTestRenderer::from_setup(WgpuSetup::CreateNew(WgpuSetupCreateNew { device_descriptor, ..setup }))
}

/// The window as with `--renderer wgpu`, with maps by GPU or CPU.
fn open_on(by_gpu: bool) -> Option<Screen> {
    found("gpu", adapter::open_best(true))?;
    let builder = Harness::builder().with_size(vec2(900.0, 600.0)).renderer(renderer());
    let mut screen = builder.build_eframe(|context| {
        let document = Document::parse(ONE_FOCUS.to_owned(), "one").unwrap();
        if by_gpu {
            Window::of(context, Editor::new(document))
        } else {
            Window::new(&context.egui_ctx, document, Evaluator::Cpu)
        }
    });
    rest(&mut screen);
    Some(screen)
}

/// r, g, b of the map on the screen.
fn seen(screen: &mut Screen) -> Vec<[u8; 3]> {
    screen.remove_cursor();
    rest(screen);
    let rect = lens(screen).rect;
    let image = screen.render().unwrap();
    let rows = rect.top().ceil() as u32 + 1..rect.bottom() as u32 - 1;
    let columns = rect.left().ceil() as u32 + 1..rect.right() as u32 - 1;
    let pixel = |x, y| -> [u8; 3] { image.get_pixel(x, y).0[..3].try_into().unwrap() };
    rows.flat_map(|y| columns.clone().map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}

#[test]
fn a_drag_reads_back_only_figures_and_allocates_nothing_after_its_first_frame() {
    let Some(mut screen) = open_on(true) else { return };
    assert!(screen.state().gpu().is_some());
    let (from, to) = (at(&screen, 0.0, 0.0), at(&screen, 30.0, 20.0));
    screen.hover_at(from);
    screen.step();
    screen.drag_at(from);
    screen.step();
    let mut before = screen.state().work();
    let first = before;
    for frame in 1..=200 {
        screen.hover_at(from + (to - from) * (frame as f32 / 200.0));
        screen.step();
        let work = screen.state().work();
        let Work { read_back, allocations, .. } = work.since(before);
        assert!(read_back <= MOST_BYTES, "frame {frame}: {read_back} bytes");
        assert!(frame <= 1 || allocations == 0, "frame {frame}: {allocations} allocations");
        before = work;
    }
    let drives = before.since(first).superposition;
    assert!(drives > 150, "the focus follows the pointer: {drives} drives in 200 frames");
    screen.drop_at(to);
    rest(&mut screen);
    let map = screen.state().shown().map.as_ref().unwrap();
    assert!(map.largest > 100.0 && map.error < 1e-3, "figures have been read back: {map:?}");
}

#[test]
fn the_picture_on_the_device_equals_the_cpus() {
    let (Some(mut by_gpu), Some(mut by_cpu)) = (open_on(true), open_on(false)) else { return };
    for quantity in [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7] {
        let mut pictures = Vec::new();
        for screen in [&mut by_gpu, &mut by_cpu] {
            key(screen, quantity);
            screen.state_mut().editor_mut().oscillation.playing = false;
            assert!(screen.state().shown().problem.is_none(), "{:?}", screen.state().shown().problem);
            pictures.push(seen(screen));
        }
        let [a, b] = &pictures[..] else { unreachable!() };
        assert_eq!(a.len(), b.len());
        let bright = a.iter().filter(|pixel| pixel.iter().any(|&channel| channel > 60)).count();
        assert!(bright > a.len() / 1000, "{quantity:?}: the picture is not empty");
        let far = |(a, b): &(&[u8; 3], &[u8; 3])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 3);
        let off = a.iter().zip(b).filter(far).count();
        // The table of a phase is steep at its cut.
        let allowed = if quantity == Key::Num2 { a.len() / 200 } else { 0 };
        assert!(off <= allowed, "{quantity:?}: {off} of {} pixels differ", a.len());
    }
}

/// The window as in a browser: the GPU computes, and another device draws.
fn open_beside(evaluator: Evaluator) -> Screen {
    let builder = Harness::builder().with_size(vec2(900.0, 600.0));
    let mut screen = builder.build_eframe(|context| {
        Window::new(&context.egui_ctx, Document::parse(ONE_FOCUS.to_owned(), "one").unwrap(), evaluator)
    });
    rest(&mut screen);
    screen
}

#[test]
fn maps_of_a_separate_gpu_arrive_during_a_drag_without_blocking_frames() {
    let Some(gpu) = found("gpu", adapter::open_best(true)) else { return };
    let mut by_gpu = open_beside(Evaluator::Gpu(Box::new(gpu)));
    let mut by_cpu = open_beside(Evaluator::Cpu);
    let (from, to) = (at(&by_gpu, 0.0, 0.0), at(&by_gpu, 30.0, 20.0));
    let (mut arrived, mut left) = (0, 0);
    for screen in [&mut by_gpu, &mut by_cpu] {
        screen.hover_at(from);
        screen.step();
        screen.drag_at(from);
        screen.step();
        let mut before = screen.state().work();
        for frame in 1..=60 {
            screen.hover_at(from + (to - from) * (frame as f32 / 60.0));
            screen.step();
            assert!(screen.state().shown().map.is_some(), "frame {frame}: the previous picture stays");
            let work = screen.state().work();
            let has_come = work.since(before).read_back > 0;
            (arrived, left) = (arrived + u32::from(has_come), left + u32::from(!has_come));
            before = work;
        }
        screen.drop_at(to);
    }
    // The CPU's 60 frames never read back.
    left -= 60;
    assert!(arrived > 3 && left > 3, "{arrived} maps came, and {left} frames were drawn without");
    rest(&mut by_gpu);
    rest(&mut by_cpu);
    assert!(by_gpu.state().gpu().is_some());
    let [(_, a), (_, b)] = [&mut by_gpu, &mut by_cpu].map(|screen| screen.state_mut().numbers().unwrap());
    let peak = b.iter().copied().fold(0.0, f32::max);
    let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(
        a.len() == b.len() && off < 2e-3 * peak,
        "the last picture shows the last position: {off} of {peak}"
    );
    let map = by_gpu.state().shown().map.as_ref().unwrap();
    assert!((map.largest / f64::from(peak) - 1.0).abs() < 1e-3 && map.error < 1e-3, "{map:?}");
}

#[test]
fn after_a_lost_device_the_window_uses_another() {
    let Some(mut screen) = open_on(true) else { return };
    screen.state().gpu().unwrap().lose();
    let (from, to) = (at(&screen, 0.0, 0.0), at(&screen, 10.0, 0.0));
    drag(&mut screen, from, to);
    let shown = screen.state().shown();
    assert!(screen.state().gpu().is_none() && shown.evaluator.starts_with("CPU"), "{}", shown.evaluator);
    let Shape::Point { at } = scene(&screen).targets[0].shape else { panic!("no point") };
    assert!((at.x - 0.01).abs() < 1e-3, "the drag continues: {at}");
}
