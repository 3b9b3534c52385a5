// The path that the interpolation listings of the laser manuals share: a line of 100000 pulses and one back and up, both
// with 50 pulse/ms and 2 pulse/ms^2, in coordinate system 1 of axes 1 and 2.
#ifndef LASER_PATH_H
#define LASER_PATH_H

#include "example.h"
#include <string.h>

// The controller, its first laser channel (in the GUS family axis connector 7), and coordinate system 1. The manuals leave the
// latter out ("set up coordinate system 1").
inline void open_path(bool lsr)
{
    TCrdPrm crd;
    CALL(GT_Open());
    CALL(GT_AxisOn(1));
    CALL(GT_AxisOn(2));
    memset(&crd, 0, sizeof crd);
    crd.dimension = 2;
    crd.profile[0] = 1;
    crd.profile[1] = 2;
    crd.synVelMax = 500;
    crd.synAccMax = 10;
    CALL(GT_SetCrdPrm(1, &crd));
    if (!lsr) {
        CALL(GT_SetAxisMode(AXIS_LASER, 1));
    }
}

// Starts coordinate system 1 and waits until it is at rest.
inline void run_path()
{
    short runs = 1;
    long segments;
    CALL(GT_CrdStart(1, 0));
    while (runs) {
        CALL(GT_CrdStatus(1, &runs, &segments, 0));
    }
    printf("%ld segments\n", segments);
    CALL(GT_Close());
}

inline bool is_lsr(int count, char **words)
{
    return count > 1 && words[1][0] == 'l';
}

#endif
