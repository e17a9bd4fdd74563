//! Groups: targets selected together by a click on the map.

use std::collections::{BTreeMap, BTreeSet};

use crate::scene::{Scene, Target};

/// Stem of generated names; a number follows.
const STEM: &str = "Group";

/// A target and those of its group.
pub fn around(scene: &Scene, index: usize) -> BTreeSet<usize> {
    match scene.targets.get(index) {
        Some(target) if !target.group.is_empty() => {
            let is_in = |(_, other): &(usize, &Target)| other.group == target.group;
            scene.targets.iter().enumerate().filter(is_in).map(|(index, _)| index).collect()
        }
        _ => [index].into(),
    }
}

/// The group that all of the selected targets are in.
pub fn common<'a>(scene: &'a Scene, selection: &BTreeSet<usize>) -> Option<&'a str> {
    let mut groups = selection.iter().filter_map(|&index| scene.targets.get(index)).map(|it| &it.group);
    let first = groups.next().filter(|group| !group.is_empty())?;
    groups.all(|group| group == first).then_some(first)
}

/// Whether any of the selected targets is in a group.
pub fn any(scene: &Scene, selection: &BTreeSet<usize>) -> bool {
    selection.iter().any(|&index| scene.targets.get(index).is_some_and(|target| !target.group.is_empty()))
}

/// Groups the selection.
pub fn join(scene: &mut Scene, selection: &BTreeSet<usize>) {
    let name = fresh(&scene.targets, STEM);
    rename(scene, selection, &name);
}

/// Renames the group of the selection; an empty name ungroups it.
pub fn rename(scene: &mut Scene, selection: &BTreeSet<usize>, name: &str) {
    for &index in selection {
        if let Some(target) = scene.targets.get_mut(index) {
            name.clone_into(&mut target.group);
        }
    }
}

/// Gives copies, from index `first` on, groups of their own.
pub fn part(targets: &mut [Target], first: usize) {
    let mut names = BTreeMap::new();
    for index in first..targets.len() {
        let own = targets[index].group.clone();
        let is_taken = targets[..first].iter().any(|it| it.group == own);
        if own.is_empty() || !is_taken {
            continue;
        }
        let name = names.entry(own.clone()).or_insert_with(|| fresh(targets, &own));
        targets[index].group.clone_from(name);
    }
}

/// A name that no group has: the stem of another, and the next free number.
fn fresh(targets: &[Target], like: &str) -> String {
    let stem = like.trim_end_matches(|letter: char| letter.is_ascii_digit()).trim_end();
    let is_free = |name: &String| targets.iter().all(|target| target.group != *name);
    (1..).map(|number| format!("{stem} {number}")).find(is_free).unwrap_or_default()
}
