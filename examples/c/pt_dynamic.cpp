// GXN listing 2-2: PT from a dynamic FIFO. Two periods of a sine of velocity, 10 pulse/ms high and 1 s long, cut into
// segments of 16 ms: 126 segments go through a ring of 64 places. The motion starts when the ring is full. Figure 2-5.
#include "example.h"
#include <math.h>

int main()
{
    const short axis = 1;
    const double amplitude = 10, period = 1.0, step = 0.016, turn = 2 * acos(-1.0);
    const int loops = 2;
    double pos = 0, before = 0, time = 0;
    int loop = 1, segments = 0;
    bool started = false;
    short space;

    open_axes(1);
    CALL(GTN_ZeroPos(1, axis));
    CALL(GTN_PrfPt(1, axis, PT_MODE_DYNAMIC));
    CALL(GTN_PtClear(1, axis));

    while (loop <= loops) {
        CALL(GTN_PtSpace(1, axis, &space));
        if (space > 0) {
            time += step;
            double vel = amplitude * sin(turn / period * time);
            pos += 1000 * (vel + before) * step / 2;
            before = vel;
            if (time < loop * period) {
                CALL(GTN_PtData(1, axis, pos, (long)(time * 1000)));
            } else {
                // The period ends at rest where it began.
                CALL(GTN_PtData(1, axis, 0, (long)(loop * period * 1000), PT_SEGMENT_STOP));
                pos = 0;
                time = loop * period;
                before = 0;
                loop++;
            }
            segments++;
        } else if (!started) {
            CALL(GTN_PtStart(1, 1 << (axis - 1)));
            started = true;
        }
    }
    wait_for(1 << (axis - 1));
    CALL(GTN_GetPrfPos(1, axis, &pos));
    printf("%d segments, at %.1f\n", segments, pos);
    CALL(GTN_AxisOff(1, axis));
    CALL(GTN_Close());
    return 0;
}
