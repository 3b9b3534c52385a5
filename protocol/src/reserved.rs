//! Numbers kept for the commands that have no layout yet, so that none is given twice: PT 0x02xx, PVT 0x03xx,
//! laser 0x06xx, buffered laser 0x07xx, coordinate systems 0x08xx, distance follow 0x09xx. (0x04xx and
//! 0x05xx are Follow and FollowEx.) A command moves to [`crate::command::COMMANDS`] with its number when it is built.
//!
//! Calls that never reach the wire have no number: Open and Close are the link's opening and Bye, and
//! GetLastReason reads what the client keeps.

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
    (0x0700, "BufLaserOn"),
    (0x0701, "BufLaserOff"),
    (0x0702, "BufLaserPrfCmd"),
    (0x0703, "BufLaserPrfFollow"),
    (0x0704, "BufLaserFollowMode"),
    (0x0705, "BufLaserFollowRatio"),
    (0x0706, "BufLaserFollowTable"),
    (0x0707, "BufLaserFollowOff"),
    (0x0708, "SetLaserFollowTable"),
    (0x0709, "BufLaserFollowSpline"),
    (0x0800, "SetCrdPrm"),
    (0x0801, "GetCrdPrm"),
    (0x0802, "CrdClear"),
    (0x0803, "CrdSpace"),
    (0x0804, "CrdStart"),
    (0x0805, "CrdStop"),
    (0x0806, "CrdStatus"),
    (0x0807, "GetCrdPos"),
    (0x0808, "GetCrdVel"),
    (0x0809, "GetRemainderSegNum"),
    (0x080A, "SetCrdStopDec"),
    (0x080B, "SetOverride"),
    (0x080C, "InitLookAhead"),
    (0x080D, "CrdData"),
    (0x080E, "LnXY"),
    (0x080F, "LnXYZ"),
    (0x0810, "LnXYZA"),
    (0x0811, "LnXYG0"),
    (0x0812, "ArcXYR"),
    (0x0813, "ArcXYC"),
    (0x0814, "ArcYZR"),
    (0x0815, "ArcYZC"),
    (0x0816, "ArcZXR"),
    (0x0817, "ArcZXC"),
    (0x0818, "BufDelay"),
    (0x0819, "BufIO"),
    (0x081A, "BufDoBit"),
    (0x081B, "BufDA"),
    (0x081C, "BufMove"),
    (0x081D, "BufGear"),
    (0x0900, "SetLaserDisMode"),
    (0x0901, "SetLaserDisRatio"),
    (0x0902, "SetLaserDisTable1D"),
    (0x0903, "SetLaserDisTable2D"),
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
