//! What comes before everything else: memory.
//!
//! In: the chip as the reset left it. Out: SRAM 1–3 clocked (RM0433 2.4, 8.7.42), every RAM written once, which its ECC
//! needs (RM0433 3.2), the state of the tick copied from flash. Owns nothing. It touches no pin: all of them are analog
//! from reset on (RM0433 11.4.1). Assembly, since there is no memory yet that a function could use.
use core::arch::global_asm;

global_asm!(
    ".section .text.__pre_init",
    ".global __pre_init",
    ".type __pre_init,%function",
    ".thumb_func",
    "__pre_init:",
    // RCC_AHB2ENR: SRAM1EN, SRAM2EN, SRAM3EN; read back, so that the clock is there (RM0433 8.5.8).
    "ldr r0, =0x580244dc",
    "ldr r1, [r0]",
    "orr r1, r1, #0xe0000000",
    "str r1, [r0]",
    "ldr r1, [r0]",
    // Pairs of first and last address; 0, 0 ends them. What survives a reset is in none of them, nor what is copied.
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
    "3: ldr r0, =__sitcm",
    "ldr r1, =__eitcm",
    "ldr r2, =__siitcm",
    "4: cmp r0, r1",
    "bhs 6f",
    "ldmia r2!, {{r3}}",
    "stmia r0!, {{r3}}",
    "b 4b",
    "6: bx lr",
    ".align 2",
    "5:",
    ".word 0x00000400, _stack_start",
    ".word 0x20000000, 0x20020000",
    ".word 0x24000000, 0x24080000",
    ".word 0x30000000, 0x30048000",
    ".word 0x38000000, 0x38010000",
    ".word 0, 0",
    ".ltorg",
    ".size __pre_init, . - __pre_init",
    ".previous",
);
