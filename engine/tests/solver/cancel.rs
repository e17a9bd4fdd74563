//! Solving that would take hours ends when it is cancelled, and iterations when their time is over.

use std::path::Path;
use std::time::Duration;

use sonoglyph::gauge::{Cancel, Gauge};
use sonoglyph::scene::{Method, Scene, file};
use sonoglyph::solver::{self, SolveError, frames};
use strum::VariantArray;

fn scene(text: &str) -> Scene {
    file::parse(&format!("format = 1\n{text}"), Path::new("a.toml")).unwrap()
}

const FOCI: &str = "[[target]]\nkind = \"circle\"\nradius = 0.05\npoints = 120\n";
const MOTION: &str = "[motion]\npath = \"circle\"\nframes = 64\n";

/// A solver table: the most iterations and the longest search.
fn solver(method: Method) -> String {
    format!("[solver]\nmethod = \"{}\"\niterations = 100000\nsearch = 3600.0\n", method.into_str())
}

/// Cancels what is solved soon after it has begun.
fn cancelled<T>(solve: impl FnOnce(&Gauge) -> Result<T, SolveError> + Send) -> bool {
    let cancel = Cancel::default();
    let gauge = Gauge::default().until(&cancel);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(30));
            cancel.cancel();
        });
        matches!(gauge.lead(|| solve(&gauge)), Err(SolveError::Cancelled))
    })
}

#[test]
fn a_cancelled_solver_ends() {
    // Those without iterations take less time than the cancelling, unless there are thousands of elements.
    let has_iterations = |method: &Method| match method {
        Method::Weighted | Method::Gs | Method::Gspat | Method::Wgs | Method::Greedy | Method::Best => true,
        Method::Focus | Method::Pinv | Method::Naive => false,
    };
    for method in Method::VARIANTS.iter().copied().filter(has_iterations) {
        let still = scene(&[FOCI, &solver(method)].concat());
        assert!(cancelled(|_| solver::solve(&still)), "{method:?}");
        let moving = scene(&[FOCI, &solver(method), MOTION].concat());
        assert!(cancelled(|gauge| frames::follow_with(&moving, gauge)), "{method:?} in motion");
    }
    let shape = "[[target]]\nkind = \"text\"\ntext = \"HIT\"\n";
    let area = "[[target]]\nkind = \"circle\"\nfill = true\n";
    let traps = "[[board]]\n[[board]]\nat = [0, 0, 0.2]\nnormal = [0, 0, -1]\n[[target]]\nkind = \"trap\"\n\
                 at = [0, 0, 0.1]\n[[target]]\nkind = \"trap\"\nat = [0.03, 0, 0.1]\n";
    for text in [shape, area, traps] {
        assert!(cancelled(|_| solver::solve(&scene(&[text, &solver(Method::Best)].concat()))), "{text}");
    }
    let large =
        "[array]\nrows = 128\ncolumns = 128\n[[target]]\nkind = \"circle\"\nradius = 0.05\npoints = 300\n";
    for method in [Method::Pinv, Method::Best] {
        let large = scene(&format!("{large}[solver]\nmethod = \"{}\"\n", method.into_str()));
        assert!(cancelled(|_| solver::solve(&large)), "{method:?}");
    }
}

#[test]
fn iterations_end_with_their_time() {
    for method in [Method::Weighted, Method::Wgs, Method::Greedy, Method::Best] {
        let text = format!("{FOCI}[solver]\nmethod = \"{}\"\niterations = 100000\n", method.into_str());
        let limited = || Gauge::default().iterating_for(Duration::from_millis(100));
        let found = limited().lead(|| solver::solve(&scene(&text))).unwrap();
        assert!(found.quality.min_pressure > 0.0, "{method:?}");
        let moving = scene(&[&text, MOTION].concat());
        let found = frames::follow_with(&moving, &limited()).unwrap();
        assert!(found.frames.iter().all(|frame| frame.min_pressure() > 0.0), "{method:?} in motion");
    }
}
