//! Edges at the ends of jumpers, in counts of TIM2, by its capture channels and DMA.
//!
//! In: ends, edges. Out: counts since the beginning of a tick. Owns TIM2's channels, streams 3 to 6
//! of DMA1 and a buffer. An edge takes some counts to the capture register, the same for every
//! channel. Fails: edges beyond the buffer are not kept.
use crate::report::Report;
use crate::wires::End;
use core::sync::atomic::{AtomicU32, Ordering, fence};
use stm32_metapac::dma::vals::{Dir, Pl, Size};
use stm32_metapac::timer::vals::CcmrInputCcs;
use stm32_metapac::{DMA1, DMAMUX1, TIM2};

/// Edges kept of a channel.
pub const EDGES: usize = 128;
const CHANNELS: usize = 4;
/// The stream, and channel of DMAMUX1, of the first channel.
const STREAM: usize = 3;
/// TIM2_CH1 there (RM0433 17.3.2); the others follow.
const TIM2_CH1: u8 = 18;

#[unsafe(link_section = ".dma.captures")]
static COUNTS: [[AtomicU32; EDGES]; CHANNELS] = [const { [const { AtomicU32::new(0) }; EDGES] }; CHANNELS];

/// Edges that are captured.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// To the low level.
    Falling,
    /// To the high level.
    Rising,
    /// Both.
    Any,
}

/// Begins to capture these; whatever was captured before is dropped.
pub fn begin(captures: &[(End, Edge)]) {
    stop();
    captures.iter().for_each(|(end, edge)| begin_into(*end, *edge, &COUNTS[end.channel]));
}

/// Begins to capture edges of an end into these words. Its channel stands.
pub fn begin_into(end: End, edge: Edge, words: &'static [AtomicU32]) {
    let channel = end.channel;
    let stream = DMA1.st(STREAM + channel);
    DMAMUX1.ccr(STREAM + channel).write(|w| w.set_dmareq_id(TIM2_CH1 + channel as u8));
    stream.par().write_value(TIM2.ccr(channel).as_ptr() as u32);
    stream.m0ar().write_value(words.as_ptr() as u32);
    stream.ndtr().write(|w| w.set_ndt(words.len() as u16));
    stream.cr().write(|w| {
        w.set_dir(Dir::PERIPHERAL_TO_MEMORY);
        w.set_minc(true);
        w.set_psize(Size::BITS32);
        w.set_msize(Size::BITS32);
        w.set_pl(Pl::LOW);
        w.set_en(true);
    });
    TIM2.ccmr_input(channel / 2).modify(|w| w.set_ccs(channel % 2, CcmrInputCcs::TI4));
    TIM2.ccer().modify(|w| {
        w.set_ccp(channel, edge != Edge::Rising);
        w.set_ccnp(channel, edge == Edge::Any);
        w.set_cce(channel, true);
    });
    // A capture of before is fetched: it asks for nothing.
    TIM2.ccr(channel).read();
    TIM2.dier().modify(|w| w.set_ccde(channel, true));
}

/// Ends all captures; what was captured stays.
pub fn stop() {
    for channel in 0..CHANNELS {
        TIM2.dier().modify(|w| w.set_ccde(channel, false));
        TIM2.ccer().modify(|w| w.set_cce(channel, false));
        let stream = DMA1.st(STREAM + channel);
        stream.cr().modify(|w| w.set_en(false));
        while stream.cr().read().en() {}
        let (half, flag) = ((STREAM + channel) / 4, (STREAM + channel) % 4);
        DMA1.ifcr(half).write(|w| {
            w.set_tcif(flag, true);
            w.set_htif(flag, true);
            w.set_teif(flag, true);
            w.set_dmeif(flag, true);
            w.set_feif(flag, true);
        });
    }
    // Before the buffer is read.
    fence(Ordering::SeqCst);
}

/// Edges captured so far of an end.
pub fn count(end: End) -> usize {
    EDGES - left(end)
}

/// Words of an end that no edge has filled yet.
pub fn left(end: End) -> usize {
    DMA1.st(STREAM + end.channel).ndtr().read().ndt().into()
}

/// The words of an end's channel.
pub fn counts(end: End) -> &'static [AtomicU32] {
    &COUNTS[end.channel]
}

/// Reports the edges of an end, after [`stop`]: the line's name, then counts, the first `most`.
// In place of its callers it would take a KiB of the stack for each of them.
#[inline(never)]
pub fn report_to(report: &mut Report, name: &str, end: End, most: usize) {
    let mut counts = [0; EDGES];
    let kept = count(end).min(most).min(EDGES);
    for (to, from) in counts.iter_mut().zip(&COUNTS[end.channel]) {
        *to = from.load(Ordering::Relaxed).into();
    }
    report.line(name, &counts[..kept]);
}
