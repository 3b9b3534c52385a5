//! Calls as statements of a job, so that a random program can be pasted and run by hand.
use super::{Call, Kind, Setup};
use crate::reference::follow::{Asymmetric, Datum, Item};
use crate::reference::light::Family;
use crate::reference::pvt::Points;

impl Setup {
    /// A statement of a job, the one with this number.
    pub fn text(&self, number: usize, call: &Call) -> String {
        let at = |axis: &usize| {
            let (core, axis) = self.axes[*axis];
            format!("{core},{axis}")
        };
        let of = |mask: &u32| {
            let (core, mask) = self.mask(*mask);
            format!("{core},{mask}")
        };
        let both = |mask: &u32, option: &u32| {
            let (core, bits) = self.mask(*mask);
            format!("{core},{bits},{}", self.mask(*option & *mask).1)
        };
        let written = match call {
            Call::Sleep { ns } => return format!("Sleep({});", *ns as f64 / 1e6),
            // A job has one tick.
            Call::SetTick { us } => return format!("// GT_SetTick({us});"),
            Call::WaitStop { mask } => {
                let (core, bits) = self.mask(*mask);
                return format!("WaitStop({core},{bits},0);");
            }
            Call::Axis { kind, axis } => return self.plain(*kind, &at(axis)),
            Call::Stop { mask, abrupt } => format!("GTN_Stop({})", both(mask, abrupt)),
            Call::SetPrfPos { axis, pos } => format!("GTN_SetPrfPos({},{pos})", at(axis)),
            Call::SetStopDec { axis, smooth } => format!("GTN_SetStopDec({},{smooth:?},1000)", at(axis)),
            Call::SetEncPos { axis, pos } => format!("GTN_SetEncPos({},{pos})", at(axis)),
            Call::SynchAxisPos { mask } => format!("GTN_SynchAxisPos({})", of(mask)),
            Call::SetAxisBand { axis, band, time } => format!("GTN_SetAxisBand({},{band},{time})", at(axis)),
            Call::SetPosErr { axis, error } => format!("GTN_SetPosErr({},{error})", at(axis)),
            Call::SetSoftLimit { axis, positive, negative } => {
                format!("GTN_SetSoftLimit({},{positive},{negative})", at(axis))
            }
            Call::SetTrapPrm { axis, acc, dec } => {
                return format!("trap.acc = {acc:?}; trap.dec = {dec:?}; rtn = GTN_SetTrapPrm({},&trap);", at(axis));
            }
            Call::SetJogPrm { axis, acc, dec } => {
                return format!("jog.acc = {acc:?}; jog.dec = {dec:?}; rtn = GTN_SetJogPrm({},&jog);", at(axis));
            }
            Call::SetPos { axis, pos } => format!("GTN_SetPos({},{pos})", at(axis)),
            Call::SetVel { axis, vel } => format!("GTN_SetVel({},{vel:?})", at(axis)),
            Call::Update { mask } => format!("GTN_Update({})", of(mask)),
            Call::PrfPt { axis, mode } => format!("GTN_PrfPt({},{mode})", at(axis)),
            Call::PtData { axis, pos, time_ms, kind, fifo } => {
                format!("GTN_PtData({},{pos:?},{time_ms},{kind},{fifo})", at(axis))
            }
            Call::PtClear { axis, fifo } => format!("GTN_PtClear({},{fifo})", at(axis)),
            Call::PtSpace { axis, fifo } => format!("GTN_PtSpace({},&space,{fifo})", at(axis)),
            Call::SetPtLoop { axis, loops } => format!("GTN_SetPtLoop({},{loops})", at(axis)),
            Call::SetPtMemory { axis, memory } => format!("GTN_SetPtMemory({},{memory})", at(axis)),
            Call::PtStart { mask, option } => format!("GTN_PtStart({})", both(mask, option)),
            Call::PrfFollow { axis, dir } => format!("GTN_PrfFollow({},{dir})", at(axis)),
            Call::SetFollowMaster { axis, master, kind, item } => {
                let (index, kind) = self.master(*axis, *master, *kind);
                format!("GTN_SetFollowMaster({},{index},{kind},{item})", at(axis))
            }
            Call::SetFollowLoop { axis, loops } => format!("GTN_SetFollowLoop({},{loops})", at(axis)),
            Call::SetFollowEvent { axis, event, dir, pos } => {
                format!("GTN_SetFollowEvent({},{event},{dir},{pos})", at(axis))
            }
            Call::FollowData { axis, datum, fifo } => {
                let Datum { master, slave, kind, .. } = datum;
                format!("GTN_FollowData({},{},{slave:?},{kind},{fifo})", at(axis), *master as i64)
            }
            Call::FollowClear { axis, fifo } => format!("GTN_FollowClear({},{fifo})", at(axis)),
            Call::FollowSpace { axis, fifo } => format!("GTN_FollowSpace({},&space,{fifo})", at(axis)),
            Call::FollowStart { mask, option } => format!("GTN_FollowStart({})", both(mask, option)),
            Call::FollowSwitch { mask } => format!("GTN_FollowSwitch({})", of(mask)),
            Call::SetFollowMemory { axis, memory } => format!("GTN_SetFollowMemory({},{memory})", at(axis)),
            Call::PvtTable { axis, table, points } => return table_text(self.axes[*axis].0, *table, points, number),
            Call::PvtCalculate { core, points } => return calculate_text(*core, points, number),
            Call::PvtTableSelect { axis, table } => format!("GTN_PvtTableSelect({},{table})", at(axis)),
            Call::SetPvtLoop { axis, loops } => format!("GTN_SetPvtLoop({},{loops})", at(axis)),
            Call::PvtStart { mask } => format!("GTN_PvtStart({})", of(mask)),
            Call::Ex(of) => return ex(&self.text(number, of)),
            Call::FollowEntry { axis, item, fifo } => entry_text(&at(axis), item, *fifo),
            Call::AsymmetricWay { core, master, ratios: [r0, r1], shares: [all, first] } => {
                format!("GTN_GetFollowDataPercent2Ex({core},{master:?},{r0:?},{r1:?},{all:?},{first:?},&value)")
            }
            Call::FollowSwitchNow { axis, table } => {
                format!("GTN_FollowSwitchNowEx({},{},0,0)", at(axis), if *table { 2 } else { 1 })
            }
            Call::Terminal { axis, kind, level } => {
                let (core, axis) = self.axes[*axis];
                format!("GTN_SimInput({core},{kind},{axis},{})", i16::from(*level))
            }
            Call::Guard { axis, kind: 2, on } => format!("GTN_Alarm{}({})", if *on { "On" } else { "Off" }, at(axis)),
            Call::Guard { axis, kind, on } => {
                format!("GTN_Lmts{}({},{kind})", if *on { "On" } else { "Off" }, at(axis))
            }
            Call::Sense { core, sense } => format!("GTN_LmtSns({core},{sense})"),
            Call::SetCapture { axis, mode } => format!("GTN_SetCaptureMode({},{mode})", at(axis)),
            Call::Effect(effect) => return effect.text(),
            Call::Light(of) => return of.text(number),
            Call::LightTable(of) => return of.text(number),
            Call::Abort { core } => format!("GTN_Abort({core})"),
            Call::Reset { core } => format!("GTN_Reset({core})"),
            Call::Path(of) => return of.text(self),
        };
        format!("rtn = {written};")
    }

    fn plain(&self, kind: Kind, axis: &str) -> String {
        let more = match kind {
            Kind::AxisOn | Kind::AxisOff | Kind::PrfTrap | Kind::PrfJog | Kind::PrfPvt => "",
            Kind::ZeroPos | Kind::ClrSts => ",1",
            Kind::GetPtLoop | Kind::GetFollowLoop | Kind::GetFollowLoopEx => ",&loops",
            Kind::GetPvtLoop => ",&loops,&word",
            Kind::GetFollowStatus | Kind::GetFollowStatusEx => ",&fifo,&pending",
            Kind::GetFollowMemory | Kind::GetFollowMemoryEx => ",&fifo",
            Kind::GetFollowEvent | Kind::GetFollowEventEx => ",&fifo,&pending,&word",
            Kind::GetFollowMaster | Kind::GetFollowMasterEx => ",&fifo,&pending,&space",
            Kind::GetStopReason => ",&fifo",
            Kind::GetCaptureStatus => ",&fifo,&word",
            Kind::GetSts | Kind::GetPrfMode | Kind::GetPos | Kind::GetPosErr => ",&word",
            Kind::GetPrfPos | Kind::GetPrfVel | Kind::GetPrfAcc | Kind::GetEncPos | Kind::GetEncVel => ",&value",
            Kind::GetVel => ",&value",
            Kind::GetTrapPrm => ",&trap",
            Kind::GetJogPrm => ",&jog",
            Kind::GetSoftLimit | Kind::GetAxisBand => ",&loops,&word",
            Kind::GetStopDec => ",&value,&place[0]",
            Kind::GetPtMemory => ",&fifo",
            Kind::PvtStatus => ",&fifo,&value",
        };
        format!("rtn = GTN_{kind:?}({axis}{more});")
    }

    /// A whole job that can be pasted.
    pub fn job<'a>(&self, tick_us: u32, calls: impl Iterator<Item = &'a Call>) -> String {
        let mut text = format!("#pragma profile {}\n#pragma tick {tick_us}\n#pragma continue\n", self.profile);
        if self.family == Family::Lsr {
            text += "#pragma family lsr\n";
        }
        text += "short rtn, space, fifo, pending; long loops, word; unsigned long light; double value;\n";
        text += "double place[4]; TCrdPrm prm; memset(&prm,0,sizeof(prm));\n";
        text += "TTrapPrm trap; TJogPrm jog;\nmemset(&trap,0,sizeof(trap)); memset(&jog,0,sizeof(jog));\n";
        for (number, call) in calls.enumerate() {
            text += &self.text(number, call);
            text.push('\n');
        }
        text
    }
}

/// A statement of Follow as one of FollowEx.
fn ex(text: &str) -> String {
    text.replacen('(', "Ex(", 1)
}

fn entry_text(at: &str, item: &Item, fifo: i16) -> String {
    match item {
        Item::Segment(datum) => {
            let Datum { master, slave, kind, percent } = datum;
            format!("GTN_FollowDataPercentEx({at},{master:?},{slave:?},{kind},{percent},{fifo})")
        }
        Item::Asymmetric(Asymmetric { master, slave, ratios: [r0, r1], percent }) => {
            format!("GTN_FollowDataPercent2Ex({at},{master:?},{slave:?},{r0:?},{r1:?},{percent},&word,{fifo})")
        }
        Item::Output { index, level } => format!("GTN_FollowDoBitEx({at},12,{index},{},{fifo})", i16::from(*level)),
        Item::Delay { cycles } => format!("GTN_FollowDelayEx({at},{cycles},{fifo})"),
        Item::Wait { index, level, ms } => {
            format!("GTN_FollowDiBitEx({at},4,{index},{},{ms},{fifo})", i16::from(*level))
        }
        Item::Switch { table } => format!("GTN_FollowSwitchNowEx({at},{},1,{fifo})", if *table { 2 } else { 1 }),
    }
}

/// A table with the declarations of its arrays.
fn table_text(core: i16, table: i16, points: &Points, number: usize) -> String {
    let column = |letter: char, values: Vec<f64>| {
        let values: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        format!("double {letter}{number}[] = {{{}}}; ", values.join(","))
    };
    fn column_of<const N: usize>(points: &[[f64; N]], index: usize) -> Vec<f64> {
        points.iter().map(|point| point[index]).collect()
    }
    fn columns<const N: usize>(points: &[[f64; N]]) -> Vec<Vec<f64>> {
        (0..N).map(|index| column_of(points, index)).collect()
    }
    let (name, columns, more) = match points {
        Points::Pvt(points) => ("PvtTable", columns(points), String::new()),
        Points::Ex(points) => ("PvtTableEx", columns(points), String::new()),
        Points::Complete(points, begin, end) => {
            let room = vec![0.0; points.len()];
            let with_room = [columns(points), vec![room.clone(), room.clone(), room]].concat();
            ("PvtTableComplete", with_room, format!(",{begin:?},{end:?}"))
        }
        Points::Percent(points, begin) => ("PvtTablePercent", columns(points), format!(",{begin:?}")),
        Points::Continuous(points, begin) => ("PvtTableContinuous", columns(points), format!(",{begin:?}")),
    };
    let count = points.count();
    let named = columns.into_iter().zip('a'..='z').collect::<Vec<_>>();
    let arguments: String = named.iter().map(|(_, letter)| format!(",{letter}{number}")).collect();
    let arrays: String = named.into_iter().map(|(values, letter)| column(letter, values)).collect();
    format!("{arrays}rtn = GTN_{name}({core},{table},{count}{arguments}{more});")
}

/// The same of what a table would have.
fn calculate_text(core: i16, points: &Points, number: usize) -> String {
    let text = table_text(core, 0, points, number);
    let room = vec!["0.0"; points.count()].join(",");
    // The number of the table and what follows the arrays go, and room for the result comes.
    let begin = if let Points::Percent(_, begin) = points { format!(",{begin:?}") } else { String::new() };
    let (arrays, call) = text.split_once("rtn = ").unwrap_or_default();
    let arguments = call.split_once(",0,").map_or("", |(_, rest)| rest);
    let columns: Vec<&str> = arguments.trim_end_matches(");").split(',').collect();
    let columns = &columns[..columns.len() - 1];
    let name = if begin.is_empty() { "Continuous" } else { "Percent" };
    format!(
        "{arrays}double o{number}[] = {{{room}}}; rtn = GTN_Pvt{name}Calculate({core},{}{begin},o{number});",
        columns.join(",")
    )
}
