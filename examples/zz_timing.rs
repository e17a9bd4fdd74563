//! Scratch.
use sonoglyph::drive::Drive;
use sonoglyph::field::{Evaluator, Quantity, Request, Stages};
use std::time::Instant;
fn median(mut t: Vec<f64>) -> f64 {
    t.sort_by(f64::total_cmp);
    t[t.len() / 2]
}
fn main() {
    let repeats = 41;
    for name in ["five-points", "hit"] {
        let scene = sonoglyph::studio::opening::open(format!("assets/scenes/{name}.toml").as_ref()).unwrap();
        let solution = sonoglyph::solver::solve(&scene).unwrap();
        let t = (0..repeats)
            .map(|_| {
                let s = Instant::now();
                let solution = sonoglyph::solver::solve(&scene).unwrap();
                std::hint::black_box(&solution);
                s.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        let solve = median(t);
        let mut stages = Stages::new(Evaluator::Cpu);
        let mut t = Vec::new();
        for i in 0..repeats + 1 {
            let drive = Drive {
                phases: solution.drive.phases.iter().map(|p| p + 0.1 * f64::from(i)).collect(),
                ..solution.drive.clone()
            };
            let s = Instant::now();
            let request = Request::new(&scene, vec![drive], Quantity::Rms, (512, 512));
            let map = stages.take_map(&request).unwrap();
            std::hint::black_box(&map);
            if i > 0 {
                t.push(s.elapsed().as_secs_f64() * 1e3);
            }
        }
        println!("{name}: solve {solve:.3} ms, map {:.3} ms", median(t));
    }
}
