// What the examples share: every call is checked, and a refused one ends the program with its reason.
#ifndef EXAMPLE_H
#define EXAMPLE_H

#include "gts.h"
#include <stdio.h>
#include <stdlib.h>

inline void done(const char *call, short code)
{
    if (code != 0) {
        char reason[512] = "";
        GT_GetLastReason(reason, sizeof reason);
        fprintf(stderr, "%s = %d: %s\n", call, code, reason);
        GT_Close();
        exit(1);
    }
}

#define CALL(call) done(#call, call)

// A controller of the GXN series with axes 1 to `axes` of core 1 ready: no limit switches, no alarms, servo on.
inline void open_axes(short axes)
{
    CALL(GTN_Open());
    CALL(GTN_Reset(1));
    CALL(GTN_LoadConfig(1, "test.cfg"));
    CALL(GTN_ClrSts(1, 1, 8));
    for (short axis = 1; axis <= axes; axis++) {
        CALL(GTN_AxisOn(1, axis));
    }
}

// Waits until neither axis of the mask is in motion.
inline void wait_for(long mask)
{
    long status[8];
    bool runs = true;
    while (runs) {
        runs = false;
        CALL(GTN_GetSts(1, 1, status, 8));
        for (int axis = 0; axis < 8; axis++) {
            runs = runs || ((mask >> axis & 1) != 0 && (status[axis] & 0x400) != 0);
        }
    }
}

#endif
