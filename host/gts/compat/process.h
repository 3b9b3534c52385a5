/* process.h for Linux: threads of the C runtime. */
#ifndef BEAMTICK_PROCESS_H
#define BEAMTICK_PROCESS_H

#include "windows.h"

#include <stdint.h>

static inline uintptr_t _beginthreadex(void *security, unsigned stack, unsigned (__stdcall *routine)(void *), void *parameter,
                                       unsigned flags, unsigned *id)
{
    struct beamtick_start start = {0, routine, NULL, NULL, parameter};
    HANDLE thread = beamtick_thread(start, (flags & CREATE_SUSPENDED) != 0);
    (void)security;
    (void)stack;
    if (id != NULL) {
        *id = (unsigned)beamtick_number(thread);
    }
    return (uintptr_t)thread;
}

static inline void _endthreadex(unsigned code) { beamtick_thread_exit(code); }

/* Programs wait for what this returns, so its handle stays until the process ends. */
static inline uintptr_t _beginthread(void (__cdecl *routine)(void *), unsigned stack, void *parameter)
{
    struct beamtick_start start = {0, NULL, NULL, routine, parameter};
    HANDLE thread = beamtick_thread(start, 0);
    (void)stack;
    return thread == NULL ? (uintptr_t)-1 : (uintptr_t)thread;
}

static inline void _endthread(void) { beamtick_thread_exit(0); }
#define _getpid getpid

#endif
