//! The force on the scene's bead at a point and on the displayed plane, computed on a thread on demand.

use egui::Context;
use glam::DVec3;

use crate::acoustics::Aperture;
use crate::app::later::Later;
use crate::drive::Drive;
use crate::force::Levitation;
use crate::scene::Scene;
use crate::ui::view::Lens;
use crate::ui::{Arrows, Editor, Levitated, Panel, Shown, arrows, bead};

/// Points on each of the three curves.
const PLACES: usize = 81;

/// The drives and the bead.
#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    scene: Scene,
    aperture: Aperture,
    drives: Vec<Drive>,
    /// m, where it is put.
    at: Option<DVec3>,
    /// Points of the force arrows, m.
    places: Vec<DVec3>,
}

#[derive(Debug, Default)]
pub struct Levitating {
    made: Later<Wanted, (Option<Levitated>, Arrows)>,
}

impl Levitating {
    pub fn is_running(&self) -> bool {
        self.made.is_running()
    }

    /// Collects finished values, and returns whether there were any.
    pub fn collect(&mut self) -> bool {
        self.made.collect()
    }

    /// Requests the displayed values; until they are available, the previous ones stay. Arrows are only on maps.
    pub fn update(&mut self, editor: &Editor, shown: &mut Shown, lens: Option<&Lens>, ctx: &Context) {
        let is_seen = editor.panel == Panel::Scene && editor.bead.is_shown && !editor.layout.presents;
        let at = bead::place(editor, shown).filter(|_| is_seen);
        let lens = lens.filter(|_| editor.bead.arrows && !editor.view.is_shaded());
        let sound = shown.sound.as_ref();
        let sound = sound.filter(|sound| {
            (at.is_some() || lens.is_some()) && sound.drive().phases.len() == sound.aperture.positions.len()
        });
        let Some(sound) = sound else {
            (shown.levitated, shown.arrows) = (None, None);
            return;
        };
        let wanted = Wanted {
            scene: editor.scene().clone(),
            aperture: sound.aperture.clone(),
            drives: sound.drives.clone(),
            at,
            places: lens.map(|lens| arrows::places(editor, lens)).unwrap_or_default(),
        };
        self.made.ask(&wanted, ctx, make);
        if let Some((levitated, arrows)) = self.made.get(&wanted) {
            shown.levitated = levitated.clone();
            shown.arrows = Some(arrows.clone());
        }
        shown.levitated.take_if(|_| at.is_none());
        shown.arrows.take_if(|_| lens.is_none());
    }
}

fn make(wanted: &Wanted) -> (Option<Levitated>, Arrows) {
    let Wanted { scene, aperture, drives, at, places } = wanted;
    let levitation = Levitation::new(scene, aperture, drives);
    let levitated = at.map(|at| Levitated {
        hold: levitation.hold(at),
        forces: levitation.forces(at),
        load: levitation.load,
        curves: levitation.curves(at, levitation.wavelength, PLACES),
        warning: levitation.sphere.warning(),
    });
    (levitated, Arrows { forces: levitation.forces_at(places), places: places.clone() })
}
