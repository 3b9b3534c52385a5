// A home search by hand: negative limit, then the home switch by capture. The limit's time-out by GetTickCount.
#include "stdafx.h"
#include <windows.h>
#include "gts.h"

static bool WaitMotion(short axis, DWORD timeout, short (*ended)(short))
{
    DWORD t0 = GetTickCount();
    while (true)
    {
        long sts;
        GT_GetSts(axis, &sts);
        if (ended && ended(axis))
            return true;
        if (!(sts & 0x400))
            return ended == NULL;
        if (GetTickCount() - t0 > timeout)
            return false;
        Sleep(1);
    }
}

static short Captured(short axis)
{
    short status = 0;
    long value = 0;
    GT_GetCaptureStatus(axis, &status, &value);
    return status;
}

static void MoveTo(short axis, long pos, double vel)
{
    TTrapPrm trap;
    GT_PrfTrap(axis);
    GT_GetTrapPrm(axis, &trap);
    trap.acc = trap.dec = 1;
    GT_SetTrapPrm(axis, &trap);
    GT_SetPos(axis, pos);
    GT_SetVel(axis, vel);
    GT_Update(1 << (axis - 1));
}

int _tmain(int argc, _TCHAR *argv[])
{
    short axis = argc > 1 ? (short)_ttoi(argv[1]) : 1;
    long sts, value = 0;
    short status = 0;
    double pos;
    if (GT_Open(0, 1))
        return 1;
    GT_AlarmOff(axis);
    GT_LmtsOn(axis);
    GT_ClrSts(axis);
    GT_AxisOn(axis);
    // To the negative limit.
    MoveTo(axis, -500000, 20);
    if (!WaitMotion(axis, 60000, NULL))
    {
        printf("no limit\n");
        return 2;
    }
    GT_GetSts(axis, &sts);
    printf("limit=%d\n", (sts & 0x40) != 0);
    GT_ClrSts(axis);
    // Away from it, until the home switch.
    GT_SetCaptureMode(axis, CAPTURE_HOME);
    GT_GetPrfPos(axis, &pos);
    MoveTo(axis, (long)pos + 100000, 10);
    if (!WaitMotion(axis, 60000, Captured))
    {
        printf("no home\n");
        return 3;
    }
    GT_Stop(1 << (axis - 1), 0);
    WaitMotion(axis, 10000, NULL);
    GT_GetCaptureStatus(axis, &status, &value);
    MoveTo(axis, value, 5);
    WaitMotion(axis, 10000, NULL);
    GT_GetPrfPos(axis, &pos);
    printf("at capture=%d\n", (long)pos == value);
    GT_ZeroPos(axis);
    GT_GetPrfPos(axis, &pos);
    printf("zero=%.0f\n", pos);
    GT_Close();
    return 0;
}
