// GUS chapter 3, second listing, and LSR listing 2: power by the rate of pulses of 10 us, here 20 kHz.
#include "example.h"
#include <windows.h>

int main(int count, char **words)
{
    const bool lsr = count > 1 && words[1][0] == 'l';
    double power;
    CALL(GT_Open());
    if (lsr) {
        CALL(GT_SetLaserMode(0)); // up to 96 kHz
        CALL(GT_LaserPowerMode(LASER_CTRL_FREQUENCY, 96, 0, 0, 0));
    } else {
        CALL(GT_SetAxisMode(AXIS_LASER, 1));
        CALL(GT_LaserPowerMode(LASER_CTRL_FREQUENCY, 1000, 0, 0));
    }
    CALL(GT_SetPulseWidth(10, 0));
    CALL(GT_LaserPrfCmd(20, 0));
    CALL(GT_SetHSIOOpt(1, 0));
    Sleep(10);
    CALL(GT_GetLaserPower(0, &power));
    printf("%.2f kHz\n", power);
    CALL(GT_SetHSIOOpt(0, 0));
    CALL(GT_Close());
    return 0;
}
