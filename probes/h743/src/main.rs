#![no_std]
#![no_main]
//! Tries what the emulated core has to do as a Cortex-M7 does it (Armv7-M Architecture Reference
//! Manual, B1.5).
//!
//! In: nothing. Out: words in SRAM 4, from 0x3800_0000: how many, then the words.
//! `host/h743/tests/core.rs` knows what must be there. The second run, after the reset that the
//! first one asks for, adds its words after those of the first.
use core::arch::asm;
use core::panic::PanicInfo;
use core::ptr::{read_volatile, write_volatile};
use cortex_m::asm::{dsb, isb, wfi};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use cortex_m::register::{basepri, control};
use cortex_m_rt::{entry, exception};

/// Where the words go: how many, then they.
const LOG: *mut u32 = 0x3800_0000 as *mut u32;
/// RCC_RSR.
const RSR: *mut u32 = 0x5802_44d0 as *mut u32;

/// One entry of the vector table.
type Vector = unsafe extern "C" fn();

unsafe extern "C" {
    fn DefaultHandler();
}

/// Interrupts 0 to 2 are ours.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [Vector; 150] = {
    let mut table = [DefaultHandler as Vector; 150];
    table[0] = low;
    table[1] = high;
    table[2] = equal;
    table
};

fn note(word: u32) {
    // SAFETY: SRAM 4 is there from reset on, and nothing else lies in it.
    unsafe {
        let count = read_volatile(LOG);
        write_volatile(LOG, count + 1);
        write_volatile(LOG.add(1 + count as usize), word);
    }
}

fn pend(interrupt: u32) {
    // SAFETY: sets a bit of NVIC_ISPR0.
    unsafe { (*NVIC::PTR).ispr[0].write(1 << interrupt) };
    dsb();
    isb();
}

/// Interrupt 0, priority 0x80: it is preempted by 1, but not by 2.
unsafe extern "C" fn low() {
    note(0x100);
    SCB::set_pendsv();
    pend(2);
    pend(1);
    note(0x101);
}

/// Interrupt 1, priority 0x40; it spoils every register that the core saves.
unsafe extern "C" fn high() {
    note(0x110);
    // SAFETY: registers that a handler may use.
    unsafe {
        asm!(
            "vmov s0, r0", "vmov s1, r0", "vmov s15, r0", "vadd.f32 s2, s0, s1", "vmsr fpscr, r0",
            in("r0") 0x3f80_0000u32, out("s0") _, out("s1") _, out("s2") _, out("s15") _,
        );
    }
}

/// Interrupt 2, priority 0x80.
unsafe extern "C" fn equal() {
    note(0x120);
}

#[exception]
fn PendSV() {
    note(0x130);
}

#[exception]
fn SVCall() {
    note(0x140);
}

/// SysTicks that came.
static mut TICKS: u32 = 0;

#[exception]
fn SysTick() {
    // SAFETY: written here only, and a word.
    unsafe { write_volatile(&raw mut TICKS, read_volatile(&raw const TICKS) + 1) };
}

/// Goes on after the UDF that brought it here; `frame` is what the core has stored.
extern "C" fn undefined(frame: *mut u32) {
    // SAFETY: the frame's word 6 is the program counter; UDF is two bytes long. CFSR is cleared by
    // writing what it holds.
    unsafe {
        let scb = &*SCB::PTR;
        note(0x150);
        note(scb.cfsr.read());
        note(scb.hfsr.read());
        let (cfsr, hfsr) = (scb.cfsr.read(), scb.hfsr.read());
        scb.cfsr.write(cfsr);
        scb.hfsr.write(hfsr);
        write_volatile(frame.add(6), read_volatile(frame.add(6)) + 2);
    }
}

/// Both faults come here with their frame; the one that broke the stack ends in a reset.
#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn UsageFault() {
    core::arch::naked_asm!("mov r0, sp", "b {body}", body = sym undefined)
}

#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn HardFault() {
    core::arch::naked_asm!(
        "ldr r1, =0x20010000", "cmp sp, r1", "blo 1f", "mov r0, sp", "b {body}",
        "1: ldr r0, =0x20020000", "mov sp, r0", "b {overflow}",
        body = sym undefined, overflow = sym overflowed,
    )
}

extern "C" fn overflowed() -> ! {
    // SAFETY: reads a status register.
    note(0x160);
    note(unsafe { (*SCB::PTR).cfsr.read() } & 1 << 4);
    SCB::sys_reset()
}

#[entry]
fn main() -> ! {
    // SAFETY: RCC_RSR shows what the reset was.
    let reset = unsafe { read_volatile(RSR) };
    if reset & 1 << 24 != 0 {
        note(0x200);
        note(reset);
        // SAFETY: RMVF clears the flags.
        unsafe { write_volatile(RSR, 1 << 16) };
        note(unsafe { read_volatile(RSR) });
        cortex_m::asm::bkpt();
    }
    let Some(mut core) = cortex_m::Peripherals::take() else { panic!() };
    // SAFETY: no critical section relies on priorities yet.
    unsafe {
        for (n, priority) in [(0, 0x80), (1, 0x40), (2, 0x80)] {
            core.NVIC.ipr[n].write(priority);
        }
        core.SCB.set_priority(SystemHandler::PendSV, 0xe0);
        core.NVIC.iser[0].write(7);
    }
    preempts();
    masks();
    floating(&mut core.SCB);
    process_stack();
    sleeps(&mut core.SYST);
    blocks(&mut core.SYST);
    faults(&mut core.SCB);
    note(0x1ff);
    guard(&mut core.MPU);
    overflow(0);
    panic!()
}

/// More urgent preempts; as urgent waits; the bell comes last; a call comes at once.
fn preempts() {
    note(1);
    pend(0);
    // SAFETY: our own handler.
    unsafe { asm!("svc 0") };
    note(2);
}

/// BASEPRI holds what is less urgent, PRIMASK everything; WFI wakes after PRIMASK.
fn masks() {
    note(3);
    // SAFETY: nothing relies on what is masked.
    unsafe { basepri::write(0x60) };
    pend(2);
    note(4);
    pend(1);
    note(5);
    // SAFETY: as above.
    unsafe { basepri::write(0) };
    isb();
    note(6);
    cortex_m::interrupt::disable();
    pend(1);
    note(7);
    wfi();
    note(8);
    // SAFETY: as above.
    unsafe { cortex_m::interrupt::enable() };
    isb();
    note(9);
}

/// What a thread has in floating-point registers survives a handler that uses them.
fn floating(scb: &mut SCB) {
    scb.enable_fpu();
    let (a, b, c, status): (u32, u32, u32, u32);
    // SAFETY: pends interrupt 1 and uses registers that are declared.
    unsafe {
        asm!(
            "vmov s0, {x}", "vmov s1, {y}", "vmov s15, {x}", "vmsr fpscr, {f}",
            "str {one}, [{ispr}]", "dsb", "isb",
            "vmov {a}, s0", "vmov {b}, s1", "vmov {c}, s15", "vmrs {status}, fpscr",
            "vmsr fpscr, {zero}",
            x = in(reg) 0x4048_f5c3u32, y = in(reg) 0xc020_0000u32, f = in(reg) 0x0180_0000u32, one = in(reg) 2u32,
            ispr = in(reg) &raw const (*NVIC::PTR).ispr[0], zero = in(reg) 0u32,
            a = lateout(reg) a, b = lateout(reg) b, c = lateout(reg) c, status = lateout(reg) status,
            out("s0") _, out("s1") _, out("s15") _,
        );
    }
    for word in [0x300, a, b, c, status] {
        note(word);
    }
}

/// A thread on the process stack is interrupted and goes on.
fn process_stack() {
    static mut STACK: [u64; 64] = [0; 64];
    let (inside, after): (u32, u32);
    // SAFETY: switches the stack of the thread and back; nothing is on the stack in between but
    // frames of exceptions.
    unsafe {
        let top = (&raw mut STACK).cast::<u64>().add(64);
        asm!(
            "msr psp, {top}", "mrs {c}, control", "orr {c}, {c}, #2", "msr control, {c}", "isb",
            "str {one}, [{ispr}]", "dsb", "isb",
            "mrs {inside}, control", "bic {c}, {c}, #2", "msr control, {c}", "isb", "mrs {after}, control",
            top = in(reg) top, c = out(reg) _, one = in(reg) 4u32, ispr = in(reg) &raw const (*NVIC::PTR).ispr[0],
            inside = lateout(reg) inside, after = lateout(reg) after,
        );
    }
    note(0x310);
    note(inside & 2);
    note(after & 2);
    note(u32::from(control::read().spsel().is_psp()));
}

/// Sleeps until SysTick, ten times: what the counter says is the time that passed.
fn sleeps(timer: &mut SYST) {
    timer.set_reload(63_999);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
    for _ in 0..10 {
        wfi();
    }
    note(0x320);
    // SAFETY: a word that only the handler writes.
    note(unsafe { read_volatile(&raw const TICKS) });
    timer.disable_counter();
}

/// Conditional blocks under a rain of interrupts: the sum is what it would be without.
fn blocks(timer: &mut SYST) {
    timer.set_reload(36);
    timer.clear_current();
    timer.enable_counter();
    let mut sum = 1u32;
    for n in 0..2000u32 {
        // SAFETY: arithmetic only.
        unsafe {
            asm!(
                "lsrs {t}, {s}, #1", "ittee cs", "eorcs {s}, {t}, {p}", "addcs {s}, {s}, {n}", "movcc {s}, {t}",
                "addcc.w {s}, {s}, {n}, lsl #3",
                s = inout(reg) sum, t = out(reg) _, p = in(reg) 0xedb8_8320u32, n = in(reg) n,
            );
        }
    }
    timer.disable_counter();
    timer.disable_interrupt();
    note(0x330);
    note(sum);
    // SAFETY: a word that only the handler writes.
    note(u32::from(unsafe { read_volatile(&raw const TICKS) } > 100));
}

/// An undefined instruction: a usage fault where that is on, else a hard fault.
fn faults(scb: &mut SCB) {
    // SAFETY: our handlers step over it.
    unsafe { asm!("udf #0") };
    scb.enable(cortex_m::peripheral::scb::Exception::UsageFault);
    // SAFETY: as above.
    unsafe { asm!("udf #0") };
    note(0x340);
}

/// Nobody may touch the 32 KiB below the stack's 64.
fn guard(mpu: &mut cortex_m::peripheral::MPU) {
    // SAFETY: nothing lies there.
    unsafe {
        mpu.rnr.write(0);
        mpu.rbar.write(0x2000_8000);
        mpu.rasr.write(1 | 14 << 1 | 1 << 28);
        mpu.ctrl.write(1 | 1 << 2);
    }
    dsb();
    isb();
}

/// Calls itself until the stack is full.
#[inline(never)]
#[allow(unconditional_recursion, reason = "the stack must fill")]
fn overflow(depth: u32) -> u32 {
    let mut place = [depth; 64];
    core::hint::black_box(&mut place);
    overflow(depth + 1) + place[(depth % 64) as usize]
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    note(0xdead);
    loop {
        cortex_m::asm::bkpt();
    }
}
