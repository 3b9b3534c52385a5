// Point to point with a thread that watches: CreateThread, an event that ends it, WaitForSingleObject.
#include "stdafx.h"
#include <windows.h>
#include "gts.h"

#define AXIS 1

static HANDLE g_hStop;
static volatile LONG g_samples = 0;
static double g_maxVel = 0;

DWORD WINAPI WatchThread(LPVOID lpParam)
{
    short axis = *(short *)lpParam;
    while (WaitForSingleObject(g_hStop, 10) == WAIT_TIMEOUT)
    {
        double vel = 0;
        GT_GetPrfVel(axis, &vel);
        if (vel > g_maxVel)
            g_maxVel = vel;
        InterlockedIncrement(&g_samples);
    }
    return 42;
}

int _tmain(int argc, _TCHAR *argv[])
{
    short sRtn, axis = AXIS;
    TTrapPrm trap;
    double pos = 0;
    long sts = 0;
    DWORD dwId = 0, dwCode = 0;

    sRtn = GT_Open();
    if (sRtn != 0)
    {
        printf("GT_Open failed: %d\n", sRtn);
        return 1;
    }
    GT_Reset();
    GT_ClrSts(1, 8);
    GT_AxisOn(AXIS);
    GT_ZeroPos(AXIS);
    g_hStop = CreateEvent(NULL, TRUE, FALSE, NULL);
    HANDLE hThread = CreateThread(NULL, 0, WatchThread, &axis, 0, &dwId);

    GT_PrfTrap(AXIS);
    GT_GetTrapPrm(AXIS, &trap);
    trap.acc = 0.25;
    trap.dec = 0.125;
    trap.smoothTime = 25;
    GT_SetTrapPrm(AXIS, &trap);
    GT_SetVel(AXIS, 50);
    GT_SetPos(AXIS, 50000L);
    GT_Update(1 << (AXIS - 1));
    do
    {
        Sleep(1);
        GT_GetSts(AXIS, &sts);
        GT_GetPrfPos(AXIS, &pos);
    } while (sts & 0x400);

    SetEvent(g_hStop);
    WaitForSingleObject(hThread, INFINITE);
    GetExitCodeThread(hThread, &dwCode);
    CloseHandle(hThread);
    CloseHandle(g_hStop);
    GT_AxisOff(AXIS);
    GT_Close();
    printf("pos=%.0f maxVel=%.1f code=%lu samples=%s\n", pos, g_maxVel, dwCode, g_samples > 100 ? "many" : "few");
    return 0;
}
