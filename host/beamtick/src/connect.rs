//! The command line's link to a controller.
use crate::Failure;
use crate::command_line::{FamilyName, LinkOptions, Settings, Steps};
use crate::profile;
use client::{Client, Family, Link, Options, ProductProfile};
use protocol::reason::Reason;
use std::net::TcpListener;
use virtual_board::{Board, Config, Served, VirtualLink, share};

/// Servo tick of the virtual controller where none is asked for: the compatible value of SPEC 1.
pub const TICK_US: u32 = 250;

/// Client options from the settings; `wanted` is the profile where the command line names none.
fn options(settings: &Settings, wanted: Option<ProductProfile>) -> Result<Options, Failure> {
    let profile = match &settings.profile {
        None => wanted,
        Some(name) => Some(profile::named(name)?),
    };
    // Without a job, nothing asks for a family.
    let family = settings.family.or(wanted.map(|_| FamilyName::Gus)).map(|family| match family {
        FamilyName::Gus => Family::Gus,
        FamilyName::Lsr => Family::Lsr,
    });
    Ok(Options { profile, family, tick_us: settings.tick_us, ..Options::default() })
}

/// A virtual controller as the command line wants it.
pub fn config(tick_us: Option<u32>, profile: ProductProfile, steps: Steps) -> Config {
    let board = Config { tick_us: tick_us.unwrap_or(TICK_US), profile: profile as u8, ..Config::default() };
    Config { step_limit: steps.limit.unwrap_or(board.step_limit), ..board }
}

/// The client of a virtual controller.
pub fn simulated(settings: &Settings, steps: Steps, wanted: Option<ProductProfile>) -> Result<Client, Failure> {
    let options = options(settings, wanted)?;
    let config = config(settings.tick_us, options.profile.unwrap_or(ProductProfile::Gus), steps);
    let board = share(Board::new(config));
    Ok(Client::open(Box::new(VirtualLink::new(board)), options)?)
}

/// A virtual controller in real time, and a link to it.
pub fn real_time(tick_us: Option<u32>, profile: ProductProfile) -> Result<(Served, Box<dyn Link>), Failure> {
    let failed = |error| Failure::Job(format!("the virtual controller cannot listen: {error}"));
    let listener = TcpListener::bind("127.0.0.1:0").map_err(failed)?;
    let config = config(tick_us, profile, Steps::default());
    let served = virtual_board::serve(listener, None, config).map_err(failed)?;
    let link = client::link::open(&format!("tcp:{}", served.address()))?;
    Ok((served, link))
}

/// What a link may be.
const LINKS: [&str; 4] = ["tcp", "serial", "qemu", "virtual"];

/// The rate of the reference board's ST-LINK.
const RATE: &str = "3000000";

/// The link that a name of a port alone stands for, with its rate or without.
fn of_port(name: &str) -> Option<String> {
    let (port, rate) = name.rsplit_once(':').unwrap_or((name, RATE));
    let is_com = |port: &str| {
        let number = port.trim_start_matches("\\\\.\\").to_ascii_uppercase();
        number.strip_prefix("COM").is_some_and(|number| number.parse::<u16>().is_ok())
    };
    let is_port = |port: &str| port.starts_with("/dev/") || is_com(port);
    let is_rate = !rate.is_empty() && rate.bytes().all(|byte| byte.is_ascii_digit());
    is_port(port).then(|| format!("serial:{port}:{}", if is_rate { rate } else { RATE }))
}

/// Fails where a name is none of a link.
pub fn check(name: &str) -> Result<(), Failure> {
    let (kind, place) = name.split_once(':').map_or((name, None), |(kind, place)| (kind, Some(place)));
    let port = of_port(name).map(|link| format!("; this is a serial port: --link {link}"));
    let near = || match job::nearest(kind, LINKS.into_iter()).first() {
        Some(known) if *known != kind => format!("; the nearest known word is {known}"),
        _ => String::new(),
    };
    let is_link = match (kind, place) {
        ("tcp", Some(place)) => place.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok()),
        ("serial", Some(port)) => match client::link::wrong_rate(name) {
            Some(why) => return Err(Failure::Input(format!("--link {name}: {why}"))),
            None => !port.is_empty(),
        },
        ("qemu", _) | ("virtual", None) => true,
        _ => false,
    };
    if is_link {
        return Ok(());
    }
    let known = "a link is tcp:HOST:PORT, serial:PATH[:BAUD], qemu or virtual";
    Err(Failure::Input(format!("--link {name}: {known}{}", port.unwrap_or_else(near))))
}

/// The link of this name.
pub fn named(name: &str, options: &LinkOptions) -> Result<Box<dyn Link>, Failure> {
    check(name)?;
    Ok(match name {
        "qemu" => {
            let image = client::qemu::image(options.image.clone()).map_err(|error| Failure::Input(error.reason))?;
            client::link::open(&format!("qemu:{}", image.display()))?
        }
        name => client::link::open(name)?,
    })
}

/// What else may be at a serial port.
const OTHER_IMAGE: &str = "Look at the port and its rate. On a Nucleo the bring-up image may still run: flash the board's own (fifth \
    step of docs/bring-up.md)";

/// A client over a link; `reason` says why a job wants a larger profile than the first.
pub fn linked(
    link: Box<dyn Link>,
    settings: &Settings,
    wanted: Option<ProductProfile>,
    reason: Option<&str>,
) -> Result<Client, Failure> {
    let options = options(settings, wanted)?;
    let profile = options.profile;
    let is_serial = link.name().starts_with("serial:");
    Client::open(link, options).map_err(|error| {
        if is_serial && error.code == client::error::NO_ANSWER {
            return Failure::Job(format!("error {}: {error}. {OTHER_IMAGE}", error.code));
        }
        let too_large = error.refusal.is_some_and(|refusal| refusal.reason.get() == Reason::ProfileTooLarge as u16);
        match profile.zip(reason).filter(|_| too_large && settings.profile.is_none()) {
            Some((profile, reason)) => Failure::Job(format!(
                "error {}: {error}\nThe job's {reason}, which profile {} holds; --profile NAME chooses another.",
                error.code,
                profile.name()
            )),
            None => error.into(),
        }
    })
}
