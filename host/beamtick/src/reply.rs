//! Packed requests and replies as text, by the protocol's own table.
use protocol::command::COMMANDS;

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
                _ => None,
            }
        };
    }
    number!("F64" f64, "I16" i16, "I32" i32, "U16" u16, "U32" u32, "U64" u64, "u8" u8)
}

/// A request's fields as `name value`, without its items.
pub fn request(opcode: u16, mut body: &[u8]) -> String {
    let Some(info) = COMMANDS.iter().find(|info| info.opcode == opcode) else { return String::new() };
    let mut text: Vec<String> =
        fields(info.fields, &mut body).iter().map(|(name, value)| format!("{name} {value}")).collect();
    if !body.is_empty() {
        text.push(format!("and {} bytes of items", body.len()));
    }
    text.join(", ")
}

/// What a reply says: `name value`, a value for each item.
pub fn reply(opcode: u16, mut body: &[u8]) -> String {
    let Some(info) = COMMANDS.iter().find(|info| info.opcode == opcode) else { return String::new() };
    let mut text: Vec<String> = Vec::new();
    for (name, value) in fields(info.reply, &mut body) {
        // The clock is in the summary; the count is that of the values shown.
        match name {
            "clock_ms" | "count" if !info.reply_items.is_empty() => {}
            "value" => text.push(value),
            _ => text.push(format!("{name} {value}")),
        }
    }
    while !body.is_empty() {
        let item = fields(info.reply_items, &mut body);
        if item.is_empty() {
            break;
        }
        let values: Vec<String> = item.into_iter().map(|(_, value)| value).collect();
        let shown = values.join("/");
        text.push(match shown.parse::<i32>() {
            Ok(status) if info.name == "GetSts" => format!("{status:#x}"),
            _ => shown,
        });
    }
    text.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::command::{GetJogPrm, GetPrfPos, GetSts, JogPrm, Long, PtData, PtSpace, Real, Reals, Request, Short};
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
        assert_eq!(reply(PtSpace::OPCODE, Short { value: 32.into() }.as_bytes()), "32");
        let mut bytes = Reals { clock_ms: 5.into(), count: 2.into() }.as_bytes().to_vec();
        bytes.extend([Real { value: 1.5.into() }, Real { value: (-2.0).into() }].as_bytes());
        assert_eq!(reply(GetPrfPos::OPCODE, &bytes), "1.5 -2");
        let mut bytes = Reals { clock_ms: 5.into(), count: 1.into() }.as_bytes().to_vec();
        bytes.extend(Long { value: 0xa00.into() }.as_bytes());
        assert_eq!(reply(GetSts::OPCODE, &bytes), "0xa00");
        let jog = JogPrm { acc: 1.0.into(), dec: 0.5.into(), smooth: 0.0.into() };
        assert_eq!(reply(GetJogPrm::OPCODE, jog.as_bytes()), "acc 1 dec 0.5 smooth 0");
        assert_eq!(reply(PtSpace::OPCODE, &[1]), "");
    }
}
