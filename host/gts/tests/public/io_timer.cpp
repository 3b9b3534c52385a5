// Outputs by a multimedia timer, a light that runs; inputs are polled. Times by timeGetTime.
#include "stdafx.h"
#include <windows.h>
#include <mmsystem.h>
#include "gts.h"
#pragma comment(lib, "winmm.lib")

static volatile int g_ticks = 0;
static volatile long g_mask = 0;

void CALLBACK OnTimer(UINT uTimerID, UINT uMsg, DWORD_PTR dwUser, DWORD_PTR dw1, DWORD_PTR dw2)
{
    short bit = (short)(g_ticks % 8 + 1);
    GT_SetDoBit(MC_GPO, bit, 0);
    GT_SetDoBit(MC_GPO, (short)(bit == 1 ? 8 : bit - 1), 1);
    long value;
    GT_GetDo(MC_GPO, &value);
    g_mask |= ~value & 0xff;
    g_ticks++;
}

int _tmain(int argc, _TCHAR *argv[])
{
    TIMECAPS tc;
    if (GT_Open() != 0)
    {
        _tprintf(_T("no card\n"));
        return -1;
    }
    GT_SetDo(MC_GPO, 0xffff);
    timeGetDevCaps(&tc, sizeof(TIMECAPS));
    timeBeginPeriod(tc.wPeriodMin);
    DWORD start = timeGetTime();
    MMRESULT timer = timeSetEvent(100, 1, OnTimer, 0, TIME_PERIODIC | TIME_CALLBACK_FUNCTION);
    if (timer == 0)
        return -2;
    int edges = 0;
    long last = 0, di = 0;
    GT_GetDi(MC_GPI, &last);
    while (timeGetTime() - start < 2050)
    {
        GT_GetDi(MC_GPI, &di);
        if ((di ^ last) & 1)
            edges++;
        last = di;
        Sleep(1);
    }
    timeKillEvent(timer);
    int ticks = g_ticks;
    Sleep(300);
    timeEndPeriod(tc.wPeriodMin);
    printf("ticks=%d after=%d mask=%02lx edges=%d\n", ticks, g_ticks - ticks, g_mask, edges);
    GT_Close();
    return 0;
}
