// Calls per second: reads, commands that the tick executes, and PtData in a loop. Argument: seconds for each.
#include "gts.h"
#include "check.h"
#include <chrono>

static double seconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int main(int count, char **words)
{
    const double time = count > 1 ? atof(words[1]) : 0.2;
    double pos, begin;
    long calls;
    DONE(GT_Open());
    for (begin = seconds(), calls = 0; seconds() - begin < time; calls++) {
        DONE(GT_GetPrfPos(1, &pos));
    }
    printf("read %.0f\n", (double)calls / (seconds() - begin));
    for (begin = seconds(), calls = 0; seconds() - begin < time; calls++) {
        DONE(GT_SetStopDec(1, 1, 1000));
    }
    printf("command %.0f\n", (double)calls / (seconds() - begin));
    DONE(GT_PrfPt(1));
    DONE(GT_SetPtMemory(1, 1));
    for (begin = seconds(), calls = 0; seconds() - begin < time;) {
        DONE(GT_PtClear(1));
        for (int n = 1; n <= 1000 && seconds() - begin < time; n++, calls++) {
            DONE(GT_PtData(1, n, n));
        }
    }
    DONE(GT_GetPrfPos(1, &pos));
    printf("PtData %.0f\n", (double)calls / (seconds() - begin));
    DONE(GT_Close());
    return failures;
}
