//! The licences listed in release archives are those that cargo-deny allows for dependencies.

use std::collections::BTreeSet;

use serde::Deserialize;

#[derive(Deserialize)]
struct Deny {
    licenses: Licences,
}

#[derive(Deserialize)]
struct Licences {
    allow: BTreeSet<String>,
    exceptions: Vec<Exception>,
}

#[derive(Deserialize)]
struct Exception {
    name: String,
    allow: Vec<String>,
}

fn read(name: &str) -> String {
    std::fs::read_to_string(format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn archives_list_the_allowed_licences_of_dependencies() {
    #[derive(Deserialize)]
    struct About {
        accepted: BTreeSet<String>,
    }

    let text = read("about.toml");
    let about: About = toml::from_str(&text).unwrap();
    let Deny { licenses } = toml::from_str(&read("deny.toml")).unwrap();
    assert_eq!(about.accepted, licenses.allow);
    let table: toml::Table = toml::from_str(&text).unwrap();
    for Exception { name, allow } in licenses.exceptions {
        let accepted: Vec<String> = table[&name]["accepted"].clone().try_into().unwrap();
        assert_eq!(accepted, allow, "{name}");
    }
}
