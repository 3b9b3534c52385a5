// PT data in loops: batches change no return value.
#include "gts.h"
#include "check.h"

int main()
{
    short space;
    double pos;
    long status;
    DONE(GT_Open());
    DONE(GT_AxisOn(1));
    DONE(GT_AxisOn(2));
    DONE(GT_PrfPt(1));
    DONE(GT_SetPtMemory(1, 1));
    DONE(GT_PtClear(1, 0));
    DONE(GT_PtClear(1, 1));

    // Space counts what is queued; the 1025th segment is refused by its own call.
    for (int n = 1; n <= 1024; n++) {
        DONE(GT_PtSpace(1, &space));
        HOLDS(space == 1025 - n);
        DONE(GT_PtData(1, n, n));
    }
    DONE(GT_PtSpace(1, &space));
    HOLDS(space == 0);
    REFUSED(1, "FIFO is full", GT_PtData(1, 2000, 2000));

    // A wrong segment in the middle is refused by its own call, and those around it are there.
    for (int n = 1; n <= 100; n++) {
        DONE(GT_PtData(1, n, n, PT_SEGMENT_NORMAL, 1));
        if (n == 50) {
            REFUSED(7, "time_ms is 50", GT_PtData(1, n, n, PT_SEGMENT_NORMAL, 1));
            REFUSED(7, "kind is 3", GT_PtData(1, n, n + 1, 3, 1));
            REFUSED(7, "pulse/ms", GT_PtData(1, 1e12, n + 1, PT_SEGMENT_NORMAL, 1));
        }
    }
    DONE(GT_PtSpace(1, &space, 1));
    HOLDS(space == 924);

    // Data of two axes and two FIFOs in turn.
    DONE(GT_PrfPt(2));
    DONE(GT_PtClear(2));
    for (int n = 1; n <= 20; n++) {
        DONE(GT_PtData(2, 10 * n, n));
        DONE(GT_PtData(1, 100 + n, 100 + n, PT_SEGMENT_NORMAL, 1));
    }
    DONE(GT_PtSpace(2, &space));
    HOLDS(space == 12);
    DONE(GT_PtSpace(1, &space, 1));
    HOLDS(space == 904);

    // Data that is queued is there for the start that follows, and runs.
    DONE(GT_PtData(2, 210, 21));
    DONE(GT_PtData(2, 220, 22));
    DONE(GT_PtStart(3));
    do {
        DONE(GT_GetSts(1, &status));
    } while (status & 0x400);
    DONE(GT_GetPrfPos(1, &pos));
    HOLDS(pos == 1024);
    DONE(GT_GetPrfPos(2, &pos));
    HOLDS(pos == 220);

    // A read sees what was queued before it.
    DONE(GT_PtClear(2));
    DONE(GT_PtData(2, 1, 1));
    DONE(GT_PtData(2, 2, 2));
    DONE(GT_PtData(2, 3, 3));
    DONE(GT_GetSts(2, &status));
    DONE(GT_PtSpace(2, &space));
    HOLDS(space == 29);

    // Dynamic: the stream goes on while it runs, and a new one begins after Stop, with data that comes too early for
    // what was there before.
    DONE(GT_PrfPt(1, PT_MODE_DYNAMIC));
    DONE(GT_PtClear(1));
    DONE(GT_SetPtMemory(1, 0));
    DONE(GT_PtClear(1));
    int sent = 0;
    for (; sent < 64; sent++) {
        DONE(GT_PtData(1, 10 * (sent + 1), 10 * (sent + 1), PT_SEGMENT_EVEN));
    }
    DONE(GT_PtStart(1));
    while (sent < 300) {
        DONE(GT_PtSpace(1, &space));
        HOLDS(space >= 0 && space <= 64);
        if (space > 0) {
            sent++;
            DONE(GT_PtData(1, 10 * sent, 10 * sent, sent == 300 ? PT_SEGMENT_STOP : PT_SEGMENT_EVEN));
        }
    }
    do {
        DONE(GT_GetSts(1, &status));
    } while (status & 0x400);
    DONE(GT_GetPrfPos(1, &pos));
    HOLDS(pos == 1024 + 3000);
    DONE(GT_PtData(1, 5, 5));
    DONE(GT_PtData(1, 10, 10, PT_SEGMENT_STOP));
    DONE(GT_PtSpace(1, &space));
    HOLDS(space == 62);
    DONE(GT_Close());
    return verdict();
}
