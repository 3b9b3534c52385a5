// PVT on three axes; workers compute the tables and share the card by a mutex, a semaphore counts what is ready.
#include "stdafx.h"
#include <windows.h>
#include <math.h>
#include "gts.h"

#define WORKERS 3
#define POINTS 64

static HANDLE g_mutex, g_ready;
static short g_rtn[WORKERS];

DWORD WINAPI Worker(LPVOID p)
{
    int n = (int)(INT_PTR)p;
    double t[POINTS], pos[POINTS], vel[POINTS];
    for (int i = 0; i < POINTS; i++)
    {
        double phase = (double)i / (POINTS - 1);
        t[i] = 1000.0 * (n + 1) * phase;
        pos[i] = 5000 * (1 - cos(2 * 3.14159265358979 * phase));
        vel[i] = i == 0 || i == POINTS - 1 ? 0 : 5000 * sin(2 * 3.14159265358979 * phase) * 2 * 3.14159265358979 / (1000.0 * (n + 1));
    }
    WaitForSingleObject(g_mutex, INFINITE);
    short axis = (short)(n + 1);
    short rtn = GT_PrfPvt(axis);
    if (!rtn)
        rtn = GT_PvtTable(axis, POINTS, t, pos, vel);
    if (!rtn)
        rtn = GT_PvtTableSelect(axis, axis);
    if (!rtn)
        rtn = GT_SetPvtLoop(axis, 1);
    g_rtn[n] = rtn;
    ReleaseMutex(g_mutex);
    ReleaseSemaphore(g_ready, 1, NULL);
    return 100 + n;
}

int _tmain(int argc, _TCHAR *argv[])
{
    HANDLE threads[WORKERS];
    DWORD code, sum = 0;
    if (GT_Open())
        return 1;
    for (short i = 1; i <= WORKERS; i++)
        GT_AxisOn(i);
    g_mutex = CreateMutex(NULL, FALSE, NULL);
    g_ready = CreateSemaphore(NULL, 0, WORKERS, NULL);
    for (int n = 0; n < WORKERS; n++)
        threads[n] = CreateThread(NULL, 0, Worker, (LPVOID)(INT_PTR)n, 0, NULL);
    DWORD all = WaitForMultipleObjects(WORKERS, threads, TRUE, 10000);
    for (int n = 0; n < WORKERS; n++)
    {
        GetExitCodeThread(threads[n], &code);
        sum += code;
        CloseHandle(threads[n]);
        if (WaitForSingleObject(g_ready, 0) != WAIT_OBJECT_0)
            return 3;
    }
    DWORD t0 = GetTickCount();
    short start = GT_PvtStart((1 << WORKERS) - 1);
    double top[WORKERS] = {0};
    long sts[WORKERS];
    bool moving = start == 0;
    while (moving)
    {
        double pos[WORKERS];
        GT_GetPrfPos(1, pos, WORKERS);
        GT_GetSts(1, sts, WORKERS);
        moving = false;
        for (int n = 0; n < WORKERS; n++)
        {
            if (pos[n] > top[n])
                top[n] = pos[n];
            moving = moving || (sts[n] & 0x400);
        }
        Sleep(1);
    }
    char text[100];
    sprintf_s(text, sizeof(text), "%d%d%d", g_rtn[0], g_rtn[1], g_rtn[2]);
    printf("waited=%lu sum=%lu rtn=%s top=%.0f,%.0f,%.0f seconds=%.1f\n", all, sum, text, top[0], top[1], top[2],
           (GetTickCount() - t0) / 1000.0);
    CloseHandle(g_mutex);
    CloseHandle(g_ready);
    return GT_Close();
}
