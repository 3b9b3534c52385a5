// GXN listing 4-4: PVT, Continuous. X goes 30000 pulses, Y 20000, both with at most 10 pulse/ms, 0.01 pulse/ms^2 and S-shaped
// ramps. The controller calculates how long each takes; the shorter one begins later, so that both arrive together. Figure 4-15.
#include "example.h"
#include <windows.h>

struct Curve {
    double pos[2], vel[2], percent[2], vel_max[2], acc[2], dec[2], time[2];
};

int main()
{
    Curve curves[2] = {
        {{0, 30000}, {0, 0}, {100, 100}, {10, 10}, {0.01, 0.01}, {0.01, 0.01}, {0, 0}},
        {{0, 20000}, {0, 0}, {100, 100}, {10, 10}, {0.01, 0.01}, {0.01, 0.01}, {0, 0}},
    };
    double pos[2];

    open_axes(2);
    Sleep(1000);
    CALL(GTN_PrfPvt(1, 1));
    CALL(GTN_PrfPvt(1, 2));
    for (Curve &c : curves) {
        CALL(GTN_PvtContinuousCalculate(1, 2, c.pos, c.vel, c.percent, c.vel_max, c.acc, c.dec, c.time));
        printf("%.0f ms\n", c.time[1]);
    }
    const double last = curves[0].time[1] > curves[1].time[1] ? curves[0].time[1] : curves[1].time[1];
    for (short n = 0; n < 2; n++) {
        Curve &c = curves[n];
        const short table = (short)(n + 1);
        CALL(GTN_PvtTableContinuous(1, table, 2, c.pos, c.vel, c.percent, c.vel_max, c.acc, c.dec, last - c.time[1]));
        CALL(GTN_PvtTableSelect(1, table, table));
    }
    CALL(GTN_PvtStart(1, 3));
    wait_for(3);
    CALL(GTN_GetPrfPos(1, 1, pos, 2));
    printf("X %.1f, Y %.1f\n", pos[0], pos[1]);
    CALL(GTN_AxisOff(1, 1));
    CALL(GTN_AxisOff(1, 2));
    CALL(GTN_Close());
    return 0;
}
