//! The very first code after a reset: memory.
//!
//! In: the chip as the reset left it. Out: SRAM 1–3 with their clock (RM0433 2.4, 8.7.42), and the
//! backup SRAM with its clock and write access (8.7.44, 6.4.4). Every RAM is written once, which
//! its ECC needs (RM0433 3.2): with zeros, and the stack with a word that shows later what was used
//! ([`super::stack`]). The state of the tick and its code are copied from flash. Owns nothing.
//! Fails never. It touches no pin: all of them are analog after a reset (RM0433 11.4.1). It is
//! assembly, since there is no memory yet that a function could use.
use super::stack::PAINT;
use core::arch::global_asm;

global_asm!(
    ".section .text.__pre_init",
    ".global __pre_init",
    ".type __pre_init,%function",
    ".thumb_func",
    "__pre_init:",
    // RCC_AHB2ENR: SRAM1EN, SRAM2EN, SRAM3EN; read back, so that the clock is on (RM0433 8.5.8).
    "ldr r0, =0x580244dc",
    "ldr r1, [r0]",
    "orr r1, r1, #0xe0000000",
    "str r1, [r0]",
    "ldr r1, [r0]",
    // PWR_CR1: DBP, without which the backup SRAM is write-protected; RCC_AHB4ENR: BKPRAMEN.
    "ldr r0, =0x58024800",
    "ldr r1, [r0]",
    "orr r1, r1, #0x100",
    "str r1, [r0]",
    "7: ldr r1, [r0]",
    "tst r1, #0x100",
    "beq 7b",
    "ldr r0, =0x580244e0",
    "ldr r1, [r0]",
    "orr r1, r1, #0x10000000",
    "str r1, [r0]",
    "ldr r1, [r0]",
    // Pairs of first address and end; 0, 0 ends them. What survives a reset is in none of them.
    "adr r4, 5f",
    "movs r2, #0",
    "movs r3, #0",
    "1: ldmia r4!, {{r0, r1}}",
    "cmp r1, #0",
    "beq 3f",
    "2: strd r2, r3, [r0], #8",
    "cmp r0, r1",
    "blo 2b",
    "b 1b",
    // The stack is painted.
    "3: ldr r0, =_stack_end",
    "ldr r1, =_stack_start",
    "ldr r2, ={paint}",
    "mov r3, r2",
    "8: strd r2, r3, [r0], #8",
    "cmp r0, r1",
    "blo 8b",
    // What is copied: first address and end, and its source in flash; an end of 0 ends them.
    "9: ldmia r4!, {{r0, r1, r5}}",
    "cmp r1, #0",
    "beq 6f",
    "4: cmp r0, r1",
    "bhs 9b",
    "ldrd r2, r3, [r5], #8",
    "strd r2, r3, [r0], #8",
    "b 4b",
    // The code is written before the core fetches it.
    "6: dsb",
    "isb",
    "bx lr",
    ".align 2",
    "5:",
    ".word 0x00000200, 0x00010000",
    ".word 0x20000000, 0x20020000",
    ".word 0x24000000, 0x24080000",
    ".word 0x30000000, 0x30047f00",
    ".word 0x38000000, 0x38010000",
    ".word 0x38800000, 0x38801000",
    ".word 0, 0",
    ".word __sstate, __estate, __sistate",
    ".word __shot, __ehot, __sihot",
    ".word 0, 0, 0",
    ".ltorg",
    ".size __pre_init, . - __pre_init",
    ".previous",
    paint = const PAINT,
);
