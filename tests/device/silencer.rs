//! The silencer of the native device's model: phases and amplitudes change by steps.

use sonoglyph::device::native::model::Model;
use sonoglyph::device::native::packet::Packet;

use crate::native::{apply, playing, ramp, run};

#[test]
fn an_amplitude_moves_by_its_step_and_stops_at_its_level() {
    for (step, level) in [(0x0080, 30), (0x0100, 120), (0x0600, 100), (0xFFFF, 90)] {
        let mut model = Model::new(8);
        // The width of a pulse is its amplitude.
        apply(&mut model, &Packet::widths(&ramp()));
        apply(&mut model, &Packet::silencer(0xFFFF, step));
        apply(&mut model, &Packet::enable(1000));
        let (step, most) = (u32::from(step), u32::from(level) << 8);
        let mut moves = |slot: u8, level: u8, moved: &dyn Fn(u32) -> u32| {
            apply(&mut model, &Packet::frame(slot, &[[0, level]; 256], true));
            // It plays the sweep before the packet.
            model.period();
            for periods in 1..=most / step + 3 {
                let width = u32::from(model.period()[0].width);
                assert_eq!(width, moved(step * periods) >> 8, "{step:#x} to {level}, {periods} periods");
            }
        };
        moves(1, level, &|by| by.min(most));
        moves(2, 0, &|by| most.saturating_sub(by));
    }
}

#[test]
fn a_muted_device_is_off_within_256_periods_however_slow_its_silencer() {
    for (step, periods) in [(0x0001, 256), (0x0100, 256), (0x0600, 44), (0xFFFF, 2)] {
        let mut model = playing(7, &[0; 256]);
        // One element alone.
        let mut pairs = [[0, 0]; 256];
        pairs[7] = [0, 255];
        apply(&mut model, &Packet::frame(2, &pairs, true));
        run(&mut model, 2);
        apply(&mut model, &Packet::silencer(0x0300, step));
        apply(&mut model, &Packet::mute());
        let off = (1..=300).find(|_| {
            model.period();
            !model.outputs_on()
        });
        assert_eq!(off, Some(periods), "{step:#x}");
    }
}

#[test]
fn an_element_that_moves_alone_reaches_its_level() {
    let mut model = playing(8, &[0; 256]);
    run(&mut model, 50);
    apply(&mut model, &Packet::silencer(0x0100, 0x0100));
    let mut phases = [0; 256];
    phases[0] = 40;
    apply(&mut model, &Packet::phases(2, 255, &phases, true));
    run(&mut model, 60);
    let played = *model.played();
    assert_eq!(played[0].rise.wrapping_sub(played[1].rise), 40);
}

#[test]
fn the_silencer_turns_phases_the_short_way() {
    let mut model = playing(8, &[250; 256]);
    apply(&mut model, &Packet::silencer(0x0100, 0xFFFF));
    apply(&mut model, &Packet::phases(2, 255, &[6; 256], true));
    let rises: Vec<_> = (0..15).map(|_| i32::from(model.period()[0].rise)).collect();
    let steps: Vec<_> = rises.windows(2).map(|pair| (pair[1] - pair[0]).rem_euclid(256)).collect();
    assert_eq!(steps.iter().sum::<i32>(), 12);
    assert!(steps.iter().all(|&step| step <= 1), "{rises:?}");
}
