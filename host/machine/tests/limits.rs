//! Every limit of the machine file: at the limit it is taken, beyond it file, line, key and limit
//! are named.
use machine::{Machine, Mode, questions, write};

/// The usual file of three axes and a laser, with one line replaced.
fn with(key: &str, value: &str) -> Result<Machine, String> {
    let (usual, _) = write(&questions("XYZ", true)).unwrap();
    let (mut table, mut text, mut replaced) = (String::new(), String::new(), 0);
    for line in usual.lines() {
        if let Some(name) = line.strip_prefix('[') {
            table = format!("{}.", name.trim_end_matches(']'));
        }
        let name = line.trim_start_matches("# ").split('=').next().unwrap_or("").trim();
        let is_it = !line.starts_with('[') && format!("{table}{name}") == key;
        replaced += usize::from(is_it);
        text += &match (is_it, value) {
            (true, "") => format!("# {name} =\n"),
            (true, value) => format!("{name} = {value}\n"),
            (false, _) => format!("{line}\n"),
        };
    }
    assert_eq!(replaced, 1, "{key}");
    Machine::read("m.toml", &text)
}

#[test]
fn limits_are_those_of_the_page() {
    // Key, values that are taken, values that are refused, what the refusal says.
    let rows: &[(&str, &[&str], &[&str], &str)] = &[
        ("family", &["\"gus\"", "\"lsr\""], &["\"gts\"", "3"], "family cannot be read"),
        (
            "link.board",
            &["\"qemu\"", "\"virtual\"", "\"tcp:a:1\"", "\"tcp:[::1]:65535\"", "\"serial:/dev/ttyACM0\""],
            &[
                "\"usb\"",
                "\"tcp:host\"",
                "\"tcp:host:\"",
                "\"tcp::5000\"",
                "\"tcp:a:0\"",
                "\"tcp:a:65536\"",
                "\"serial:\"",
            ],
            "it is virtual, tcp:HOST:PORT, serial:PATH[:BAUD] or qemu",
        ),
        (
            "axes.x.number",
            &["4", "8"],
            &["0", "9", "64", "-1"],
            "it is a whole number from 1 to 8 (a path reaches no other",
        ),
        ("axes.y.number", &["5"], &["1"], "as that of X; each axis has its own"),
        (
            "axes.x.steps_per_mm",
            &["0.001", "2000", "80.123456789"],
            &["0", "-1", "nan", "inf", "100001"],
            "pulses a mm",
        ),
        ("axes.x.steps_per_mm", &[], &["80.1234567891"], "10 decimals; at most 9 count"),
        ("axes.x.invert", &["true", "false"], &["-1", "\"no\""], "axes.x.invert cannot be read"),
        (
            "axes.x.travel",
            &["[-100000, 100000]"],
            &["[0, 0]", "[5, -5]", "[0, 100001]", "[nan, 1]"],
            "it is [least, greatest]",
        ),
        ("axes.x.travel", &[], &["[0]", "[0, 1, 2]"], "values; it is [least, greatest]"),
        ("axes.x.travel", &[], &["3"], "axes.x.travel cannot be read"),
        ("axes.x.max_rate", &["0.001", "1e7"], &["0", "1e8", "nan"], "it is 0.001 to 10000000 mm/min"),
        ("axes.x.acceleration", &["0.001", "1e7"], &["0", "-2"], "mm/s²"),
        ("axes.x.home", &["0", "300"], &["-0.1", "301"], "it is 0 to 300 mm, the travel"),
        ("axes.x.limits", &["\"both\""], &["\"all\"", "true"], "axes.x.limits cannot be read"),
        ("axes.x.alarm", &["true"], &["1"], "axes.x.alarm cannot be read"),
        ("laser.channel", &["0", "1"], &["2", "-1"], "it is a whole number from 0 to 1"),
        ("laser.mode", &["\"duty\""], &["\"pwm\""], "laser.mode cannot be read"),
        ("laser.carrier_khz", &["0.001", "2000"], &["0.0005", "3e3", "nan"], "it is 0.001 to 2000 kHz"),
        ("laser.carrier_khz", &[], &[""], "laser has no carrier_khz; the duty mode needs it"),
        ("laser.pulse_width_us", &[], &["5"], "is for the mode \"frequency\" only"),
        (
            "laser.power",
            &["[0, 100]", "[0.001, 0.001]", "[5, 5.0]"],
            &["[0, 0]", "[0, 101]", "[-1, 5]", "[6, 5]", "[nan, 5]", "[0, inf]"],
            "it is [power at S = 0, power at s_max]: 0 to the second, and 0.001 to 100 %",
        ),
        ("laser.power", &[], &["[5]", "[0, 1, 2]", "[]"], "values; it is [power at S = 0, power at s_max]"),
        ("laser.s_max", &["255", "1e6"], &["0", "1e7"], "it is 0.001 to 1000000"),
        (
            "laser.on_delay_us",
            &["65535", "2.0"],
            &["65536", "-1", "0.5", "nan"],
            "it is a whole number from 0 to 65535 µs",
        ),
        ("laser.off_delay_us", &["65535"], &["65536", "-1"], "it is a whole number from 0 to 65535 µs"),
        ("path.junction_deviation", &["0.0001", "10"], &["0", "11"], "it is 0.0001 to 10 mm"),
        ("path.arc_tolerance", &["0.0001", "1"], &["0", "2"], "it is 0.0001 to 1 mm"),
        ("outputs.mist", &["1", "16"], &["0", "17"], "it is a whole number from 1 to 16"),
        ("outputs.flood", &["1", "16"], &["0", "17"], "it is a whole number from 1 to 16"),
    ];
    for (key, taken, refused, says) in rows {
        for value in *taken {
            with(key, value).unwrap_or_else(|error| panic!("{key} = {value}: {error}"));
        }
        for value in *refused {
            let error = with(key, value).expect_err(&format!("{key} = {value}"));
            assert!(error.starts_with("m.toml:") && error.contains(says), "{key} = {value}: {error}");
            let name = key.rsplit('.').next().unwrap();
            assert!(error.contains(name), "{key} = {value}: {error}");
        }
    }
}

#[test]
fn an_error_names_line_and_key() {
    let file = |axis_y: &str| {
        format!(
            "# a comment = none\n[axes.x]\nnumber = 1\nsteps_per_mm = 80\ntravel = [0, 100]\nmax_rate = 6000\nacceleration = 500\n\n\
             [axes.y]\n{axis_y}\n"
        )
    };
    let good = "number = 2\nsteps_per_mm = 80\ntravel = [\n  0,\n  100\n]\nmax_rate = 6000\nacceleration = 500";
    let machine = Machine::read("m.toml", &file(good)).unwrap();
    assert_eq!((machine.axes.len(), machine.laser(), machine.axes[1].travel), (2, None, (0.0, 100.0)));
    let cases = [
        (good.replace("number = 2", "number = 2\nspeed = 4"), "m.toml:11: axes.y.speed cannot be read: unknown field"),
        (
            good.replace("max_rate", "maxrate"),
            "m.toml:16: axes.y.maxrate cannot be read: unknown field `maxrate`, expected one of `number`, \
             `steps_per_mm`, `invert`, `travel`, `max_rate`, `acceleration`, `home`, `limits`, `alarm`; the nearest \
             known key is `max_rate`",
        ),
        (
            format!("{good}\n[link]\nbaord = \"qemu\""),
            "m.toml:19: link.baord cannot be read: unknown field `baord`, expected `board`; the nearest known key is \
             `board`",
        ),
        (format!("{good}\n[axes.a]\nnumber = 3"), "m.toml:18: axes.a is a fourth axis"),
        (
            good.replace("max_rate = 6000", "max_rate = \"fast\""),
            "m.toml:16: axes.y.max_rate cannot be read: invalid type: string \"fast\", expected a number;",
        ),
        (good.replace("max_rate = 6000\n", ""), "m.toml:9: axes.y cannot be read: missing field `max_rate`"),
        (
            good.replace("6000", "6e6").replace("80", "9000"),
            "m.toml:16: axes.y.max_rate is 6000000; at 9000 pulses a mm it is below 218447",
        ),
        (
            good.replace("acceleration = 500", "acceleration = 5e6").replace("80", "9000"),
            "m.toml:17: axes.y.acceleration is 5000000",
        ),
        (good.replace("100\n]", "100"), "m.toml:12: axes.y.travel has a list that is not closed: `]` is missing"),
        (
            good.replace("[\n  0,\n  100\n]", "[0, 300 # mm"),
            "m.toml:12: axes.y.travel has a list that is not closed: `]` is missing",
        ),
        (
            good.replace("max_rate = 6000\nacceleration = 500\n", "").replace("[\n  0,\n  100\n]", "[0, 300\n[laser]"),
            "m.toml:12: axes.y.travel has a list that is not closed: `]` is missing",
        ),
        (good.replace("  0,", "  0 0,"), "m.toml:13: axes.y.travel cannot be read: "),
        (format!("{good}\n[laser"), "m.toml:18: "),
    ];
    for (text, says) in cases {
        let error = Machine::read("m.toml", &file(&text)).unwrap_err();
        assert!(error.starts_with(says), "{says}\n{error}");
    }
    let error = Machine::read(
        "m.toml",
        "[axes.x]\nnumber = 1\nsteps_per_mm = 80\ntravel = [0, 1]\nmax_rate = 1\nacceleration = 1\n",
    );
    assert!(error.unwrap_err().contains("has no table [axes.y]"));
    assert!(Machine::read("m.toml", "").unwrap_err().contains("has no table [axes.x]"));
}

/// What is no value of TOML: the error says what the key wants.
#[test]
fn what_is_no_value_gets_an_example_of_one() {
    for (key, value, says) in [
        ("axes.x.alarm", "no", "it is written as `alarm = false`: true where the drive's alarm input is in use"),
        ("axes.x.alarm", "False", "it is written as `alarm = false`: true where"),
        ("axes.x.max_rate", "100mm", "it is written as `max_rate = 12000`: greatest speed, mm/min"),
        ("axes.z.steps_per_mm", "100,5", "it is written as `steps_per_mm = 100`: pulses a mm"),
        ("laser.pulse_width_us", "4us", "it is: pulse width of the frequency mode, µs"),
        ("family", "gus", "it is written as `family = \"gus\"`: laser family"),
    ] {
        let error = with(key, value).unwrap_err();
        assert!(error.contains(&format!(": {key} cannot be read: ")), "{error}");
        assert!(error.contains(says) && !error.contains("nan"), "{error}");
    }
}

/// A layer of the command line: each error names the key and what is allowed.
#[test]
fn typing_errors_of_a_layer_name_the_key() {
    let (_, machine) = write(&questions("XY", true)).unwrap();
    let given = |text: &str| {
        let mut machine = machine.clone();
        machine.add_layers(&[text.to_owned()]).map(|()| machine.layers.remove(0))
    };
    for (text, says) in [
        ("power=20%,speed=600", "power is `20%`; it is a number, in the unit of laser.power and without it"),
        ("power=,speed=600", "power is ``; it is a number, in the unit of laser.power and without it"),
        ("power=20,speed=600mm/min", "speed is `600mm/min`; it is a number, in mm/min and without the unit"),
        ("power=20 speed=3000", "power is `20 speed=3000`; a comma is missing before `speed`"),
        ("colour=#f00 power=2,speed=6", "colour is `#f00 power=2`; a comma is missing before `power`"),
        ("power=2,speed=6,passes=1.5", "passes is `1.5`; it is a whole number"),
        ("power=2,speed=6,order=first", "order is `first`; it is a whole number"),
        ("power=2,speed=6,light=m4", "light is `m4`; it is follow or constant"),
        ("skip=yes", "skip is `yes`; it is true or false"),
        (
            "colour=0000ff,skip=true",
            "colour is \"0000ff\"; a colour is \"#rrggbb\", or a number of AutoCAD from 1 to 255; write \"#0000ff\"",
        ),
        ("colour=000011,skip=true", "write \"#000011\""),
        ("colour=123456,skip=true", "write \"#123456\""),
        ("colour=256,skip=true", "colour is 256; a colour is \"#rrggbb\", or a number of AutoCAD from 1 to 255"),
        ("power=nan,speed=600", "power is NaN; it is 0 to 100 % (laser.power)"),
    ] {
        let error = given(text).unwrap_err();
        assert!(error.starts_with(&format!("--layer {text}: ")) && error.ends_with(says), "{text}: {error}");
    }
    let layer = given("name=5,layer=007,colour=30,power=1e1,speed=+600,light=constant,passes=2,order=-1").unwrap();
    assert_eq!((layer.name.as_str(), layer.drawing_layer.as_deref()), ("5", Some("007")));
    assert_eq!((layer.power, layer.speed, layer.passes, layer.order), (10.0, 600.0, 2, -1));
    assert_eq!(given("colour=#0000ff,skip=true").unwrap().colour, Some(machine::Colour::Rgb([0, 0, 255])));
}

#[test]
fn modes_need_what_is_theirs() {
    let laser = |lines: &str, family: &str, number: u8| {
        let axis = |letter: char, number: u8| {
            format!(
                "[axes.{letter}]\nnumber = {number}\nsteps_per_mm = 80\ntravel = [0, 9]\nmax_rate = 60\nacceleration = 5\n"
            )
        };
        let text = format!("family = \"{family}\"\n{}{}[laser]\n{lines}", axis('x', 1), axis('y', number));
        Machine::read("m.toml", &text)
    };
    let pulses = "channel = 0\nmode = \"frequency\"\npulse_width_us = 4\npower = [0, 20]\ns_max = 255\n";
    let found = laser(pulses, "gus", 2).unwrap().lasers.remove(0);
    assert_eq!((found.mode, found.pulse_width_us, found.power, found.unit()), (Mode::Frequency, 4, (0.0, 20.0), "kHz"));
    let volts = "channel = 1\nmode = \"analog\"\npower = [0, 5]\ns_max = 255\n";
    assert_eq!(laser(volts, "gus", 8).unwrap().lasers.remove(0).unit(), "V");
    for (lines, family, number, says) in [
        (
            pulses.replace("pulse_width_us = 4\n", ""),
            "gus",
            2,
            "laser has no pulse_width_us; the frequency mode needs it",
        ),
        (pulses.replace("20]", "30]"), "lsr", 2, "laser.power is [0, 30]; it is"),
        (pulses.replace("[0, 20]", "[0.0001, 20]"), "lsr", 2, "and 0.001 to 24 kHz"),
        (
            pulses.replace("= 4\n", "= 4001\n"),
            "lsr",
            2,
            "laser.pulse_width_us is 4001; it is a whole number from 1 to 4000 µs",
        ),
        (volts.replace("5]", "11]"), "gus", 2, "and 0.001 to 10 V"),
        (pulses.to_owned(), "gus", 7, "laser.channel is 0: in family gus it uses the connector of axis 7"),
    ] {
        let error = laser(&lines, family, number).unwrap_err();
        assert!(error.contains(says), "{says}\n{error}");
    }
    assert!(laser(pulses, "lsr", 7).is_ok());
}

#[test]
fn figures_in_pulses_are_those_of_the_axis() {
    let machine = with("axes.x.steps_per_mm", "160").unwrap();
    let axis = machine.axis('X').unwrap();
    // 12000 mm/min are 0.2 mm/ms; 1000 mm/s² are 0.001 mm/ms².
    assert!((axis.rate() - 32.0).abs() < 1e-12 && (axis.pulse_acceleration() - 0.16).abs() < 1e-12);
}

#[test]
fn layers_are_checked_and_an_unknown_key_names_the_nearest() {
    let with = |lines: &str| {
        let (text, _) = write(&questions("XY", true)).unwrap();
        let count = text.lines().count();
        (Machine::read("m.toml", &format!("{text}[[layers]]\npower = 5\nspeed = 600\n{lines}\n")), count + 4)
    };
    for (lines, says) in [
        ("pases = 2", "layers.pases cannot be read: unknown field `pases`"),
        ("pases = 2", "the nearest known key is `passes`"),
        ("passes = 0", "layers.passes is 0; it is a whole number from 1 to 1000"),
        ("passes = 1001", "layers.passes is 1001"),
        ("colour = \"red\"", "layers.colour is \"red\"; a colour is \"#rrggbb\", or a number of AutoCAD from 1 to 255"),
        ("colour = \"#ff00\"", "layers.colour is \"#ff00\""),
        ("colour = 256", "layers.colour is 256"),
        ("light = \"m4\"", "layers.light cannot be read"),
        ("[[layers]]\npower = 101\nspeed = 5", "layers.power is 101; it is 0 to 100 % (laser.power)"),
        ("[[layers]]\npower = nan\nspeed = 5", "layers.power is NaN"),
        ("[[layers]]\nspeed = 0\npower = 5", "layers.speed is 0; it is 0.001 to 10000000 mm/min"),
    ] {
        let (read, line) = with(lines);
        let error = read.unwrap_err();
        let line = line + usize::from(lines.starts_with('['));
        assert!(error.starts_with(&format!("m.toml:{line}: ")) && error.contains(says), "{lines}: {error}");
    }
    // What no key is like names none.
    let error = with("wat = 2").0.unwrap_err();
    assert!(error.contains("unknown field `wat`") && !error.contains("nearest"), "{error}");
    for lines in ["[[layers]]\nspeed = 5", "[[layers]]\npower = 5"] {
        let error = with(lines).0.unwrap_err();
        assert!(error.contains("a layer needs power and speed, or skip = true"), "{error}");
    }
    let machine = with("colour = \"#a0f\"\n[[layers]]\ncolour = 30\nlayer = \"CUT\"\nskip = true").0.unwrap();
    assert_eq!(machine.layers[0].colour, Some(machine::Colour::Rgb([0xaa, 0, 0xff])));
    assert_eq!((machine.layers[1].colour, machine.layers[1].skip), (Some(machine::Colour::Index(30)), true));
}

#[test]
fn two_lasers_have_names_and_a_channel_each() {
    let axis = |letter: char, number: u8| {
        format!(
            "[axes.{letter}]\nnumber = {number}\nsteps_per_mm = 80\ntravel = [0, 9]\nmax_rate = 60\nacceleration = 5\n"
        )
    };
    let laser = |table: &str, channel: u8, mode: &str| {
        let carrier = if mode == "duty" { "carrier_khz = 10\n" } else { "" };
        format!("[{table}]\nchannel = {channel}\nmode = \"{mode}\"\n{carrier}power = [0, 10]\ns_max = 255\n")
    };
    let file = |tables: &[String]| axis('x', 1) + &axis('y', 2) + &tables.concat();
    // Twelve lines of axes, then six or five of each laser.
    let (zebra, ant) = (laser("lasers.zebra", 1, "duty"), laser("lasers.ant", 0, "analog"));
    let both = file(&[zebra.clone(), ant.clone()]);
    let machine = Machine::read("m.toml", &both).unwrap();
    let named = |machine: &Machine| machine.laser().unwrap().name.clone().unwrap();
    assert_eq!((machine.lasers.len(), named(&machine).as_str()), (2, "zebra"), "the first of the file");
    assert_eq!(named(&Machine::read_for("m.toml", &both, Some("ant")).unwrap()), "ant");
    // In one table, too.
    let inline = file(&["[lasers]\nzebra = { channel = 1, mode = \"analog\", power = [0, 9], s_max = 1 }\n\
                        ant = { channel = 0, mode = \"analog\", power = [0, 9], s_max = 1 }\n"
        .to_owned()]);
    assert_eq!(named(&Machine::read("m.toml", &inline).unwrap()), "zebra");
    // One laser may have a name, and layers may say it.
    let layer = |lines: &str| format!("[[layers]]\npower = 9\nspeed = 6\n{lines}\n");
    let one = file(&[zebra.clone(), layer("laser = \"zebra\"")]);
    assert_eq!(Machine::read("m.toml", &one).unwrap().layers[0].laser, 0);
    let machine = Machine::read("m.toml", &(both.clone() + &layer("") + &layer("laser = \"ant\""))).unwrap();
    assert_eq!([machine.layers[0].laser, machine.layers[1].laser], [0, 1]);
    let shown = machine::show(&machine);
    assert!(shown.contains("laser \"zebra\": channel 1, duty") && shown.contains("laser \"ant\": channel 0, voltage"));
    assert!(shown.contains("laser \"ant\", 9 V at 6 mm/min"), "{shown}");
    let cases = [
        (
            file(&[zebra.clone(), laser("laser", 0, "analog")]),
            "m.toml:19: laser stands beside [lasers.NAME]; a machine has one laser, [laser], or named ones: give this one \
             a name, as [lasers.NAME], or remove it",
        ),
        (
            file(&[zebra.clone(), laser("lasers.ant", 1, "analog")]),
            "m.toml:20: lasers.ant.channel is 1, as lasers.zebra.channel; each laser has its own: 0 or 1",
        ),
        (
            file(&[zebra.clone(), ant.clone(), laser("lasers.bee", 0, "analog")]),
            "m.toml:24: lasers.bee is one laser too many; a machine has 2, one for each channel: remove one",
        ),
        (file(&["[lasers]\n".to_owned()]), "m.toml:13: lasers holds no laser; each has a table [lasers.NAME]"),
        (
            file(&["[lasers]\nchannel = 0\n".to_owned()]),
            "m.toml:14: lasers.channel cannot be read: invalid type: integer `0`, expected the table LaserKeys; a laser \
             has a table with its name, as [lasers.cut]",
        ),
        (
            file(&[laser("lasers.\"a b\"", 0, "analog")]),
            "m.toml:13: lasers.\"a b\" is no name of a laser; it is 1 to 32 letters, digits, - and _",
        ),
        (
            file(&[laser("lasers.ant", 2, "analog")]),
            "m.toml:14: lasers.ant.channel is 2; it is a whole number from 0 to 1",
        ),
        (file(&[ant.replace("power = [0, 10]", "power = [0, 11]")]), "m.toml:16: lasers.ant.power is [0, 11]; it is"),
        (file(&[ant.replace("s_max", "smax")]), "m.toml:17: lasers.ant.smax cannot be read: unknown field `smax`"),
        (
            both.clone() + &layer("laser = \"bee\""),
            "m.toml:27: layers.laser is \"bee\"; lasers are \"zebra\" and \"ant\"",
        ),
        (
            file(&[zebra.clone(), layer("laser = \"bee\"")]),
            "m.toml:22: layers.laser is \"bee\"; the only laser is \"zebra\"",
        ),
        (
            file(&[laser("laser", 0, "duty"), layer("laser = \"bee\"")]),
            "m.toml:22: layers.laser is \"bee\"; the machine file has one laser, [laser], which has no name: leave this out",
        ),
        (
            file(&[layer("laser = \"bee\"").replace("9", "0")]),
            "m.toml:16: layers.laser is \"bee\"; the machine file has no laser",
        ),
        (
            both.clone() + &layer("laser = \"ant\"").replace("9", "11"),
            "m.toml:25: layers.power is 11; it is 0 to 10 V (lasers.ant.power)",
        ),
        (
            file(&[zebra.replace("channel = 1", "channel = 0"), ant.replace("channel = 0", "channel = 1")])
                .replace("number = 2", "number = 7"),
            "m.toml:14: lasers.zebra.channel is 0: in family gus it uses the connector of axis 7",
        ),
    ];
    for (text, says) in cases {
        let error = Machine::read("m.toml", &text).unwrap_err();
        assert!(error.starts_with(says), "{says}\n{error}");
    }
    let error = Machine::read_for("m.toml", &both, Some("bee")).unwrap_err();
    assert_eq!(error, "m.toml: --laser is \"bee\"; lasers are \"zebra\" and \"ant\"");
}
