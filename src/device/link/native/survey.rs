//! The survey of a native board and its line: identification, store, and error-free bit rates.

use std::collections::VecDeque;
use std::path::Path;

use web_time::{Duration, Instant};

use crate::device::link::native::ask::Asker;
use crate::device::link::native::connect;
use crate::device::link::native::session::{ANSWER, has_room};
use crate::device::link::shared::LEAD;
use crate::device::link::shared::LinkError;
use crate::device::native::line;
use crate::device::native::packet::{Body, Info, Kind, Outcome, Packet, REPLY, Status, Table};
use crate::device::port::Port;
use crate::device::profile::Profile;
use crate::device::statistics::Durations;
use crate::device::task;

/// Bit rates that adapters have, slowest first.
pub const RATES: [u32; 10] =
    [115_200, 230_400, 460_800, 921_600, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 6_000_000, 8_000_000];
/// Duration of a trial at a rate.
const TRIAL: Duration = Duration::from_millis(400);
/// Number of lost frames that ends a trial.
const MOST_LOST: u32 = 8;
/// Slots that are read back, those of the latest frames.
const READ_BACK: usize = 4;
/// Time for a device left at another rate to return to the default: 0.82 s.
const FALLBACK: Duration = Duration::from_millis(900);

/// Findings, in this order.
#[derive(Clone, Debug, PartialEq)]
pub enum Discovery {
    /// Identification, and initial counters.
    Board(Info, Status),
    Rate(Trial),
}

/// Frames at one bit rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    pub baud: u32,
    pub outcome: TrialOutcome,
}

#[derive(Clone, Debug, PartialEq)]
pub enum TrialOutcome {
    /// The adapter or the board does not have this rate.
    Impossible(String),
    Tried(Figures),
}

/// Results of a burst of frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    pub sent: u32,
    /// Frames not answered, spoiled or refused.
    pub lost: u32,
    /// Slots with contents other than sent.
    pub wrong: u32,
    pub frames_per_second: f64,
    /// Median time from a frame's last byte to its answer.
    pub round_trip: Duration,
}

impl Trial {
    /// Everything arrived.
    pub fn is_clean(&self) -> bool {
        matches!(&self.outcome, TrialOutcome::Tried(figures) if figures.sent > 0 && figures.lost + figures.wrong == 0)
    }
}

/// Surveys the device of address 0, reports findings, and returns the fastest error-free rate. The device is silent
/// meanwhile, and in power-up state afterwards.
///
/// # Errors
/// A missing port, or no answer from a native device.
pub async fn survey(path: &Path, tell: &mut dyn FnMut(Discovery)) -> Result<Option<u32>, LinkError> {
    let mut port = Port::open(path, Profile::Native.baud()).await?;
    let mut asker = Asker::new();
    let info = connect::introduce(&mut port, &mut asker, 0, &|| false).await?;
    if let Body::Status(status) = asker.reset(&mut port, 0).await?.body {
        tell(Discovery::Board(info, status));
    }
    let mut fastest = None;
    for baud in RATES.into_iter().filter(|&baud| baud <= connect::largest_baud(&info)) {
        let trial = Trial { baud, outcome: at_rate(&mut port, &mut asker, &info, baud).await? };
        match trial.is_clean() {
            true => fastest = Some(baud),
            false => come_back(&mut port, &mut asker, &info).await?,
        }
        tell(Discovery::Rate(trial));
    }
    come_back(&mut port, &mut asker, &info).await?;
    asker.reset(&mut port, 0).await?;
    Ok(fastest)
}

/// One rate: agreed upon, tried, and verified by reading back the store.
async fn at_rate(
    port: &mut Port,
    asker: &mut Asker,
    info: &Info,
    baud: u32,
) -> Result<TrialOutcome, LinkError> {
    let packet = match connect::agreeable(info, baud) {
        Ok(packet) => packet,
        Err(error) => return Ok(TrialOutcome::Impossible(error.to_string())),
    };
    asker.order(port, &packet).await?;
    if let Err(error) = port.set_baud(baud).await {
        return Ok(TrialOutcome::Impossible(error.to_string()));
    }
    Burst::new(info).run(port, asker).await.map(TrialOutcome::Tried)
}

/// Frames into idle slots, as fast as answers allow.
struct Burst {
    slots: u8,
    figures: Figures,
    on_the_way: VecDeque<Frame>,
    round_trips: Durations,
}

/// A frame on its way.
struct Frame {
    seq: u8,
    number: u32,
    gone: Instant,
}

impl Burst {
    fn new(info: &Info) -> Self {
        let slots = info.slots.saturating_sub(1) as u8;
        Self {
            slots,
            figures: Figures::default(),
            on_the_way: VecDeque::new(),
            round_trips: Durations::default(),
        }
    }

    /// Slot 0 plays, the others are written in turn.
    fn slot(&self, number: u32) -> u8 {
        1 + (number % u32::from(self.slots.max(1))) as u8
    }

    async fn run(mut self, port: &mut Port, asker: &mut Asker) -> Result<Figures, LinkError> {
        let begun = Instant::now();
        let mut written: Vec<u32> = Vec::new();
        // The trial ends early on a dead line.
        while begun.elapsed() < TRIAL && self.figures.lost < MOST_LOST {
            while self.has_room() && port.backlog() < LEAD {
                self.send(port).await?;
            }
            self.hear(port, asker, &mut written).await?;
        }
        while !self.on_the_way.is_empty() {
            self.hear(port, asker, &mut written).await?;
        }
        let seconds = begun.elapsed().as_secs_f64();
        self.figures.frames_per_second = f64::from(self.figures.sent - self.figures.lost) / seconds;
        self.figures.round_trip = self.round_trips.spread().map_or(Duration::ZERO, |spread| spread.median);
        self.figures.wrong = self.read_back(port, asker, &written).await?;
        Ok(self.figures)
    }

    /// The number of slots with contents other than sent, of the latest frames.
    async fn read_back(&self, port: &mut Port, asker: &mut Asker, written: &[u32]) -> Result<u32, LinkError> {
        let mut wrong = 0;
        // A small store holds fewer of them.
        for &number in written.iter().rev().take(READ_BACK.min(usize::from(self.slots))) {
            let digest = asker.ask(port, &Packet::digest(Table::Slot(self.slot(number)))).await?;
            let told = digest.and_then(|reply| match reply.body {
                Body::Digest(digest) => Some(digest.crc),
                Body::Info(_) | Body::Status(_) => None,
            });
            let right = told == Some(line::digest(pattern(number).as_flattened()));
            wrong += u32::from(!right);
        }
        Ok(wrong)
    }

    fn has_room(&self) -> bool {
        let first = self.on_the_way.front().map(|frame| frame.gone);
        has_room(self.on_the_way.len(), first, Instant::now())
    }

    async fn send(&mut self, port: &mut Port) -> Result<(), LinkError> {
        let number = self.figures.sent;
        let seq = number as u8;
        let packet = Packet::frame(self.slot(number), &pattern(number), false).numbered(seq);
        let gone = port.write(&packet.to_line()).await?;
        self.figures.sent += 1;
        self.on_the_way.push_back(Frame { seq, number, gone });
        Ok(())
    }

    async fn hear(
        &mut self,
        port: &mut Port,
        asker: &mut Asker,
        written: &mut Vec<u32>,
    ) -> Result<(), LinkError> {
        for reply in asker.replies(port, Duration::from_millis(1)).await? {
            let place = self.on_the_way.iter().position(|frame| frame.seq == reply.seq);
            let Some(place) = place.filter(|_| reply.code == Kind::Frame.code() + REPLY) else { continue };
            // Unanswered packets before it were lost.
            self.figures.lost += place as u32;
            let Some(frame) = self.on_the_way.drain(..=place).next_back() else { continue };
            self.round_trips.note(Instant::now().saturating_duration_since(frame.gone));
            match reply.outcome == Outcome::Ok {
                true => written.push(frame.number),
                false => self.figures.lost += 1,
            }
        }
        let now = Instant::now();
        while self.on_the_way.front().is_some_and(|frame| now > frame.gone + ANSWER) {
            self.on_the_way.pop_front();
            self.figures.lost += 1;
        }
        Ok(())
    }
}

/// Bytes that differ from frame to frame, with zeros and long runs without.
fn pattern(number: u32) -> [[u8; 2]; 256] {
    std::array::from_fn(|n| {
        let n = n as u32 + number;
        [(n * 37) as u8, (n / 3) as u8]
    })
}

/// Returns to the power-up rate: by agreement, or by waiting.
async fn come_back(port: &mut Port, asker: &mut Asker, info: &Info) -> Result<(), LinkError> {
    let usual = Profile::Native.baud();
    let agreed = asker.ask(port, &connect::agreeable(info, usual)?).await?;
    port.set_baud(usual).await?;
    if agreed.is_none() {
        task::sleep(FALLBACK).await;
    }
    asker.order(port, &Packet::status()).await.map(drop)
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeSet, HashSet};

    use super::*;
    use crate::device::native::model::Model;
    use crate::device::port::virtual_board;
    use crate::device::task::finish;

    fn info() -> Info {
        let Body::Info(info) = Model::new(7).apply(&Packet::info()).body else { panic!("no info") };
        info
    }

    fn port(profile: Profile) -> Port {
        finish(Port::open(&virtual_board(profile), Profile::Native.baud())).unwrap()
    }

    /// Results with a virtual board of `sent` frames, of which `lost` were lost.
    fn burst(profile: Profile, slots: u8, sent: u32, lost: u32) -> Figures {
        let figures = Figures { sent, lost, ..Figures::default() };
        let burst = Burst { slots, figures, ..Burst::new(&info()) };
        finish(burst.run(&mut port(profile), &mut Asker::new())).unwrap()
    }

    #[test]
    fn a_trial_is_clean_if_all_that_was_sent_arrived() {
        let tried = |sent, lost, wrong| Trial {
            baud: RATES[0],
            outcome: TrialOutcome::Tried(Figures { sent, lost, wrong, ..Figures::default() }),
        };
        assert!(tried(9, 0, 0).is_clean());
        let impossible = Trial { baud: RATES[0], outcome: TrialOutcome::Impossible("no rate".to_owned()) };
        for trial in [tried(0, 0, 0), tried(9, 1, 0), tried(9, 0, 1), impossible] {
            assert!(!trial.is_clean(), "{trial:?}");
        }
    }

    #[test]
    fn a_dead_line_ends_a_trial_within_a_window() {
        // A stock board does not answer.
        let figures = burst(Profile::SonicSurface, 63, MOST_LOST - 1, MOST_LOST - 1);
        assert!(figures.sent < 100, "{figures:?}");
        assert_eq!((figures.lost, figures.frames_per_second), (figures.sent, 0.0));
        let begun = Instant::now();
        let figures = burst(Profile::SonicSurface, 63, 100, MOST_LOST);
        let seconds = begun.elapsed().as_secs_f64();
        assert_eq!((figures.sent, figures.lost), (100, MOST_LOST));
        assert!(figures.frames_per_second >= f64::from(100 - MOST_LOST) / seconds, "{figures:?}");
    }

    #[test]
    fn refused_frames_count_as_lost() {
        // Slots from 64 on, which the board does not have.
        let figures = burst(Profile::Native, 255, 63, MOST_LOST - 1);
        assert!(figures.sent > 63, "{figures:?}");
        assert_eq!((figures.lost, figures.wrong), (figures.sent - 63 + MOST_LOST - 1, 0));
    }

    #[test]
    fn slots_with_other_contents_are_wrong() {
        for slots in [3, 64] {
            let (mut port, mut asker) = (port(Profile::Native), Asker::new());
            let mut burst = Burst::new(&Info { slots, ..info() });
            let sent: Vec<_> = (0..READ_BACK as u32).collect();
            sent.iter().for_each(|_| finish(burst.send(&mut port)).unwrap());
            let mut wrong =
                |written: &[u32]| finish(burst.read_back(&mut port, &mut asker, written)).unwrap();
            // A busy machine may miss an answer.
            assert!((0..5).any(|_| wrong(&sent) == 0), "{slots} slots");
            assert_eq!((wrong(&[7, 8]), wrong(&[])), (2, 0), "{slots} slots");
        }
    }

    #[test]
    fn every_slot_but_the_one_that_plays_is_written() {
        for slots in [2, 64, 256] {
            let burst = Burst::new(&Info { slots, ..info() });
            let written: BTreeSet<_> = (0..1000).map(|number| u16::from(burst.slot(number))).collect();
            assert!(written.into_iter().eq(1..slots), "{slots}");
        }
    }

    #[test]
    fn the_frames_of_a_trial_differ_and_hold_every_byte() {
        const FRAMES: u32 = 768;
        let frames: HashSet<_> = (0..FRAMES).map(pattern).collect();
        assert_eq!(frames.len(), FRAMES as usize);
        let bytes = |frame: &[[u8; 2]; 256]| frame.as_flattened().iter().copied().collect::<BTreeSet<_>>();
        assert!(frames.iter().all(|frame| bytes(frame).len() == 256));
    }
}
