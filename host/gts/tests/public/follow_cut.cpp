// A flying cut: the slave follows a jogging master by tables; a queue timer reports while it goes.
#include <cstdio>
#include <vector>
#include <windows.h>
#include "gts.h"

using namespace std;

struct Report
{
    CRITICAL_SECTION lock;
    vector<double> slave;
};

VOID CALLBACK Sample(PVOID param, BOOLEAN)
{
    Report *report = (Report *)param;
    double pos;
    GT_GetPrfPos(2, &pos);
    EnterCriticalSection(&report->lock);
    report->slave.push_back(pos);
    LeaveCriticalSection(&report->lock);
}

int main()
{
    const short master = 1, slave = 2;
    if (GT_Open() != 0)
        return 1;
    GT_ClrSts(1, 2);
    GT_AxisOn(master);
    GT_AxisOn(slave);
    GT_PrfJog(master);
    TJogPrm jog;
    GT_GetJogPrm(master, &jog);
    jog.acc = 1;
    jog.dec = 1;
    GT_SetJogPrm(master, &jog);
    GT_SetVel(master, 50);
    GT_PrfFollow(slave, 0);
    GT_FollowClear(slave, 0);
    GT_SetFollowMaster(slave, master, FOLLOW_MASTER_PROFILE);
    GT_SetFollowLoop(slave, 1);
    GT_FollowData(slave, 20000, 10000);
    GT_FollowData(slave, 40000, 30000, FOLLOW_SEGMENT_EVEN);
    GT_FollowData(slave, 60000, 40000);
    GT_SetFollowEvent(slave, FOLLOW_EVENT_START, 1);
    if (GT_FollowStart(1 << (slave - 1)) != 0)
        return 2;

    Report report;
    InitializeCriticalSection(&report.lock);
    HANDLE queue = CreateTimerQueue(), timer = NULL;
    CreateTimerQueueTimer(&timer, queue, Sample, &report, 50, 50, WT_EXECUTEDEFAULT);
    GT_Update(1 << (master - 1));
    long sts;
    do
    {
        Sleep(5);
        GT_GetSts(slave, &sts);
    } while (sts & 0x400);
    DeleteTimerQueueTimer(queue, timer, INVALID_HANDLE_VALUE);
    DeleteTimerQueue(queue);
    GT_Stop(1, 1);
    double pos;
    GT_GetPrfPos(slave, &pos);
    size_t rising = 0;
    for (size_t i = 1; i < report.slave.size(); i++)
        rising += report.slave[i] >= report.slave[i - 1];
    printf("slave=%.0f monotonic=%d samples=%d\n", pos, rising + 1 == report.slave.size(),
           max((int)report.slave.size() / 10, 0) * 10);
    DeleteCriticalSection(&report.lock);
    GT_Close();
    return 0;
}
