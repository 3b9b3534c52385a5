// GUS chapter 3, third listing, and LSR listing 3: power by a voltage, here 2.5 V of at most 5 V. No connector has to be
// changed for it.
#include "example.h"
#include <windows.h>

int main()
{
    double power;
    CALL(GT_Open());
    CALL(GT_LaserPowerMode(LASER_CTRL_VOLTAGE, 5, 0, 0));
    CALL(GT_LaserPrfCmd(2.5, 0));
    CALL(GT_SetHSIOOpt(1, 0));
    Sleep(10);
    CALL(GT_GetLaserPower(0, &power));
    printf("%.2f V\n", power);
    CALL(GT_SetHSIOOpt(0, 0));
    CALL(GT_Close());
    return 0;
}
