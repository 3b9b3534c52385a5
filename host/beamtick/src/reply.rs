//! Packed requests and replies as text, by the protocol's own table.
use protocol::command::{CommandInfo, Request, SetLaserDisTable1D, SetLaserDisTable2D, info, widths};
use protocol::reason::stop_reason;

/// Fields of `bytes`, as far as they reach.
fn fields(layout: &[(&'static str, &'static str)], bytes: &mut &[u8]) -> Vec<(&'static str, String)> {
    layout.iter().map_while(|(name, of)| Some((*name, field(of, bytes)?))).collect()
}

fn field(of: &str, bytes: &mut &[u8]) -> Option<String> {
    macro_rules! number {
        ($($name:literal $type:ty),*) => {
            match of {
                $( $name => {
                    let (head, rest) = bytes.split_first_chunk()?;
                    *bytes = rest;
                    Some(<$type>::from_le_bytes(*head).to_string())
                } )*
                "[u8; 16]" => {
                    let (head, rest) = bytes.split_first_chunk::<16>()?;
                    *bytes = rest;
                    Some(String::from_utf8_lossy(head).trim_end_matches('\0').to_owned())
                }
                _ => elements(of, bytes).map(|elements| elements.join("/")),
            }
        };
    }
    number!("F64" f64, "I16" i16, "I32" i32, "U16" u16, "U32" u32, "U64" u64, "u8" u8)
}

/// The elements of an array.
fn elements(of: &str, bytes: &mut &[u8]) -> Option<Vec<String>> {
    let (of, count) = of.strip_prefix('[')?.strip_suffix(']')?.split_once("; ")?;
    (0..count.parse::<usize>().ok()?).map(|_| field(of, bytes)).collect()
}

/// A request's fields as `name value`, without its items.
pub fn request(opcode: u16, mut body: &[u8]) -> String {
    let Some(info) = info(opcode) else { return String::new() };
    let mut text: Vec<String> =
        fields(info.fields, &mut body).iter().map(|(name, value)| format!("{name} {value}")).collect();
    if !body.is_empty() {
        text.push(format!("and {} bytes of items", body.len()));
    }
    text.join(", ")
}

/// Items that a read asks for; none for a command whose items go in pieces.
fn asked(info: &CommandInfo, mut request: &[u8]) -> usize {
    let values = fields(info.fields, &mut request);
    let value = |wanted: &str| values.iter().find(|(name, _)| *name == wanted).map(|(_, value)| value);
    match (value("count"), value("first")) {
        (Some(count), None) if !info.reply_items.is_empty() => count.parse().unwrap_or(0),
        _ => 0,
    }
}

/// What the reply to a request says: `name value`, a value for each item that was asked for. What
/// lies past the last axis is 0.
pub fn reply(opcode: u16, request: &[u8], mut body: &[u8]) -> String {
    let Some(info) = info(opcode) else { return String::new() };
    let mut text: Vec<String> = Vec::new();
    for (name, value) in fields(info.reply, &mut body) {
        // The clock is in the summary; the count is that of the values shown.
        match name {
            "clock_ms" | "count" if !info.reply_items.is_empty() => {}
            "value" => text.push(value),
            _ => text.push(format!("{name} {value}")),
        }
    }
    let nothing = vec![0; widths(info.reply_items)];
    let mut left = asked(info, request);
    let mut rest = body;
    while !rest.is_empty() || left > 0 {
        if rest.is_empty() {
            rest = &nothing;
        }
        let item = fields(info.reply_items, &mut rest);
        if item.is_empty() {
            break;
        }
        left = left.saturating_sub(1);
        let values: Vec<String> = item.into_iter().map(|(_, value)| value).collect();
        let shown = values.join("/");
        text.push(match shown.parse::<i32>() {
            Ok(status) if info.name == "GetSts" => format!("{status:#x}"),
            _ => shown,
        });
    }
    text.join(" ")
}

/// Why motion stopped, of a reply that reports it: the number and the text.
pub fn stop(opcode: u16, mut body: &[u8]) -> Option<String> {
    let info = info(opcode)?;
    let values = fields(&[info.reply, info.reply_items].concat(), &mut body);
    let (_, number) = values.iter().find(|(name, _)| *name == "reason")?;
    Some(format!("{number} ({})", stop_reason(number.parse().ok()?)))
}

/// What a laser command did not take as it was given: a text for each bit of its reply's `limited`.
pub fn limited(opcode: u16, mut body: &[u8]) -> Vec<String> {
    let Some(info) = info(opcode) else { return Vec::new() };
    // LaserStatus uses the word for a state.
    if info.reply.last().is_none_or(|(name, _)| *name != "held") {
        return Vec::new();
    }
    // Nearly always nothing was. The word is the last field, of one byte or two.
    let fixed = body.get(..widths(info.reply)).unwrap_or_default();
    let word = fixed.get(widths(info.reply.split_last().map_or(&[], |(_, before)| before))..).unwrap_or_default();
    let bits = word.iter().rev().fold(0u16, |bits, byte| bits << 8 | u16::from(*byte));
    if bits == 0 {
        return Vec::new();
    }
    let mut values: Vec<(String, String)> = Vec::new();
    for (name, of) in info.reply {
        // Of an array, each element has a bit.
        match elements(of, &mut body) {
            Some(parts) => values.extend(parts.into_iter().zip(1..).map(|(part, k)| (format!("{name} {k}"), part))),
            None => values.extend(field(of, &mut body).map(|value| ((*name).to_owned(), value))),
        }
    }
    values.pop();
    if values.is_empty() {
        // Of a table, it is how many points.
        let text = match bits {
            1 => "a power is out of range; its nearest bound is taken".to_owned(),
            points => format!("{points} powers are out of range; their nearest bounds are taken"),
        };
        return vec![text];
    }
    let mut texts: Vec<String> = Vec::new();
    for (place, (name, value)) in values.iter().enumerate() {
        if bits >> place & 1 == 1 {
            let name = if name == "value" { "the value" } else { name };
            texts.push(format!("{name} is out of range; {value} is taken"));
        }
    }
    if opcode == SetLaserDisTable1D::OPCODE || opcode == SetLaserDisTable2D::OPCODE {
        // Bounds come back, limits do not.
        if bits >> values.len() & 1 == 1 {
            texts.push("limitPower is out of range; its nearest bound is taken".into());
        }
    }
    if bits >> 7 == 1 {
        texts.push(
            "the pulse width reaches the period at the highest rate; there it is limited to just under it".into(),
        );
    }
    texts
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::command::{GetJogPrm, GetPrfPos, GetSts, JogPrm, Long, PtData, PtSpace, Real, Reals, Short};
    use protocol::command::{LaserBounds, LaserPowerMode, LaserState, LaserStatus, LaserValue, SetPulseWidth};
    use zerocopy::IntoBytes;

    #[test]
    fn requests_and_replies_by_the_table() {
        let data = PtData {
            core: 1.into(),
            profile: 2.into(),
            pos: 0.5.into(),
            time_ms: 16.into(),
            kind: 2.into(),
            fifo: 0.into(),
        };
        assert_eq!(request(PtData::OPCODE, data.as_bytes()), "core 1, profile 2, pos 0.5, time_ms 16, kind 2, fifo 0");
        assert_eq!(reply(PtSpace::OPCODE, &[], Short { value: 32.into() }.as_bytes()), "32");
        let mut bytes = Reals { clock_ms: 5.into(), count: 2.into() }.as_bytes().to_vec();
        bytes.extend([Real { value: 1.5.into() }, Real { value: (-2.0).into() }].as_bytes());
        assert_eq!(reply(GetPrfPos::OPCODE, &[], &bytes), "1.5 -2");
        let mut bytes = Reals { clock_ms: 5.into(), count: 1.into() }.as_bytes().to_vec();
        bytes.extend(Long { value: 0xa00.into() }.as_bytes());
        assert_eq!(reply(GetSts::OPCODE, &[], &bytes), "0xa00");
        let past = GetSts { core: 1.into(), axis: 8.into(), count: 3.into() };
        assert_eq!(reply(GetSts::OPCODE, past.as_bytes(), &bytes), "0xa00 0x0 0x0");
        let jog = JogPrm { acc: 1.0.into(), dec: 0.5.into(), smooth: 0.0.into() };
        assert_eq!(reply(GetJogPrm::OPCODE, &[], jog.as_bytes()), "acc 1 dec 0.5 smooth 0");
        assert_eq!(reply(PtSpace::OPCODE, &[], &[1]), "");
    }

    #[test]
    fn what_was_held_is_named() {
        let bounds = |held| LaserBounds { max: 24.0.into(), min: 0.5.into(), held }.as_bytes().to_vec();
        assert!(limited(LaserPowerMode::OPCODE, &bounds(0)).is_empty());
        assert_eq!(limited(LaserPowerMode::OPCODE, &bounds(1)), ["max is out of range; 24 is taken"]);
        assert_eq!(limited(LaserPowerMode::OPCODE, &bounds(3)).len(), 2);
        let value = LaserValue { value: 4000.0.into(), held: 0x81 };
        let texts = limited(SetPulseWidth::OPCODE, value.as_bytes());
        assert_eq!(texts[0], "the value is out of range; 4000 is taken");
        assert!(texts[1].contains("limited"), "{texts:?}");
        assert!(limited(LaserStatus::OPCODE, LaserState { held: 1, ..LaserState::default() }.as_bytes()).is_empty());
        assert!(limited(PtSpace::OPCODE, Short { value: 32.into() }.as_bytes()).is_empty());
    }
}
