// GXN listing 4-2: PVT, Complete. P = A sin^2(pi t / 2000) through five points with continuous acceleration, again and
// again. Key A makes it half as high again, key B half as high, key Q stops. A new table takes over when the pass under way has
// ended. Figure 4-12.
#include "example.h"
#include <conio.h>
#include <ctype.h>
#include <math.h>
#include <windows.h>

static double points[5] = {0, 500, 1000, 1500, 2000};

static void send(short axis, short table, double amplitude)
{
    double pos[5], a[5], b[5], c[5];
    for (int n = 0; n < 5; n++) {
        double root = sin(acos(-1.0) / 2000 * points[n]);
        pos[n] = amplitude * root * root;
    }
    CALL(GTN_PvtTableComplete(1, table, 5, points, pos, a, b, c, 0, 0));
    CALL(GTN_PvtTableSelect(1, axis, table));
}

int main()
{
    const short axis = 1;
    double amplitude = 40000, time;
    short used = 1;
    int key = 0;

    open_axes(1);
    Sleep(1000);
    CALL(GTN_PrfPvt(1, axis));
    send(axis, 1, amplitude);
    CALL(GTN_SetPvtLoop(1, axis, 0));
    CALL(GTN_PvtStart(1, 1 << (axis - 1)));

    while (key != 'Q') {
        CALL(GTN_PvtStatus(1, axis, &used, &time));
        if (!kbhit()) {
            continue;
        }
        key = toupper(getch());
        if (key == 'A' || key == 'B') {
            amplitude *= key == 'A' ? 1.5 : 0.5;
            // The table that is not in use.
            send(axis, (short)(3 - used), amplitude);
            printf("key %c: amplitude %.0f\n", key, amplitude);
        }
    }
    CALL(GTN_Stop(1, 1 << (axis - 1), 0));
    wait_for(1 << (axis - 1));
    CALL(GTN_AxisOff(1, axis));
    CALL(GTN_Close());
    return 0;
}
