//! Published arrays with arbitrary element positions.

/// Prefix of a preset's name in place of a file.
pub const PRESET: &str = "preset:";

macro_rules! tables {
    ($($name:literal),* $(,)?) => {
        const TABLES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../assets/arrays/", $name, ".csv")))),*];
    };
}

tables!("tinylev-72", "biglev-72", "autd3-249", "bowl-64", "hexagon-91", "spiral-64");

/// The table of a published array that a scene names.
///
/// # Errors
/// The available names, for an unknown name.
pub fn table(name: &str) -> Result<&'static str, String> {
    let found = TABLES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    found.ok_or_else(|| {
        let names: Vec<_> = TABLES.iter().map(|(known, _)| *known).collect();
        format!("no preset of that name: {}", names.join(", "))
    })
}
