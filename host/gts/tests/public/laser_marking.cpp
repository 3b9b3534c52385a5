// Marks two lines: laser on in the path, power by mode; a second thread samples power and gate.
#include "stdafx.h"
#include "windows.h"
#include "process.h"
#include "gts.h"

class Marker
{
public:
    Marker() : m_quit(0), m_lit(0), m_top(0), m_thread(NULL) {}
    bool Start()
    {
        m_thread = (HANDLE)_beginthreadex(NULL, 0, Run, this, CREATE_SUSPENDED, NULL);
        SetThreadPriority(m_thread, THREAD_PRIORITY_ABOVE_NORMAL);
        return m_thread != NULL && ResumeThread(m_thread) == 1;
    }
    void Stop()
    {
        InterlockedExchange(&m_quit, 1);
        WaitForSingleObject(m_thread, INFINITE);
        CloseHandle(m_thread);
    }
    int Lit() const { return m_lit; }
    double Top() const { return m_top; }

private:
    static unsigned __stdcall Run(void *p)
    {
        Marker *self = static_cast<Marker *>(p);
        while (!self->m_quit)
        {
            short on = 0;
            double power = 0;
            GT_LaserOnStatus(&on, 0);
            GT_GetLaserPower(0, &power);
            if (on)
                self->m_lit++;
            if (power > self->m_top)
                self->m_top = power;
            Sleep(5);
        }
        return 0;
    }
    volatile LONG m_quit;
    volatile int m_lit;
    double m_top;
    HANDLE m_thread;
};

int _tmain(int argc, _TCHAR *argv[])
{
    short rtn = GT_Open();
    commandhandler("GT_Open", rtn);
    rtn = GT_AxisOn(1);
    rtn = GT_AxisOn(2);
    TCrdPrm prm = {};
    prm.dimension = 2;
    prm.synVelMax = 300;
    prm.synAccMax = 3;
    prm.profile[0] = 1;
    prm.profile[1] = 2;
    rtn = GT_SetCrdPrm(1, &prm);
    commandhandler("GT_SetCrdPrm", rtn);
    GT_SetAxisMode(AXIS_LASER, 1);
    commandhandler("GT_SetHSIOOpt", GT_SetHSIOOpt(1, 0));
    commandhandler("GT_LaserPowerMode", GT_LaserPowerMode(0, 100, 0, 0));
    commandhandler("GT_LaserOutFrq", GT_LaserOutFrq(20, 0));
    commandhandler("GT_SetLevelDelay", GT_SetLevelDelay(100, 50, 0));
    GT_CrdClear(1);
    GT_LnXY(1, 1000, 1000, 100, 1);
    GT_BufLaserOn(1);
    GT_BufLaserPrfCmd(1, 60);
    GT_LnXY(1, 31000, 1000, 100, 1);
    GT_BufLaserOff(1);
    GT_LnXY(1, 31000, 2000, 100, 1);
    GT_BufLaserOn(1);
    GT_LnXY(1, 1000, 2000, 100, 1);
    GT_BufLaserOff(1);

    Marker marker;
    if (!marker.Start())
        return 1;
    commandhandler("GT_CrdStart", GT_CrdStart(1, 0));
    short run = 1;
    long seg = 0;
    while (run)
    {
        Sleep(20);
        GT_CrdStatus(1, &run, &seg);
    }
    Sleep(20);
    marker.Stop();
    short on = 9;
    GT_LaserOnStatus(&on);
    printf("segments=%ld top=%.0f on=%d lit=%s\n", seg, marker.Top(), on,
           marker.Lit() > 100 && marker.Lit() < 250 ? "as long as the lines" : "wrong");
    GT_Close();
    return 0;
}
