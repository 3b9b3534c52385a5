// Wrong use of every kind: the right code, a reason that names what is wrong, and nothing changes.
#include "gts.h"
#include "check.h"
#include <math.h>
#include <sys/mman.h>
#include <unistd.h>

// 32 values that end where no memory is: what reads on behind them dies.
static void *last_values(size_t size)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *pages = (char *)mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED || mprotect(pages + page, page, PROT_NONE) != 0) {
        abort();
    }
    return pages + page - 32 * size;
}

// A configuration of so many axes, the last with a deceleration of its own; taken or refused as a whole.
static short load(int axes, const char *last)
{
    char name[] = "/tmp/beamtick-XXXXXX";
    FILE *file = fdopen(mkstemp(name), "w");
    for (int axis = 1; axis <= axes; axis++) {
        fprintf(file, "[profile%d]\ndecSmoothStop=%s\n[control%d]\nerrorLimit=%d\n", axis, axis < axes ? "3" : last, axis,
            1000 + axis);
    }
    fclose(file);
    short code = GTN_LoadConfig(1, name);
    unlink(name);
    return code;
}

int main()
{
    double value[1024], table[1024];
    long numbers[32];
    short shorts[32], axes[32], options[32];
    char text[16];
    char *version;
    TTrapPrm trap;
    TCrdPrm crd;
    memset(&trap, 0, sizeof trap);
    memset(&crd, 0, sizeof crd);
    for (int n = 0; n < 1024; n++) {
        value[n] = n;
        table[n] = 10.0 * n;
    }
    for (int n = 0; n < 32; n++) {
        axes[n] = (short)(n + 1);
        options[n] = 0;
    }

    // Before Open.
    REFUSED(-7, "no controller is open", GT_AxisOn(1));
    REFUSED(-7, "no controller is open", GTN_GetPrfPos(1, 1, value));
    REFUSED(-7, "no controller is open", GT_GetPrfPos(1, NULL));
    REFUSED(-7, "no controller is open", GT_LoadConfig("test.cfg"));
    DONE(GT_Close());
    GT_AxisOn(1);
    DONE(GT_GetLastReason(text, 16));
    HOLDS(strcmp(text, "AxisOn: no cont") == 0);
    HOLDS(GT_GetLastReason(text, 1) == 0 && text[0] == 0);
    HOLDS(GT_GetLastReason(text, 0) == 7);
    HOLDS(GT_GetLastReason(text, -5) == 7);
    HOLDS(GT_GetLastReason(NULL, 16) == 7);

    DONE(GTN_Open());
    // Open twice; the first goes on.
    REFUSED(-6, "open already", GTN_Open());
    REFUSED(-6, "open already", GT_Open(0, 1));
    DONE(GTN_GetVersion(1, &version));
    HOLDS(strstr(version, "profile gtn-016") != NULL);

    // NULL.
    REFUSED(7, "value is NULL", GTN_GetPrfPos(1, 1, NULL));
    REFUSED(7, "sts is NULL", GTN_GetSts(1, 1, NULL, 8));
    REFUSED(7, "version is NULL", GTN_GetVersion(1, NULL));
    REFUSED(7, "file is NULL", GTN_LoadConfig(1, NULL));
    REFUSED(7, "prm is NULL", GTN_SetTrapPrm(1, 1, NULL));
    REFUSED(7, "prm is NULL", GTN_GetTrapPrm(1, 1, NULL));
    REFUSED(7, "crdPrm is NULL", GTN_SetCrdPrm(1, 1, NULL));
    REFUSED(7, "time is NULL", GTN_PvtTable(1, 1, 3, NULL, table, table));
    REFUSED(7, "vel is NULL", GTN_PvtTable(1, 1, 3, value, table, NULL));
    REFUSED(7, "value is NULL", GTN_SetDac(1, 1, NULL, 2));
    REFUSED(7, "axis is NULL", GTN_PtStartPro(1, NULL, options, 2));
    REFUSED(7, "tableId is NULL", GTN_PvtStatus(1, 1, NULL, value));
    REFUSED(7, "ratio is NULL", GT_SetLaserDisRatio(NULL, 0, 100));

    // Counts of 0 and 1000. A read may reach past the last axis: zeros there (GXN table 5-1, note 2).
    REFUSED(7, "count is 0", GTN_GetSts(1, 1, numbers, 0));
    numbers[31] = -1;
    DONE(GTN_GetSts(1, 1, numbers, 32));
    HOLDS(numbers[31] == 0);
    REFUSED(7, "count is -1", GTN_GetPrfPos(1, 1, value, -1));
    value[999] = value[1000] = -1;
    DONE(GTN_GetPrfVel(1, 1, value, 1000));
    HOLDS(value[999] == 0 && value[1000] == -1);
    for (int n = 0; n < 1024; n++) {
        value[n] = n;
    }
    REFUSED(7, "count is 0", GTN_ClrSts(1, 1, 0));
    REFUSED(7, "count is 1000", GTN_ZeroPos(1, 1, 1000));
    REFUSED(7, "count is 0", GTN_SetDac(1, 1, shorts, 0));
    REFUSED(7, "count is 1000", GTN_SetDac(1, 1, shorts, 1000));
    REFUSED(7, "count is 0", GTN_PtStartPro(1, axes, options, 0));
    REFUSED(7, "count is 1000", GTN_PtStartPro(1, axes, options, 1000));
    REFUSED(7, "count is 0", GTN_PvtTable(1, 1, 0, value, table, table));
    REFUSED(7, "count is 1", GTN_PvtTable(1, 1, 1, value, table, table));
    REFUSED(7, "count is 1025", GTN_PvtTable(1, 1, 1025, value, table, table));
    REFUSED(7, "count is -3", GTN_PvtTableComplete(1, 1, -3, value, table, NULL, NULL, NULL));
    REFUSED(7, "count is 2000000000", GTN_PvtPercentCalculate(1, 2000000000, value, table, value, 0, value));
    REFUSED(7, "count", GTN_GetAdc(1, 1, value, 0));
    REFUSED(7, "adc", GTN_GetAdc(1, 1000, value, 1));
    REFUSED(7, "count", GTN_GetDac(1, 1, shorts, 0));

    // The same with arrays that are no longer than what is taken at most.
    {
        double *reals = (double *)last_values(sizeof(double));
        long *longs = (long *)last_values(sizeof(long));
        short *words = (short *)last_values(sizeof(short));
        short plane[2] = {1, 2}, wide[2] = {1000, 2}, high[2] = {2, 1000}, big[2] = {32, 32}, none[2] = {0, 2};
        REFUSED(7, "count is 1000; it must be from 1 to 32", GTN_SetDac(1, 1, words, 1000));
        REFUSED(7, "count is 33; it must be from 1 to 32", GTN_PtStartPro(1, words, words, 33));
        REFUSED(7, "count is 1025; it must be from 2 to 1024", GTN_PvtTable(1, 1, 1025, reals, reals, reals));
        REFUSED(7, "count is 1000; it must be from 1 to 32", GT_SetLaserFollowTable(1, 1000, reals, reals));
        REFUSED(7, "count is 33; it must be from 1 to 32", GT_SetLaserFollowTable(1, 33, reals, reals));
        REFUSED(7, "count is 0; it must be from 1 to 32", GT_SetLaserFollowTable(1, 0, reals, reals));
        REFUSED(7, "count is 1000; it must be from 1 to 32", GT_SetLaserDisTable1D(1000, reals, longs, 0, 100));
        REFUSED(7, "count is -1; it must be from 1 to 32", GT_SetLaserDisTable1D(-1, reals, longs, 0, 100));
        REFUSED(7, "count is 1000; it must be from 1 to 32",
            GT_SetLaserDisTable2D(plane, wide, reals, longs, longs, 0, 100));
        REFUSED(7, "count is 1000; it must be from 1 to 32",
            GT_SetLaserDisTable2D(plane, high, reals, longs, longs, 0, 100));
        REFUSED(7, "count is 0; it must be from 1 to 32", GT_SetLaserDisTable2D(plane, none, reals, longs, longs, 0, 100));
        REFUSED(7, "256", GT_SetLaserDisTable2D(plane, big, reals, longs, longs, 0, 100));
    }

    // Numbers that name nothing, and numbers that are none.
    REFUSED(7, "core is 3", GTN_AxisOn(3, 1));
    REFUSED(7, "core is 0", GTN_GetSts(0, 1, numbers));
    REFUSED(7, "axis is 9", GTN_AxisOn(1, 9));
    REFUSED(7, "profile is 0", GTN_PrfPt(1, 0));
    REFUSED(7, "mask", GTN_Update(1, 0x10000));
    REFUSED(7, "not a finite number", GTN_SetVel(1, 1, (double)NAN));
    REFUSED(7, "not a finite number", GTN_SetStopDec(1, 1, (double)INFINITY, 1));
    REFUSED(7, "mode", GTN_PrfPt(1, 1, 2));
    REFUSED(7, "channel is 2", GT_LaserPrfCmd(10, 2));
    axes[1] = 40;
    REFUSED(7, "axis is 40", GTN_PtStartPro(1, axes, options, 2));
    axes[1] = 2;
    options[1] = 2;
    REFUSED(7, "option is 2", GTN_PtStartPro(1, axes, options, 2));
    axes[1] = 1;
    options[1] = 1;
    REFUSED(7, "axis 1 is listed twice", GTN_PtStartPro(1, axes, options, 2));

    // A long of 64 bits.
    if (sizeof(long) > 4) {
        REFUSED(7, "pos is 5000000000", GTN_SetPos(1, 1, (long)5e9));
        REFUSED(7, "time is 4294967296", GTN_PtData(1, 1, 10, (long)4294967296.0));
        REFUSED(7, "mask is 4294967296", GTN_Update(1, (long)4294967296.0));
        REFUSED(7, "delayTime", GTN_FollowDelayEx(1, 1, (unsigned long)-1, 0));
        DONE(GTN_SetSoftLimit(1, 1, 0x7fffffff, (long)0x80000000u));
        DONE(GTN_GetSoftLimit(1, 1, &numbers[0], &numbers[1]));
        HOLDS(numbers[0] == 0x7fffffff && numbers[1] == -2147483647L - 1);
    }

    // The wrong state.
    REFUSED(1, "is 0; set the motion", GTN_Update(1, 1));
    REFUSED(1, "not in the mode", GTN_PtData(1, 1, 10, 10));
    REFUSED(1, "not in the mode", GTN_PvtStart(1, 1));
    DONE(GTN_PrfPvt(1, 1));
    REFUSED(1, "empty", GTN_PvtStart(1, 1));
    REFUSED(1, "FollowMaster", (GTN_PrfFollow(1, 2), GTN_FollowData(1, 2, 100, 100), GTN_FollowStart(1, 2)));
    DONE(GTN_PrfPt(1, 1));
    REFUSED(1, "FIFO holds no data", GTN_PtStart(1, 1));
    DONE(GTN_PtData(1, 1, 10, 10));
    REFUSED(7, "greater than 10", GTN_PtData(1, 1, 20, 10));
    REFUSED(1, "servo is off", GTN_PtStart(1, 1));
    // A mask of 0 does nothing.
    DONE(GTN_PtStart(1, 0));
    DONE(GTN_Update(1, 0));
    DONE(GTN_Stop(1, 0, 0));

    // Refused data of a long table leaves the table as it was.
    DONE(GTN_PrfPvt(1, 3));
    for (int n = 0; n < 1024; n++) {
        value[n] = n;
        table[n] = 0;
    }
    DONE(GTN_PvtTable(1, 3, 1000, value, table, table));
    value[999] = 0;
    REFUSED(7, "greater than 998", GTN_PvtTable(1, 3, 1000, value, table, table));

    // Files.
    REFUSED(7, "no-such-file.cfg", GTN_LoadConfig(1, "no-such-file.cfg"));

    DONE(GTN_Close());
    REFUSED(-7, "no controller is open", GTN_AxisOn(1, 1));
    DONE(GTN_Close());
    DONE(GT_Open());
    DONE(GT_Close());

    // A file of more axes than a message holds: 24 are there.
    double smooth, abrupt, smooth_before, abrupt_before;
    long error, error_before;
    setenv("BEAMTICK_PROFILE", "gsn-048", 1);
    DONE(GTN_Open(5, 2));
    DONE(GTN_GetStopDec(1, 1, &smooth_before, &abrupt_before));
    DONE(GTN_GetPosErr(1, 1, &error_before));
    HOLDS(smooth_before != 3 && error_before != 1001);
    REFUSED(7, "axis is 25; allowed are 1 to 24 (item 25): axis 25 in /tmp/beamtick-", load(25, "3"));
    REFUSED(7, "dec_smooth", load(24, "1e30"));
    REFUSED(7, "(item 24): axis 24 in /tmp/beamtick-", load(24, "1e30"));
    REFUSED(7, "(item 3): axis 3 in /tmp/beamtick-", load(3, "1e30"));
    for (short axis = 1; axis <= 24; axis++) {
        DONE(GTN_GetStopDec(1, axis, &smooth, &abrupt));
        DONE(GTN_GetPosErr(1, axis, &error));
        HOLDS(smooth == smooth_before && abrupt == abrupt_before && error == error_before);
    }
    DONE(load(24, "5"));
    for (short axis = 1; axis <= 24; axis++) {
        DONE(GTN_GetStopDec(1, axis, &smooth, &abrupt));
        DONE(GTN_GetPosErr(1, axis, &error));
        HOLDS(smooth == (axis < 24 ? 3 : 5) && error == 1000 + axis);
    }
    DONE(GTN_Close());
    unsetenv("BEAMTICK_PROFILE");
    return verdict();
}
