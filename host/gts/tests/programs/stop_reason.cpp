// Why motion has stopped: an end, an underrun, a wait that was not met, a Stop; of axes and of coordinate systems.
#include "gts.h"
#include <windows.h>

#include "check.h"

static void stopped(int line, short axis, short wanted, const char *text)
{
    short reason = -1;
    char told[100] = "";
    DONE(GT_GetStopReason(axis, &reason, told, (short)sizeof told));
    if (reason != wanted || strcmp(told, text) != 0) {
        printf("line %d: axis %d stopped for reason %d (%s); wanted %d (%s)\n", line, axis, reason, told, wanted, text);
        failures++;
    }
}
#define STOPPED(axis, reason, text) stopped(__LINE__, axis, reason, text)

static void pt()
{
    DONE(GT_PrfPt(1, PT_MODE_DYNAMIC));
    // NORMAL ends at 2 pulse/ms, STOP at 0.
    DONE(GT_PtData(1, 10, 10));
    DONE(GT_PtStart(1));
    Sleep(20);
    STOPPED(1, 10, "an underrun");
    DONE(GT_ClrSts(1));
    DONE(GT_PtData(1, 10, 10, PT_SEGMENT_STOP));
    DONE(GT_PtStart(1));
    Sleep(20);
    STOPPED(1, 1, "it has ended");
}

static void wait_for_an_input()
{
    TJogPrm jog = {1, 1, 0};
    DONE(GT_PrfJog(1));
    DONE(GT_SetJogPrm(1, &jog));
    DONE(GT_SetVel(1, 10));
    DONE(GT_PrfFollowEx(2));
    DONE(GT_SetFollowMasterEx(2, 1));
    DONE(GT_FollowDataPercentEx(2, 100, 100));
    DONE(GT_FollowDiBitEx(2, MC_GPI, 1, 1, 20));
    DONE(GT_FollowDataPercentEx(2, 200, 200));
    DONE(GT_FollowStartEx(1 << 1));
    STOPPED(2, 0, "it has not moved");
    DONE(GT_Update(1));
    Sleep(100);
    STOPPED(2, 15, "an input did not come in time");
    DONE(GT_Stop(1, 0));
    Sleep(100);
    STOPPED(1, 2, "a smooth Stop");
}

static void crd_stopped(int line, short wanted, const char *text)
{
    short reason = -1;
    char told[100] = "";
    DONE(GT_GetCrdStopReason(1, &reason, told, (short)sizeof told));
    if (reason != wanted || strcmp(told, text) != 0) {
        printf("line %d: it stopped for reason %d (%s); wanted %d (%s)\n", line, reason, told, wanted, text);
        failures++;
    }
}

static void crd()
{
    TCrdPrm prm = {2, {0, 0, 1, 2}, 100, 10, 0, 1, {0}};
    DONE(GT_SetCrdPrm(1, &prm));
    crd_stopped(__LINE__, 0, "it has not moved");
    DONE(GT_LnXY(1, 100, 0, 10, 1));
    DONE(GT_CrdStart(1, 0));
    Sleep(100);
    crd_stopped(__LINE__, 1, "it has ended");
    DONE(GT_LnXY(1, 100000, 0, 10, 1));
    DONE(GT_CrdStart(1, 0));
    Sleep(100);
    DONE(GT_Stop(1 << 8, 1 << 8));
    Sleep(10);
    crd_stopped(__LINE__, 3, "an abrupt Stop");
    STOPPED(3, 3, "an abrupt Stop");
}

static void room()
{
    short reason = -1;
    char text[8] = "1234567";
    DONE(GT_GetStopReason(2, &reason));
    HOLDS(reason == 15);
    DONE(GT_GetStopReason(2, &reason, NULL, 0));
    DONE(GTN_GetStopReason(1, 2, &reason, text, 3));
    HOLDS(strcmp(text, "an") == 0 && strcmp(text + 3, "4567") == 0);
    DONE(GTN_GetCrdStopReason(1, 1, &reason, text, 1));
    HOLDS(text[0] == 0 && text[1] == 'n');
    REFUSED(7, "size is 0; it must be from 1 to 32767", GT_GetStopReason(2, &reason, text, 0));
    REFUSED(7, "reason", GT_GetStopReason(2, NULL));
    REFUSED(7, "axis is 9; allowed are 1 to 8", GT_GetStopReason(9, &reason));
    REFUSED(7, "crd is 3; allowed are 1 to 2", GT_GetCrdStopReason(3, &reason));
}

// A read past the last axis is done, and what is not there is 0 (GXN table 5-1, note 2).
static void past_the_last_axis()
{
    long status[4] = {-1, -1, -1, -1};
    double position[4] = {-1, -1, -1, -1};
    unsigned long clock = 0;
    DONE(GT_SetPrfPos(8, 77));
    DONE(GT_GetSts(7, status, 3, &clock));
    HOLDS((status[0] & 0x200) != 0 && (status[1] & 0x200) != 0 && status[2] == 0 && status[3] == -1 && clock != 0);
    DONE(GT_GetPrfPos(8, position, 3));
    HOLDS(position[0] == 77 && position[1] == 0 && position[2] == 0 && position[3] == -1);
    short values[4] = {-1, -1, -1, -1};
    DONE(GT_GetDac(7, values, 4));
    HOLDS(values[2] == 0 && values[3] == 0);
    REFUSED(7, "axis is 9; allowed are 1 to 8", GT_GetSts(9, status));
    REFUSED(7, "count is 0; allowed are 1 to 32767", GT_GetSts(1, status, 0));
    REFUSED(7, "count is 3; allowed are 1 to 2", GT_ZeroPos(7, 3));
}

int main()
{
    DONE(GT_Open());
    for (short axis = 1; axis <= 8; axis++) {
        DONE(GT_AxisOn(axis));
    }
    pt();
    wait_for_an_input();
    crd();
    room();
    past_the_last_axis();
    // A refusal has the name of the function.
    short number;
    REFUSED(7, "GetStopReason: axis is 99", GT_GetStopReason(99, &number, NULL, 0));
    REFUSED(7, "GetCrdStopReason: crd is 9", GT_GetCrdStopReason(9, &number, NULL, 0));
    DONE(GT_Close());
    return verdict();
}
