//! The list of all commands by name, used by menus, keys, palette and help.

use egui::{Context, Key, KeyboardShortcut, Modifiers, Theme};
use strum::{IntoStaticStr, VariantArray};

use crate::device::health::State;
use crate::field::Quantity;
use crate::picture::figure::Format;
use crate::scene::motion;
use crate::studio::animate::Kind;
use crate::ui::board::{BoardCommand, Plays};
use crate::ui::command::{Command, Export, Purpose};
use crate::ui::playback::Moment;
use crate::ui::tool;
use crate::ui::tool::Tool;
use crate::ui::{
    IN_PAGE, clipboard, compare, dialog::state::Dialog, edit, edit::Align, editor::Editor, figure, group,
    layout::Panel, level, shown::Shown, timeline, way,
};

/// Factor per step of the window's scale, and its limits.
const SCALE_STEP: f32 = 1.25;
/// Scale factor of the presentation mode.
pub const PRESENTED: f32 = 1.5;
pub const SCALES: [f32; 6] = [0.75, 1.0, 1.25, 1.5, 1.75, 2.0];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    New,
    Open,
    Examples,
    Save,
    SaveAs,
    Import,
    OpenDrive,
    CopyLink,
    Quit,
    Undo,
    Redo,
    Cut,
    Copy,
    Paste,
    Duplicate,
    Delete,
    SelectAll,
    Group,
    Ungroup,
    Align(Align),
    DistributeAcross,
    DistributeUp,
    Snap,
    Grid,
    Export(Export),
    Tool(Tool),
    SmallerBrush,
    LargerBrush,
    Quantity(Quantity),
    ShowEverything,
    Space,
    Targets,
    Profile,
    Compare,
    Play,
    Mean,
    Waves,
    Timeline,
    ShowPanel(Panel),
    TogglePanel,
    Present,
    Larger,
    Smaller,
    UsualScale,
    DarkTheme,
    WhiteBackground,
    Send,
    PlayMotion,
    Stop,
    Serve,
    Palette,
    Manual,
    Help,
    About,
}

/// Position of an action in the menus and in the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Group {
    File,
    Edit,
    Export,
    Tools,
    View,
    Board,
    Help,
}

const fn ctrl(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

const fn ctrl_shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key)
}

const fn plain(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::NONE, key)
}

impl Action {
    /// In the order of the menus.
    pub fn all() -> Vec<Self> {
        use Action as A;
        let mut all = vec![
            A::New,
            A::Open,
            A::Examples,
            A::Save,
            A::SaveAs,
            A::Import,
            A::OpenDrive,
            A::CopyLink,
            A::Quit,
            A::Undo,
            A::Redo,
            A::Cut,
        ];
        all.extend([A::Copy, A::Paste, A::Duplicate, A::Delete, A::SelectAll, A::Group, A::Ungroup]);
        all.extend(Align::VARIANTS.iter().copied().map(A::Align));
        all.extend([A::DistributeAcross, A::DistributeUp, A::Snap, A::Grid]);
        all.extend(
            [
                Export::Figure(Format::Pdf),
                Export::Map,
                Export::Sheet,
                Export::Numbers,
                Export::Drive,
                Export::Profile,
                Export::Elements,
                Export::Motion(Kind::Gif),
            ]
            .map(A::Export),
        );
        all.extend(Tool::VARIANTS.iter().copied().map(A::Tool));
        all.extend([A::SmallerBrush, A::LargerBrush]);
        all.extend(Quantity::ALL.map(A::Quantity));
        all.extend([A::ShowEverything, A::Space, A::Targets, A::Profile, A::Compare]);
        all.extend([A::Play, A::Mean, A::Waves, A::Timeline]);
        all.extend(Panel::VARIANTS.iter().copied().map(A::ShowPanel));
        all.extend([A::TogglePanel, A::Present, A::Larger, A::Smaller, A::UsualScale]);
        all.extend([A::DarkTheme, A::WhiteBackground]);
        all.extend([A::Send, A::PlayMotion, A::Stop, A::Serve, A::Palette, A::Manual, A::Help, A::About]);
        // A page ends as the browser ends it, and has no sockets.
        all.retain(|action| !(IN_PAGE && [A::Quit, A::Serve].contains(action)));
        all
    }

    pub fn name(self) -> String {
        let name = match self {
            Self::New => "New",
            Self::Open => "Open…",
            Self::Examples => "Examples…",
            Self::Save => "Save",
            Self::SaveAs => "Save as…",
            Self::Import => "Import drawing…",
            Self::OpenDrive => "Open drive…",
            Self::CopyLink => "Copy scene as link",
            Self::Quit => "Quit",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::Cut => "Cut",
            Self::Copy => "Copy",
            Self::Paste => "Paste",
            Self::Duplicate => "Duplicate",
            Self::Delete => "Delete",
            Self::SelectAll => "Select all",
            Self::Group => "Group",
            Self::Ungroup => "Ungroup",
            Self::Align(align) => align.into_str(),
            Self::DistributeAcross => "Distribute horizontally",
            Self::DistributeUp => "Distribute vertically",
            Self::Snap => "Snap to the grid",
            Self::Grid => "Show the grid",
            Self::Export(Export::Figure(_)) => "Figure…",
            Self::Export(Export::Map) => "View as PNG…",
            Self::Export(Export::Sheet) => "Sheet as PNG…",
            Self::Export(Export::Numbers) => "Map data (NPY)…",
            Self::Export(Export::Drive) => "Phases and amplitudes (CSV)…",
            Self::Export(Export::Profile) => "Line profile (CSV)…",
            Self::Export(Export::Elements) => "Elements (CSV)…",
            Self::Export(Export::Calibration { .. }) => "Calibration of the measured field (CSV)…",
            Self::Export(Export::Report) => "Report of the measured field…",
            Self::Export(Export::Motion(_)) => "Motion…",
            Self::Tool(tool) => tool.into_str(),
            Self::SmallerBrush => "Smaller brush",
            Self::LargerBrush => "Larger brush",
            Self::Quantity(quantity) => return format!("Show: {}", quantity.declaration().title),
            Self::ShowEverything => "Fit the view",
            Self::Space => "3D view",
            Self::Targets => "Show targets",
            Self::Profile => "Line profile",
            Self::Compare => "Compare",
            Self::Play => "Play or pause",
            Self::Mean => "Mean of a cycle",
            Self::Waves => "Waves of the liquid",
            Self::Timeline => "Timeline in presentation mode",
            Self::ShowPanel(Panel::Motion) => "Motion & modulation panel",
            Self::ShowPanel(panel) => return format!("{} panel", panel.into_str()),
            Self::TogglePanel => "Show panel",
            Self::Present => "Presentation mode",
            Self::Larger => "Larger window scale",
            Self::Smaller => "Smaller window scale",
            Self::UsualScale => "Usual window scale",
            Self::DarkTheme => "Dark theme",
            Self::WhiteBackground => "White background",
            Self::Send => "Send to the board",
            Self::PlayMotion => "Play the motion on the board",
            Self::Stop => "Stop the board",
            Self::Serve => "Allow remote control",
            Self::Palette => "All commands…",
            Self::Manual => "Manual…",
            Self::Help => "Keys and tools…",
            Self::About => "About Sonoglyph…",
        };
        name.to_owned()
    }

    pub fn group(self) -> Group {
        match self {
            Self::New
            | Self::Open
            | Self::Examples
            | Self::Save
            | Self::SaveAs
            | Self::Import
            | Self::OpenDrive
            | Self::CopyLink
            | Self::Quit => Group::File,
            Self::Undo
            | Self::Redo
            | Self::Cut
            | Self::Copy
            | Self::Paste
            | Self::Duplicate
            | Self::Delete
            | Self::SelectAll
            | Self::Group
            | Self::Ungroup
            | Self::Align(_)
            | Self::DistributeAcross
            | Self::DistributeUp
            | Self::Snap
            | Self::Grid => Group::Edit,
            Self::Export(_) => Group::Export,
            Self::Tool(_) | Self::SmallerBrush | Self::LargerBrush => Group::Tools,
            Self::Quantity(_)
            | Self::ShowEverything
            | Self::Space
            | Self::Targets
            | Self::Profile
            | Self::Compare
            | Self::Play
            | Self::Mean
            | Self::Waves
            | Self::Timeline
            | Self::ShowPanel(_)
            | Self::TogglePanel
            | Self::Present
            | Self::Larger
            | Self::Smaller
            | Self::UsualScale
            | Self::DarkTheme
            | Self::WhiteBackground => Group::View,
            Self::Send | Self::PlayMotion | Self::Stop | Self::Serve => Group::Board,
            Self::Palette | Self::Manual | Self::Help | Self::About => Group::Help,
        }
    }

    /// Its keys, the one that menus show first.
    pub fn keys(self) -> Vec<KeyboardShortcut> {
        match self {
            Self::New => vec![ctrl(Key::N)],
            Self::Open => vec![ctrl(Key::O)],
            Self::Save => vec![ctrl(Key::S)],
            Self::SaveAs => vec![ctrl_shift(Key::S)],
            Self::Quit => vec![ctrl(Key::Q)],
            Self::Undo => vec![ctrl(Key::Z)],
            Self::Redo => vec![ctrl_shift(Key::Z), ctrl(Key::Y)],
            Self::Cut => vec![ctrl(Key::X)],
            Self::Copy => vec![ctrl(Key::C)],
            Self::Paste => vec![ctrl(Key::V)],
            Self::Duplicate => vec![ctrl(Key::D)],
            Self::Delete => vec![plain(Key::Delete), plain(Key::Backspace)],
            Self::SelectAll => vec![ctrl(Key::A)],
            Self::Group => vec![ctrl(Key::G)],
            Self::Ungroup => vec![ctrl_shift(Key::G)],
            Self::Snap => vec![plain(Key::K)],
            Self::Tool(tool) => vec![plain(tool.key())],
            Self::SmallerBrush => vec![plain(Key::OpenBracket)],
            Self::LargerBrush => vec![plain(Key::CloseBracket)],
            Self::Quantity(quantity) => digit(quantity).map(plain).into_iter().collect(),
            Self::ShowEverything => vec![plain(Key::Num0)],
            Self::Space => vec![plain(Key::F3)],
            Self::Targets => vec![plain(Key::M)],
            Self::Profile => vec![plain(Key::X)],
            Self::Play => vec![plain(Key::Space)],
            Self::Timeline => vec![plain(Key::F8)],
            Self::TogglePanel => vec![plain(Key::F9)],
            Self::Present => vec![plain(Key::F11)],
            Self::Larger => vec![ctrl(Key::Plus), ctrl(Key::Equals)],
            Self::Smaller => vec![ctrl(Key::Minus)],
            Self::UsualScale => vec![ctrl(Key::Num0)],
            Self::Palette => vec![ctrl(Key::P)],
            Self::Help => vec![plain(Key::F1)],
            Self::Examples
            | Self::Align(_)
            | Self::DistributeAcross
            | Self::DistributeUp
            | Self::Compare
            | Self::Grid
            | Self::WhiteBackground
            | Self::Manual
            | Self::About
            | Self::Import
            | Self::OpenDrive
            | Self::CopyLink
            | Self::Export(_)
            | Self::Mean
            | Self::Waves
            | Self::ShowPanel(_)
            | Self::DarkTheme
            | Self::Send
            | Self::PlayMotion
            | Self::Stop
            | Self::Serve => Vec::new(),
        }
    }

    /// The keys in words, as menus show them.
    pub fn shortcut(self, ctx: &Context) -> String {
        if self == Self::Stop {
            return "Esc Esc".to_owned();
        }
        self.keys().first().map_or_else(String::new, |keys| written(keys, ctx))
    }

    /// Whether its keys also act while a widget has the keyboard: neither letters nor text editing keys.
    pub fn is_for_the_window(self) -> bool {
        matches!(
            self,
            Self::New
                | Self::Open
                | Self::Save
                | Self::SaveAs
                | Self::Quit
                | Self::TogglePanel
                | Self::Timeline
                | Self::Present
                | Self::Larger
                | Self::Smaller
                | Self::UsualScale
                | Self::Palette
                | Self::Help
        )
    }

    /// Whether what it switches is on; `None` of an action that switches nothing.
    pub fn is_on(self, editor: &Editor, ctx: &Context) -> Option<bool> {
        let switches = [
            (Self::Snap, editor.snaps),
            (Self::Grid, editor.view.grid),
            (Self::Space, editor.space.is_on),
            (Self::Targets, editor.view.marks),
            (Self::Profile, editor.view.section),
            (Self::Compare, editor.compare.is_some()),
            (Self::TogglePanel, editor.layout.has_panel(ctx)),
            (Self::Present, editor.layout.presents),
            (Self::DarkTheme, ctx.theme() == Theme::Dark),
            (Self::WhiteBackground, editor.view.is_light),
        ];
        switches.into_iter().find(|(action, _)| *action == self).map(|(_, is_on)| is_on)
    }

    /// Why it cannot be done now.
    ///
    /// # Errors
    /// The missing requirement, as a sentence.
    pub fn possible(self, editor: &Editor, shown: &Shown) -> Result<(), &'static str> {
        let is_one_of = |actions: &[Self]| actions.contains(&self);
        let has_waves = editor.view.quantity.declaration().of_liquid;
        if let Self::Quantity(quantity) = self
            && let Some(refusal) = level::refusal(quantity, &editor.view, editor.scene())
        {
            return Err(refusal);
        }
        let lacks = [
            (self == Self::Undo && !editor.document.can_undo(), "There is nothing to undo"),
            (self == Self::Redo && !editor.document.can_redo(), "There is nothing to redo"),
            (
                is_one_of(&[Self::Cut, Self::Copy, Self::Duplicate, Self::Delete])
                    && editor.selection.is_empty()
                    && !(is_one_of(&[Self::Duplicate, Self::Delete]) && editor.chosen_body().is_some())
                    && !(self == Self::Delete && way::can_delete(editor)),
                "No target is selected",
            ),
            (
                matches!(self, Self::Group | Self::Align(_)) && editor.selection.len() < 2,
                "Select two targets or more",
            ),
            (
                is_one_of(&[Self::DistributeAcross, Self::DistributeUp]) && editor.selection.len() < 3,
                "Select three targets or more",
            ),
            (
                self == Self::Ungroup && !group::any(editor.scene(), &editor.selection),
                "No selected target is in a group",
            ),
            (self == Self::SelectAll && editor.scene().targets.is_empty(), "The scene has no targets"),
            (
                self == Self::PlayMotion && shown.board.health.is_none(),
                "Connect to a board in the Device panel first",
            ),
            (
                ((matches!(self, Self::Export(Export::Motion(_))) && !has_waves) || self == Self::PlayMotion)
                    && !motion::moves(editor.scene()),
                "Nothing moves. Choose a path in the Motion panel first",
            ),
            (
                is_one_of(&[
                    Self::Export(Export::Numbers),
                    Self::Export(Export::Profile),
                    Self::Profile,
                    Self::Compare,
                ]) && editor.space.is_on,
                "Only for the map: leave the 3D view first",
            ),
            (
                self == Self::Play && !timeline::can_play(editor),
                "Nothing moves: choose a path in the Motion panel, or show the instantaneous pressure",
            ),
            (
                self == Self::Mean && !motion::moves(editor.scene()),
                "Nothing moves: choose a path in the Motion panel",
            ),
            (
                is_one_of(&[Self::Mean, Self::Waves, Self::Play]) && !editor.scene().has_drive(),
                "The scene has no targets",
            ),
            (self == Self::Stop && shown.board.plays == Plays::Nothing, "The board is silent"),
        ];
        lacks.iter().find(|(is_lacking, _)| *is_lacking).map_or(Ok(()), |(_, what)| Err(what))
    }

    /// Runs it, if possible.
    pub fn run(self, editor: &mut Editor, shown: &Shown, ctx: &Context, commands: &mut Vec<Command>) {
        if self.possible(editor, shown).is_err() {
            return;
        }
        let mut ask_for_file = |purpose: Purpose| editor.ask_for_file(purpose);
        match self {
            Self::New => editor.ask(Command::New, commands),
            Self::Open => ask_for_file(Purpose::Open),
            Self::Examples => editor.dialog = Some(Dialog::Examples),
            Self::Save => commands.push(Command::Save),
            Self::SaveAs => ask_for_file(Purpose::SaveAs),
            Self::Import => ask_for_file(Purpose::Import),
            Self::OpenDrive => ask_for_file(Purpose::Drive),
            Self::CopyLink => commands.push(Command::CopyLink),
            Self::Quit => editor.ask(Command::Close, commands),
            Self::Undo => editor.undo(),
            Self::Redo => editor.redo(),
            Self::Cut => {
                clipboard::copy(editor, ctx);
                clipboard::delete(editor);
            }
            Self::Copy => clipboard::copy(editor, ctx),
            Self::Paste => commands.push(Command::Paste),
            Self::Duplicate => clipboard::duplicate_chosen(editor),
            Self::Delete => clipboard::delete_chosen(editor),
            Self::Group => group::join(&mut editor.document.scene, &editor.selection),
            Self::Ungroup => group::rename(&mut editor.document.scene, &editor.selection, ""),
            Self::SelectAll => editor.selection = (0..editor.scene().targets.len()).collect(),
            Self::Align(align) => {
                let axes = editor.view.axes(editor.scene());
                edit::align(&mut editor.document.scene, &editor.selection, &axes, align);
            }
            Self::DistributeAcross | Self::DistributeUp => {
                let axes = editor.view.axes(editor.scene());
                let is_upwards = self == Self::DistributeUp;
                edit::distribute(&mut editor.document.scene, &editor.selection, &axes, is_upwards);
            }
            Self::Snap => editor.snaps = !editor.snaps,
            Self::Grid => editor.view.grid = !editor.view.grid,
            Self::Export(Export::Figure(_)) => {
                let offer = [figure::available(editor, shown), figure::displayed(editor, shown)];
                editor.figure.follow(&editor.view, &editor.document.scene, offer);
                editor.dialog = Some(Dialog::Figure);
            }
            Self::Export(Export::Motion(_)) => editor.dialog = Some(Dialog::Film),
            Self::Export(export) => ask_for_file(Purpose::Export(export)),
            Self::Tool(tool) => editor.tool = tool,
            Self::SmallerBrush => editor.brush.scale(1.0 / tool::STEP),
            Self::LargerBrush => editor.brush.scale(tool::STEP),
            // Space shows the pressure alone.
            Self::Quantity(quantity) => (editor.view.quantity, editor.space.is_on) = (quantity, false),
            Self::ShowEverything => editor.fit(),
            Self::Space => editor.space.is_on = !editor.space.is_on,
            Self::Targets => editor.view.marks = !editor.view.marks,
            Self::Profile => editor.view.section = !editor.view.section,
            Self::Compare => compare::toggle(editor),
            Self::Play => drop(timeline::play_or_pause(editor)),
            Self::Mean => (editor.playback.moment, editor.playback.playing) = (Moment::Mean, false),
            Self::Waves => {
                let is_on = matches!(editor.playback.moment.of(editor.view.quantity), Moment::Wave(_));
                timeline::show_waves(editor, !is_on);
            }
            Self::Timeline => editor.layout.has_timeline = !editor.layout.has_timeline,
            Self::ShowPanel(panel) => (editor.panel, editor.layout.is_drawn_out) = (panel, true),
            Self::TogglePanel => editor.layout.toggle(ctx),
            Self::Present => present(editor, ctx, !editor.layout.presents),
            Self::Larger => scale(ctx, ctx.zoom_factor() * SCALE_STEP),
            Self::Smaller => scale(ctx, ctx.zoom_factor() / SCALE_STEP),
            Self::UsualScale => scale(ctx, 1.0),
            Self::WhiteBackground => editor.view.is_light = !editor.view.is_light,
            Self::DarkTheme => {
                let is_dark = ctx.theme() == Theme::Dark;
                ctx.set_theme(if is_dark { Theme::Light } else { Theme::Dark });
            }
            Self::Send => send(editor, shown, commands),
            Self::PlayMotion => commands.push(Command::Board(BoardCommand::PlayMotion)),
            Self::Stop => commands.push(Command::Board(BoardCommand::Stop)),
            Self::Serve => commands.push(Command::Serve(shown.serving.is_none())),
            Self::Palette => editor.dialog = Some(Dialog::Palette { text: String::new(), chosen: 0 }),
            Self::Manual => editor.dialog = Some(Dialog::Manual(0)),
            Self::Help => editor.dialog = Some(Dialog::Help),
            Self::About => editor.dialog = Some(Dialog::About),
        }
    }
}

/// Plays the scene, with its motion. Without a board, connects to the known port, or leads to the page where one is
/// chosen.
fn send(editor: &mut Editor, shown: &Shown, commands: &mut Vec<Command>) {
    let is_known = !editor.board.port().is_empty() && shown.board.unavailable.is_none();
    match shown.board.health.as_ref().map(|health| &health.state) {
        None if is_known => commands.push(Command::Board(BoardCommand::Connect)),
        None | Some(State::Lost(_)) => {
            editor.panel = Panel::Device;
            (editor.layout.is_drawn_out, editor.layout.is_folded) = (true, false);
            commands.push(Command::Board(BoardCommand::AskForBoard));
            return;
        }
        Some(State::Connecting | State::Ready) => {}
    }
    let moves = motion::moves(editor.scene());
    commands.push(Command::Board(if moves { BoardCommand::PlayMotion } else { BoardCommand::Send }));
}

/// A shortcut by the signs on the keys, such as "Ctrl +".
fn written(keys: &KeyboardShortcut, ctx: &Context) -> String {
    let text = ctx.format_shortcut(keys);
    let modifiers = text.strip_suffix(keys.logical_key.name()).unwrap_or_default();
    format!("{}{}", modifiers.replace('+', " "), keys.logical_key.symbol_or_name())
}

/// Scales everything in the window by a factor.
pub fn scale(ctx: &Context, factor: f32) {
    ctx.set_zoom_factor(factor.clamp(SCALES[0], SCALES[SCALES.len() - 1]));
}

/// Toggles the presentation mode: the map alone, with large text.
pub fn present(editor: &mut Editor, ctx: &Context, presents: bool) {
    let before = std::mem::replace(&mut editor.layout.presents, presents);
    let by = |presents: bool| if presents { PRESENTED } else { 1.0 };
    ctx.set_zoom_factor(ctx.zoom_factor() * by(presents) / by(before));
}

/// The digit key of a quantity, by its position.
fn digit(quantity: Quantity) -> Option<Key> {
    const DIGITS: [Key; 9] =
        [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    let place = Quantity::ALL.iter().position(|own| *own == quantity)?;
    DIGITS.get(place).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_has_a_name_and_keys_of_its_own() {
        let all = Action::all();
        for (place, action) in all.iter().enumerate() {
            for other in &all[place + 1..] {
                assert_ne!(action.name(), other.name());
                assert!(
                    action.keys().iter().all(|keys| !other.keys().contains(keys)),
                    "{action:?} {other:?}"
                );
            }
            assert!(Group::VARIANTS.contains(&action.group()));
        }
    }
}
