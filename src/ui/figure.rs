//! The panels of a figure: what can be shown now, and what is on the screen.

use crate::picture::figure::elements::Elements;
use crate::picture::figure::page::Plot;
use crate::picture::figure::table::Table;
use crate::picture::sheet::amplitude_title;
use crate::rounding::milliseconds;
use crate::studio::convention::Convention;
use crate::ui::beside::With;
use crate::ui::dialog::options::Piece;
use crate::ui::section;
use crate::ui::{editor::Editor, shown::MethodRow, shown::Shown};

/// The pieces that can be shown now, in the order of panels.
pub fn available(editor: &Editor, shown: &Shown) -> Vec<Piece> {
    let is_flat = !editor.space.is_on;
    let (has_map, is_surface) = (shown.map.is_some(), editor.view.quantity.declaration().is_surface());
    let second = editor.compare.as_ref().filter(|compare| {
        is_flat && compare.is_split && shown.beside.as_ref().is_some_and(|beside| beside.map.is_some())
    });
    let all = [
        (Piece::Map, has_map),
        (Piece::Second, second.is_some()),
        (Piece::Difference, second.is_some_and(|compare| compare.with != With::Plane)),
        (Piece::Relief, has_map && is_surface),
        (Piece::SecondRelief, second.is_some() && is_surface),
        (Piece::Space, !is_flat && shown.space.is_some()),
        (Piece::Profile, is_flat && section::Profile::of(editor, shown).is_some()),
        (Piece::Phases, shown.sound.is_some()),
        (Piece::Amplitudes, shown.solution.is_some()),
        (Piece::Pattern, editor.parts.beam.newest().is_some()),
        (Piece::Polar, editor.parts.beam.newest().is_some()),
        (Piece::Methods, !shown.methods.is_empty()),
    ];
    all.into_iter().filter(|(_, is_there)| *is_there).map(|(piece, _)| piece).collect()
}

/// The pieces on the screen.
pub fn displayed(editor: &Editor, shown: &Shown) -> Vec<Piece> {
    let is_subtracted = editor.compare.as_ref().is_some_and(|compare| compare.is_subtracted());
    let beside = if is_subtracted { Piece::Difference } else { Piece::Second };
    let wanted: &[Piece] = match (editor.space.is_on, editor.view.is_shaded()) {
        (true, _) => &[Piece::Space],
        (false, true) => &[Piece::Relief, Piece::SecondRelief],
        (false, false) => &[Piece::Map, beside],
    };
    let has_profile = !editor.space.is_on && editor.view.section;
    let is_wanted = |piece: &Piece| wanted.contains(piece) || (has_profile && *piece == Piece::Profile);
    available(editor, shown).into_iter().filter(is_wanted).collect()
}

/// A plot that needs no field, with its title.
pub fn plot(piece: Piece, editor: &Editor, shown: &Shown) -> Option<(String, Plot)> {
    let scene = editor.scene();
    match piece {
        Piece::Profile => {
            let (name, curve) = section::curve(editor, shown)?;
            Some((name, Plot::Curve(curve)))
        }
        Piece::Phases => {
            let drive = shown.sound.as_ref()?.drive();
            let elements = Elements::phases(scene, &drive.phases, &drive.amplitudes);
            Some(("Phase per element".to_owned(), Plot::Elements(elements)))
        }
        Piece::Amplitudes => {
            let solution = shown.solution.as_ref()?;
            let elements = Elements::amplitudes(scene, &solution.excitation, &solution.drive.amplitudes);
            Some((amplitude_title(solution).to_owned(), Plot::Elements(elements)))
        }
        Piece::Pattern | Piece::Polar => {
            let [curve, polar] = editor.parts.beam.newest()?.panels();
            let (name, plot) = if piece == Piece::Polar { polar } else { curve };
            Some((name.to_owned(), plot))
        }
        Piece::Methods => {
            let table = methods(&shown.methods, editor.view.convention);
            Some(("Methods compared".to_owned(), Plot::Table(table)))
        }
        Piece::Map
        | Piece::Second
        | Piece::Difference
        | Piece::Relief
        | Piece::SecondRelief
        | Piece::Space => None,
    }
}

/// The comparison of methods as a table.
fn methods(rows: &[MethodRow], convention: Convention) -> Table {
    let cells = |row: &MethodRow| {
        let mut cells = vec![row.method.title().to_owned()];
        cells.extend(match &row.solution {
            Ok(solution) => [
                convention.pressure(solution.quality.min_pressure),
                format!("{:.1} %", 100.0 * solution.quality.spread),
                milliseconds(solution.seconds, 1),
            ],
            Err(_) => ["–"; 3].map(str::to_owned),
        });
        cells
    };
    let head = ["Method", "Weakest", "std/mean", "Time"].map(str::to_owned).to_vec();
    Table { head, rows: rows.iter().map(cells).collect() }
}
