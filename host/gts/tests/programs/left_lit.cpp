// A card that is closed, and a program that ends without closing it, leave no light; the next on command works.
// argv[1]: close, exit, leave, or read or light: a thread ends the program while another one reads, or lights. The controller is a served one, which outlives the program.
#include "gts.h"
#include "check.h"
#include <chrono>
#include <thread>

int main(int count, char **arguments)
{
    const char *how = count > 1 ? arguments[1] : "close";
    DONE(GT_Open());
    short cause;
    DONE(GT_GetLaserFault(0, &cause));
    HOLDS(cause == 0);
    unsigned short on;
    DONE(GT_GetHSIOOpt(&on, 0));
    HOLDS(on == 0);
    DONE(GT_SetAxisMode(7, 1));
    DONE(GT_LaserOutFrq(10, 0));
    DONE(GT_LaserPrfCmd(50, 0));
    DONE(GT_LaserOn(0));
    DONE(GT_GetHSIOOpt(&on, 0));
    HOLDS(on == 1);
    int failed = verdict();
    fflush(stdout);
    if (strcmp(how, "close") == 0 && GT_Close() != 0)
        return 1;
    if (strcmp(how, "exit") == 0)
        exit(failed);
    bool reads = strcmp(how, "read") == 0;
    if (reads || strcmp(how, "light") == 0)
    {
        std::thread([failed] {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            exit(failed);
        }).detach();
        double position;
        for (;;)
        {
            if (reads)
                GT_GetPrfPos(1, &position);
            else
                GT_LaserOn(0);
        }
    }
    return failed;
}
