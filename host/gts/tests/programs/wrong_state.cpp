// Calls in the wrong state, by state and function: the code, a reason that says what is wrong, and nothing changes.
#include "gts.h"
#include "check.h"

static short status_of(short axis, long bit)
{
    long status = 0;
    DONE(GT_GetSts(axis, &status));
    return (status & bit) != 0;
}

static void wait_for(short axis)
{
    while (status_of(axis, 0x400)) {
    }
}

// An axis that has not been put into the mode of the call.
static void wrong_mode()
{
    TTrapPrm trap = {1, 1, 0, 0};
    TJogPrm jog = {1, 1, 0};
    short number, index, type, item, dir;
    long position, count;
    double time[3] = {0, 100, 200}, pos[3] = {0, 100, 200}, at;
    static const char mode[] = "is not in the mode";
    DONE(GT_PrfPvt(1));
    REFUSED(1, "PVT table 1 is empty", GT_PvtStart(1));
    REFUSED(1, mode, GT_SetTrapPrm(1, &trap));
    REFUSED(1, mode, GT_GetTrapPrm(1, &trap));
    REFUSED(1, mode, GT_SetJogPrm(1, &jog));
    REFUSED(1, mode, GT_GetJogPrm(1, &jog));
    REFUSED(1, mode, GT_SetPos(1, 10));
    DONE(GT_GetPos(1, &position));
    REFUSED(1, mode, GT_SetVel(1, 10));
    DONE(GT_GetVel(1, &at));
    REFUSED(1, mode, GT_Update(1));
    REFUSED(1, mode, GT_PtSpace(1, &number));
    REFUSED(1, mode, GT_PtData(1, 10, 10));
    REFUSED(1, mode, GT_PtClear(1));
    REFUSED(1, mode, GT_PtStart(1));
    REFUSED(1, mode, GT_SetPtLoop(1, 2));
    REFUSED(1, mode, GT_GetPtLoop(1, &count));
    REFUSED(1, mode, GT_SetPtMemory(1, 1));
    REFUSED(1, mode, GT_GetPtMemory(1, &number));
    short axes[1] = {1}, options[1] = {0};
    REFUSED(1, mode, GT_PtStartPro(axes, options, 1));
    REFUSED(1, mode, GT_SetFollowMaster(1, 2));
    REFUSED(1, mode, GT_GetFollowMaster(1, &index, &type, &item));
    REFUSED(1, mode, GT_SetFollowMemory(1, 1));
    REFUSED(1, mode, GT_GetFollowMemory(1, &number));
    REFUSED(1, mode, GT_SetFollowLoop(1, 1));
    REFUSED(1, mode, GT_GetFollowLoop(1, &count));
    REFUSED(1, mode, GT_SetFollowEvent(1, FOLLOW_EVENT_START, 1));
    REFUSED(1, mode, GT_GetFollowEvent(1, &number, &dir, &position));
    REFUSED(1, mode, GT_FollowSpace(1, &number));
    REFUSED(1, mode, GT_FollowData(1, 100, 100));
    REFUSED(1, mode, GT_FollowClear(1));
    REFUSED(1, mode, GT_FollowStart(1));
    REFUSED(1, mode, GT_FollowSwitch(1));
    DONE(GT_PrfTrap(1));
    REFUSED(1, mode, GT_SetJogPrm(1, &jog));
    REFUSED(1, mode, GT_PvtTableSelect(1, 1));
    REFUSED(1, mode, GT_SetPvtLoop(1, 1));
    REFUSED(1, mode, GT_GetPvtLoop(1, &count, &position));
    REFUSED(1, mode, GT_PvtStart(1));
    DONE(GT_PvtTable(1, 3, time, pos, time));
}

static void nothing_to_do()
{
    // No acceleration, no data, no table, no master, the servo off.
    DONE(GT_PrfTrap(1));
    REFUSED(1, "set the motion parameters first", GT_Update(1));
    DONE(GT_PrfPt(2));
    REFUSED(1, "holds no data", GT_PtStart(2));
    DONE(GT_PtData(2, 10, 10));
    DONE(GT_AxisOff(2));
    REFUSED(1, "servo is off", GT_PtStart(2));
    DONE(GT_AxisOn(2));
    DONE(GT_PrfPvt(3));
    REFUSED(1, "PVT table 9 is empty", GT_PvtTableSelect(3, 9));
    DONE(GT_PrfFollow(4));
    short master = -1, type = -1, item = -1;
    DONE(GT_GetFollowMaster(4, &master, &type, &item));
    HOLDS(master == 0 && type == 2 && item == 0);
    DONE(GT_FollowData(4, 100, 100));
    REFUSED(1, "SetFollowMaster", GT_FollowStart(1 << 3));
    DONE(GT_SetFollowMaster(4, 5));
    DONE(GT_FollowClear(4));
    REFUSED(1, "holds no data", GT_FollowStart(1 << 3));
    REFUSED(1, "is not running", GT_FollowSwitch(1 << 3));
    REFUSED(1, "direction", (GT_PrfFollow(4, 1), GT_PrfFollow(4, -1)));
}

static void full()
{
    short space;
    DONE(GT_PrfPt(1));
    for (int n = 1; n <= 32; n++) {
        DONE(GT_PtData(1, n, n));
    }
    REFUSED(1, "FIFO is full; 32 segments fit", GT_PtData(1, 33, 33));
    DONE(GT_PtSpace(1, &space));
    HOLDS(space == 0);
    DONE(GT_PrfFollow(2));
    for (int n = 1; n <= 16; n++) {
        DONE(GT_FollowData(2, 100 * n, 100 * n));
    }
    REFUSED(1, "FIFO is full; 16 segments fit", GT_FollowData(2, 1700, 1700));
    DONE(GT_FollowSpace(2, &space));
    HOLDS(space == 0);
}

// Axis 1 jogs, 2 runs a PVT table, 3 a PT list, 4 follows 1.
static void moving()
{
    TJogPrm jog = {1, 1, 0};
    TCrdPrm crd;
    double time[3] = {0, 5000, 10000}, pos[3] = {0, 5000, 10000}, vel[3] = {0, 1, 0};
    short axes[1] = {3}, options[1] = {0};
    static const char moves[] = "is moving; stop it first";
    DONE(GT_PrfJog(1));
    DONE(GT_SetJogPrm(1, &jog));
    DONE(GT_SetVel(1, 10));
    DONE(GT_PrfPvt(2));
    DONE(GT_PvtTable(2, 3, time, pos, vel));
    DONE(GT_PvtTableSelect(2, 2));
    DONE(GT_PrfPt(3));
    DONE(GT_PtData(3, 5000, 5000));
    DONE(GT_PrfFollow(4));
    DONE(GT_SetFollowMaster(4, 1));
    DONE(GT_FollowData(4, 100000, 100000));
    DONE(GT_SetFollowEvent(4, FOLLOW_EVENT_START, 1));
    DONE(GT_Update(1));
    DONE(GT_PvtStart(1 << 1));
    DONE(GT_PtStart(1 << 2));
    DONE(GT_FollowStart(1 << 3));
    for (short axis = 1; axis <= 4; axis++) {
        HOLDS(status_of(axis, 0x400));
    }
    REFUSED(1, moves, GT_PrfTrap(1));
    REFUSED(1, moves, GT_PrfJog(2));
    REFUSED(1, moves, GT_PrfPt(1));
    REFUSED(1, moves, GT_PrfPvt(1));
    REFUSED(1, moves, GT_PrfFollow(1));
    REFUSED(1, moves, GT_PrfFollowEx(1));
    REFUSED(1, moves, GT_ZeroPos(1));
    REFUSED(1, moves, GT_SetPrfPos(1, 0));
    // It changes nothing.
    DONE(GT_SynchAxisPos(1));
    REFUSED(1, "moving", GT_SetTick(500));
    memset(&crd, 0, sizeof crd);
    crd.dimension = 1;
    crd.profile[0] = 1;
    crd.synVelMax = 100;
    crd.synAccMax = 1;
    REFUSED(1, moves, GT_SetCrdPrm(1, &crd));
    REFUSED(1, "PVT table 2 is in use by axis 2", GT_PvtTable(2, 3, time, pos, vel));
    REFUSED(1, moves, GT_PvtStart(1 << 1));
    REFUSED(1, moves, GT_PtStart(1 << 2));
    REFUSED(1, moves, GT_PtStartPro(axes, options, 1));
    REFUSED(1, moves, GT_SetPtMemory(3, 1));
    REFUSED(1, "is running; it can be cleared at rest", GT_PtClear(3));
    REFUSED(1, moves, GT_SetFollowMaster(4, 5));
    REFUSED(1, moves, GT_SetFollowMemory(4, 1));
    REFUSED(1, moves, GT_FollowStart(1 << 3));
    REFUSED(1, "is running; it can be cleared at rest", GT_FollowClear(4));
    REFUSED(1, "holds no data", GT_FollowSwitch(1 << 3));
    DONE(GT_Stop(0xf, 0xf));
    for (short axis = 1; axis <= 4; axis++) {
        wait_for(axis);
    }
}

static void paths()
{
    static const char unset[] = "call SetCrdPrm first";
    TCrdPrm crd;
    TCrdData data, ahead[16];
    short runs;
    long number, space;
    double value[8];
    memset(&crd, 0, sizeof crd);
    memset(&data, 0, sizeof data);
    DONE(GT_PrfTrap(5));
    REFUSED(1, "axis connector 7 carries step pulses", GT_BufLaserOn(1));
    REFUSED(1, "axis connector 7 carries step pulses", GT_LaserOn());
    DONE(GT_SetAxisMode(7, 1));
    // No SetCrdPrm yet.
    REFUSED(1, unset, GT_GetCrdPrm(1, &crd));
    REFUSED(1, unset, GT_CrdClear(1, 0));
    REFUSED(1, unset, GT_CrdSpace(1, &space));
    REFUSED(1, unset, GT_CrdStart(1, 0));
    REFUSED(1, unset, GT_GetCrdPos(1, value));
    REFUSED(1, unset, GT_GetRemainderSegNum(1, &number));
    REFUSED(1, unset, GT_InitLookAhead(1, 0, 5, 1, 16, ahead));
    REFUSED(1, unset, GT_CrdData(1, &data));
    REFUSED(1, unset, GT_LnXY(1, 100, 0, 10, 1));
    REFUSED(1, unset, GT_LnXYZ(1, 100, 0, 0, 10, 1));
    REFUSED(1, unset, GT_LnXYZA(1, 100, 0, 0, 0, 10, 1));
    REFUSED(1, unset, GT_LnXYG0(1, 100, 0, 10, 1));
    REFUSED(1, unset, GT_ArcXYC(1, 100, 0, 50, 0, 0, 10, 1));
    REFUSED(1, unset, GT_ArcXYR(1, 100, 0, 50, 0, 10, 1));
    REFUSED(1, unset, GT_ArcYZC(1, 100, 0, 50, 0, 0, 10, 1));
    REFUSED(1, unset, GT_ArcYZR(1, 100, 0, 50, 0, 10, 1));
    REFUSED(1, unset, GT_ArcZXC(1, 100, 0, 50, 0, 0, 10, 1));
    REFUSED(1, unset, GT_ArcZXR(1, 100, 0, 50, 0, 10, 1));
    REFUSED(1, unset, GT_BufDelay(1, 5));
    REFUSED(1, unset, GT_BufIO(1, MC_GPO, 1, 1));
    REFUSED(1, unset, GT_BufDoBit(1, MC_GPO, 2, 1));
    REFUSED(1, unset, GT_BufDA(1, 3, 1000));
    REFUSED(1, unset, GT_BufMove(1, 5, 100, 10, 1, 1));
    REFUSED(1, unset, GT_BufGear(1, 5, 100));
    REFUSED(1, unset, GT_BufLaserOn(1));
    REFUSED(1, unset, GT_BufLaserOff(1));
    REFUSED(1, unset, GT_BufLaserPrfCmd(1, 20));
    REFUSED(1, unset, GT_BufLaserFollowMode(1));
    REFUSED(1, unset, GT_BufLaserFollowRatio(1, 0.1, 0, 50));
    REFUSED(1, unset, GT_BufLaserFollowOff(1));
    REFUSED(1, "follow table 1 of laser channel 0 is empty", GT_BufLaserFollowTable(1, 1, 0, 50));

    crd.dimension = 2;
    crd.profile[0] = 1;
    crd.profile[1] = 2;
    crd.synVelMax = 100;
    crd.synAccMax = 1;
    DONE(GT_SetCrdPrm(1, &crd));
    REFUSED(1, "holds nothing to do", GT_CrdStart(1, 0));
    REFUSED(1, "is not in the mode", GT_Update(1));
    REFUSED(1, "is not in the mode", GT_PtStart(1));
    for (int n = 0; n < 1024; n++) {
        DONE(GT_LnXY(1, 10 * (n + 1), 0, 10, 1));
    }
    DONE(GT_CrdSpace(1, &space));
    HOLDS(space == 0);
    REFUSED(1, "FIFO is full; 1024 entries fit", GT_LnXY(1, 0, 0, 10, 1));
    REFUSED(1, "FIFO is full", GT_BufDelay(1, 1));
    REFUSED(1, "FIFO is full", GT_BufLaserOn(1));
    REFUSED(1, "holds entries", GT_InitLookAhead(1, 0, 5, 1, 16, ahead));

    DONE(GT_CrdStart(1, 0));
    DONE(GT_CrdStatus(1, &runs, &number));
    HOLDS(runs == 1);
    REFUSED(1, "coordinate system 1 is running", GT_CrdStart(1, 0));
    REFUSED(1, "coordinate system 1 is running", GT_SetCrdPrm(1, &crd));
    REFUSED(1, "coordinate system 1 is running", GT_CrdClear(1, 0));
    REFUSED(1, "coordinate system 1 is running", GT_LaserPowerMode(0, 100, 0));
    REFUSED(1, "is moving", GT_PrfTrap(1));
    REFUSED(1, "is moving", GT_ZeroPos(1));
    DONE(GT_CrdStop(1, 0));
    do {
        DONE(GT_CrdStatus(1, &runs, &number));
    } while (runs);
    DONE(GT_CrdClear(1, 0));
    // An axis taken away from its coordinate system.
    DONE(GT_PrfTrap(2));
    DONE(GT_LnXY(1, 100, 0, 10, 1));
    REFUSED(1, "call SetCrdPrm again", GT_CrdStart(1, 0));
}

static void lasers()
{
    double ratio[4] = {0.1, 0, 0, 0};
    short dac[1] = {100};
    REFUSED(1, "distance follow is off", GT_SetLaserDisRatio(ratio, 0, 100));
    DONE(GT_LaserPowerMode(2, 10, 0));
    REFUSED(1, "belongs to laser channel 0", GT_SetDac(1, dac, 1));
}

static void off()
{
    TJogPrm jog = {1, 1, 0};
    DONE(GT_PrfJog(6));
    DONE(GT_SetJogPrm(6, &jog));
    DONE(GT_SetVel(6, 10));
    DONE(GT_AxisOff(6));
    REFUSED(1, "servo is off; call AxisOn first", GT_Update(1 << 5));
}

int main()
{
    DONE(GT_Open());
    DONE(GT_Reset());
    DONE(GT_LoadConfig("test.cfg"));
    for (short axis = 1; axis <= 8; axis++) {
        DONE(GT_AxisOn(axis));
    }
    wrong_mode();
    nothing_to_do();
    full();
    moving();
    paths();
    lasers();
    off();
    DONE(GT_Close());
    return verdict();
}
