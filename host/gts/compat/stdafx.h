/* stdafx.h for Linux: what programs written for Windows expect of it, and the manuals' commandhandler, which they call
 * and never define. */
#ifndef BEAMTICK_STDAFX_H
#define BEAMTICK_STDAFX_H

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "tchar.h"
#include "beamtick_crt.h"

#ifdef __cplusplus
extern "C" {
#endif
/* The reason of the calling thread's last failure, whichever card it was on. */
void beamtick_last_reason(char *text, short size);
#ifdef __cplusplus
}
#endif

/* Prints a call that failed, with its return value and the reason. */
static inline void commandhandler(const char *command, short error)
{
    if (error != 0) {
        char reason[512] = "";
        beamtick_last_reason(reason, (short)sizeof reason);
        fprintf(stderr, "%s = %d: %s\n", command, error, reason);
    }
}

#endif
