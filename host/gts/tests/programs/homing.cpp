// Homing in all modes that this board has, with a home switch at a place and limits at both ends.
#include <gts.h>
#include <string.h>
#include <windows.h>
#include "check.h"

static const long HOME_FROM = 4000, HOME_TO = 4300, LIMIT_DOWN = -2000;
static long LIMIT_UP = 9000, zero = 0;

// What a machine does: its switches follow the axis. Places are those of the first naming.
static void machine()
{
    double at;
    DONE(GT_GetEncPos(1, &at));
    at += zero;
    DONE(GT_SimInput(MC_HOME, 1, at >= HOME_FROM && at <= HOME_TO));
    DONE(GT_SimInput(MC_LIMIT_POSITIVE, 1, at >= LIMIT_UP));
    DONE(GT_SimInput(MC_LIMIT_NEGATIVE, 1, at <= LIMIT_DOWN));
}

static THomeStatus run(THomePrm *prm)
{
    THomeStatus status;
    memset(&status, 0, sizeof(status));
    DONE(GT_GoHome(1, prm));
    int looks = 0;
    do
    {
        machine();
        Sleep(1);
        DONE(GT_GetHomeStatus(1, &status));
    } while (status.run && ++looks < 60000);
    HOLDS(status.run == 0);
    return status;
}

// The axis stands at the offset; where its zero is, in places of the machine.
static void ends_at(THomePrm *prm, long low, long high)
{
    double planned, encoder;
    long sts;
    for (int n = 0; n < 40; n++)
    {
        machine();
        Sleep(1);
    }
    DONE(GT_GetPrfPos(1, &planned));
    DONE(GT_GetEncPos(1, &encoder));
    DONE(GT_GetSts(1, &sts));
    HOLDS(planned == prm->homeOffset);
    HOLDS(encoder == prm->homeOffset);
    HOLDS((sts & 0x400) == 0);
    if (zero < low || zero > high)
    {
        printf("the origin is at %ld, not from %ld to %ld\n", zero, low, high);
        HOLDS(false);
    }
}

static void from(long place)
{
    TTrapPrm trap = {2, 2, 0, 0};
    DONE(GT_PrfTrap(1));
    DONE(GT_SetTrapPrm(1, &trap));
    DONE(GT_SetVel(1, 40));
    DONE(GT_SetPos(1, place - zero));
    DONE(GT_ClrSts(1));
    DONE(GT_Update(1));
    long sts = 0x400;
    for (int n = 0; n < 10000 && (sts & 0x400); n++)
    {
        machine();
        Sleep(1);
        DONE(GT_GetSts(1, &sts));
    }
    DONE(GT_ClrSts(1));
}

// Nobody asks on the way: the library takes it on all the same.
static int alone()
{
    THomePrm prm;
    THomeStatus status;
    double at;
    memset(&prm, 0, sizeof(prm));
    prm.mode = 20;
    prm.moveDir = prm.edge = 1;
    prm.velHigh = prm.velLow = 10;
    prm.acc = prm.dec = 1;
    prm.searchHomeDistance = 1000;
    DONE(GT_Open());
    DONE(GT_AxisOn(1));
    DONE(GT_GoHome(1, &prm));
    Sleep(2000);
    DONE(GT_GetHomeStatus(1, &status));
    HOLDS(status.run == 0 && status.error == 8 && status.targetPos == 1000);
    DONE(GT_GetPrfPos(1, &at));
    HOLDS(at == 1000);
    // The wait for a switch that comes meanwhile.
    prm.searchHomeDistance = 0;
    prm.moveDir = -1;
    DONE(GT_GoHome(1, &prm));
    Sleep(50);
    DONE(GT_SimInput(MC_HOME, 1, 1));
    Sleep(3000);
    DONE(GT_GetHomeStatus(1, &status));
    HOLDS(status.run == 0 && status.error == 0 && status.stage == 100);
    DONE(GT_GetPrfPos(1, &at));
    HOLDS(at == 0);
    DONE(GT_Close());
    return verdict();
}

// One homing by index; the place of the edge that it finds.
static void finds(THomePrm *prm, short mode, short move, short index, long place)
{
    prm->mode = mode;
    prm->moveDir = move;
    prm->indexDir = index;
    THomeStatus status = run(prm);
    if (status.error != 0 || status.stage != 100)
        printf("mode %d: error %d, stage %d\n", mode, status.error, status.stage);
    HOLDS(status.error == 0 && status.stage == 100);
    zero += status.capturePos;
    ends_at(prm, place, place);
}

// The virtual controller's encoders have an index edge every 10,000 counts, one of them at 0.
static int indexed()
{
    THomePrm prm;
    memset(&prm, 0, sizeof(prm));
    prm.edge = 1;
    prm.velHigh = 20;
    prm.velLow = 2;
    prm.acc = prm.dec = 0.5;
    prm.homeOffset = 50;
    LIMIT_UP = 12000;
    DONE(GT_Open());
    DONE(GT_Reset());
    DONE(GT_AxisOn(1));
    DONE(GT_LmtsOn(1));
    // The index alone, from either side.
    finds(&prm, 30, 0, 1, 10000);
    finds(&prm, 30, 0, -1, 10000);
    // Home, then the index, on either side of it.
    from(2000);
    finds(&prm, 22, 1, 1, 10000);
    from(6000);
    finds(&prm, 22, -1, -1, 0);
    // The limit, then the index on the way back.
    finds(&prm, 12, 1, -1, 10000);
    finds(&prm, 12, -1, 1, 0);
    // The limit, home on the way back, the index.
    finds(&prm, 13, -1, 1, 10000);
    finds(&prm, 13, 1, -1, 0);
    // None within the distance: nothing is renamed.
    from(1000);
    prm.mode = 30;
    prm.indexDir = 1;
    prm.searchIndexDistance = 500;
    THomeStatus status = run(&prm);
    HOLDS(status.error == 10 && status.stage == 30);
    double at;
    DONE(GT_GetPrfPos(1, &at));
    HOLDS(at == 1500);
    DONE(GT_Close());
    return verdict();
}

int main(int argc, char **argv)
{
    if (argc > 1)
        return strcmp(argv[1], "index") == 0 ? indexed() : alone();
    DONE(GT_Open());
    DONE(GT_Reset());
    DONE(GT_AxisOn(1));
    DONE(GT_LmtsOn(1));
    THomePrm prm;
    memset(&prm, 0, sizeof(prm));
    prm.moveDir = 1;
    prm.edge = 1;
    prm.triggerIndex = 1;
    prm.velHigh = 20;
    prm.velLow = 2;
    prm.acc = prm.dec = 0.5;
    prm.smoothTime = 10;
    prm.homeOffset = 50;

    // Home, from below: the edge at its begin.
    prm.mode = 20;
    THomeStatus status = run(&prm);
    HOLDS(status.error == 0 && status.stage == 100);
    zero += status.capturePos;
    ends_at(&prm, HOME_FROM - 5, HOME_FROM + 120);

    // The other edge, from below: the end of the switch.
    from(3000);
    prm.edge = 0;
    status = run(&prm);
    HOLDS(status.error == 0);
    zero += status.capturePos;
    ends_at(&prm, HOME_TO - 5, HOME_TO + 120);
    prm.edge = 1;

    // Home, from above.
    from(6000);
    prm.moveDir = -1;
    prm.homeOffset = -300;
    status = run(&prm);
    HOLDS(status.error == 0);
    zero += status.capturePos;
    ends_at(&prm, HOME_TO - 120, HOME_TO + 5);

    // Limit and home: down to the limit, then up to the edge.
    prm.mode = 11;
    prm.homeOffset = 0;
    status = run(&prm);
    HOLDS(status.error == 0);
    zero += status.capturePos;
    ends_at(&prm, HOME_FROM - 5, HOME_FROM + 120);

    // Limit alone: its origin is where the slow approach stopped.
    prm.mode = 10;
    prm.escapeStep = 500;
    prm.homeOffset = 200;
    status = run(&prm);
    HOLDS(status.error == 0);
    zero += status.capturePos;
    ends_at(&prm, LIMIT_DOWN - 40, LIMIT_DOWN);

    // No home within the distance; nothing is renamed.
    from(5000);
    double before, after;
    DONE(GT_GetPrfPos(1, &before));
    prm.mode = 20;
    prm.moveDir = 1;
    prm.searchHomeDistance = 300;
    status = run(&prm);
    HOLDS(status.error == 8 && status.stage == 20);
    DONE(GT_GetPrfPos(1, &after));
    HOLDS(after == before + 300);

    // A Stop on the way is an end with an error, as is a servo that goes off.
    prm.searchHomeDistance = 0;
    prm.mode = 11;
    DONE(GT_GoHome(1, &prm));
    Sleep(100);
    DONE(GT_Stop(1, 0));
    Sleep(200);
    DONE(GT_GetHomeStatus(1, &status));
    HOLDS(status.run == 0 && status.error == 4);
    DONE(GT_GoHome(1, &prm));
    Sleep(50);
    DONE(GT_AxisOff(1));
    Sleep(50);
    DONE(GT_GetHomeStatus(1, &status));
    HOLDS(status.run == 0 && status.error == 2);
    DONE(GT_Close());
    return verdict();
}
