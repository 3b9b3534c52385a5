//! `compat/stdafx.h` with either header, before and after it: `commandhandler` prints the reason
//! of the call that failed.

mod toolchain;

use toolchain::{Language, build, command};

/// The first error output line of a program.
fn printed(name: &str, headers: [&str; 2], main: &str) -> Option<String> {
    let [first, second] = headers;
    let text = format!("#include \"{first}\"\n#include \"{second}\"\nint main(void)\n{{\n{main}    return 0;\n}}\n");
    for language in [Language::C, Language::Cpp] {
        let built = build(language, name, &text)?;
        let done = command(&built, &[("BEAMTICK_LINK", "virtual:max")]).output().unwrap();
        assert!(done.status.success(), "{name}: {done:?}");
        let printed = String::from_utf8(done.stderr).unwrap();
        if language == Language::Cpp {
            return Some(printed);
        }
    }
    None
}

#[test]
fn the_reason_is_that_of_the_card_that_failed() {
    // Card 0 fails first, then card 3: each line has its own reason, and a call that is done prints
    // nothing.
    let main = "    short code = GT_AxisOn(0, 1);\n    commandhandler(\"closed\", code);\n    commandhandler(\"open\", GT_Open(3, 0, 1));\n    \
                commandhandler(\"axis\", GT_AxisOn(3, 99));\n    commandhandler(\"start\", GT_PtStart(3, 1, 0));\n    \
                commandhandler(\"again\", GT_AxisOn(0, 1));\n    commandhandler(\"card\", GT_AxisOn(77, 1));\n";
    for headers in [["gts_cards.h", "stdafx.h"], ["stdafx.h", "gts_cards.h"]] {
        let Some(text) = printed("handled_cards", headers, main) else { return };
        let lines: Vec<&str> = text.lines().collect();
        let parts = [
            "closed = -7: AxisOn: no controller is open",
            "axis = 7: AxisOn: axis is 99",
            "start = 1: PtStart: axis 1 is not in the mode",
        ];
        assert_eq!(lines.len(), 5, "{text}");
        for (line, part) in lines.iter().zip(parts) {
            assert!(line.starts_with(part), "{headers:?}: {line}, wanted {part}");
        }
        assert!(lines[3].starts_with("again = -7: AxisOn: no controller is open"), "{text}");
        assert!(lines[4].starts_with("card = 7: AxisOn: cardNum is 77"), "{text}");
    }
}

#[test]
fn the_reason_of_the_single_card_is_printed() {
    let main = "    commandhandler(\"closed\", GT_AxisOn(1));\n    commandhandler(\"open\", GTN_Open(5, 1));\n    \
                commandhandler(\"core\", GTN_AxisOn(3, 1));\n";
    for headers in [["gts.h", "stdafx.h"], ["stdafx.h", "gts.h"]] {
        let Some(text) = printed("handled_card", headers, main) else { return };
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2, "{text}");
        assert!(lines[0].starts_with("closed = -7: AxisOn: no controller is open"), "{text}");
        assert!(lines[1].starts_with("core = 7: AxisOn: core is 3"), "{text}");
    }
}
