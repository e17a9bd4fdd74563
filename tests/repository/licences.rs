//! Every dependency may be used: its licence is one of those that deny.toml allows, to all crates or to this one.

#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

use std::collections::BTreeSet;
use std::process::Command;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

#[derive(serde::Deserialize)]
struct Deny {
    licenses: Licences,
}

#[derive(serde::Deserialize)]
struct Licences {
    allow: Vec<String>,
    exceptions: Vec<Exception>,
}

#[derive(serde::Deserialize)]
struct Exception {
    name: String,
    allow: Vec<String>,
}

fn meets(expression: &str, allowed: &[String]) -> bool {
    let expression = spdx::Expression::parse_mode(expression, spdx::ParseMode::LAX).unwrap();
    let allowed: Vec<_> = allowed.iter().map(|name| spdx::Licensee::parse(name).unwrap()).collect();
    expression.evaluate(|requirement| allowed.iter().any(|licensee| licensee.satisfies(requirement)))
}

impl Licences {
    fn read() -> Self {
        let text = std::fs::read_to_string(format!("{FOLDER}/deny.toml")).unwrap();
        toml::from_str::<Deny>(&text).unwrap().licenses
    }

    fn exception(&self, name: &str) -> Option<&Exception> {
        self.exceptions.iter().find(|exception| exception.name == name)
    }

    fn allow(&self, name: &str, expression: &str) -> bool {
        let own = self.exception(name).map_or(&[][..], |exception| &exception.allow);
        meets(expression, &[&self.allow[..], own].concat())
    }
}

/// Name and licence of what is built on some platform; Cargo.lock also names what no feature asks for.
fn packages() -> BTreeSet<(String, String)> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--all-features", "--target", "all", "--edges", "normal,build,dev"])
        .args(["--prefix", "none", "--format", "{p}|{l}"])
        .current_dir(FOLDER)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let parted = |line: &str| {
        let line = line.trim_end_matches(" (*)");
        let (package, licence) = line.split_once('|').unwrap_or_else(|| panic!("{line} states no licence"));
        (package.split(' ').next().unwrap().to_owned(), licence.to_owned())
    };
    String::from_utf8(output.stdout).unwrap().lines().map(parted).collect()
}

#[test]
fn every_dependency_has_an_allowed_licence() {
    let (licences, packages) = (Licences::read(), packages());
    assert!(packages.len() > 50, "{} packages", packages.len());
    for (name, licence) in &packages {
        assert!(licences.allow(name, licence), "{name}: {licence} is not allowed");
    }
    for Exception { name, allow } in &licences.exceptions {
        let is_needed = packages.iter().any(|(own, licence)| own == name && !meets(licence, &licences.allow));
        assert!(is_needed, "{name} does not need an exception for {allow:?}");
    }
}

#[test]
fn an_exception_holds_for_its_crate_alone() {
    let licences = Licences::read();
    assert!(licences.allow("serialport", "MPL-2.0") && !licences.allow("serialport", "GPL-3.0"));
    assert!(!licences.allow("serial", "MPL-2.0") && licences.allow("serial", "MPL-2.0 OR MIT"));
}

#[test]
fn archives_take_the_licences_that_dependencies_may_have() {
    #[derive(serde::Deserialize)]
    struct About {
        accepted: BTreeSet<String>,
    }

    let text = std::fs::read_to_string(format!("{FOLDER}/about.toml")).unwrap();
    let about: About = toml::from_str(&text).unwrap();
    let licences = Licences::read();
    assert_eq!(about.accepted, licences.allow.into_iter().collect());
    let table: toml::Table = toml::from_str(&text).unwrap();
    for Exception { name, allow } in licences.exceptions {
        let accepted: Vec<String> = table[&name]["accepted"].clone().try_into().unwrap();
        assert_eq!(accepted, allow, "{name}");
    }
}
