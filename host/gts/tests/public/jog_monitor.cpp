// Jog until a key is hit, a monitor thread by _beginthreadex, shared values in a critical section.
#include "stdafx.h"
#include <windows.h>
#include <process.h>
#include <conio.h>
#include "gts.h"

struct AxisState
{
    double prfPos;
    double prfVel;
    long sts;
    unsigned long clock;
};

static CRITICAL_SECTION g_cs;
static AxisState g_state;
static volatile bool g_run = true;

unsigned int __stdcall MonitorProc(void *pParam)
{
    UNREFERENCED_PARAMETER(pParam);
    while (g_run)
    {
        AxisState now;
        GT_GetPrfPos(2, &now.prfPos, 1, &now.clock);
        GT_GetPrfVel(2, &now.prfVel);
        GT_GetSts(2, &now.sts);
        EnterCriticalSection(&g_cs);
        g_state = now;
        LeaveCriticalSection(&g_cs);
        Sleep(20);
    }
    _endthreadex(0);
    return 0;
}

int main()
{
    TJogPrm jog;
    unsigned int threadId;
    double top = 0;
    int looks = 0;

    if (GT_Open() != 0)
        return 1;
    GT_ClrSts(2);
    GT_AxisOn(2);
    InitializeCriticalSection(&g_cs);
    HANDLE hMonitor = (HANDLE)_beginthreadex(NULL, 0, &MonitorProc, NULL, 0, &threadId);

    GT_PrfJog(2);
    GT_GetJogPrm(2, &jog);
    jog.acc = 0.1;
    jog.dec = 0.1;
    jog.smooth = 0.5;
    GT_SetJogPrm(2, &jog);
    GT_SetVel(2, 20);
    GT_Update(1 << 1);

    while (!_kbhit())
    {
        EnterCriticalSection(&g_cs);
        AxisState s = g_state;
        LeaveCriticalSection(&g_cs);
        top = max(top, s.prfVel);
        looks++;
        Sleep(50);
    }
    _getch();
    GT_Stop(1 << 1, 0);
    do
    {
        Sleep(20);
        EnterCriticalSection(&g_cs);
        long sts = g_state.sts;
        LeaveCriticalSection(&g_cs);
        if (!(sts & (1 << 10)))
            break;
    } while (true);

    g_run = false;
    DWORD waited = WaitForSingleObject(hMonitor, 2000);
    CloseHandle(hMonitor);
    DeleteCriticalSection(&g_cs);
    GT_Close();
    printf("top=%.1f looks=%d waited=%lu moved=%d\n", top, looks, waited, g_state.prfPos > 10000);
    return 0;
}
