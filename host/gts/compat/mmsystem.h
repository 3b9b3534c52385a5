/* mmsystem.h for Linux: multimedia timers and their clock. */
#ifndef BEAMTICK_MMSYSTEM_H
#define BEAMTICK_MMSYSTEM_H

#include "windows.h"

typedef UINT MMRESULT;
typedef void (CALLBACK TIMECALLBACK)(UINT timer, UINT message, DWORD_PTR user, DWORD_PTR first, DWORD_PTR second);
typedef TIMECALLBACK *LPTIMECALLBACK;
typedef struct timecaps_tag {
    UINT wPeriodMin, wPeriodMax;
} TIMECAPS, *PTIMECAPS, *LPTIMECAPS;

#define TIMERR_NOERROR 0
#define TIME_ONESHOT 0
#define TIME_PERIODIC 1
#define TIME_CALLBACK_FUNCTION 0
#define TIME_CALLBACK_EVENT_SET 0x10
#define TIME_KILL_SYNCHRONOUS 0x100

static inline MMRESULT timeBeginPeriod(UINT period) { (void)period; return TIMERR_NOERROR; }
static inline MMRESULT timeEndPeriod(UINT period) { (void)period; return TIMERR_NOERROR; }
static inline DWORD timeGetTime(void) { return GetTickCount(); }

static inline MMRESULT timeGetDevCaps(LPTIMECAPS caps, UINT size)
{
    (void)size;
    caps->wPeriodMin = 1;
    caps->wPeriodMax = 1000000;
    return TIMERR_NOERROR;
}

/* With TIME_CALLBACK_EVENT_SET the routine is an event's handle. */
static inline MMRESULT timeSetEvent(UINT delay, UINT resolution, LPTIMECALLBACK routine, DWORD_PTR user, UINT flags)
{
    unsigned long period = flags & TIME_PERIODIC ? delay : 0;
    (void)resolution;
    if (delay == 0 || routine == NULL) {
        return 0;
    }
    if (flags & TIME_CALLBACK_EVENT_SET) {
        unsigned long event;
        memcpy(&event, &routine, sizeof event);
        return (MMRESULT)beamtick_number(beamtick_timer(delay, period, NULL, NULL, NULL, event));
    }
    return (MMRESULT)beamtick_number(beamtick_timer(delay, period, routine, NULL, (void *)user, 0));
}

/* After it the routine is not called any more. */
static inline MMRESULT timeKillEvent(UINT timer)
{
    return beamtick_timer_end(beamtick_handle(timer), 1) ? TIMERR_NOERROR : 11;
}

#endif
