// A sine streamed by PT: a producer thread keeps the FIFO filled and says by an event that it has ended.
#include <stdio.h>
#include <stdlib.h>
#include <math.h>
#include <windows.h>
#include <process.h>
#include "gts.h"

const double PI = 3.14159265358979;
static HANDLE g_started, g_done;
static int g_sent = 0;

void Producer(void *arg)
{
    short space;
    long time = 0;
    (void)arg;
    for (int i = 1; i <= 600; i++)
    {
        double pos = 1000 * sin(2 * PI * i / 200.0);
        do
        {
            GT_PtSpace(3, &space, 0);
            if (space == 0)
                Sleep(5);
        } while (space == 0);
        time += 10;
        if (GT_PtData(3, i == 600 ? 0 : pos, time, i == 600 ? PT_SEGMENT_STOP : PT_SEGMENT_NORMAL, 0) == 0)
            g_sent++;
        if (i == 30)
            SetEvent(g_started);
    }
    SetEvent(g_done);
    _endthread();
}

int main()
{
    if (GT_Open())
        return 1;
    GT_ClrSts(3);
    GT_AxisOn(3);
    GT_PrfPt(3, PT_MODE_DYNAMIC);
    GT_PtClear(3);
    g_started = CreateEvent(NULL, FALSE, FALSE, NULL);
    g_done = CreateEvent(NULL, FALSE, FALSE, NULL);
    _beginthread(Producer, 0, NULL);
    WaitForSingleObject(g_started, INFINITE);
    DWORD begin = GetTickCount();
    if (GT_PtStart(1 << 2) != 0)
        return 2;
    double high = 0, low = 0;
    while (WaitForSingleObject(g_done, 0) != WAIT_OBJECT_0)
    {
        double pos;
        GT_GetPrfPos(3, &pos);
        high = pos > high ? pos : high;
        low = pos < low ? pos : low;
        Sleep(2);
    }
    long sts;
    do
    {
        GT_GetSts(3, &sts);
        Sleep(1);
    } while (sts & 0x400);
    DWORD end = GetTickCount();
    printf("sent=%d high=%.0f low=%.0f seconds=%.1f\n", g_sent, high, low, (end - begin) / 1000.0);
    CloseHandle(g_started);
    CloseHandle(g_done);
    return GT_Close();
}
