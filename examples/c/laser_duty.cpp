// GUS chapter 3, first listing, and LSR listing 1: power by the duty of a 10 kHz carrier, here 25 % of 10 to 100 %.
#include "example.h"
#include <windows.h>

int main(int count, char **words)
{
    const bool lsr = count > 1 && words[1][0] == 'l';
    double power;
    CALL(GT_Open());
    if (!lsr) {
        // Axis connector 7 becomes laser channel 0; the earlier series has a connector of its own.
        CALL(GT_SetAxisMode(AXIS_LASER, 1));
    }
    CALL(GT_LaserPowerMode(LASER_CTRL_MODE_PWM1, 100, 10, 0));
    CALL(GT_LaserOutFrq(10, 0));
    CALL(GT_LaserPrfCmd(25, 0));
    CALL(GT_SetHSIOOpt(1, 0));
    Sleep(10);
    CALL(GT_GetLaserPower(0, &power));
    printf("%.2f %%\n", power);
    CALL(GT_SetHSIOOpt(0, 0));
    CALL(GT_Close());
    return 0;
}
