// A link that dies in the middle of a move: the code of the failure from then on, and a new Open after Close.
#include "gts.h"
#include "check.h"

int main()
{
    TJogPrm jog = {1, 1, 0};
    double pos;
    short code = 0;
    DONE(GT_Open());
    DONE(GT_AxisOn(1));
    DONE(GT_PrfJog(1));
    DONE(GT_SetJogPrm(1, &jog));
    DONE(GT_SetVel(1, 10));
    DONE(GT_Update(1));
    DONE(GT_PrfPt(2));
    DONE(GT_PtClear(2));
    for (int n = 1; n <= 10; n++) {
        DONE(GT_PtData(2, n, n));
    }
    printf("moving\n");
    fflush(stdout);
    getchar();
    for (int n = 0; n < 100000000 && code == 0; n++) {
        code = GT_GetPrfPos(1, &pos);
    }
    printf("dead %d\n", code);
    REFUSED(code, "tcp:", GT_AxisOn(1));
    REFUSED(code, "tcp:", GT_GetPrfPos(1, &pos));
    HOLDS(code >= -7 && code <= -1);
    DONE(GT_Close());
    REFUSED(-7, "no controller is open", GT_GetPrfPos(1, &pos));
    REFUSED(-6, "cannot open", GT_Open());
    return verdict();
}
