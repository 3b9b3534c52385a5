// GXN listing 3-2: Follow from one FIFO, table 3-4. The master jogs at 50 pulse/ms; the slave begins when the master
// passes 50000 pulses and repeats a trapezoid of ratio 0 to 1 to 0 for ever. A key ends it. Figures 3-5 and 3-6.
#include "example.h"
#include <conio.h>

int main()
{
    const short master = 1, slave = 2;
    const long lengths[3] = {20000, 20000, 20000};
    const double distances[3] = {10000, 20000, 10000};
    TJogPrm jog;
    short space;
    double vel[8];
    long master_pos = 0, loops;
    double slave_pos = 0;

    open_axes(2);
    CALL(GTN_ZeroPos(1, master));
    CALL(GTN_ZeroPos(1, slave));

    CALL(GTN_PrfJog(1, master));
    CALL(GTN_GetJogPrm(1, master, &jog));
    jog.acc = 1;
    CALL(GTN_SetJogPrm(1, master, &jog));
    CALL(GTN_SetVel(1, master, 50));
    CALL(GTN_Update(1, 1 << (master - 1)));

    CALL(GTN_PrfFollow(1, slave));
    CALL(GTN_FollowClear(1, slave));
    CALL(GTN_SetFollowMaster(1, slave, master));
    for (int n = 0; n < 3; n++) {
        CALL(GTN_FollowSpace(1, slave, &space));
        master_pos += lengths[n];
        slave_pos += distances[n];
        CALL(GTN_FollowData(1, slave, master_pos, slave_pos));
    }
    CALL(GTN_SetFollowLoop(1, slave, 0));
    CALL(GTN_SetFollowEvent(1, slave, FOLLOW_EVENT_PASS, 1, 50000));
    CALL(GTN_FollowStart(1, 1 << (slave - 1)));

    while (!kbhit()) {
        CALL(GTN_GetPrfVel(1, 1, vel, 8));
    }
    getch();
    CALL(GTN_GetFollowLoop(1, slave, &loops));
    printf("%ld passes, master %.2f, slave %.2f pulse/ms\n", loops, vel[master - 1], vel[slave - 1]);
    CALL(GTN_AxisOff(1, master));
    CALL(GTN_AxisOff(1, slave));
    CALL(GTN_Close());
    return 0;
}
