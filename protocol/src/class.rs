//! What a command is: the columns of the table in [`crate::command`] that say what it does and
//! where it may stand. Nobody else lists commands by what they are; who has to know asks
//! [`crate::command::class`]. The columns do not travel, so they are no part of the schema hash.

/// What a command is, and where it may stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Class {
    /// What it does.
    pub kind: CommandKind,
    /// In which lanes it is accepted.
    pub lanes: LaneRule,
}

/// What a command does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    /// It reads a state.
    Read(ReadOf),
    /// The reply gives values of the points in the request; nothing else is read or changed.
    Calculate,
    /// It puts entries into a FIFO, which a commit publishes to the tick.
    Data(DataStore),
    /// It carries a piece of a table; the last piece completes it.
    Table(Table),
    /// It sets axes in motion.
    Start,
    /// It changes anything else of the machine.
    Set,
    /// It concerns the session alone: whether the client lives, and what it records.
    Session,
    /// It controls the program from outside; the reply is the program's state.
    Program,
    /// It is a step of the program itself: a wait, or its end.
    Step,
}

/// What a read is of. Reads of one kind have one layout, apart from [`ReadOf::Other`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReadOf {
    /// The controller: no fields.
    Controller,
    /// One axis: core, axis.
    Axis,
    /// Consecutive axes: core, first axis, count.
    Axes,
    /// One axis in the mode of the command's chapter: core, axis.
    Follow,
    /// A laser channel: core, channel.
    Laser,
    /// A coordinate system: core, system.
    Crd,
    /// A FIFO of a coordinate system: core, system, FIFO.
    CrdFifo,
    /// What has fields, or checks, of its own.
    Other,
}

/// What entries go into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataStore {
    /// Segments of PT.
    Pt,
    /// Entries of Follow and FollowEx. FollowSwitchNowEx is data only if its `buffer` is not 0.
    Follow,
    /// Entries of a coordinate system.
    Path,
    /// Laser changes among them.
    Light,
    /// Lines of common speeds, many in one command.
    Lines,
    /// Calls of the kinds `Path` and `Light`, joined in one command.
    Joined,
}

/// What a table is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Table {
    /// PVT.
    Pvt,
    /// Powers and ratios of a laser channel.
    Laser,
}

/// Where a command may stand. A program is *active* while it is held or runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaneRule {
    /// In a program, and in the immediate lane at any time.
    Any,
    /// In a program; in the immediate lane while no program is active.
    Exclusive,
    /// As `Exclusive`, but with value 0 at any time: switching off is as urgent as a Stop.
    ExclusiveUnlessZero,
    /// In the immediate lane alone, at any time.
    Immediate,
    /// In the immediate lane alone, while no program is active.
    ImmediateExclusive,
    /// In a program alone.
    Program,
}

/// The chapters of the manuals whose commands share an upper byte of their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chapter {
    /// Follow.
    Follow,
    /// FollowEx.
    FollowEx,
    /// Lasers.
    Laser,
    /// Coordinate systems.
    Crd,
    /// Gear.
    Gear,
    /// Any other.
    Other,
}

/// The chapter of a command.
pub const fn chapter(opcode: u16) -> Chapter {
    match opcode >> 8 {
        4 => Chapter::Follow,
        5 => Chapter::FollowEx,
        6 => Chapter::Laser,
        8 => Chapter::Crd,
        10 => Chapter::Gear,
        _ => Chapter::Other,
    }
}

impl LaneRule {
    /// Whether a program may hold the command.
    pub const fn in_program(self) -> bool {
        !matches!(self, LaneRule::Immediate | LaneRule::ImmediateExclusive)
    }

    /// Whether the immediate lane takes it while a program is active.
    pub const fn beside_program(self) -> bool {
        matches!(self, LaneRule::Any | LaneRule::Immediate)
    }
}

impl CommandKind {
    /// Whether it changes nothing at all.
    pub const fn reads(self) -> bool {
        matches!(self, CommandKind::Read(_) | CommandKind::Calculate)
    }

    /// Whether it is a call that `PathMany` may hold: one entry of a FIFO of a coordinate system.
    pub const fn joins(self) -> bool {
        matches!(self, CommandKind::Data(DataStore::Path | DataStore::Light))
    }

    /// Whether it can neither light nor move anything, now or later.
    pub const fn is_harmless(self) -> bool {
        self.reads() || matches!(self, CommandKind::Session | CommandKind::Program | CommandKind::Step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{COMMANDS, CommandInfo, class};
    use std::vec::Vec;

    fn types(command: &CommandInfo) -> Vec<&'static str> {
        command.fields.iter().map(|(_, of)| *of).collect()
    }

    #[test]
    fn every_number_has_the_class_of_its_row() {
        for number in 0..=u16::MAX {
            let row = COMMANDS.iter().find(|command| command.opcode == number);
            assert_eq!(class(number), row.map(|command| command.class), "{number:#06x}");
        }
    }

    /// The dispatcher reads all requests of such a kind as one struct.
    #[test]
    fn reads_of_one_kind_have_one_layout() {
        for command in COMMANDS {
            let wanted = match command.class.kind {
                CommandKind::Read(ReadOf::Controller) => 0,
                CommandKind::Read(ReadOf::Axis | ReadOf::Follow | ReadOf::Laser | ReadOf::Crd) => 2,
                CommandKind::Read(ReadOf::Axes | ReadOf::CrdFifo) => 3,
                _ => continue,
            };
            assert_eq!(types(command), ["I16"; 3][..wanted], "{}", command.name);
            assert!(command.items.is_empty(), "{}", command.name);
            let named = |index: usize, name: &str| command.fields.get(index).is_none_or(|(field, _)| *field == name);
            assert!(named(0, "core"), "{}", command.name);
            let last = if command.class.kind == CommandKind::Read(ReadOf::Axes) { "count" } else { "fifo" };
            assert!(named(2, last), "{}", command.name);
        }
    }

    #[test]
    fn a_name_says_what_its_command_is() {
        for command in COMMANDS {
            let (name, kind) = (command.name, command.class.kind);
            if name.starts_with("Get")
                || name.ends_with("Status") && kind != CommandKind::Program
                || name.contains("Space")
            {
                assert!(matches!(kind, CommandKind::Read(_)), "{name}");
            }
            if ["Set", "Clr", "Prf", "Ena", "Dis", "Axis"].iter().any(|start| name.starts_with(start)) {
                assert!(!kind.is_harmless() || name == "AxisStatus", "{name}");
            }
            assert_eq!(
                name.starts_with("Pvt") && name.ends_with("Calculate"),
                kind == CommandKind::Calculate,
                "{name}"
            );
            assert_eq!(name.starts_with("BufLaser"), kind == CommandKind::Data(DataStore::Light), "{name}");
        }
    }

    #[test]
    fn calls_that_join_name_their_fifo() {
        for command in COMMANDS {
            let offset = crate::command::fifo_offset(command.opcode);
            assert_eq!(offset.is_some(), command.class.kind.joins(), "{}", command.name);
            let Some(offset) = offset else { continue };
            assert_eq!(command.fields[..2], [("core", "I16"), ("crd", "I16")], "{}", command.name);
            let before: Vec<_> = command.fields.iter().take_while(|(name, _)| *name != "fifo").copied().collect();
            assert_eq!(crate::command::widths(&before), offset, "{}", command.name);
        }
    }

    #[test]
    fn what_a_program_excludes_is_not_read() {
        for command in COMMANDS {
            let Class { kind, lanes } = command.class;
            assert!(!kind.reads() || lanes == LaneRule::Any, "{}", command.name);
            assert_eq!(kind == CommandKind::Step, lanes == LaneRule::Program, "{}", command.name);
            assert!(kind != CommandKind::Program || lanes == LaneRule::Immediate, "{}", command.name);
            let starts = matches!(kind, CommandKind::Start | CommandKind::Data(_) | CommandKind::Table(_));
            assert!(!starts || lanes == LaneRule::Exclusive, "{}", command.name);
        }
    }
}
