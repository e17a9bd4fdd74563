//! Tables of places: x, y and perhaps z in metres, with or without times and names of columns, for one target or more.
//!
//! | columns | |
//! |---|---|
//! | `x`, `y`, `z` | a row per place; without `z`, or with 0 in every row, targets keep their heights |
//! | `t` | s, the time of the row |
//! | `target` (or `id`) | the number of the row's target, from 1 |
//! | `x1`, `y1`, `z1`, `x2` … | places of several targets in one row |
//!
//! Units may stand behind names: `x [mm]`, `t (ms)`. Without names the columns are x,y or x,y,z or t,x,y,z.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::echo;
use crate::scene::motion::{Trace, TracePlace};
use crate::studio::routes::line::{FARTHEST, LineError, MOST_PLACES, Traced};
use crate::table::{Table, TableError};

/// The columns of rows without names, by their count.
const NAMELESS: [(usize, &str); 3] = [(2, "x,y"), (3, "x,y,z"), (4, "t,x,y,z")];
/// Names of the column of times, and of the column of targets.
const TIMES: [&str; 4] = ["t", "time", "seconds", "time_s"];
const TARGETS: [&str; 5] = ["target", "id", "trap", "point", "particle"];
/// Units of length and time, with their size in m and s.
const LENGTHS: [(&str, f64); 5] = [("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("um", 1e-6), ("in", 0.0254)];
const SECONDS: [(&str, f64); 3] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6)];

impl From<TableError> for LineError {
    fn from(TableError { line, reason }: TableError) -> Self {
        Self { line, reason }
    }
}

/// The traces of a table.
pub(super) fn read(text: &str) -> Result<Traced, LineError> {
    let head = Head::of(text)?;
    let moved = |error: TableError| LineError { line: (error.line - head.added).max(1), ..error.into() };
    let mut table = Table::open(head.text.as_bytes(), [], ["t", "target"]).map_err(moved)?;
    let mut series = |name| table.series(name).map_err(moved);
    let columns = [series("x")?, series("y")?, series("z")?];
    let [x, y, z] = &columns;
    let line = |line: u64| (line - head.added).max(1);
    if x.is_empty() || x.len() != y.len() || (!z.is_empty() && z.len() != x.len()) {
        let reason = "a path has the columns x,y or x,y,z, or x1,y1,z1,x2,y2,z2 of several targets, with t before \
                      them if it has times; or it is G-code";
        return Err(LineError::new(line(table.line()), reason));
    }
    if table.has("target") && (x.len() > 1 || head.is_numbered) {
        return Err(LineError::new(
            line(table.line()),
            "give either a column of targets or numbered columns",
        ));
    }
    let mut traces: BTreeMap<Option<usize>, Trace> = BTreeMap::new();
    let mut rows = 0;
    while let Some(row) = table.next_row().map_err(moved)? {
        let refuse = |reason: String| LineError::new(line(table.line()), reason);
        rows += 1;
        if rows > MOST_PLACES {
            return Err(refuse(format!("more than the {MOST_PLACES} rows that a path may have")));
        }
        let [time, target] = row.optional;
        let time = time.map(|time| time * head.second);
        for number in 0..x.len() {
            let value = |axis: usize| {
                let Some(&place) = columns[axis].get(number) else { return Ok(0.0) };
                let name = ["x", "y", "z"][axis];
                let value = table.value(name, place).map_err(moved)?;
                let value =
                    value.ok_or_else(|| refuse(format!("{name} = nan: must be a number in every row")))?;
                let metres = value * head.metre;
                if metres.abs() > FARTHEST {
                    return Err(refuse(format!(
                        "{name} = {metres} m is farther than {FARTHEST} m: places are in metres, or name the unit, as in \
                         `{name} [mm]`"
                    )));
                }
                Ok(metres)
            };
            let at = DVec3::new(value(0)?, value(1)?, value(2)?);
            let own = match target {
                Some(own) if own.fract() == 0.0 && own >= 1.0 && own < 1e9 => Some(own as usize - 1),
                Some(own) => return Err(refuse(format!("target = {own}: must be its number, from 1"))),
                None => head.is_numbered.then_some(number),
            };
            let trace = traces.entry(own).or_default();
            let before = trace.places.last().and_then(|place| place.time);
            if let (Some(time), Some(before)) = (time, before)
                && time <= before
            {
                return Err(refuse(format!(
                    "t = {time}: must be later than {before} s, the time of the row before"
                )));
            }
            trace.target = own;
            trace.has_height |= at.z != 0.0;
            trace.places.push(TracePlace { at, time, jumps: false });
        }
    }
    if traces.is_empty() {
        return Err(LineError::new(line(table.line()), "there are no places in it"));
    }
    Ok((traces.into_values().collect(), Vec::new()))
}

/// A table with uniform names of columns.
struct Head {
    text: String,
    /// Lines that the table has more than the file.
    added: u64,
    /// Whether columns have the numbers of targets.
    is_numbered: bool,
    /// Size of the units in m and s.
    metre: f64,
    second: f64,
}

impl Head {
    fn of(text: &str) -> Result<Self, LineError> {
        let is_remark = |line: &str| line.is_empty() || line.starts_with(['#', '%']);
        let at = text.lines().position(|line| !is_remark(line.trim()));
        let Some(at) = at else { return Err(LineError::new(1, "the file is empty")) };
        let lines: Vec<_> = text.lines().collect();
        let names = lines[at].trim();
        let separator = [',', ';', '\t', ' '].into_iter().find(|separator| names.contains(*separator));
        let separator = separator.unwrap_or(',');
        let fields: Vec<_> =
            names.split(separator).map(str::trim).filter(|field| !field.is_empty()).collect();
        let is_number = |field: &&str| field.replace(',', ".").parse::<f64>().is_ok();
        let mut head = Self { text: String::new(), added: 0, is_numbered: false, metre: 1.0, second: 1.0 };
        let mut own = |line: &str| head.text.extend([line, "\n"]);
        let remark = |line: &&str| line.trim_start().starts_with('%');
        let rest = |line: &str| if remark(&line) { format!("#{line}") } else { line.to_owned() };
        if fields.iter().all(is_number) {
            let named = NAMELESS.iter().find(|(count, _)| *count == fields.len());
            let Some((_, columns)) = named else {
                let count = fields.len();
                let reason = format!(
                    "{count} columns without names: x,y or x,y,z or t,x,y,z need none, others a line with their names"
                );
                return Err(LineError::new(at as u64 + 1, reason));
            };
            own(&uniform(columns, separator));
            lines.iter().for_each(|line| own(&rest(line)));
            head.added = 1;
            return Ok(head);
        }
        let (mut columns, mut units) = (Vec::new(), [None, None]);
        for field in &fields {
            let Column { name, number, unit } = Column::of(field);
            if ["x0", "y0", "z0"].contains(&&*name) {
                let reason = format!("`{}`: targets are numbered from 1", echo::value(field));
                return Err(LineError::new(at as u64 + 1, reason));
            }
            let is_time = name == "t";
            let known: &[(&str, f64)] = if is_time { &SECONDS } else { &LENGTHS };
            let is_place = ["x", "y", "z"].contains(&&*name);
            if (is_time || is_place) && !unit.is_empty() {
                let Some((_, size)) = known.iter().find(|(known, _)| *known == unit) else {
                    let reason = format!("the unit of `{}` is not known", echo::value(field));
                    return Err(LineError::new(at as u64 + 1, reason));
                };
                units[usize::from(is_time)].get_or_insert(*size);
            }
            head.is_numbered |= is_place && number.is_some();
            columns.push(if is_place { format!("{name}{}", number.unwrap_or(1) - 1) } else { name });
        }
        (head.metre, head.second) = (units[0].unwrap_or(1.0), units[1].unwrap_or(1.0));
        let mut text = String::new();
        for (index, line) in lines.iter().enumerate() {
            text += &if index == at { columns.join(&separator.to_string()) } else { rest(line) };
            text.push('\n');
        }
        head.text = text;
        Ok(head)
    }
}

/// Names of columns as in a table with numbered places.
fn uniform(columns: &str, separator: char) -> String {
    let number = |name: &str| if name == "t" { name.to_owned() } else { format!("{name}0") };
    columns.split(',').map(number).collect::<Vec<_>>().join(&separator.to_string())
}

/// A name of a column, in parts.
struct Column {
    name: String,
    /// Of a target, from 1.
    number: Option<usize>,
    unit: String,
}

impl Column {
    fn of(field: &str) -> Self {
        let plain = field.trim_matches(['"', '\'']).trim().to_lowercase().replace(['µ', 'μ'], "u");
        let end = plain.find(['[', '(', '/']).unwrap_or(plain.len());
        let (name, unit) = plain.split_at(end);
        let mut unit = unit.trim_matches(['[', ']', '(', ')', '/', ' ']).to_owned();
        let mut name = name.trim().to_owned();
        for (known, _) in LENGTHS.iter().chain(&SECONDS) {
            if let Some(short) = name.strip_suffix(known).and_then(|short| short.strip_suffix('_')) {
                (name, unit) = (short.to_owned(), (*known).to_owned());
                break;
            }
        }
        if TIMES.contains(&&*name) {
            return Self { name: "t".to_owned(), number: None, unit };
        }
        if TARGETS.contains(&&*name) {
            return Self { name: "target".to_owned(), number: None, unit };
        }
        let letters = name.trim_end_matches(|digit: char| digit.is_ascii_digit());
        let number = name[letters.len()..].parse().ok().filter(|number| *number > 0);
        match letters.trim_end_matches('_') {
            axis @ ("x" | "y" | "z") if number.is_some() => Self { name: axis.to_owned(), number, unit },
            _ => Self { name, number: None, unit },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(text: &str) -> Vec<Vec<DVec3>> {
        let (traces, _) = read(text).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        traces.iter().map(|trace| trace.places.iter().map(|place| place.at).collect()).collect()
    }

    #[test]
    fn tables_of_every_usual_layout_hold_the_same_places() {
        let wanted = [DVec3::new(0.01, 0.02, 0.1), DVec3::new(-0.03, 0.0, 0.12)];
        for text in [
            "x,y,z\n0.01,0.02,0.1\n-0.03,0,0.12\n",
            "0.01,0.02,0.1\n-0.03,0,0.12",
            "# by hand\n\nZ;Y;X\n0,1;0,02;0,01\n0,12;0;-0,03\n",
            "% by Matlab\n0.01 0.02 0.1\n-0.03 0 0.12\n",
            "x [mm]\ty [mm]\tz [mm]\n10\t20\t100\n-30\t0\t120\n",
            "x_mm,y_mm,z_mm,remark\n10,20,100,start\n-30,0,120,end\n",
            "t,x,y,z\n0,0.01,0.02,0.1\n0.5,-0.03,0,0.12\n",
            "2,0.01,0.02,0.1\r\n2.5,-0.03,0,0.12\r\n",
            "time (ms),X (cm),Y (cm),Z (cm)\n2,1,2,10\n502,-3,0,12\n",
        ] {
            let read = places(text);
            let [own] = &read[..] else { panic!("{text:?}") };
            assert!(own.iter().zip(wanted).all(|(a, b)| a.distance(b) < 1e-12), "{text:?}: {own:?}");
            let (traces, _) = super::read(text).unwrap();
            let times: Vec<_> = traces[0].places.iter().filter_map(|place| place.time).collect();
            assert!(times.is_empty() || (times[1] - times[0] - 0.5).abs() < 1e-12, "{text:?}: {times:?}");
        }
    }

    #[test]
    fn several_targets_stand_in_columns_or_in_rows() {
        let [a, b, c, d] = [0.01, 0.02, 0.03, 0.04].map(|x| DVec3::new(x, 0.0, 0.1));
        for text in [
            "x1,y1,z1,x2,y2,z2\n0.01,0,0.1,0.03,0,0.1\n0.02,0,0.1,0.04,0,0.1\n",
            "x,y,z,id\n0.01,0,0.1,1\n0.03,0,0.1,2\n0.02,0,0.1,1\n0.04,0,0.1,2\n",
        ] {
            assert_eq!(places(text), [[a, b], [c, d]], "{text}");
            let (traces, _) = read(text).unwrap();
            assert_eq!(traces.iter().map(|trace| trace.target).collect::<Vec<_>>(), [Some(0), Some(1)]);
        }
        for (text, has_height) in
            [("x,y\n0,0\n1,1\n", false), ("x,y,z\n0,0,0\n1,1,0\n", false), ("0,0,0.1\n", true)]
        {
            assert_eq!(read(text).unwrap().0[0].has_height, has_height, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, error) in [
            ("", "1: the file is empty"),
            ("x,y,z\n", "1: there are no places"),
            ("a,b\n1,2\n", "1: a path has the columns x,y or x,y,z"),
            ("x,y,z\n1,2,0\n3,zero,1\n", "3: y = `zero`: not a finite number"),
            ("1,2,0\n3,zero,1\n", "2: y = `zero`: not a finite number"),
            ("0,1,2,0\n0,3,2,1\n", "2: t = 0: must be later than 0 s"),
            (
                "x,y,z\n30,20,100\n",
                "2: x = 30 m is farther than 10 m: places are in metres, or name the unit",
            ),
            ("1,2,3,4,5\n", "1: 5 columns without names"),
            ("x [ft],y [ft]\n1,2\n", "1: the unit of `x [ft]` is not known"),
            ("x0,y0,x1,y1\n0,0,1,1\n", "1: `x0`: targets are numbered from 1"),
            ("x,y,id\n1,2,0\n", "2: target = 0: must be its number, from 1"),
            ("x,y\n1,nan\n", "2: y = nan: must be a number"),
        ] {
            let said = read(text).unwrap_err().to_string();
            assert!(said.starts_with(error), "{text:?}: {said}");
        }
    }
}
