//! Whether a hand feels a scene: steady sound is hardly felt, so a modulation is offered.

use std::fmt;

use crate::device::profile::Profile;
use crate::device::stock::{self, Modulated};
use crate::scene::{Envelope, Liquid, Modulation, Scene, motion};

/// Hz; skin is most sensitive near it.
const FREQUENCY: f64 = 200.0;
/// Cycles per second from which a moving focus is felt without a modulation.
const FLUTTER: f64 = 20.0;

/// A modulation that makes a scene felt on a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// Hz
    pub frequency: f64,
    profile: Profile,
    /// Bits per second, if the board's line is too slow for more.
    slow: Option<u32>,
}

impl Offer {
    /// For a scene at rest, or in motion, on a board at a bit rate; `None` if it is felt, or not for a hand.
    pub fn new(scene: &Scene, moves: bool, profile: Profile, baud: u32) -> Option<Self> {
        let flutters = moves && motion::cycle(scene).is_some_and(|cycle| cycle.rate >= FLUTTER);
        if !is_steady(&scene.modulation) || flutters || !is_for_a_hand(scene) {
            return None;
        }
        let asked = Modulation { shape: Envelope::Sine, frequency: FREQUENCY, ..Modulation::default() };
        let fastest = match profile.answers() {
            true => None,
            false => match stock::modulated(profile, &asked, baud) {
                // It modulates all that it plays.
                Modulated::ByBoard(..) => return None,
                Modulated::Never(fastest) => Some(fastest),
                Modulated::Steady | Modulated::FromHere(_) | Modulated::OneFrequency => None,
            },
        };
        let frequency = fastest.map_or(FREQUENCY, |fastest| fastest.floor().max(1.0));
        Some(Self { frequency, profile, slow: fastest.map(|_| baud) })
    }

    /// The same modulation with this waveform.
    pub fn of(self, modulation: &Modulation) -> Modulation {
        Modulation { shape: Envelope::Sine, frequency: self.frequency, depth: 1.0, ..modulation.clone() }
    }

    /// Reason for the board's limit, as text.
    pub fn limit(self) -> Option<String> {
        let baud = self.slow?;
        let (name, frequency) = (self.profile.name(), self.frequency);
        Some(format!("{name} is switched on and off at most {frequency} times a second at {baud} baud"))
    }
}

impl fmt::Display for Offer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { frequency, .. } = self;
        write!(f, "steady sound is hardly felt: [modulation] shape = \"sine\", frequency = {frequency:?} ")?;
        match self.limit() {
            None => f.write_str("makes it felt"),
            Some(limit) => write!(f, "makes it felt a little; {limit}"),
        }
    }
}

/// Whether the envelope is always the same.
fn is_steady(modulation: &Modulation) -> bool {
    match modulation.shape {
        Envelope::Off => true,
        Envelope::Sine | Envelope::Square | Envelope::File => modulation.depth == 0.0,
        Envelope::Tones => modulation.tones.iter().all(|tone| tone.depth == 0.0),
    }
}

/// A scene with a liquid or a trap is for them, and so is the standing wave between opposed boards.
fn is_for_a_hand(scene: &Scene) -> bool {
    let mut visible = scene.targets.iter().filter(|target| target.visible).peekable();
    let is_liquid = scene.liquid != Liquid::default() || scene.aims_at_depression();
    let mut boards = scene.boards.iter();
    let are_opposed =
        boards.next().is_some_and(|first| boards.any(|board| board.normal.dot(first.normal) < 0.0));
    visible.peek().is_some() && !visible.any(|target| target.shape.is_trap()) && !is_liquid && !are_opposed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::opening;

    fn offer(text: &str, profile: Profile) -> Option<Offer> {
        let scene = opening::parse(&format!("format = 1\n{text}"), "a.toml".as_ref()).unwrap();
        Offer::new(&scene, true, profile, profile.baud())
    }

    #[test]
    fn a_steady_scene_for_a_hand_is_offered_200_hz() {
        let steady = [
            "[[target]]\n",
            "[[target]]\n[modulation]\nshape = \"sine\"\ndepth = 0.0\n",
            "[[target]]\n[motion]\npath = \"circle\"\nrate = 5.0\n",
            "[[target]]\n[[target]]\nkind = \"trap\"\nvisible = false\n",
        ];
        for text in steady {
            assert_eq!(offer(text, Profile::SonicSurfaceTactile), None, "it modulates by itself");
            let others = [Profile::SonicSurfaceTactile, Profile::Acoustophoretic512];
            for profile in Profile::choices().filter(|profile| !others.contains(profile)) {
                let offer = offer(text, profile).unwrap_or_else(|| panic!("{text} on {}", profile.name()));
                assert_eq!((offer.frequency, offer.limit()), (200.0, None), "{text}");
            }
        }
        let others = [
            "",
            "[[target]]\nvisible = false\n",
            "[[target]]\n[modulation]\nshape = \"square\"\nfrequency = 40.0\n",
            "[[target]]\n[motion]\npath = \"circle\"\nrate = 50.0\n",
            "[[target]]\n[liquid]\nname = \"water\"\n",
            "[[target]]\n[liquid]\ndepth = 0.01\n",
            "[[target]]\nkind = \"circle\"\n[solver]\ntarget = \"depression\"\n",
            "[[target]]\nkind = \"trap\"\n",
            "[[target]]\n[[board]]\n[[board]]\nat = [0, 0, 0.2]\nnormal = [0, 0, -1]\n",
        ];
        for text in others {
            assert_eq!(offer(text, Profile::Native), None, "{text}");
        }
    }

    #[test]
    fn a_slow_board_is_offered_what_it_can_play() {
        let profile = Profile::Acoustophoretic512;
        let offer = offer("[[target]]\n", profile).unwrap();
        let played = stock::modulated(profile, &offer.of(&Modulation::default()), profile.baud());
        assert_eq!(played, Modulated::FromHere(24.0));
        assert_eq!(
            offer.to_string(),
            "steady sound is hardly felt: [modulation] shape = \"sine\", frequency = 24.0 makes it felt a little; \
             acoustophoretic-512 is switched on and off at most 24 times a second at 250000 baud"
        );
    }
}
