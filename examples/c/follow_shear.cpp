// GXN listing 3-1: Follow as a flying shear, tables 3-2 and 3-3, figure 3-4. The belt carries the goods past; the knife
// turns once, 8000 pulses, for every 10000 of the belt, and goes as fast as the belt while it cuts. FIFO 0
// brings it to the first cut, 2500 at 5000; FIFO 1 leads from one cut to the next, again and again.
#include "example.h"
#include <windows.h>

static const short belt = 1, knife = 2;

int main()
{
    // From one cut to the next: ratio 1, then 1 to 0.6, 0.6, 0.6 to 1, and 1.
    const struct {
        long belt;
        double knife;
    } turn[5] = {{1000, 1000}, {4000, 3400}, {6000, 4600}, {9000, 7000}, {10000, 8000}};
    TJogPrm jog;
    short fifo, pending;
    long cuts;
    double pos[2];

    open_axes(2);
    CALL(GTN_ZeroPos(1, belt));
    CALL(GTN_ZeroPos(1, knife));

    CALL(GTN_PrfJog(1, belt));
    CALL(GTN_GetJogPrm(1, belt, &jog));
    jog.acc = 1;
    CALL(GTN_SetJogPrm(1, belt, &jog));
    CALL(GTN_SetVel(1, belt, 50));

    CALL(GTN_PrfFollow(1, knife));
    CALL(GTN_SetFollowMaster(1, knife, belt));
    // To the first cut the ratio goes from 0 to 1; CONTINUE begins where that ends.
    CALL(GTN_FollowData(1, knife, 5000, 2500));
    for (int n = 0; n < 5; n++) {
        short type = n == 0 ? FOLLOW_SEGMENT_CONTINUE : FOLLOW_SEGMENT_NORMAL;
        CALL(GTN_FollowData(1, knife, turn[n].belt, turn[n].knife, type, 1));
    }
    CALL(GTN_SetFollowLoop(1, knife, 0));
    CALL(GTN_SetFollowEvent(1, knife, FOLLOW_EVENT_START, 1));
    CALL(GTN_FollowStart(1, 1 << (knife - 1)));
    // FIFO 1 takes over at the first cut.
    CALL(GTN_FollowSwitch(1, 1 << (knife - 1)));
    CALL(GTN_Update(1, 1 << (belt - 1)));

    Sleep(900);
    CALL(GTN_GetFollowStatus(1, knife, &fifo, &pending));
    CALL(GTN_GetFollowLoop(1, knife, &cuts));
    printf("FIFO %d, %ld cuts after the first\n", fifo, cuts);
    // The knife comes to rest with the belt, and then follows no more.
    CALL(GTN_Stop(1, 1 << (belt - 1), 0));
    wait_for(1 << (belt - 1));
    CALL(GTN_GetPrfPos(1, belt, pos, 2));
    printf("belt %.1f, knife %.1f\n", pos[0], pos[1]);
    CALL(GTN_Stop(1, 1 << (knife - 1), 0));
    wait_for(1 << (knife - 1));
    CALL(GTN_AxisOff(1, belt));
    CALL(GTN_AxisOff(1, knife));
    CALL(GTN_Close());
    return 0;
}
