//! `sonoglyph devices`: what could compute the field here, and what would.

use crate::field::gpu::adapter::{self, Kind};
use crate::simd::Isa;

pub fn run() -> anyhow::Result<()> {
    let adapters = adapter::adapters();
    println!("GPU adapters, the best first:");
    if adapters.is_empty() {
        println!("  none: no graphics driver offers one");
    }
    for info in &adapters {
        println!("  {info}");
    }
    let sets: Vec<_> = Isa::available().iter().map(|isa| isa.name()).collect();
    println!("CPU evaluator:");
    println!("  {} threads, {} (has {})", rayon::current_num_threads(), Isa::best().name(), sets.join(", "));
    println!("f64 reference:");
    println!("  always there");
    println!("`--backend auto` would use:");
    match adapters.first() {
        Some(info) if info.kind != Kind::Software => println!("  {} for maps, since it is a GPU", info.name),
        Some(info) => println!(
            "  the CPU evaluator for maps, since {} is software that runs on this same CPU, and slower on it",
            info.name
        ),
        None => println!("  the CPU evaluator for maps, since there is no GPU adapter"),
    }
    println!("  the f64 reference for points");
    Ok(())
}
