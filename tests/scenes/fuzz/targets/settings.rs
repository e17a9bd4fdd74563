//! The window's settings: any file gives values within their limits, which survive writing.

use sonoglyph::app::settings::Settings;

use super::is_one_line;

pub fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let settings = match Settings::parse(text) {
        Ok(settings) => settings,
        Err(why) => return is_one_line(&why),
    };
    assert!(settings.size.iter().all(|side| (150.0..=16_384.0).contains(side)), "{settings:?}");
    let place = settings.position.unwrap_or([0.0; 2]);
    assert!(place.iter().all(|x| (-16_384.0..=16_384.0).contains(x)), "{settings:?}");
    assert!((100.0..=1000.0).contains(&settings.panel_width), "{settings:?}");
    assert!((50.0..=1000.0).contains(&settings.section_height), "{settings:?}");
    assert!((1e-4..=0.1).contains(&settings.grid), "{settings:?}");
    assert!(settings.recent.len() <= 10, "{settings:?}");
    let written = toml::to_string(&settings).expect("settings serialise");
    assert_eq!(Settings::parse(&written), Ok(settings));
}
