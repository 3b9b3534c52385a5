// GXN listing 2-1: PT from a static FIFO. A trapezoid of three segments of 1024 ms: up to 2 pulse/ms, even, down to
// rest at 4096 pulses. Figure 2-4.
#include "example.h"

int main()
{
    const short axis = 1;
    short space;
    double pos, vel;

    open_axes(1);
    CALL(GTN_ZeroPos(1, axis));
    CALL(GTN_PrfPt(1, axis));
    CALL(GTN_PtClear(1, axis));
    CALL(GTN_PtSpace(1, axis, &space));
    printf("%d free segments\n", space);

    CALL(GTN_PtData(1, axis, 1024, 1024));
    CALL(GTN_PtSpace(1, axis, &space));
    CALL(GTN_PtData(1, axis, 1024 + 2048, 2048));
    CALL(GTN_PtSpace(1, axis, &space));
    CALL(GTN_PtData(1, axis, 1024 + 2048 + 1024, 3072));
    CALL(GTN_PtSpace(1, axis, &space));
    printf("%d free segments after three\n", space);

    CALL(GTN_PtStart(1, 1 << (axis - 1)));
    wait_for(1 << (axis - 1));
    CALL(GTN_GetPrfPos(1, axis, &pos));
    CALL(GTN_GetPrfVel(1, axis, &vel));
    printf("at %.1f with %.2f pulse/ms\n", pos, vel);
    CALL(GTN_AxisOff(1, axis));
    CALL(GTN_Close());
    return 0;
}
