/* windows.h for Linux: Sleep, in the controller's time (docs/c.md). */
#ifndef BEAMTICK_WINDOWS_H
#define BEAMTICK_WINDOWS_H

#ifdef __cplusplus
extern "C" {
#endif
void beamtick_sleep(unsigned long milliseconds);
#ifdef __cplusplus
}
#endif

static inline void Sleep(unsigned long milliseconds)
{
    beamtick_sleep(milliseconds);
}

#endif
