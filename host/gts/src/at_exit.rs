//! Runs a function when the process ends by itself: `exit`, or the end of `main`.
//!
//! In: a function. Out: it has run while the library's threads were still alive. Windows: a DLL's
//! own `atexit` runs only when the system has ended all other threads, with the locks they held. So
//! the C runtime of the process gets the function. It does nothing once the process is being ended
//! by the system (`ExitProcess`, a runtime linked statically).

/// Runs `end` at the end of the process; nothing where there is no C runtime to ask.
#[cfg(not(windows))]
pub fn run(end: extern "C" fn()) {
    unsafe extern "C" {
        fn atexit(end: extern "C" fn()) -> std::ffi::c_int;
    }
    // SAFETY: `end` takes no arguments, never unwinds into C and may run at any time.
    unsafe { atexit(end) };
}

#[cfg(windows)]
pub use windows::run;

#[cfg(windows)]
mod windows {
    use std::ffi::{CStr, c_char, c_int, c_void};
    use std::sync::OnceLock;

    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn GetModuleHandleA(name: *const c_char) -> *mut c_void;
        fn GetModuleHandleExA(flags: u32, address: *const c_void, module: *mut *mut c_void) -> c_int;
        fn GetProcAddress(module: *mut c_void, name: *const c_char) -> *const c_void;
    }
    #[link(name = "ntdll")]
    unsafe extern "system" {
        fn RtlDllShutdownInProgress() -> u8;
    }

    /// GetModuleHandleEx: the module that an address lies in, never to be unloaded.
    const PIN_FROM_ADDRESS: u32 = 1 | 4;
    /// The C runtimes of a process, and what registers a function with each: MinGW's, and that of
    /// Visual Studio from 2015 on.
    const RUNTIMES: [(&CStr, &CStr); 2] = [(c"msvcrt.dll", c"_onexit"), (c"ucrtbase.dll", c"_crt_atexit")];

    static END: OnceLock<extern "C" fn()> = OnceLock::new();

    extern "C" fn ends() -> c_int {
        // SAFETY: it takes nothing and only reads a flag.
        if unsafe { RtlDllShutdownInProgress() } == 0
            && let Some(end) = END.get()
        {
            end();
        }
        0
    }

    /// See the other one. With both runtimes in a process it may run twice.
    pub fn run(end: extern "C" fn()) {
        END.get_or_init(|| end);
        let mut module = std::ptr::null_mut();
        // SAFETY: the address is one of this library; it stays loaded, so that the runtimes can
        // call it.
        unsafe { GetModuleHandleExA(PIN_FROM_ADDRESS, ends as *const c_void, &mut module) };
        for (runtime, name) in RUNTIMES {
            // SAFETY: both texts end with 0; the functions have this type in their runtimes
            // (`_onexit` returns an address, which is not looked at), and `ends` never unwinds and
            // may run at any time.
            unsafe {
                let runtime = GetModuleHandleA(runtime.as_ptr());
                let register =
                    if runtime.is_null() { runtime } else { GetProcAddress(runtime, name.as_ptr()).cast_mut() };
                if !register.is_null() {
                    let register: extern "C" fn(extern "C" fn() -> c_int) -> *mut c_void =
                        std::mem::transmute(register);
                    register(ends);
                }
            }
        }
    }
}
