// Several cards: each is a controller of its own, and the ranges of their numbers are checked.
#include "gts_cards.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int failures = 0;
#define CHECK(what)                                       \
    do {                                                  \
        if (!(what)) {                                    \
            printf("line %d: not %s\n", __LINE__, #what); \
            failures++;                                   \
        }                                                 \
    } while (0)

int main()
{
    char reason[256], *version;
    double pos;
    CHECK(GT_AxisOn(0, 1) == -7);
    CHECK(GT_Open(16) == 7 && GT_Open(-1) == 7);
    CHECK(GT_Open(0) == 0 && GT_Open(3, 0, 1) == 0);
    CHECK(GT_Open(3) == -6);
    CHECK(GT_SetPrfPos(0, 1, 100) == 0 && GT_SetPrfPos(3, 1, 300) == 0);
    CHECK(GT_GetPrfPos(0, 1, &pos) == 0 && pos == 100);
    CHECK(GT_GetPrfPos(3, 1, &pos) == 0 && pos == 300);
    CHECK(GT_GetPrfPos(1, 1, &pos) == -7);
    // The card of its own profile (BEAMTICK_PROFILE_3).
    CHECK(GT_GetVersion(3, &version) == 0 && strstr(version, "r688c-024") != NULL);
    CHECK(GT_AxisOn(3, 24) == 0 && GT_AxisOn(0, 24) == 7);
    CHECK(GT_GetLastReason(0, reason, sizeof reason) == 0 && strstr(reason, "axis is 24") != NULL);
    CHECK(GT_GetLastReason(3, reason, sizeof reason) == 0 && strstr(reason, "open already") != NULL);
    CHECK(GT_Close(0) == 0 && GT_AxisOn(0, 1) == -7 && GT_AxisOn(3, 1) == 0);
    CHECK(GT_Close(3) == 0);
    // Two cards do not write one file; when the first is closed, the other one may, and writes it anew.
    char trace[] = "/tmp/beamtick-XXXXXX";
    close(mkstemp(trace));
    setenv("BEAMTICK_TRACE", trace, 1);
    CHECK(GT_Open(0) == 0);
    CHECK(GT_Open(3) == -6);
    CHECK(GT_GetLastReason(3, reason, sizeof reason) == 0 && strstr(reason, trace) != NULL);
    CHECK(strstr(reason, "another controller") != NULL && strstr(reason, "BEAMTICK_TRACE_3") != NULL);
    CHECK(GT_GetPrfPos(0, 1, &pos) == 0 && GT_GetPrfPos(3, 1, &pos) == -7);
    CHECK(GT_Close(0) == 0);
    CHECK(GT_Open(3) == 0 && GT_Open(0) == -6 && GT_Close(3) == 0);
    setenv("BEAMTICK_TRACE_3", "/dev/null", 1);
    CHECK(GT_Open(0) == 0 && GT_Open(3) == 0 && GT_Close(0) == 0 && GT_Close(3) == 0);
    unlink(trace);
    printf(failures ? "%d checks failed\n" : "all checks passed\n", failures);
    return failures != 0;
}
