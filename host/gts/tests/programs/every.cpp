// Every function, called as it is meant: it returns 0, and what it reads back is what was set.
#include "gts.h"
#include "check.h"

static void wait_for(short axis)
{
    long status;
    do {
        DONE(GT_GetSts(axis, &status));
    } while (status & 0x400);
}

static bool is_lsr()
{
    char *version;
    DONE(GT_GetVersion(&version));
    return strstr(version, "family lsr") != NULL;
}

static void session()
{
    unsigned long clock = 0, loop = 0;
    char reason[64];
    DONE(GT_Reset());
    DONE(GT_LoadConfig("test.cfg"));
    DONE(GT_ClrSts(1, 8));
    DONE(GT_GetClock(&clock, &loop));
    HOLDS(loop > 0);
    DONE(GT_SetTick(250));
    DONE(GT_SetLinkLoss(500, 0));
    double lossMs;
    short stopAll;
    DONE(GT_GetLinkLoss(&lossMs, &stopAll));
    HOLDS(lossMs == 500 && stopAll == 0);
    DONE(GT_SetInterlock(1));
    DONE(GT_Abort());
    DONE(GT_GetLastReason(reason, sizeof reason));
}

static void axes()
{
    double value[8], smooth, abrupt;
    long status[8], mode[8], positive, negative, band, time, error;
    unsigned long clock = 0;
    short captured[8];
    for (short axis = 1; axis <= 8; axis++) {
        DONE(GT_AxisOn(axis));
    }
    DONE(GT_AxisOff(8));
    DONE(GT_ZeroPos(1, 8));
    DONE(GT_SetPrfPos(7, 1234));
    DONE(GT_SetEncPos(7, 1234));
    DONE(GT_SynchAxisPos(1 << 6));
    DONE(GT_GetPrfPos(7, value));
    HOLDS(value[0] == 1234);
    DONE(GT_GetEncPos(1, value, 8, &clock));
    DONE(GT_GetPrfVel(1, value, 8));
    HOLDS(value[0] == 0);
    DONE(GT_GetPrfAcc(1, value, 8));
    DONE(GT_GetEncVel(1, value, 8));
    DONE(GT_GetSts(1, status, 8, &clock));
    short stopped = -1;
    DONE(GT_GetStopReason(1, &stopped));
    HOLDS(stopped == 0);
    HOLDS((status[0] & 0x200) && !(status[7] & 0x200) && clock > 0);
    DONE(GT_GetPrfMode(1, mode, 8));
    HOLDS(mode[0] == 0);
    DONE(GT_SetStopDec(1, 2, 500));
    DONE(GT_GetStopDec(1, &smooth, &abrupt));
    HOLDS(smooth == 2 && abrupt == 500);
    DONE(GT_SetAxisBand(1, 5, 4));
    DONE(GT_GetAxisBand(1, &band, &time));
    HOLDS(band == 5 && time == 4);
    DONE(GT_SetSoftLimit(1, 1000000, -1000000));
    DONE(GT_GetSoftLimit(1, &positive, &negative));
    HOLDS(positive == 1000000 && negative == -1000000);
    DONE(GT_LmtsOn(1));
    DONE(GT_LmtsOff(1));
    DONE(GT_LmtSns(0));
    DONE(GT_AlarmOn(1));
    DONE(GT_AlarmOff(1));
    DONE(GT_SetPosErr(1, 30000));
    DONE(GT_GetPosErr(1, &error));
    HOLDS(error == 30000);
    DONE(GT_SetCaptureMode(1, CAPTURE_HOME));
    DONE(GT_GetCaptureStatus(1, captured, status, 2, &clock));
    HOLDS(captured[0] == 0);
    DONE(GT_Stop(3, 0));
}

static void trap_and_jog()
{
    TTrapPrm trap = {1, 2, 0, 10}, trap_read;
    TJogPrm jog = {1, 2, 0.5}, jog_read;
    long pos;
    double vel, value;
    DONE(GT_PrfTrap(1));
    DONE(GT_SetTrapPrm(1, &trap));
    DONE(GT_GetTrapPrm(1, &trap_read));
    HOLDS(trap_read.dec == 2 && trap_read.smoothTime == 10);
    DONE(GT_SetPos(1, 1000));
    DONE(GT_GetPos(1, &pos));
    HOLDS(pos == 1000);
    DONE(GT_SetVel(1, 20));
    DONE(GT_GetVel(1, &vel));
    HOLDS(vel == 20);
    DONE(GT_PrfJog(2));
    DONE(GT_SetJogPrm(2, &jog));
    DONE(GT_GetJogPrm(2, &jog_read));
    HOLDS(jog_read.smooth == 0.5);
    DONE(GT_SetVel(2, 5));
    DONE(GT_Update(3));
    wait_for(1);
    DONE(GT_GetPrfPos(1, &value));
    HOLDS(value == 1000);
    DONE(GT_Stop(2, 0));
    wait_for(2);
}

static void inputs_and_outputs()
{
    long bits;
    short dac[2] = {16384, -16384}, dac_read[2];
    double adc[2];
    DONE(GT_GetDi(MC_GPI, &bits));
    DONE(GT_SetDo(MC_GPO, 0x5));
    DONE(GT_GetDo(MC_GPO, &bits));
    HOLDS((bits & 0xf) == 0x5);
    DONE(GT_SetDoBit(MC_GPO, 2, 1));
    DONE(GT_GetDo(MC_GPO, &bits));
    HOLDS((bits & 0xf) == 0x7);
    long words[4] = {-1, -1, -1, -1};
    DONE(GT_SetDoEx(MC_GPO, words, 1));
    DONE(GT_GetDoEx(MC_GPO, words, 4));
    HOLDS(words[0] == -1 && words[1] == 0 && words[2] == 0 && words[3] == 0);
    words[0] = 7;
    DONE(GTN_SetDoEx(1, MC_GPO, words, 1));
    DONE(GTN_GetDoEx(1, MC_GPO, words));
    HOLDS(words[0] == 7);
    words[3] = 9;
    DONE(GT_GetDiEx(MC_GPI, words, 4));
    HOLDS(words[0] == 0 && words[3] == 0);
    DONE(GTN_GetDiEx(1, MC_GPI, words));
    DONE(GT_SetDac(3, dac, 2));
    DONE(GT_GetDac(3, dac_read, 2));
    HOLDS(dac_read[0] == 16384 && dac_read[1] == -16384);
    DONE(GT_GetAdc(1, adc, 2));
    /* What is set is read at once, also under LmtSns: levels are those of the terminals. */
    const short types[] = {MC_LIMIT_POSITIVE, MC_LIMIT_NEGATIVE, MC_ALARM, MC_HOME, MC_GPI, MC_ARRIVE};
    for (short type : types) {
        DONE(GT_SimInput(type, 8, 1));
        DONE(GT_GetDi(type, &bits));
        HOLDS(bits == 0x80);
        DONE(GT_SimInput(type, 8, 0));
        DONE(GTN_GetDi(1, type, &bits));
        HOLDS(bits == 0);
    }
    DONE(GT_LmtSns(0x8000));
    DONE(GT_GetDi(MC_LIMIT_NEGATIVE, &bits));
    HOLDS(bits == 0);
    DONE(GT_LmtSns(0));
    DONE(GTN_SimInput(1, MC_INTERLOCK, 1, 1));
    DONE(GT_SimInput(MC_INTERLOCK, 1, 0));
    DONE(GT_ClrSts(1, 8));
    /* A read lasts a tick, which samples the interlock. */
    DONE(GT_GetDi(MC_GPI, &bits));
    DONE(GT_ClrLaserFault(0));
    DONE(GT_ClrLaserFault(1));
    DONE(GT_SimAdc(2, -3.5));
    DONE(GT_GetAdc(1, adc, 2));
    HOLDS(adc[0] == 0 && adc[1] > -3.501 && adc[1] < -3.499);
    DONE(GTN_SimAdc(1, 2, 0));
}

static void pt()
{
    short space, memory, list[2] = {3, 4}, options[2] = {0, 0};
    long loops;
    for (short axis = 3; axis <= 4; axis++) {
        DONE(GT_PrfPt(axis));
        DONE(GT_SetPtMemory(axis, 1));
        DONE(GT_GetPtMemory(axis, &memory));
        HOLDS(memory == 1);
        DONE(GT_PtClear(axis));
        DONE(GT_PtData(axis, 10, 10));
        DONE(GT_PtData(axis, 20, 20, PT_SEGMENT_STOP));
        DONE(GT_PtSpace(axis, &space));
        HOLDS(space == 1022);
        DONE(GT_SetPtLoop(axis, 2));
    }
    DONE(GT_PtStart(1 << 2));
    wait_for(3);
    DONE(GT_GetPtLoop(3, &loops));
    HOLDS(loops == 2);
    DONE(GT_PtStartPro(list, options, 2));
    wait_for(3);
    wait_for(4);
}

static void pvt()
{
    double time[3] = {0, 100, 200}, pos[3] = {0, 100, 200}, vel[3] = {0, 1.5, 0}, percent[3] = {0, 0, 0}, found[3], at[1];
    double a[3], b[3], c[3], most[2] = {2, 2}, acc[2] = {0.1, 0.1}, ends[2] = {0, 100}, rest[2] = {0, 0}, none[2] = {0, 0};
    long count, loop;
    short table[1];
    DONE(GT_PrfPvt(5));
    DONE(GT_PvtTable(1, 3, time, pos, vel));
    DONE(GT_PvtTableEx(2, 3, time, pos, vel, vel));
    DONE(GT_PvtTableComplete(3, 3, time, pos, a, b, c));
    DONE(GT_PvtTablePercent(4, 3, time, pos, percent));
    DONE(GT_PvtPercentCalculate(3, time, pos, percent, 0, found));
    HOLDS(found[1] == 2 && found[2] == 0);
    DONE(GT_PvtContinuousCalculate(2, ends, rest, none, most, acc, acc, at));
    DONE(GT_PvtTableContinuous(5, 2, ends, rest, none, most, acc, acc, 0));
    DONE(GT_PvtTableSelect(5, 1));
    DONE(GT_SetPvtLoop(5, 1));
    DONE(GT_PvtStart(1 << 4));
    DONE(GT_PvtStatus(5, table, at));
    HOLDS(table[0] == 1);
    wait_for(5);
    DONE(GT_GetPvtLoop(5, &count, &loop));
    HOLDS(count == 1 && loop == 1);
}

static void follow()
{
    short space, memory, index, type, item, event, dir, fifo, waits;
    long loop, pos;
    DONE(GT_PrfFollow(6));
    DONE(GT_SetFollowMaster(6, 2));
    DONE(GT_GetFollowMaster(6, &index, &type, &item));
    HOLDS(index == 2 && type == FOLLOW_MASTER_PROFILE && item == 0);
    DONE(GT_SetFollowMemory(6, 1));
    DONE(GT_GetFollowMemory(6, &memory));
    HOLDS(memory == 1);
    DONE(GT_FollowClear(6));
    DONE(GT_FollowClear(6, 1));
    DONE(GT_FollowData(6, 100, 100));
    DONE(GT_FollowData(6, 200, 200, FOLLOW_SEGMENT_EVEN, 1));
    DONE(GT_FollowSpace(6, &space));
    HOLDS(space == 511);
    DONE(GT_SetFollowLoop(6, 0));
    DONE(GT_SetFollowEvent(6, FOLLOW_EVENT_PASS, 1, 1000000));
    DONE(GT_GetFollowEvent(6, &event, &dir, &pos));
    HOLDS(event == FOLLOW_EVENT_PASS && dir == 1 && pos == 1000000);
    DONE(GT_FollowStart(1 << 5));
    DONE(GT_FollowSwitch(1 << 5));
    DONE(GT_GetFollowLoop(6, &loop));
    DONE(GT_GetFollowStatus(6, &fifo, &waits));
    DONE(GT_Stop(1 << 5, 1 << 5));
    wait_for(6);
}

static void follow_ex()
{
    short space, memory, index, event, dir, fifo, waits, first;
    long loop, pos;
    double slave;
    DONE(GT_PrfFollowEx(6));
    DONE(GT_SetFollowMasterEx(6, 2));
    DONE(GT_GetFollowMasterEx(6, &index));
    HOLDS(index == 2);
    DONE(GT_SetFollowMemoryEx(6, 0));
    DONE(GT_GetFollowMemoryEx(6, &memory));
    HOLDS(memory == 0);
    DONE(GT_FollowClearEx(6));
    DONE(GT_FollowDataPercentEx(6, 100, 50));
    DONE(GT_FollowDataPercent2Ex(6, 200, 150, 1, 1, 100, &first));
    DONE(GT_GetFollowDataPercent2Ex(50, 1, 1, 100, 50, &slave));
    DONE(GT_FollowDoBitEx(6, MC_GPO, 1, 0));
    DONE(GT_FollowDelayEx(6, 4));
    DONE(GT_FollowDiBitEx(6, MC_GPI, 1, 0, 10));
    DONE(GT_FollowSpaceEx(6, &space));
    HOLDS(space < 16);
    DONE(GT_FollowClearEx(6, 1));
    DONE(GT_FollowDataPercentEx(6, 100, 100, FOLLOW_SEGMENT_EVEN, 0, 1));
    DONE(GT_SetFollowLoopEx(6, 0));
    DONE(GT_SetFollowEventEx(6, FOLLOW_EVENT_PASS, 1, 1000000));
    DONE(GT_GetFollowEventEx(6, &event, &dir, &pos));
    HOLDS(pos == 1000000);
    DONE(GT_FollowStartEx(1 << 5));
    DONE(GT_FollowSwitchEx(1 << 5));
    DONE(GT_FollowSwitchNowEx(6, FOLLOW_SWITCH_TABLE));
    DONE(GT_GetFollowLoopEx(6, &loop));
    DONE(GT_GetFollowStatusEx(6, &fifo, &waits));
    DONE(GT_Stop(1 << 5, 1 << 5));
    wait_for(6);
}

static void lasers(bool lsr)
{
    unsigned short on = 9;
    unsigned long time;
    short value, map, cause;
    double power;
    if (lsr) {
        DONE(GT_SetLaserMode(0));
        REFUSED(8, "", GT_SetAxisMode(AXIS_LASER, 1));
    } else {
        DONE(GT_SetAxisMode(AXIS_LASER, 1));
    }
    DONE(GT_LaserPowerMode(LASER_CTRL_MODE_PWM1, 100, 0));
    DONE(GT_LaserOutFrq(10));
    DONE(GT_SetPulseWidth(10));
    DONE(GT_SetWaitPulse(1, 5, 2));
    DONE(GT_SetWaitPulseEx(0, 5, 2));
    DONE(GT_SetPreVltg(0, 1));
    DONE(GT_SetLevelDelay(20, 10));
    DONE(GT_EnaFPK(10, 5, 0));
    DONE(GT_DisFPK());
    DONE(GT_SetLaserCrdMap(0, 1));
    DONE(GT_GetLaserCrdMap(0, &map));
    HOLDS(map == 1);
    DONE(GT_ZeroLaserOnTime(0));
    DONE(GT_LaserPrfCmd(30));
    DONE(GT_LaserOn());
    DONE(GT_LaserOnStatus(&value));
    HOLDS(value == 1);
    DONE(GT_GetHSIOOpt(&on));
    HOLDS(on == 1);
    DONE(GT_GetLaserPower(0, &power));
    DONE(GT_SetHSIOOpt(0));
    DONE(GT_LaserOff());
    DONE(GT_GetLaserOnTime(0, &time));
    DONE(GT_GetLaserFault(0, &cause));
    HOLDS(cause == 0);
    DONE(GT_ClrLaserFault(0));
}

static void paths(bool lsr)
{
    TCrdPrm crd, crd_read;
    TCrdData data, ahead[16];
    short runs;
    long segment, space, left;
    double pos[8], vel, vels[2] = {0, 100}, powers[2] = {10, 50};
    double ratio[4] = {0.1, 0, 0, 0}, scale[4] = {1000, 1000, 1000, 1000};
    long places[4] = {0, 0, 0, 0};
    memset(&crd, 0, sizeof crd);
    crd.dimension = 4;
    for (short n = 0; n < 4; n++) {
        crd.profile[n] = (short)(n + 1);
    }
    crd.synVelMax = 100;
    crd.synAccMax = 1;
    crd.setOriginFlag = 1;
    crd.originPos[1] = 50;
    DONE(GT_SetCrdPrm(1, &crd));
    DONE(GT_GetCrdPrm(1, &crd_read));
    HOLDS(crd_read.dimension == 4 && crd_read.profile[3] == 4 && crd_read.originPos[1] == 50);
    DONE(GT_SetCrdStopDec(1, 1, 10));
    DONE(GT_SetOverride(1, 1));
    DONE(GT_GetLaserFollowFilter(1, &vel));
    HOLDS(vel == 1);
    DONE(GT_SetLaserFollowFilter(1, 0.5));
    DONE(GTN_GetLaserFollowFilter(1, 1, &vel));
    HOLDS(vel == 0.5);
    DONE(GTN_SetLaserFollowFilter(1, 1, 1));
    DONE(GT_SetCrdLimit(1, 1, 100, 1));
    DONE(GT_GetCrdLimit(1, 1, &vel, pos));
    HOLDS(vel == 100);
    DONE(GT_CrdClear(1, 0));
    DONE(GT_CrdClear(1, 1));
    DONE(GT_SetLaserFollowTable(1, 2, vels, powers, 0));
    DONE(GT_SetLaserDisMode(1, 0, places, scale));
    DONE(GT_SetLaserDisRatio(ratio, 0, 100));
    DONE(GT_SetLaserDisRatio(ratio));

    DONE(GT_LnXY(1, 1000, 0, 50, 1));
    DONE(GT_LnXYZ(1, 1000, 1000, 100, 50, 1));
    DONE(GT_LnXYZA(1, 0, 0, 0, 100, 50, 1));
    DONE(GT_LnXYG0(1, 100, 0, 50, 1));
    DONE(GT_ArcXYC(1, 100, 0, 100, 0, CIRCLE_DIR_CW, 20, 1));
    DONE(GT_ArcXYR(1, 300, 0, 100, CIRCLE_DIR_CW, 20, 1));
    DONE(GT_ArcYZC(1, 0, 0, 50, 0, CIRCLE_DIR_CCW, 20, 1));
    DONE(GT_ArcYZR(1, 100, 0, 50, CIRCLE_DIR_CCW, 20, 1));
    DONE(GT_ArcZXC(1, 0, 300, 0, 50, CIRCLE_DIR_CCW, 20, 1));
    DONE(GT_ArcZXR(1, 0, 400, 50, CIRCLE_DIR_CCW, 20, 1));
    DONE(GT_BufDelay(1, 5));
    DONE(GT_BufIO(1, MC_GPO, 3, 1));
    DONE(GT_BufDoBit(1, MC_GPO, 2, 1));
    DONE(GT_BufDA(1, 3, 1000));
    DONE(GT_PrfTrap(5));
    DONE(GT_BufMove(1, 5, 500, 10, 1, 1));
    DONE(GT_BufGear(1, 7, 100));
    DONE(GT_BufLaserFollowMode(1));
    DONE(GT_BufLaserFollowRatio(1, 0.1, 0, 50));
    DONE(GT_BufLaserOn(1));
    DONE(GT_LnXY(1, 500, 100, 50, 1));
    DONE(GT_BufLaserFollowTable(1, 1, 0, 50));
    DONE(GT_BufLaserFollowOff(1));
    DONE(GT_BufLaserPrfFollow(1, 0.1, 0, 50));
    DONE(GT_BufLaserPrfCmd(1, 20));
    DONE(GT_BufLaserOff(1));
    DONE(GT_CrdSpace(1, &space));
    HOLDS(space > 900 && space < 1024);
    DONE(GT_GetRemainderSegNum(1, &left));
    HOLDS(left == 11);
    DONE(GT_CrdStart(1, 0));
    DONE(GT_GetCrdVel(1, &vel));
    DONE(GT_CrdStop(1, 0));
    do {
        DONE(GT_CrdStatus(1, &runs, &segment));
    } while (runs);
    DONE(GT_CrdStart(1, 0));
    do {
        DONE(GT_CrdStatus(1, &runs, &segment));
    } while (runs);
    HOLDS(segment == 11);
    DONE(GT_GetCrdPos(1, pos));
    short stopped = -1;
    char text[80];
    DONE(GT_GetCrdStopReason(1, &stopped, text, sizeof text));
    HOLDS(stopped == 1 && strcmp(text, "it has ended") == 0);
    HOLDS(pos[0] == 500 && pos[1] == 100 && pos[3] == 100);

    DONE(GT_CrdClear(1, 1));
    DONE(GT_InitLookAhead(1, 1, 5, 1, 16, ahead));
    memset(&data, 0, sizeof data);
    data.pos[0] = 600;
    data.vel = 50;
    data.acc = 1;
    DONE(GT_CrdData(1, &data, 1));
    DONE(GT_LnXY(1, 700, 0, 50, 1, 0, 1));
    DONE(GT_CrdData(1, NULL, 1));
    DONE(GT_CrdStart(1, 1));
    do {
        DONE(GT_CrdStatus(1, &runs, &segment, 1));
    } while (runs);
    HOLDS(segment == 2);

    double table[8] = {0, 1, 0, 0, 0, 0, 0, 0};
    long points[8] = {0, 100, 0, 100, 0, 100, 0, 100};
    double limits[4] = {100, 100, 100, 100};
    DONE(GT_SetLaserDisTable1D(2, table, points, 0, 100, limits));
    short which[2] = {1, 2}, counts[2] = {2, 2};
    double grid[4] = {0, 1, 1, 0};
    long xs[2] = {0, 100}, ys[2] = {0, 100};
    DONE(GT_SetLaserDisTable2D(which, counts, grid, xs, ys, 0, 100, limits));
    DONE(GT_SetLaserDisMode(0, 0, NULL, NULL));
    (void)lsr;
}

/* Kept, in controller time, or refused with what is missing. */
static void beyond()
{
    long raw = 0, di = 0, ls[2] = {0, 0};
    unsigned long before = 0, after = 0, ms = 0;
    short s = 0, t = 0;
    unsigned short us = 0;
    double d = 0;
    DONE(GT_GetDi(MC_GPI, &di));
    DONE(GT_GetDiRaw(MC_GPI, &raw));
    HOLDS(raw == di);
    DONE(GT_GetClockHighPrecision(&before));
    DONE(GT_Delay(20));
    DONE(GT_DelayHighPrecision(40));
    DONE(GT_GetClockHighPrecision(&after));
    DONE(GT_GetClock(&ms));
    /* 30 ms are 240 units of 125 us, and the reads are a tick each. */
    HOLDS(after - before >= 240 && after - before <= 250);
    HOLDS(ms >= after / 8 && ms <= after / 8 + 2);

    TPid pid = {1, 0.5, 2, 3, 4, 5, 6, 7}, back = {0, 0, 0, 0, 0, 0, 0, 0};
    DONE(GT_GetPid(1, 1, &back));
    HOLDS(back.kp == 0 && back.limit == 32767);
    DONE(GT_SetPid(1, 2, &pid));
    DONE(GT_GetPid(1, 2, &back));
    HOLDS(back.kp == 1 && back.ki == 0.5 && back.kaff == 4 && back.integralLimit == 5 && back.derivativeLimit == 6 && back.limit == 7);
    pid.kd = -1;
    REFUSED(7, "kd is -1", GT_SetPid(1, 2, &pid));
    REFUSED(7, "index is 4", GT_SetPid(1, 4, &pid));
    REFUSED(7, "control is 9", GT_GetPid(9, 1, &pid));
    REFUSED(7, "pid is NULL", GT_SetPid(1, 1, NULL));
    DONE(GT_GetPid(1, 2, &back));
    HOLDS(back.kd == 2);
    DONE(GT_SetControlFilter(8, 3));
    DONE(GT_GetControlFilter(8, &s));
    HOLDS(s == 3);
    DONE(GT_SetKvffFilter(1, 3, 10.5));
    DONE(GT_GetKvffFilter(1, &s, &d));
    HOLDS(s == 3 && d == 10.5);
    DONE(GT_SetAxisPrfVelFilter(1, 4));
    DONE(GT_GetAxisPrfVelFilter(1, &s));
    DONE(GT_SetAxisEncVelFilter(1, 5));
    DONE(GT_GetAxisEncVelFilter(1, &t));
    HOLDS(s == 4 && t == 5);
    DONE(GT_SetProfileScale(1, -2, 3));
    DONE(GT_GetProfileScale(1, &s, &t));
    HOLDS(s == -2 && t == 3);
    REFUSED(7, "beta is 0", GT_SetProfileScale(1, 1, 0));
    DONE(GT_SetEncoderScale(1, 2, 5));
    DONE(GT_GetEncoderScale(1, &s, &t));
    HOLDS(s == 2 && t == 5);
    DONE(GT_SetMtrBias(2, -300));
    DONE(GT_GetMtrBias(2, &s));
    DONE(GT_SetMtrLmt(2, 30000));
    DONE(GT_GetMtrLmt(2, &t));
    HOLDS(s == -300 && t == 30000);
    REFUSED(7, "dac is 9", GT_SetMtrBias(9, 0));
    DONE(GT_SetAdcFilter(1, 10));
    DONE(GT_CtrlMode(1, 1));
    REFUSED(7, "mode is 2", GT_CtrlMode(1, 2));
    DONE(GT_EncOn(1));
    REFUSED(1, "pulse output", GT_EncOff(1));
    DONE(GT_StepDir(1));
    REFUSED(1, "step and direction", GT_StepPulse(1));
    DONE(GT_EncSns(0));
    REFUSED(1, "exchange its A and B", GT_EncSns(1));
    DONE(GT_GpiSns(0));
    REFUSED(1, "general inputs", GT_GpiSns(1));

    const char *module = "no extension modules";
    REFUSED(1, module, GT_ExtModuleInit());
    REFUSED(1, module, GT_SetExtDo(1, 1));
    REFUSED(1, module, GT_SetExtDoBit(1, 1));
    REFUSED(1, module, GT_GetExtDo(1, &raw));
    REFUSED(1, module, GT_GetExtDoBit(1, &s));
    REFUSED(1, module, GT_GetExtDi(1, &raw));
    REFUSED(1, module, GT_GetExtDiBit(1, &s));
    REFUSED(1, module, GT_SetExtAo(1, 5));
    REFUSED(1, module, GT_GetExtAi(1, &d));
    REFUSED(1, module, GT_OpenExtMdl());
    REFUSED(1, module, GT_CloseExtMdl());
    REFUSED(1, module, GT_ResetExtMdl());
    REFUSED(1, module, GT_LoadExtConfig("ext.cfg"));
    REFUSED(1, module, GT_SetExtIoValue(1, 1));
    REFUSED(1, module, GT_GetExtIoValue(1, &us));
    REFUSED(1, module, GT_SetExtIoBit(1, 1, 1));
    REFUSED(1, module, GT_GetExtIoBit(1, 1, &us));
    REFUSED(1, module, GT_GetExtAdValue(1, 1, &us));
    REFUSED(1, module, GT_GetExtAdVoltage(1, 1, &d));
    REFUSED(1, module, GT_SetExtDaValue(1, 1, 1));
    REFUSED(1, module, GT_SetExtDaVoltage(1, 1, 1));
    REFUSED(1, "handwheel", GT_HandwheelInit());
    REFUSED(1, "handwheel", GT_SetHandwheelStopDec(1, 1, 1));
    REFUSED(1, "handwheel", GT_StartHandwheel(1, 1, 1, 1, 0, 1, 1, 1, 0));
    REFUSED(1, "handwheel", GT_EndHandwheel(1));
    REFUSED(1, "compensation", GT_SetLeadScrewComp(1, 2, 0, 100, ls, ls));
    REFUSED(1, "compensation", GT_EnableLeadScrewComp(1, 1));
    REFUSED(1, "compensation", GT_SetBacklash(1, 1, 1, 0));
    REFUSED(1, "compensation", GT_GetBacklash(1, &raw, &d, &di));
    REFUSED(1, "Cam is not there", GT_PrfCam(1));
    REFUSED(1, "Cam is not there", GT_CamStart(1));

    /* Gear, edges, an output for a time: gear.cpp goes on. */
    unsigned long edges = 0;
    DONE(GT_ClrSts(1));
    DONE(GT_AxisOn(1));
    DONE(GT_PrfGear(1));
    DONE(GT_SetGearMaster(1, 2));
    DONE(GT_GetGearMaster(1, &s));
    HOLDS(s == 2);
    DONE(GT_SetGearRatio(1, 1, 2));
    DONE(GT_GetGearRatio(1, &raw, &di));
    HOLDS(raw == 1 && di == 2);
    DONE(GT_SetGearEvent(1, 1, 0, 0));
    DONE(GT_GetGearEvent(1, &s, &raw, &di));
    HOLDS(s == 1);
    DONE(GT_GearStart(1));
    DONE(GT_Stop(1, 1));
    DONE(GT_Delay(5));
    DONE(GT_PrfTrap(1));
    DONE(GT_SetDiReverseCount(MC_GPI, 1, &edges));
    DONE(GT_GetDiReverseCount(MC_GPI, 1, &edges));
    HOLDS(edges == 0);
    DONE(GT_SetDoBitReverse(MC_GPO, 1, 1, 4));

    /* Homing: homing.cpp goes all the ways. */
    THomePrm home, kept;
    THomeStatus at;
    memset(&home, 0, sizeof(home));
    DONE(GT_HomeInit());
    DONE(GT_GetHomeStatus(4, &at));
    HOLDS(at.run == 0 && at.stage == 0 && at.error == 0);
    home.mode = 20;
    home.moveDir = 1;
    home.edge = 1;
    home.velHigh = 10;
    home.velLow = 1;
    home.acc = home.dec = 1;
    home.searchHomeDistance = 100;
    DONE(GT_AxisOff(4));
    REFUSED(1, "servo of axis 4 is off", GT_GoHome(4, &home));
    DONE(GT_AxisOn(4));
    DONE(GT_GoHome(4, &home));
    REFUSED(1, "on its way home already", GT_GoHome(4, &home));
    DONE(GT_GetHomePrm(4, &kept));
    HOLDS(kept.mode == 20 && kept.velHigh == 10 && kept.searchHomeDistance == 100);
    DONE(GT_Delay(200));
    DONE(GT_GetHomeStatus(4, &at));
    HOLDS(at.run == 0 && at.error == 8);
    home.mode = 21;
    REFUSED(7, "modes are 10, 11", GT_GoHome(4, &home));
    home.mode = 20;
    home.velLow = 0;
    REFUSED(7, "velLow is 0", GT_GoHome(4, &home));
    home.velLow = 1;
    home.mode = 30;
    DONE(GT_GoHome(4, &home));

    /* What is kept falls back. */
    DONE(GT_Reset());
    DONE(GT_GetMtrBias(2, &s));
    HOLDS(s == 0);
}

int main()
{
    DONE(GT_Open());
    const bool lsr = is_lsr();
    session();
    axes();
    trap_and_jog();
    inputs_and_outputs();
    pt();
    pvt();
    follow();
    follow_ex();
    lasers(lsr);
    paths(lsr);
    beyond();
    DONE(GT_Close());
    return verdict();
}
