// GUS chapter 4, first listing, and LSR listing 4: a power for each segment, buffered between the lines: 50 %, then 30 %.
#include "laser_path.h"

int main(int count, char **words)
{
    open_path(is_lsr(count, words));
    CALL(GT_LaserPowerMode(LASER_CTRL_MODE_PWM1, 100, 0, 0));
    CALL(GT_LaserOutFrq(10, 0));
    CALL(GT_CrdClear(1, 0));
    CALL(GT_BufLaserOn(1, 0, 0));
    CALL(GT_BufLaserPrfCmd(1, 50, 0, 0));
    CALL(GT_LnXY(1, 100000, 0, 50, 2, 0, 0));
    CALL(GT_BufLaserPrfCmd(1, 30, 0, 0));
    CALL(GT_LnXY(1, 0, 10000, 50, 2, 0, 0));
    CALL(GT_BufLaserOff(1, 0, 0));
    run_path();
    return 0;
}
