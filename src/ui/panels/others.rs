//! The panel of remote control by other programs: on or off, addresses, and counts.

use egui::{RichText, Ui};

use crate::ui::panels::form::heading;
use crate::ui::panels::{fact, form};
use crate::ui::{IN_PAGE, command::Command, shown::Shown};

pub fn show(shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    // A page has no sockets.
    if IN_PAGE {
        return;
    }
    ui.separator();
    heading(ui, "Remote control");
    let mut serves = shown.serving.is_some();
    let tip = "Programs of this computer may move targets, and start and stop a connected board, over OSC and WebSocket";
    if ui.checkbox(&mut serves, "Allow OSC and WebSocket control").on_hover_text(tip).changed() {
        commands.push(Command::Serve(serves));
    }
    let Some(serving) = &shown.serving else { return };
    for address in &serving.addresses {
        ui.add(egui::Label::new(RichText::new(address).monospace()).selectable(true));
    }
    form(ui, "others", |ui| {
        fact(ui, ("Packets", "Packets and messages that came"), serving.packets.to_string());
        fact(ui, ("Changes", "Messages that changed the scene or its playback"), serving.changes.to_string());
        let tip = "Malformed, impossible or unauthorised messages";
        fact(ui, ("Refused", tip), serving.refused.to_string());
    });
}
