//! Which interrupt of the board runs which body.

/// The emulated board.
#[cfg(feature = "mps2_an500")]
mod mps2_an500 {
    use crate::interrupts::{received, sent, tick};
    use hal::mps2_an500::uart::{Port, acknowledge_sent};

    #[unsafe(no_mangle)]
    extern "C" fn TIMER0() {
        tick();
    }

    #[unsafe(no_mangle)]
    extern "C" fn UART0_RX() {
        // One byte an interrupt.
        received();
    }

    #[unsafe(no_mangle)]
    extern "C" fn UART0_TX() {
        acknowledge_sent(Port::Link);
        sent();
    }

    #[unsafe(no_mangle)]
    extern "C" fn UART1_TX() {
        acknowledge_sent(Port::Trace);
        sent();
    }
}

/// The boards with an STM32H743.
#[cfg(all(feature = "stm32h743", not(feature = "mps2_an500")))]
mod stm32h743 {
    use crate::interrupts::{received, sent, tick};
    use hal::stm32h743::{uart, usb};

    #[unsafe(no_mangle)]
    extern "C" fn TIM2() {
        tick();
    }

    #[unsafe(no_mangle)]
    extern "C" fn USART3() {
        if uart::acknowledge() {
            sent();
        }
        while received() {}
    }

    #[unsafe(no_mangle)]
    extern "C" fn OTG_FS() {
        // SAFETY: the core's interrupt; it is asked for nothing before the device is there.
        unsafe { usb::serve() };
        sent();
    }
}
