//! Numbers kept for commands that have no layout yet, so that none is given twice: PT 0x02xx, PVT
//! 0x03xx, laser 0x06xx, buffered laser 0x07xx, distance follow 0x09xx. (0x04xx and 0x05xx are
//! Follow and FollowEx, 0x08xx coordinate systems, 0x0Axx Gear.) A command moves to
//! [`crate::command::COMMANDS`] with its number when it is built.
//!
//! Calls that never reach the wire have no number: Open and Close are the link's opening and Bye,
//! and GetLastReason reads a value that the client keeps.

/// Number and name, by number.
pub const RESERVED: &[(u16, &str)] = &[
    (0x0210, "PtStartPro"),
    (0x030D, "PvtTableContinuousEx"),
    (0x030E, "PvtTableMove"),
    (0x030F, "PvtTableMovePercent"),
    (0x0310, "PvtTableMovePercentEx"),
    (0x0311, "SetPvtTableLoop"),
    (0x0618, "SetLaserPwmDac"),
    (0x0619, "LaserPwmDacOn"),
    (0x061A, "LaserPwmDacOff"),
    (0x0709, "BufLaserFollowSpline"),
    (0x0904, "SetLaserDisTable2DEx"),
    (0x0905, "SelectLaserDisTable"),
    (0x0906, "BufSetLaserDisEnable"),
    (0x0907, "BufSelectLaserDisTable"),
];

#[cfg(test)]
mod tests {
    use super::RESERVED;
    use crate::command::COMMANDS;
    use std::collections::BTreeSet;

    #[test]
    fn every_number_and_every_name_stands_once() {
        let all = || COMMANDS.iter().map(|command| (command.opcode, command.name)).chain(RESERVED.iter().copied());
        let numbers: BTreeSet<u16> = all().map(|(number, _)| number).collect();
        let names: BTreeSet<&str> = all().map(|(_, name)| name).collect();
        assert_eq!(numbers.len(), all().count(), "a number stands twice");
        assert_eq!(names.len(), all().count(), "a name stands twice");
        assert!(RESERVED.is_sorted(), "by number");
    }
}
