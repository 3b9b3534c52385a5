// A square with round corners by interpolation; look-ahead; the time by QueryPerformanceCounter.
#include <windows.h>
#include <stdio.h>
#include <string.h>
#include <math.h>
#include "gts.h"

#pragma comment(lib, "gts.lib")

static void Check(const char *cmd, short rtn)
{
    if (rtn)
    {
        char why[200];
        GT_GetLastReason(why, sizeof(why));
        printf("%s = %d: %s\n", cmd, rtn, why);
        exit(1);
    }
}

int main(int argc, char *argv[])
{
    TCrdPrm crdPrm;
    TCrdData crdData[200];
    LARGE_INTEGER freq, t1, t2;
    short run;
    long segment, space;
    double pos[4];

    Check("GT_Open", GT_Open());
    Check("GT_Reset", GT_Reset());
    for (short i = 1; i <= 2; i++)
    {
        Check("GT_ClrSts", GT_ClrSts(i));
        Check("GT_AxisOn", GT_AxisOn(i));
    }
    memset(&crdPrm, 0, sizeof(crdPrm));
    crdPrm.dimension = 2;
    crdPrm.synVelMax = 500;
    crdPrm.synAccMax = 2;
    crdPrm.evenTime = 0;
    crdPrm.profile[0] = 1;
    crdPrm.profile[1] = 2;
    crdPrm.setOriginFlag = 1;
    Check("GT_SetCrdPrm", GT_SetCrdPrm(1, &crdPrm));
    Check("GT_CrdClear", GT_CrdClear(1, 0));
    Check("GT_InitLookAhead", GT_InitLookAhead(1, 0, 5, 2, 200, crdData));
    Check("GT_LnXY", GT_LnXY(1, 20000, 0, 100, 1, 0, 0));
    Check("GT_ArcXYC", GT_ArcXYC(1, 22000, 2000, 0, 2000, 1, 100, 1, 0, 0));
    Check("GT_LnXY", GT_LnXY(1, 22000, 20000, 100, 1, 0, 0));
    Check("GT_ArcXYR", GT_ArcXYR(1, 20000, 22000, 2000, 1, 100, 1, 0, 0));
    Check("GT_LnXY", GT_LnXY(1, 0, 22000, 100, 1));
    Check("GT_BufDelay", GT_BufDelay(1, 200, 0));
    Check("GT_BufIO", GT_BufIO(1, MC_GPO, 0x1, 0x1, 0));
    Check("GT_LnXY", GT_LnXY(1, 0, 0, 100, 1));
    Check("GT_CrdData", GT_CrdData(1, NULL, 0));
    Check("GT_CrdSpace", GT_CrdSpace(1, &space, 0));

    QueryPerformanceFrequency(&freq);
    QueryPerformanceCounter(&t1);
    Check("GT_CrdStart", GT_CrdStart(1, 0));
    do
    {
        Check("GT_CrdStatus", GT_CrdStatus(1, &run, &segment, 0));
        Check("GT_GetCrdPos", GT_GetCrdPos(1, pos));
        Sleep(10);
    } while (run == 1);
    QueryPerformanceCounter(&t2);
    double ms = (t2.QuadPart - t1.QuadPart) * 1000.0 / freq.QuadPart;
    printf("segments=%ld at %.0f,%.0f in %.0f ms\n", segment, pos[0], pos[1], floor(ms / 100 + 0.5) * 100);
    GT_Stop(0x103, 0x103);
    return GT_Close();
}
