//! Wirings: which channel of a board drives which element of a scene.
//!
//! Boards know channels, scenes know elements. A [`Wiring`] stands between them: a drive becomes [`Levels`] by channel,
//! and levels become a drive. It follows from the scene's table (`array.wiring`, or the pins of a board's own file), or
//! else from the board's own order; both are tables of `element,channel`.

use std::fmt;
use std::path::PathBuf;
use std::sync::LazyLock;

use crate::device::calibration::Calibration;
use crate::device::levels::Levels;
use crate::device::profile::Profile;
use crate::drive::Drive;
use crate::scene::check::MOST_ELEMENTS;
use crate::scene::{Placed, Scene, Size, Wire, Wires};
use crate::table::{Table, TableError};

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// The orders of known boards, by name.
        static PRESETS: LazyLock<Vec<(&str, Wires)>> = LazyLock::new(|| {
            vec![$(($name, of_board(include_str!(concat!("../../assets/wirings/", $name, ".csv"))))),*]
        });
    };
}

presets!("sonicsurface", "acoustophoretic-512", "acoustophoretic-512-asier");

/// The wires of an embedded table, which tests read.
fn of_board(csv: &str) -> Wires {
    let wires = read(csv.as_bytes(), csv.lines().filter(|line| line.starts_with(char::is_numeric)).count());
    Wires::new(wires.unwrap_or_default(), true, None)
}

/// Names of the orders of known boards.
pub(crate) fn presets() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|(name, _)| *name)
}

/// The order of a known board, for an array of its elements.
///
/// # Errors
/// The available names, for an unknown name; or an array of another size.
pub(crate) fn preset(name: &str, elements: usize) -> Result<Wires, String> {
    let Some((_, wires)) = PRESETS.iter().find(|(known, _)| *known == name) else {
        let names: Vec<_> = presets().collect();
        return Err(format!("no preset of that name: {}", names.join(", ")));
    };
    match wires.get().map_or(0, <[_]>::len) {
        own if own == elements => Ok(wires.clone()),
        own => Err(format!("the preset is of {own} elements, and the array has {elements}")),
    }
}

/// Reads CSV with the columns `element` and `channel` (both from 0), in any order; `elements` is their number in the
/// scene. Elements that are missing are not wired. Other columns are the user's own.
///
/// # Errors
/// An invalid row, duplicate elements or channels, or no wires.
pub(crate) fn read(csv: &[u8], elements: usize) -> Result<Vec<Option<Wire>>, TableError> {
    let mut table = Table::open(csv, ["element", "channel"], [])?;
    let mut wires: Vec<Option<Wire>> = vec![None; elements];
    let mut lines = std::collections::HashMap::new();
    while let Some(row) = table.next_row()? {
        let [element, channel] = row.required;
        let last = elements.saturating_sub(1);
        let element = whole(element, last)
            .ok_or_else(|| table.refusal(format!("element {element} is out of range (0-{last})")))?;
        let last = MOST_ELEMENTS as usize - 1;
        let channel = whole(channel, last)
            .ok_or_else(|| table.refusal(format!("channel {channel} is out of range (0-{last})")))?;
        let line = table.line();
        if let Some(first) = wires[element] {
            let reason = format!("element {element} is already wired in line {}", first.line);
            return Err(table.refusal(reason));
        }
        if let Some(first) = lines.insert(channel, line) {
            return Err(table.refusal(format!("channel {channel} is already wired in line {first}")));
        }
        wires[element] = Some(Wire { channel: channel as u32, line });
    }
    if lines.is_empty() {
        return Err(table.refusal("no element is wired"));
    }
    Ok(wires)
}

/// A whole number from 0 to `last`.
fn whole(number: f64, last: usize) -> Option<usize> {
    (number.fract() == 0.0 && (0.0..=last as f64).contains(&number)).then_some(number as usize)
}

/// The part of a scene's boards that one port drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    pub index: usize,
    /// Ports in all.
    pub of: usize,
}

impl Default for Share {
    fn default() -> Self {
        Self { index: 0, of: 1 }
    }
}

/// An array that does not match the board.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OtherArray {
    #[error("{array}, and {}", size(*profile, array.boards, *ports))]
    Size { profile: Profile, array: ArraySize, ports: usize },
    #[error("{}channel {channel} is out of range: {} has 0-{last}", at(from, *line), profile.name())]
    Channel { profile: Profile, from: Option<PathBuf>, line: u64, channel: usize, last: usize },
}

/// The size of a scene's array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArraySize {
    pub boards: usize,
    /// Columns and rows, if any.
    pub grid: Option<[u32; 2]>,
    /// Elements of all boards.
    pub elements: usize,
}

impl fmt::Display for ArraySize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { boards, grid, elements } = self;
        match (boards, grid) {
            (1, Some([columns, rows])) => {
                write!(f, "the scene's array has {columns} x {rows} elements (columns x rows)")
            }
            (_, Some([columns, rows])) => {
                write!(f, "the scene has {boards} boards of {columns} x {rows} elements (columns x rows)")
            }
            (_, None) => write!(f, "the scene's table of elements makes {elements} in all"),
        }
    }
}

/// The arrays that a board drives, as text.
fn size(profile: Profile, boards: usize, ports: usize) -> String {
    let each = if ports > 1 { format!(" at each of {ports} ports") } else { String::new() };
    match profile.shape() {
        Some([columns, rows]) => {
            let name = profile.name();
            let more = if boards > ports { "; `send` takes a --port for each board" } else { "" };
            format!(
                "{name} is {columns} x {rows}{each}: `array.wiring` names the channels of other arrays{more}"
            )
        }
        None => format!(
            "{} drives up to {} elements in any rows and columns{each}",
            profile.name(),
            profile.elements()
        ),
    }
}

fn at(from: &Option<PathBuf>, line: u64) -> String {
    from.as_ref().map_or_else(String::new, |path| format!("{}:{line}: ", path.display()))
}

/// A drive or a calibration of other elements than the scene's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {what} is of {own} elements, and the scene has {elements}")]
pub struct OtherCount {
    what: &'static str,
    own: usize,
    elements: usize,
}

/// The channel of each element of a scene on a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wiring {
    profile: Profile,
    channels: Vec<Option<usize>>,
}

impl Wiring {
    /// A board and its own array.
    pub fn own(profile: Profile) -> Self {
        Self { profile, channels: (0..profile.elements()).map(|n| Some(own_channel(profile, n))).collect() }
    }

    /// A board and a scene. Without wires, the array has the board's columns and rows (the pitch may differ), and
    /// several boards on a line correspond to several boards of the scene or to consecutive rows of one; or it has at
    /// most the elements of a board that drives any array. Several boards with a port or an address each drive one board
    /// of the scene each, or the next elements.
    ///
    /// # Errors
    /// An array of another size, or a wire to a channel that the board lacks.
    pub fn of(profile: Profile, scene: &Scene, share: Share) -> Result<Self, OtherArray> {
        let channels = match scene.wires() {
            Some(wires) => wired(profile, scene, share, wires)?,
            None => in_own_order(profile, scene, share)?.into_iter().map(Some).collect(),
        };
        let first = profile.elements() * share.index;
        let of_share = |channel: usize| channel.checked_sub(first).filter(|&own| own < profile.elements());
        Ok(Self { profile, channels: channels.into_iter().map(|it| it.and_then(of_share)).collect() })
    }

    /// Elements of the scene, wired or not.
    pub fn elements(&self) -> usize {
        self.channels.len()
    }

    /// Elements with a channel.
    pub fn wired(&self) -> impl DoubleEndedIterator<Item = usize> {
        (0..self.channels.len()).filter(|&element| self.channels[element].is_some())
    }

    /// The levels of a drive, calibrated.
    ///
    /// # Errors
    /// A drive or a calibration of another array.
    pub fn levels(&self, drive: &Drive, calibration: &Calibration) -> Result<Levels, OtherCount> {
        let elements = self.elements();
        for own in [drive.phases.len(), drive.amplitudes.len()] {
            if own != elements {
                return Err(OtherCount { what: "drive", own, elements });
            }
        }
        if ![0, elements].contains(&calibration.elements()) {
            return Err(OtherCount { what: "calibration", own: calibration.elements(), elements });
        }
        let mut levels = Levels::off(self.profile);
        for (element, channel) in self.channels.iter().enumerate() {
            let Some(channel) = channel else { continue };
            let (amplitude, phase) =
                calibration.corrected(element, drive.amplitudes[element], drive.phases[element]);
            levels.channels[*channel] = self.profile.level(amplitude, phase);
        }
        Ok(levels)
    }

    /// One element at full amplitude, for finding it; nothing if it is not wired.
    pub fn one(&self, element: usize) -> Levels {
        match self.channels.get(element).copied().flatten() {
            Some(channel) => Levels::one(self.profile, channel),
            None => Levels::off(self.profile),
        }
    }

    /// Neighbours in antiphase, `columns` to a row.
    pub fn checkerboard(&self, columns: usize) -> Levels {
        let columns = columns.max(1);
        let phase = |n: usize| if (n / columns + n % columns) % 2 == 1 { std::f64::consts::PI } else { 0.0 };
        let mut levels = Levels::off(self.profile);
        for (element, channel) in self.channels.iter().enumerate() {
            if let Some(channel) = channel {
                levels.channels[*channel] = self.profile.level(1.0, phase(element));
            }
        }
        levels
    }

    /// The drive that results from a drive by channel, such as [`Levels::drive`], without calibration.
    pub fn drive(&self, by_channel: &Drive) -> Drive {
        let of = |values: &[f64]| {
            let value = |channel: &Option<usize>| channel.and_then(|own| values.get(own).copied());
            self.channels.iter().map(|channel| value(channel).unwrap_or(0.0)).collect()
        };
        Drive { amplitudes: of(&by_channel.amplitudes), phases: of(&by_channel.phases) }
    }
}

/// The channels of one board of a kind, of which there may be several on a line.
fn of_one_board(profile: Profile) -> usize {
    match own_order(profile) {
        Some(order) => order.len(),
        None => profile.elements() / profile.devices().max(1),
    }
}

fn own_order(profile: Profile) -> Option<&'static [Option<Wire>]> {
    let name = profile.order()?;
    PRESETS.iter().find(|(known, _)| *known == name)?.1.get()
}

/// The channel of an element in the board's own order.
fn own_channel(profile: Profile, element: usize) -> usize {
    let Some(order) = own_order(profile) else { return element };
    let place = element % order.len();
    element - place + order[place].map_or(place, |wire| wire.channel as usize)
}

fn wired(
    profile: Profile,
    scene: &Scene,
    share: Share,
    wires: &Wires,
) -> Result<Vec<Option<usize>>, OtherArray> {
    let (each, all, one) = (scene.array.elements(), profile.elements() * share.of, of_one_board(profile));
    let last = if wires.repeats { one.min(all) - 1 } else { all - 1 };
    let channel = |element: usize| {
        let Some((board, Wire { channel, line })) = wires.wire(element, each) else { return Ok(None) };
        let (own, channel) = (channel as usize, board * one + channel as usize);
        if own > last || channel >= all {
            let channel = if own > last { own } else { channel };
            return Err(OtherArray::Channel { profile, from: wires.from.clone(), line, channel, last });
        }
        Ok(Some(channel))
    };
    (0..scene.elements()).map(channel).collect()
}

/// Columns and rows of a table of elements at the places of a regular grid, and each element's number in it.
fn grid(placed: &[Placed]) -> Option<([u32; 2], Vec<usize>)> {
    /// Spacings by which places may be off.
    const OFF: f64 = 0.25;
    let Size { extent, spacing } = Size::of(placed);
    let range = |of: fn(&Placed) -> f64| {
        let values = placed.iter().map(of);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| (low.min(it), high.max(it)))
    };
    let (x, y, z) = (range(|it| it.at.x), range(|it| it.at.y), range(|it| it.at.z));
    let is_flat = z.1 - z.0 < OFF * spacing && placed.iter().all(|it| it.normal.z > 0.99);
    if !is_flat || spacing <= 0.0 || extent > MOST_ELEMENTS as f64 * spacing {
        return None;
    }
    let count = |(low, high): (f64, f64)| ((high - low) / spacing).round() as usize + 1;
    let (columns, rows) = (count(x), count(y));
    if columns * rows != placed.len() {
        return None;
    }
    let mut taken = vec![false; placed.len()];
    let number = |it: &Placed| {
        let [across, up] = [(it.at.x - x.0) / spacing, (it.at.y - y.0) / spacing];
        let [column, row] = [across.round(), up.round()];
        let is_on = (across - column).abs() < OFF && (up - row).abs() < OFF;
        let number = row as usize * columns + column as usize;
        (is_on && !std::mem::replace(taken.get_mut(number)?, true)).then_some(number)
    };
    let numbers = placed.iter().map(number).collect::<Option<Vec<_>>>()?;
    Some(([columns as u32, rows as u32], numbers))
}

fn in_own_order(profile: Profile, scene: &Scene, share: Share) -> Result<Vec<usize>, OtherArray> {
    let (boards, elements) = (scene.boards.len().max(1), scene.elements());
    let (grid, numbers) = match scene.array.placed.get().filter(|_| scene.array.file.is_some()) {
        None => (scene.array.file.is_none().then_some([scene.array.columns, scene.array.rows]), None),
        // A board of any array takes a table in its order.
        Some(placed) => profile.shape().and_then(|_| grid(placed)).unzip(),
    };
    let together = grid.map(|[columns, rows]| [columns, rows.saturating_mul(boards as u32)]);
    // A board of the scene for each of those on the lines begins at its first channel.
    let (one, all) = (of_one_board(profile), profile.elements() * share.of);
    let (each, room) = if boards == all / one { (scene.array.elements(), one) } else { (elements, all) };
    let fits = match profile.shape() {
        Some([columns, rows]) => together == Some([columns, rows * share.of as u32]),
        None => each <= room,
    };
    if !fits {
        let array = ArraySize { boards, grid, elements };
        return Err(OtherArray::Size { profile, array, ports: share.of });
    }
    let number = |n: usize| match &numbers {
        Some(numbers) => n - n % numbers.len() + numbers[n % numbers.len()],
        None => n,
    };
    let channel = |n: usize| number(n) / each * room + own_channel(profile, number(n) % each);
    Ok((0..elements).map(channel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_preset_wires_all_of_its_channels_once() {
        for (name, wires) in &*PRESETS {
            let mut channels: Vec<_> =
                wires.get().unwrap().iter().map(|wire| wire.unwrap().channel).collect();
            channels.sort_unstable();
            assert!(channels.len() == 256 && channels.into_iter().eq(0..256), "{name}");
        }
    }
}
