//! The Liquid page: the liquid and its surface depression.

use egui::Ui;

use crate::field::Quantity;
use crate::rounding::{digits, pascals_at_most};
use crate::scene::{Light, LiquidName};
use crate::studio::liquid;
use crate::ui::panels::form::{choice, given, heading, variants};
use crate::ui::panels::{MM, Unit, fact, form, number};
use crate::ui::parts::radiation::RadiationFigures;
use crate::ui::{editor::Editor, level, shown::Shown, theme};

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    let liquid = &mut editor.document.scene.liquid;
    heading(ui, "Liquid");
    let named = crate::scene::Liquid { name: liquid.name, ..crate::scene::Liquid::default() };
    form(ui, "liquid", |ui| {
        let known = variants::<LiquidName>(Into::into).into_iter().map(|(name, text)| (Some(name), text));
        let names: Vec<_> = [(None, "none")].into_iter().chain(known).collect();
        let tip = "At 20 °C; with none, a depression is shown as of water";
        choice(ui, ("Liquid", tip), &mut liquid.name, &names);
        let density = Unit { per: 1.0, suffix: " kg/m³", decimals: 1, speed: 1.0 };
        let tip = "With gravity, the restoring force of wide depressions";
        given(ui, ("Density", tip), &mut liquid.density, named.density(), density, 1.0..=1e5);
        let tension = Unit { per: 1e3, suffix: " mN/m", decimals: 1, speed: 0.1 };
        let tip = "The restoring force of narrow depressions";
        given(
            ui,
            ("Surface tension", tip),
            &mut liquid.surface_tension,
            named.surface_tension(),
            tension,
            1e-6..=10.0,
        );
        let viscosity = Unit { per: 1e3, suffix: " mPa·s", decimals: 2, speed: 0.1 };
        let tip = "Damps waves; the depression at rest is independent of it";
        given(ui, ("Viscosity", tip), &mut liquid.viscosity, named.viscosity(), viscosity, 0.0..=1e4);
        number(
            ui,
            ("Depth", "Of the liquid: slows long waves; the depression at rest is independent of it"),
            &mut liquid.depth,
            MM,
            1e-4..=10.0,
        );
        let gravity = Unit { per: 1.0, suffix: " m/s²", decimals: 3, speed: 0.01 };
        number(ui, ("Gravity", "9.81 m/s² on earth"), &mut liquid.gravity, gravity, 1e-3..=1e3);
    });
    depression(editor, shown, ui);
    caustic(editor, ui);
}

/// The screen of caustics.
fn caustic(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "Light on a screen");
    let liquid = &mut editor.document.scene.liquid;
    let named = crate::scene::Liquid { name: liquid.name, ..crate::scene::Liquid::default() };
    form(ui, "caustic", |ui| {
        let ways = variants::<Light>(|light| match light {
            Light::Through => "transmitted",
            Light::Reflected => "reflected",
        });
        let tip =
            "Through the liquid from below, or reflected from above; along the normal of the level surface";
        choice(ui, ("Light", tip), &mut liquid.light, &ways);
        number(
            ui,
            ("Screen", "Distance from the level surface to the screen"),
            &mut liquid.screen,
            MM,
            1e-4..=100.0,
        );
        let index = Unit { per: 1.0, suffix: "", decimals: 3, speed: 0.01 };
        let tip = "Of the liquid, for light through it";
        let own = named.refractive_index();
        given(ui, ("Refractive index", tip), &mut liquid.refractive_index, own, index, 1.0..=4.0);
    });
    if !editor.view.quantity.declaration().of_light && ui.button("Show the caustic").clicked() {
        show_surface(editor, Quantity::Caustic);
    }
    let Some(light) = radiation(editor).and_then(|figures| figures.pressed.light) else { return };
    form(ui, "light", |ui| {
        let tip = "On a screen of the scene plane's size, of the light of the same area of the surface";
        fact(ui, ("Light on the screen", tip), liquid::landed(light));
        let tip = "Crossing rays produce bright lines on the screen";
        fact(ui, ("Rays cross", tip), if light.crosses { "yes" } else { "no" }.to_owned());
    });
}

/// A quantity of the liquid, on a level plane.
fn show_surface(editor: &mut Editor, quantity: Quantity) {
    editor.view.quantity = quantity;
    if !editor.view.is_level(editor.scene()) {
        level::show_xy(editor);
    }
}

fn radiation(editor: &Editor) -> Option<&RadiationFigures> {
    editor.parts.radiation.newest()?.as_ref()
}

fn depression(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    heading(ui, "Surface depression");
    if !editor.view.quantity.declaration().of_liquid {
        ui.label("The surface is the plane in view, parallel to the array.");
        if ui.button("Show the depression").clicked() {
            show_surface(editor, Quantity::Depression);
        }
    }
    let Some(radiation) = radiation(editor) else { return };
    let figures = radiation.pressed;
    form(ui, "depression", |ui| {
        let tip = "Of the scene plane, to which force, depth, volume and slope refer";
        fact(ui, ("Area", tip), liquid::area(figures.size));
        fact(
            ui,
            ("Force", "Of the radiation pressure on this area"),
            format!("{} mN", digits(1e3 * figures.force)),
        );
        if let Some(map) = shown.map.as_ref().filter(|map| map.quantity == Quantity::Radiation) {
            let tip = "Largest radiation pressure in view";
            fact(ui, ("Largest pressure", tip), pascals_at_most(map.largest));
        }
        if let Some(depression) = figures.depression {
            fact(ui, ("Deepest", "Below the undisturbed surface"), liquid::metres(depression.deepest));
            let tip = "Volume of the depression on this area";
            fact(ui, ("Displaced", tip), liquid::volume(depression.volume));
            let tip = "Rise over run; linear theory holds where it is small";
            fact(ui, ("Steepest slope", tip), digits(depression.slope));
        }
    });
    if let Some(beyond) = &radiation.beyond {
        ui.label(egui::RichText::new(beyond).color(theme::warning(ui.visuals())));
    }
}
