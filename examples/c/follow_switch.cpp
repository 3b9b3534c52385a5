// GXN listing 3-3: Follow with two FIFOs, tables 3-5 to 3-7. The slave repeats one curve; at a key it goes over by a
// transition in the other FIFO, and then repeats a new curve, written into the FIFO that the switch has emptied. The
// next key ends it. Figures 3-7 and 3-8.
#include "example.h"
#include <conio.h>

static const short master = 1, slave = 2;

// Three segments of 20000 master pulses into a FIFO.
static void curve(short fifo, const double distances[3], short first)
{
    long master_pos = 0;
    double slave_pos = 0;
    for (int n = 0; n < 3; n++) {
        master_pos += 20000;
        slave_pos += distances[n];
        CALL(GTN_FollowData(1, slave, master_pos, slave_pos, n == 0 ? first : FOLLOW_SEGMENT_NORMAL, fifo));
    }
}

int main()
{
    const double old_distances[3] = {10000, 20000, 10000}, transition[3] = {10000, 20000, 16000},
                 new_distances[3] = {16000, 20000, 16000};
    enum { OLD, TO_TRANSITION, TO_NEW, NEW } stage = OLD;
    TJogPrm jog;
    short space;
    double vel[8];
    bool pressed = false;

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
    CALL(GTN_FollowClear(1, slave, 0));
    CALL(GTN_FollowClear(1, slave, 1));
    CALL(GTN_SetFollowMaster(1, slave, master));
    curve(0, old_distances, FOLLOW_SEGMENT_NORMAL);
    CALL(GTN_SetFollowLoop(1, slave, 0));
    CALL(GTN_SetFollowEvent(1, slave, FOLLOW_EVENT_START, 1));
    CALL(GTN_FollowStart(1, 1 << (slave - 1)));

    while (!(stage == NEW && pressed)) {
        if (kbhit()) {
            getch();
            pressed = true;
        }
        if (stage == OLD && pressed) {
            pressed = false;
            CALL(GTN_FollowClear(1, slave, 1));
            curve(1, transition, FOLLOW_SEGMENT_CONTINUE);
            // It takes over when the pass under way has ended.
            CALL(GTN_FollowSwitch(1, 1 << (slave - 1)));
            stage = TO_TRANSITION;
        } else if (stage == TO_TRANSITION) {
            CALL(GTN_FollowSpace(1, slave, &space, 0));
            if (space == 16) {
                curve(0, new_distances, FOLLOW_SEGMENT_CONTINUE);
                CALL(GTN_FollowSwitch(1, 1 << (slave - 1)));
                stage = TO_NEW;
            }
        } else if (stage == TO_NEW) {
            CALL(GTN_FollowSpace(1, slave, &space, 1));
            if (space == 16) {
                stage = NEW;
            }
        }
        CALL(GTN_GetPrfVel(1, 1, vel, 8));
    }
    printf("master %.2f, slave %.2f pulse/ms\n", vel[master - 1], vel[slave - 1]);
    CALL(GTN_AxisOff(1, master));
    CALL(GTN_AxisOff(1, slave));
    CALL(GTN_Close());
    return 0;
}
