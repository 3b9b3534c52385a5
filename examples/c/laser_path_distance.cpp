// GUS chapter 5, and LSR listing 6: to a power that follows the speed (0.1 % for each pulse/ms, at most 10 %) comes one by
// distance: 0.1 % for each 1000 pulses that an axis is away from 0.
#include "laser_path.h"

int main(int count, char **words)
{
    const bool lsr = is_lsr(count, words);
    long pos[4] = {0, 0, 0, 0};
    double scale[4] = {1000, 1000, 1000, 1000};
    double ratio[4] = {0.1, 0.1, 0.1, 0.1};
    open_path(lsr);
    CALL(GT_LaserPowerMode(LASER_CTRL_MODE_PWM1, 100, 0, 0));
    CALL(GT_SetLaserDisMode(1, 0, pos, scale, 0));
    if (lsr) {
        CALL(GT_SetLaserDisRatio(ratio, 0));
    } else {
        CALL(GT_SetLaserDisRatio(ratio, 10, 100, 0));
    }
    CALL(GT_LaserOutFrq(10, 0));
    CALL(GT_CrdClear(1, 0));
    CALL(GT_BufLaserPrfFollow(1, 0.1, 0, 10, 0, 0));
    CALL(GT_BufLaserOn(1, 0, 0));
    CALL(GT_LnXY(1, 100000, 0, 50, 2, 0, 0));
    CALL(GT_LnXY(1, 0, 10000, 50, 2, 0, 0));
    CALL(GT_BufLaserOff(1, 0, 0));
    run_path();
    return 0;
}
