// GXN listing 4-3: PVT, Percent, tables 4-10 to 4-13. X goes to and fro twice; Y feeds while X turns, and rests while X
// runs evenly. Y's first point lies at 2000 ms, and so it begins then. Figures 4-13 and 4-14.
#include "example.h"
#include <windows.h>

int main()
{
    const short x = 1, y = 2, table_x = 1, table_y = 2, loops = 2;
    double time_x[7] = {0, 1000, 2000, 3000, 4000, 5000, 6000};
    double pos_x[7] = {0, 5000, 15000, 20000, 15000, 5000, 0};
    double percent_x[7] = {60, 0, 60, 60, 0, 60, 0};
    double time_y[5] = {2000, 2500, 3500, 4000, 5000};
    double pos_y[5] = {0, 2500, 12500, 15000, 15000};
    double percent_y[5] = {60, 0, 60, 0, 0};
    double vel_x[7], pos[2];

    open_axes(2);
    Sleep(1000);
    CALL(GTN_PrfPvt(1, x));
    CALL(GTN_PrfPvt(1, y));
    CALL(GTN_PvtPercentCalculate(1, 7, time_x, pos_x, percent_x, 0, vel_x));
    printf("velocities of X:");
    for (int n = 0; n < 7; n++) {
        printf(" %.0f", vel_x[n] + 0.0);
    }
    printf("\n");
    CALL(GTN_PvtTablePercent(1, table_x, 7, time_x, pos_x, percent_x, 0));
    CALL(GTN_PvtTablePercent(1, table_y, 5, time_y, pos_y, percent_y, 0));
    CALL(GTN_PvtTableSelect(1, x, table_x));
    CALL(GTN_PvtTableSelect(1, y, table_y));
    CALL(GTN_SetPvtLoop(1, x, loops));
    CALL(GTN_SetPvtLoop(1, y, 2 * loops - 1));
    const long mask = 1 << (x - 1) | 1 << (y - 1);
    CALL(GTN_PvtStart(1, mask));
    wait_for(mask);
    CALL(GTN_GetPrfPos(1, x, pos, 2));
    printf("X %.1f, Y %.1f\n", pos[0], pos[1]);
    CALL(GTN_AxisOff(1, x));
    CALL(GTN_AxisOff(1, y));
    CALL(GTN_Close());
    return 0;
}
