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

use crate::scene::motion::{Trace, TracePlace};
use crate::studio::routes::limits::{FARTHEST, MOST_PLACES, Traced};
use crate::table::{Order, Table, TableError};

/// The columns of rows without names.
const NAMELESS: [Order; 3] = [&["x", "y"], &["x", "y", "z"], &["time", "x", "y", "z"]];

/// The traces of a table.
pub(super) fn read(bytes: &[u8]) -> Result<Traced, TableError> {
    let mut table = Table::in_order(bytes, [], ["x", "y", "z", "time", "target"], &NAMELESS)?;
    let [x, y, z] = ["x", "y", "z"].map(|name| table.series(name, 1));
    let series = [x?, y?, z?];
    let [has_x, has_y] = ["x", "y"].map(|name| table.has(name));
    let [across, up, height] = series.each_ref().map(Vec::len);
    let is_numbered = across > 0;
    let is_complete = if is_numbered {
        !has_x && !has_y && across == up && (height == 0 || height == across)
    } else {
        has_x && has_y
    };
    if !is_complete {
        let reason = "a path has the columns x,y or x,y,z, or x1,y1,z1,x2,y2,z2 of several targets, with t before \
                      them if it has times; or it is G-code";
        return Err(table.refusal(reason));
    }
    if let Some(zero) = ["x0", "y0", "z0"].into_iter().find(|name| table.place(&[name]).is_some()) {
        return Err(table.refusal(format!("`{zero}`: targets are numbered from 1")));
    }
    if is_numbered && table.has("target") {
        return Err(table.refusal("give either a column of targets or numbered columns"));
    }
    let mut traces: BTreeMap<Option<usize>, Trace> = BTreeMap::new();
    let mut rows = 0;
    while let Some(row) = table.next_row()? {
        rows += 1;
        if rows > MOST_PLACES {
            return Err(table.refusal(format!("more than the {MOST_PLACES} rows that a path may have")));
        }
        let [x, y, z, time, target] = row.optional;
        let mut add = |target: Option<usize>, place: [f64; 3]| {
            let at = DVec3::from_array(place);
            for (name, metres) in ["x", "y", "z"].into_iter().zip(place) {
                if metres.abs() > FARTHEST {
                    return Err(table.refusal(format!(
                        "{name} = {metres} m is farther than {FARTHEST} m: places are in metres, or name the unit, as in \
                         `{name} [mm]`"
                    )));
                }
            }
            let trace = traces.entry(target).or_default();
            let before = trace.places.last().and_then(|place| place.time);
            if let (Some(time), Some(before)) = (time, before)
                && time <= before
            {
                return Err(table.refusal(format!(
                    "t = {time}: must be later than {before} s, the time of the row before"
                )));
            }
            trace.target = target;
            trace.has_height |= at.z != 0.0;
            trace.places.push(TracePlace { at, time, jumps: false });
            Ok(())
        };
        if !is_numbered {
            let number = match target {
                Some(own) if own.fract() == 0.0 && (1.0..1e9).contains(&own) => Some(own as usize - 1),
                Some(own) => {
                    return Err(table.refusal(format!("target = {own}: must be its number, from 1")));
                }
                None => None,
            };
            add(number, [x, y, z].map(Option::unwrap_or_default))?;
            continue;
        }
        for number in 0..across {
            let mut place = [0.0; 3];
            for ((own, name), columns) in place.iter_mut().zip(["x", "y", "z"]).zip(&series) {
                let Some(&column) = columns.get(number) else { continue };
                let name = format!("{name}{}", number + 1);
                let value = table.value(&name, column)?;
                *own = value
                    .ok_or_else(|| table.refusal(format!("{name} = nan: must be a number in every row")))?;
            }
            add(Some(number), place)?;
        }
    }
    if traces.is_empty() {
        return Err(table.refusal("there are no places in it"));
    }
    Ok((traces.into_values().collect(), Vec::new()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(text: &str) -> Vec<Vec<DVec3>> {
        let (traces, _) = read(text.as_bytes()).unwrap_or_else(|error| panic!("{text:?}: {error}"));
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
            let found = places(text);
            let [own] = &found[..] else { panic!("{text:?}") };
            assert!(own.iter().zip(wanted).all(|(a, b)| a.distance(b) < 1e-12), "{text:?}: {own:?}");
            let (traces, _) = read(text.as_bytes()).unwrap();
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
            let (traces, _) = read(text.as_bytes()).unwrap();
            assert_eq!(traces.iter().map(|trace| trace.target).collect::<Vec<_>>(), [Some(0), Some(1)]);
        }
        for (text, has_height) in
            [("x,y\n0,0\n1,1\n", false), ("x,y,z\n0,0,0\n1,1,0\n", false), ("0,0,0.1\n", true)]
        {
            assert_eq!(read(text.as_bytes()).unwrap().0[0].has_height, has_height, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, error) in [
            ("", "1: the table is empty"),
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
            ("x [ft],y [ft]\n1,2\n", "1: the column `x` is in `ft`: must be m, cm, mm, um, nm"),
            ("x0,y0,x1,y1\n0,0,1,1\n", "1: `x0`: targets are numbered from 1"),
            ("x,y,id\n1,2,0\n", "2: target = 0: must be its number, from 1"),
            ("x,y\n1,nan\n", "2: y = `nan`: not a finite number"),
        ] {
            let said = read(text.as_bytes()).unwrap_err().to_string();
            assert!(said.starts_with(error), "{text:?}: {said}");
        }
    }
}
