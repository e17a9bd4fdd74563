//! Ultraino's remote control: text commands over UDP, one per packet or line. Point numbers start at 0; y points
//! upwards.

use glam::DVec3;

use crate::control::edit::Edit;
use crate::echo;
use crate::scene::{Shape, Target};

/// Ultraino's UDP port.
pub const PORT: u16 = 8085;
/// Limit of a packet in bytes, as in Ultraino.
pub const LONGEST: usize = 1024;
/// Edits that may wait for a `commit`.
const MOST: usize = 4096;
/// Limit of points per `create`.
const MOST_POINTS: usize = 1024;
/// Position of a new point until it is placed, m.
const NEW: DVec3 = DVec3::new(0.0, 0.0, 0.1);

/// The commands since the last `commit`, which applies them together: no partial pattern is played.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draft(Vec<Edit>);

impl Draft {
    /// Takes a packet's commands. A `commit` returns the combined change, which is then played.
    ///
    /// # Errors
    /// Bytes that are not Ultraino commands; all of them are discarded.
    pub fn take(&mut self, bytes: &[u8]) -> Result<Option<Vec<Edit>>, String> {
        if bytes.len() > LONGEST {
            return Err(format!("a packet of more than {LONGEST} bytes"));
        }
        let text = std::str::from_utf8(bytes).map_err(|_| "no text".to_owned())?;
        let (mut draft, mut done) = (self.clone(), None);
        for line in text.trim_matches('\0').lines().filter(|line| !line.trim().is_empty()) {
            if draft.word(line)? {
                let edits = std::mem::take(&mut draft.0);
                done.get_or_insert_with(Vec::new).extend(edits.into_iter().chain([Edit::Send(true)]));
            }
        }
        *self = draft;
        Ok(done)
    }

    /// Whether it is `commit`.
    fn word(&mut self, line: &str) -> Result<bool, String> {
        let parts: Vec<_> = line.split_ascii_whitespace().collect();
        let wrong = || {
            format!(
                "{}: the words are clear, create N, place I X Y Z, delete I, commit and update",
                echo::value(line)
            )
        };
        let word = parts.first().map(|word| word.to_ascii_lowercase()).ok_or_else(wrong)?;
        let edits = match (word.as_str(), &parts[1..]) {
            ("clear", []) => {
                self.0.clear();
                vec![Edit::Clear]
            }
            ("create", [count]) => {
                let count: usize = count.parse().map_err(|_| wrong())?;
                if count > MOST_POINTS {
                    return Err(format!("create {count}: {MOST_POINTS} points at most"));
                }
                let point = Edit::Add(Box::new(Target::new(Shape::Point { at: NEW })));
                vec![point; count]
            }
            ("place", [index, x, y, z]) => {
                let real =
                    |text: &str| text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(wrong);
                let (x, y, z) = (real(x)?, real(y)?, real(z)?);
                vec![Edit::At(number(index).ok_or_else(wrong)?, DVec3::new(x, -z, y))]
            }
            ("delete", [index]) => vec![Edit::Remove(number(index).ok_or_else(wrong)?)],
            ("commit", []) => return Ok(true),
            // Ultraino redraws its pictures; ours are always current.
            ("update", []) => Vec::new(),
            (_, _) => return Err(wrong()),
        };
        for edit in edits {
            self.keep(edit);
        }
        if self.0.len() > MOST {
            return Err(format!("more than {MOST} words without a commit"));
        }
        Ok(false)
    }

    /// Repeated placements of a point use no more memory.
    fn keep(&mut self, edit: Edit) {
        if let (Edit::At(number, _), Some(Edit::At(last, _))) = (&edit, self.0.last())
            && number == last
        {
            self.0.pop();
        }
        self.0.push(edit);
    }
}

fn number(index: &str) -> Option<usize> {
    index.parse::<usize>().ok()?.checked_add(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn committed(text: &str) -> Vec<Edit> {
        Draft::default().take(format!("{text}\ncommit").as_bytes()).unwrap().unwrap()
    }

    #[test]
    fn a_clear_forgets_the_words_before_it() {
        let add = Edit::Add(Box::new(Target::new(Shape::Point { at: NEW })));
        // No scene needs to have a tenth point.
        assert_eq!(
            committed("create 2\nplace 9 0 0.1 0\nclear\ncreate 1"),
            [Edit::Clear, add, Edit::Send(true)]
        );
        let mut draft = Draft::default();
        for _ in 0..=MOST / MOST_POINTS {
            assert_eq!(draft.take(b"create 1024\nclear"), Ok(None));
        }
    }

    #[test]
    fn only_the_placement_just_before_is_replaced() {
        let at = |number, x| Edit::At(number, DVec3::new(x, 0.0, 0.1));
        assert_eq!(
            committed("place 0 1 0.1 0\nplace 0 2 0.1 0\nplace 1 3 0.1 0\nplace 1 4 0.1 0\nplace 0 5 0.1 0"),
            [at(1, 2.0), at(2, 4.0), at(1, 5.0), Edit::Send(true)]
        );
    }
}
