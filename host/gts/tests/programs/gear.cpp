// An axis in gear, counts of edges, and an output for a time, as a program of the vendor calls them.
#include <gts.h>
#include <string.h>
#include <windows.h>
#include "check.h"

static double at(short axis)
{
    double pos;
    DONE(GT_GetPrfPos(axis, &pos));
    return pos;
}

static void move(long pos)
{
    long sts = 0x400;
    DONE(GT_SetPos(1, pos));
    DONE(GT_Update(1));
    while (sts & 0x400)
    {
        Sleep(1);
        DONE(GT_GetSts(1, &sts));
    }
    Sleep(20);
}

int main()
{
    DONE(GT_Open());
    DONE(GT_Reset());
    DONE(GT_AxisOn(1));
    DONE(GT_AxisOn(2));
    TTrapPrm trap = {1, 1, 0, 0};
    DONE(GT_PrfTrap(1));
    DONE(GT_SetTrapPrm(1, &trap));
    DONE(GT_SetVel(1, 50));

    DONE(GT_PrfGear(2));
    DONE(GT_SetGearMaster(2, 1));
    DONE(GT_SetGearRatio(2, 2, 1, 1000));
    DONE(GT_SetGearEvent(2, GEAR_EVENT_START, 0, 0));
    DONE(GT_GearStart(1 << 1));
    short master, type, item, event;
    long even, slave, slope, first, second, mode;
    DONE(GT_GetGearMaster(2, &master, &type, &item));
    HOLDS(master == 1 && type == GEAR_MASTER_PROFILE && item == 0);
    DONE(GT_GetGearMaster(2, &master));
    DONE(GT_GetGearRatio(2, &even, &slave, &slope));
    HOLDS(even == 2 && slave == 1 && slope == 1000);
    DONE(GT_GetGearRatio(2, &even, &slave));
    DONE(GT_GetGearEvent(2, &event, &first, &second));
    HOLDS(event == 1 && first == 0 && second == 0);
    DONE(GT_GetPrfMode(2, &mode));
    HOLDS(mode == 3);
    // The slope is half as much as the ratio over its length.
    move(3000);
    HOLDS(at(2) == 250 + 1000);
    move(-3000);
    HOLDS(at(2) == 250 + 1000 - 3000);
    DONE(GT_ZeroPos(1));
    Sleep(5);
    HOLDS(at(2) == -1750);
    REFUSED(1, "moving", GT_ZeroPos(2));
    // From an encoder, upwards only, from a crossing on.
    DONE(GT_Stop(1 << 1, 0));
    Sleep(20);
    DONE(GT_PrfTrap(2));
    DONE(GT_ZeroPos(2));
    DONE(GT_PrfGear(2, 1));
    DONE(GT_SetGearMaster(2, 1, GEAR_MASTER_ENCODER));
    DONE(GT_SetGearRatio(2, 1, 3));
    DONE(GT_SetGearEvent(2, GEAR_EVENT_PASS, 1, 500));
    DONE(GT_GearStart(1 << 1));
    move(1000);
    HOLDS(at(2) == 1500);
    move(0);
    HOLDS(at(2) == 1500);
    REFUSED(7, "master_slope is 1", GT_SetGearRatio(2, 1, 1, 1));
    REFUSED(1, "AREA", GT_SetGearEvent(2, GEAR_EVENT_AREA, 0, 0));
    REFUSED(1, "", GT_PrfGear(2, 0));

    // Edges of inputs, both directions.
    unsigned long counts[2] = {0, 0};
    for (int n = 0; n < 3; n++)
    {
        DONE(GT_SimInput(MC_GPI, 2, 1));
        Sleep(1);
        DONE(GT_SimInput(MC_GPI, 2, 0));
        Sleep(1);
    }
    DONE(GT_GetDiReverseCount(MC_GPI, 1, counts, 2));
    HOLDS(counts[0] == 0 && counts[1] == 6);
    counts[0] = 5;
    counts[1] = 0;
    DONE(GT_SetDiReverseCount(MC_GPI, 1, counts, 2));
    DONE(GT_SimInput(MC_GPI, 2, 1));
    Sleep(1);
    DONE(GT_GetDiReverseCount(MC_GPI, 2, counts));
    HOLDS(counts[0] == 1);

    // An output for 10 ms.
    long levels;
    DONE(GT_SetDoBitReverse(MC_GPO, 3, 1, 40));
    DONE(GT_GetDo(MC_GPO, &levels));
    HOLDS(levels == 4);
    Sleep(15);
    DONE(GT_GetDo(MC_GPO, &levels));
    HOLDS(levels == 0);
    REFUSED(7, "reverse_time_cycles is -1", GT_SetDoBitReverse(MC_GPO, 3, 1, -1));
    DONE(GT_Close());
    return verdict();
}
