//! The visual theme of all panels, light and dark.

use std::sync::Arc;

use egui::{
    Button, Color32, Context, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, RichText, Stroke,
    TextStyle, Theme, Visuals, vec2,
};

/// The one that sheets are lettered with, too.
const FONT: &str = "Inter";
/// Tabular digits: numbers align in columns, and changing numbers do not move their unit.
const DIGITS: &str = "Inter tabular digits";
const SEMIBOLD: &str = "Inter semibold";
/// Selected, drawn or pressed items.
pub const ACCENT: Color32 = Color32::from_rgb(46, 134, 222);
/// Stop and delete buttons.
pub const DANGER: Color32 = Color32::from_rgb(205, 48, 44);
/// Over the map, on any of its colours.
pub const MARK: Color32 = Color32::WHITE;
pub const MARK_EDGE: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 190);
pub const CHOSEN: Color32 = Color32::from_rgb(72, 219, 251);

/// Behind a map.
pub fn ground(is_light: bool) -> Color32 {
    if is_light { Color32::WHITE } else { Color32::from_rgb(12, 12, 16) }
}

/// Thin lines over the map, on a dark or a light ground.
pub fn line(is_light: bool, alpha: u8) -> Color32 {
    if is_light { Color32::from_black_alpha(alpha) } else { Color32::from_white_alpha(alpha) }
}

/// Sets the font, and sizes, spacing and colours of both themes.
pub fn install(ctx: &Context) {
    let mut fonts = FontDefinitions::empty();
    for (name, bytes) in [
        (FONT, include_bytes!("../../assets/fonts/Inter-Regular.otf").as_slice()),
        (DIGITS, include_bytes!("../../assets/fonts/Inter-TabularDigits.otf")),
        (SEMIBOLD, include_bytes!("../../assets/fonts/Inter-SemiBold.otf")),
    ] {
        fonts.font_data.insert(name.to_owned(), Arc::new(FontData::from_static(bytes)));
    }
    for family in [FontFamily::Proportional, FontFamily::Monospace] {
        fonts.families.insert(family, vec![DIGITS.to_owned(), FONT.to_owned()]);
    }
    fonts.families.insert(semibold(), vec![SEMIBOLD.to_owned(), FONT.to_owned()]);
    ctx.set_fonts(fonts);
    // Larger and smaller are actions like others, with bounds.
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
    ctx.all_styles_mut(|style| {
        let font = |size| FontId::new(size, FontFamily::Proportional);
        style.text_styles = [
            (TextStyle::Heading, FontId::new(17.0, semibold())),
            (TextStyle::Body, font(13.0)),
            (TextStyle::Button, font(13.0)),
            (TextStyle::Small, font(11.5)),
            (TextStyle::Monospace, FontId::new(12.5, FontFamily::Monospace)),
        ]
        .into();
        style.spacing.item_spacing = vec2(8.0, 6.0);
        style.spacing.button_padding = vec2(8.0, 3.0);
        style.spacing.interact_size.y = 22.0;
        style.spacing.slider_width = 140.0;
        style.interaction.tooltip_delay = 0.4;
    });
    for theme in [Theme::Dark, Theme::Light] {
        ctx.set_visuals_of(theme, visuals(theme));
    }
}

fn semibold() -> FontFamily {
    FontFamily::Name(SEMIBOLD.into())
}

/// Whether a window is too narrow for map and panel side by side: the panel then covers the map, and the view bar has
/// lists.
pub fn is_narrow(ctx: &Context) -> bool {
    const NARROW: f32 = 860.0;
    ctx.content_rect().width() < NARROW
}

/// A title above a group of controls.
pub fn heading(text: &str) -> RichText {
    RichText::new(text).font(FontId::new(14.0, semibold()))
}

/// The label beside a control or a value.
pub fn label(text: &str, visuals: &Visuals) -> RichText {
    RichText::new(text).size(12.0).color(visuals.text_color().gamma_multiply(0.75))
}

/// The primary button of a dialog or page.
pub fn primary(text: &str) -> Button<'_> {
    filled(text, ACCENT)
}

/// A button that deletes or stops something.
pub fn destructive(text: &str) -> Button<'_> {
    filled(text, DANGER)
}

fn filled(text: &str, fill: Color32) -> Button<'_> {
    Button::new(RichText::new(text).color(Color32::WHITE)).fill(fill)
}

fn visuals(theme: Theme) -> Visuals {
    let mut visuals = theme.default_visuals();
    let (panel, text, faint) = match theme {
        Theme::Dark => {
            (Color32::from_rgb(30, 32, 38), Color32::from_rgb(222, 225, 232), Color32::from_rgb(38, 41, 48))
        }
        Theme::Light => (
            Color32::from_rgb(246, 247, 249),
            Color32::from_rgb(32, 35, 42),
            Color32::from_rgb(234, 236, 240),
        ),
    };
    visuals.panel_fill = panel;
    visuals.window_fill = panel;
    visuals.faint_bg_color = faint;
    visuals.override_text_color = Some(text);
    visuals.selection.bg_fill = ACCENT.gamma_multiply(if theme == Theme::Dark { 0.55 } else { 0.35 });
    visuals.selection.stroke = Stroke::new(1.0, text);
    for widget in [
        &mut visuals.widgets.noninteractive,
        &mut visuals.widgets.inactive,
        &mut visuals.widgets.hovered,
        &mut visuals.widgets.active,
        &mut visuals.widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(5);
    }
    if theme == Theme::Light {
        // White fields on the nearly white panel.
        visuals.widgets.inactive.weak_bg_fill = Color32::WHITE;
        visuals.widgets.inactive.bg_fill = Color32::from_rgb(214, 218, 226);
        visuals.widgets.inactive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(190, 195, 204));
    }
    // The focused widget is drawn as active.
    visuals.widgets.active.bg_stroke = focus_ring();
    visuals
}

/// Outline of the focused widget.
pub fn focus_ring() -> Stroke {
    Stroke::new(2.0, CHOSEN)
}

/// The colour of a good result that is visible on the panel.
pub fn good(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(92, 200, 120) } else { Color32::from_rgb(24, 128, 56) }
}

/// The colour of a warning that is readable on the panel.
pub fn warning(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(255, 190, 80) } else { Color32::from_rgb(160, 84, 0) }
}

/// The colour of an error that is readable on the panel.
pub fn error(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(255, 120, 110) } else { Color32::from_rgb(190, 30, 30) }
}
