// GXN listing 4-1: PVT with given velocities, table 4-9. Five parts from a start at 1 pulse/ms: constant acceleration,
// falling acceleration, 20 pulse/ms, and back. Figure 4-11.
#include "example.h"
#include <windows.h>

int main()
{
    const short axis = 1, table = 1;
    double time[6] = {0, 1200, 2000, 3000, 3800, 5000};
    double pos[6] = {0, 9750, 24483, 44483, 59216, 68966};
    double vel[6] = {1, 15.25, 20, 20, 15.25, 1};
    double at, found;
    short used;

    open_axes(1);
    Sleep(1000);
    CALL(GTN_PrfPvt(1, axis));
    CALL(GTN_PvtTable(1, table, 6, time, pos, vel));
    CALL(GTN_PvtTableSelect(1, axis, table));
    CALL(GTN_PvtStart(1, 1 << (axis - 1)));
    wait_for(1 << (axis - 1));
    CALL(GTN_PvtStatus(1, axis, &used, &at));
    CALL(GTN_GetPrfPos(1, axis, &found));
    printf("table %d at %.0f ms: %.1f\n", used, at, found);
    CALL(GTN_AxisOff(1, axis));
    CALL(GTN_Close());
    return 0;
}
