/* Checks of the test programs: a call's return value and a part of its reason. */
#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

static inline void check(int line, const char *call, short found, short wanted, const char *part)
{
    char reason[512] = "";
    GT_GetLastReason(reason, (short)sizeof reason);
    if (found != wanted || (wanted != 0 && strstr(reason, part) == NULL)) {
        printf("line %d: %s = %d (%s); wanted %d (%s)\n", line, call, found, reason, wanted, part);
        failures++;
    }
}

/* A call that is refused, with a part of the reason. */
#define REFUSED(code, part, call) check(__LINE__, #call, call, code, part)
/* A call that is done. */
#define DONE(call) check(__LINE__, #call, call, 0, "")
/* Anything else. */
#define HOLDS(what)                                          \
    do {                                                    \
        if (!(what)) {                                      \
            printf("line %d: not %s\n", __LINE__, #what);   \
            failures++;                                     \
        }                                                   \
    } while (0)

static inline int verdict(void)
{
    printf(failures ? "%d checks failed\n" : "all checks passed\n", failures);
    return failures != 0;
}

#endif
