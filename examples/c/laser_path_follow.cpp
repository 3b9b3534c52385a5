// GUS chapter 4, second listing, and LSR listing 5: the power follows the speed of the path, 0.1 % for each pulse/ms within 10 and
// 100 %. The earlier series follows the encoders.
#include "laser_path.h"

int main(int count, char **words)
{
    const bool lsr = is_lsr(count, words);
    open_path(lsr);
    CALL(GT_LaserPowerMode(LASER_CTRL_MODE_PWM1, 100, 0, 0));
    CALL(GT_LaserOutFrq(10, 0));
    CALL(GT_CrdClear(1, 0));
    if (lsr) {
        CALL(GT_BufLaserFollowMode(1, 1, 0, 0));
        CALL(GT_BufLaserFollowRatio(1, 0.1, 10, 100, 0, 0));
    } else {
        CALL(GT_BufLaserPrfFollow(1, 0.1, 10, 100, 0, 0));
    }
    CALL(GT_BufLaserOn(1, 0, 0));
    CALL(GT_LnXY(1, 100000, 0, 50, 2, 0, 0));
    CALL(GT_LnXY(1, 0, 10000, 50, 2, 0, 0));
    CALL(GT_BufLaserOff(1, 0, 0));
    run_path();
    return 0;
}
