//! Every dependency may be used: its licence is one of those that deny.toml allows.

use std::collections::BTreeSet;
use std::process::Command;

#[derive(serde::Deserialize)]
struct Deny {
    licenses: Licenses,
}

#[derive(serde::Deserialize)]
struct Licenses {
    allow: Vec<String>,
}

#[test]
fn every_dependency_has_an_allowed_licence() {
    let folder = env!("CARGO_MANIFEST_DIR");
    let deny: Deny =
        toml::from_str(&std::fs::read_to_string(format!("{folder}/deny.toml")).unwrap()).unwrap();
    let allowed: Vec<_> =
        deny.licenses.allow.iter().map(|name| spdx::Licensee::parse(name).unwrap()).collect();
    // What is built on some platform; Cargo.lock also names what no feature asks for.
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--all-features", "--target", "all", "--edges", "normal,build,dev"])
        .args(["--prefix", "none", "--format", "{p}|{l}"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let listed = String::from_utf8(output.stdout).unwrap();
    let packages: BTreeSet<_> = listed.lines().map(|line| line.trim_end_matches(" (*)")).collect();
    assert!(packages.len() > 50, "{} packages", packages.len());
    for package in packages {
        let (name, licence) =
            package.split_once('|').unwrap_or_else(|| panic!("{package} states no licence"));
        let expression = spdx::Expression::parse_mode(licence, spdx::ParseMode::LAX).unwrap();
        let met =
            expression.evaluate(|requirement| allowed.iter().any(|licensee| licensee.satisfies(requirement)));
        assert!(met, "{name}: {licence} is not allowed");
    }
}
