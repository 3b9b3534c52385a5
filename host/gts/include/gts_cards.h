/* gts_cards.h: several cards, as GT_x(cardNum, ...) for the first core of each.
 * Generated from the table of functions by `cargo xtask c-api`: change that, not this.
 * docs/c.md says what the library does; return values are those of the manuals. */
#ifndef BEAMTICK_GTS_CARDS_H
#define BEAMTICK_GTS_CARDS_H

#ifdef BEAMTICK_GTS_H
#error "gts.h and gts_cards.h declare the same names: include one of them"
#endif

#include <stddef.h>

#ifdef __cplusplus
#define GT_DEFAULT(value) = value
#define GT_EXTERN extern "C"
#else
#define GT_DEFAULT(value)
#define GT_EXTERN extern
#endif

#ifdef _WIN32
#define GT_API GT_EXTERN short __stdcall
#else
#define GT_API GT_EXTERN short
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct TTrapPrm {
    double acc;
    double dec;
    double velStart;
    short smoothTime;
} TTrapPrm;

typedef struct TJogPrm {
    double acc;
    double dec;
    double smooth;
} TJogPrm;

typedef struct TCrdPrm {
    short dimension;
    short profile[8];
    double synVelMax;
    double synAccMax;
    short evenTime;
    short setOriginFlag;
    long originPos[8];
} TCrdPrm;

typedef struct TCrdData {
    short motionType;
    short circlePlat;
    long pos[8];
    double radius;
    short circleDir;
    double center[3];
    double vel;
    double acc;
    short velEndZero;
    short operation[7];
    double cos[8];
    double velEnd;
    double velEndAdjust;
    double r;
} TCrdData;

#ifdef __cplusplus
}
#endif

/* A power or a bound that is left out, where that differs from 0. */
#define GT_NOT_GIVEN (-1.7976931348623157e308)

#define PT_MODE_STATIC 0
#define PT_MODE_DYNAMIC 1
#define PT_SEGMENT_NORMAL 0
#define PT_SEGMENT_EVEN 1
#define PT_SEGMENT_STOP 2
#define FOLLOW_MASTER_ENCODER 1
#define FOLLOW_MASTER_PROFILE 2
#define FOLLOW_MASTER_AXIS 3
#define FOLLOW_MASTER_AU_ENCODER 4
#define FOLLOW_MASTER_ENCODER_OTHER 101
#define FOLLOW_MASTER_AXIS_OTHER 103
#define FOLLOW_EVENT_START 1
#define FOLLOW_EVENT_PASS 2
#define FOLLOW_SEGMENT_NORMAL 0
#define FOLLOW_SEGMENT_EVEN 1
#define FOLLOW_SEGMENT_STOP 2
#define FOLLOW_SEGMENT_CONTINUE 3
#define FOLLOW_SWITCH_SEGMENT 1
#define FOLLOW_SWITCH_TABLE 2
#define MC_NONE (-1)
#define MC_LIMIT_POSITIVE 0
#define MC_LIMIT_NEGATIVE 1
#define MC_ALARM 2
#define MC_HOME 3
#define MC_GPI 4
#define MC_ARRIVE 5
#define MC_ENABLE 10
#define MC_CLEAR 11
#define MC_GPO 12
#define MC_DAC 20
#define MC_STEP 21
#define MC_PULSE 22
#define MC_ENCODER 23
#define MC_ADC 24
#define MC_AXIS 30
#define MC_PROFILE 31
#define MC_CONTROL 32
#define MC_LASER 71
#define MC_POS_COMPARE 80
#define CAPTURE_HOME 1
#define CAPTURE_INDEX 2
#define CAPTURE_PROBE 3
#define CAPTURE_HSIO0 6
#define CAPTURE_HSIO1 7
#define AXIS_LASER 7
#define AXIS_LASER_EX 8
#define LASER_CTRL_MODE_PWM1 0
#define LASER_CTRL_FREQUENCY 1
#define LASER_CTRL_VOLTAGE 2
#define LASER_CTRL_MODE_PWM2 3
#define CIRCLE_DIR_CW 0
#define CIRCLE_DIR_CCW 1
#define INTERPOLATION_CIRCLE_DIR_CW 0
#define INTERPOLATION_CIRCLE_DIR_CCW 1
#define CRD_MAX 2
#define CRD_FIFO_MAX 4096
#define INTERPOLATION_AXIS_MAX 8

/* The functions have symbols of their own, so that one library serves both headers. */
#define GT_Open GTM_Open
#define GT_Close GTM_Close
#define GT_GetLastReason GTM_GetLastReason
#define GT_Reset GTM_Reset
#define GT_LoadConfig GTM_LoadConfig
#define GT_ClrSts GTM_ClrSts
#define GT_GetVersion GTM_GetVersion
#define GT_GetClock GTM_GetClock
#define GT_SetTick GTM_SetTick
#define GT_SetLinkLoss GTM_SetLinkLoss
#define GT_AxisOn GTM_AxisOn
#define GT_AxisOff GTM_AxisOff
#define GT_Stop GTM_Stop
#define GT_ZeroPos GTM_ZeroPos
#define GT_SetPrfPos GTM_SetPrfPos
#define GT_SynchAxisPos GTM_SynchAxisPos
#define GT_SetStopDec GTM_SetStopDec
#define GT_GetStopDec GTM_GetStopDec
#define GT_SetAxisBand GTM_SetAxisBand
#define GT_GetAxisBand GTM_GetAxisBand
#define GT_GetSts GTM_GetSts
#define GT_GetPrfPos GTM_GetPrfPos
#define GT_GetPrfVel GTM_GetPrfVel
#define GT_GetPrfAcc GTM_GetPrfAcc
#define GT_GetPrfMode GTM_GetPrfMode
#define GT_GetEncPos GTM_GetEncPos
#define GT_GetEncVel GTM_GetEncVel
#define GT_SetEncPos GTM_SetEncPos
#define GT_SetSoftLimit GTM_SetSoftLimit
#define GT_GetSoftLimit GTM_GetSoftLimit
#define GT_LmtsOn GTM_LmtsOn
#define GT_LmtsOff GTM_LmtsOff
#define GT_LmtSns GTM_LmtSns
#define GT_AlarmOn GTM_AlarmOn
#define GT_AlarmOff GTM_AlarmOff
#define GT_SetPosErr GTM_SetPosErr
#define GT_GetPosErr GTM_GetPosErr
#define GT_SetCaptureMode GTM_SetCaptureMode
#define GT_GetCaptureStatus GTM_GetCaptureStatus
#define GT_PrfTrap GTM_PrfTrap
#define GT_SetTrapPrm GTM_SetTrapPrm
#define GT_GetTrapPrm GTM_GetTrapPrm
#define GT_PrfJog GTM_PrfJog
#define GT_SetJogPrm GTM_SetJogPrm
#define GT_GetJogPrm GTM_GetJogPrm
#define GT_SetPos GTM_SetPos
#define GT_GetPos GTM_GetPos
#define GT_SetVel GTM_SetVel
#define GT_GetVel GTM_GetVel
#define GT_Update GTM_Update
#define GT_GetDi GTM_GetDi
#define GT_SetDo GTM_SetDo
#define GT_GetDo GTM_GetDo
#define GT_SetDoBit GTM_SetDoBit
#define GT_SetDac GTM_SetDac
#define GT_GetDac GTM_GetDac
#define GT_GetAdc GTM_GetAdc
#define GT_SetAxisMode GTM_SetAxisMode
#define GT_LaserOn GTM_LaserOn
#define GT_LaserOff GTM_LaserOff
#define GT_LaserOnStatus GTM_LaserOnStatus
#define GT_SetHSIOOpt GTM_SetHSIOOpt
#define GT_GetHSIOOpt GTM_GetHSIOOpt
#define GT_LaserPowerMode GTM_LaserPowerMode
#define GT_LaserPrfCmd GTM_LaserPrfCmd
#define GT_LaserOutFrq GTM_LaserOutFrq
#define GT_SetPulseWidth GTM_SetPulseWidth
#define GT_SetWaitPulse GTM_SetWaitPulse
#define GT_SetWaitPulseEx GTM_SetWaitPulseEx
#define GT_SetPreVltg GTM_SetPreVltg
#define GT_SetLevelDelay GTM_SetLevelDelay
#define GT_EnaFPK GTM_EnaFPK
#define GT_DisFPK GTM_DisFPK
#define GT_SetLaserMode GTM_SetLaserMode
#define GT_ZeroLaserOnTime GTM_ZeroLaserOnTime
#define GT_GetLaserOnTime GTM_GetLaserOnTime
#define GT_SetLaserCrdMap GTM_SetLaserCrdMap
#define GT_GetLaserCrdMap GTM_GetLaserCrdMap
#define GT_GetLaserPower GTM_GetLaserPower
#define GT_GetLaserFault GTM_GetLaserFault
#define GT_ClrLaserFault GTM_ClrLaserFault
#define GT_SetCrdPrm GTM_SetCrdPrm
#define GT_GetCrdPrm GTM_GetCrdPrm
#define GT_CrdClear GTM_CrdClear
#define GT_CrdSpace GTM_CrdSpace
#define GT_CrdStart GTM_CrdStart
#define GT_CrdStop GTM_CrdStop
#define GT_CrdStatus GTM_CrdStatus
#define GT_GetCrdPos GTM_GetCrdPos
#define GT_GetCrdVel GTM_GetCrdVel
#define GT_GetRemainderSegNum GTM_GetRemainderSegNum
#define GT_SetCrdStopDec GTM_SetCrdStopDec
#define GT_SetOverride GTM_SetOverride
#define GT_InitLookAhead GTM_InitLookAhead
#define GT_SetCrdLimit GTM_SetCrdLimit
#define GT_GetCrdLimit GTM_GetCrdLimit
#define GT_CrdData GTM_CrdData
#define GT_LnXY GTM_LnXY
#define GT_LnXYZ GTM_LnXYZ
#define GT_LnXYZA GTM_LnXYZA
#define GT_LnXYG0 GTM_LnXYG0
#define GT_ArcXYR GTM_ArcXYR
#define GT_ArcXYC GTM_ArcXYC
#define GT_ArcYZR GTM_ArcYZR
#define GT_ArcYZC GTM_ArcYZC
#define GT_ArcZXR GTM_ArcZXR
#define GT_ArcZXC GTM_ArcZXC
#define GT_BufDelay GTM_BufDelay
#define GT_BufIO GTM_BufIO
#define GT_BufDoBit GTM_BufDoBit
#define GT_BufDA GTM_BufDA
#define GT_BufMove GTM_BufMove
#define GT_BufGear GTM_BufGear
#define GT_BufLaserOn GTM_BufLaserOn
#define GT_BufLaserOff GTM_BufLaserOff
#define GT_BufLaserPrfCmd GTM_BufLaserPrfCmd
#define GT_BufLaserPrfFollow GTM_BufLaserPrfFollow
#define GT_BufLaserFollowMode GTM_BufLaserFollowMode
#define GT_BufLaserFollowRatio GTM_BufLaserFollowRatio
#define GT_BufLaserFollowTable GTM_BufLaserFollowTable
#define GT_BufLaserFollowOff GTM_BufLaserFollowOff
#define GT_SetLaserFollowTable GTM_SetLaserFollowTable
#define GT_SetLaserDisMode GTM_SetLaserDisMode
#define GT_SetLaserDisRatio GTM_SetLaserDisRatio
#define GT_SetLaserDisTable1D GTM_SetLaserDisTable1D
#define GT_SetLaserDisTable2D GTM_SetLaserDisTable2D
#define GT_PrfPt GTM_PrfPt
#define GT_PtSpace GTM_PtSpace
#define GT_PtData GTM_PtData
#define GT_PtClear GTM_PtClear
#define GT_SetPtLoop GTM_SetPtLoop
#define GT_GetPtLoop GTM_GetPtLoop
#define GT_SetPtMemory GTM_SetPtMemory
#define GT_GetPtMemory GTM_GetPtMemory
#define GT_PtStart GTM_PtStart
#define GT_PtStartPro GTM_PtStartPro
#define GT_PrfPvt GTM_PrfPvt
#define GT_SetPvtLoop GTM_SetPvtLoop
#define GT_GetPvtLoop GTM_GetPvtLoop
#define GT_PvtStatus GTM_PvtStatus
#define GT_PvtStart GTM_PvtStart
#define GT_PvtTableSelect GTM_PvtTableSelect
#define GT_PvtTable GTM_PvtTable
#define GT_PvtTableEx GTM_PvtTableEx
#define GT_PvtTableComplete GTM_PvtTableComplete
#define GT_PvtTablePercent GTM_PvtTablePercent
#define GT_PvtPercentCalculate GTM_PvtPercentCalculate
#define GT_PvtTableContinuous GTM_PvtTableContinuous
#define GT_PvtContinuousCalculate GTM_PvtContinuousCalculate
#define GT_PrfFollow GTM_PrfFollow
#define GT_SetFollowMaster GTM_SetFollowMaster
#define GT_GetFollowMaster GTM_GetFollowMaster
#define GT_SetFollowLoop GTM_SetFollowLoop
#define GT_GetFollowLoop GTM_GetFollowLoop
#define GT_SetFollowEvent GTM_SetFollowEvent
#define GT_GetFollowEvent GTM_GetFollowEvent
#define GT_FollowSpace GTM_FollowSpace
#define GT_FollowData GTM_FollowData
#define GT_FollowClear GTM_FollowClear
#define GT_FollowStart GTM_FollowStart
#define GT_FollowSwitch GTM_FollowSwitch
#define GT_SetFollowMemory GTM_SetFollowMemory
#define GT_GetFollowMemory GTM_GetFollowMemory
#define GT_GetFollowStatus GTM_GetFollowStatus
#define GT_PrfFollowEx GTM_PrfFollowEx
#define GT_SetFollowMasterEx GTM_SetFollowMasterEx
#define GT_GetFollowMasterEx GTM_GetFollowMasterEx
#define GT_SetFollowLoopEx GTM_SetFollowLoopEx
#define GT_GetFollowLoopEx GTM_GetFollowLoopEx
#define GT_SetFollowEventEx GTM_SetFollowEventEx
#define GT_GetFollowEventEx GTM_GetFollowEventEx
#define GT_FollowSpaceEx GTM_FollowSpaceEx
#define GT_FollowDataPercentEx GTM_FollowDataPercentEx
#define GT_FollowClearEx GTM_FollowClearEx
#define GT_FollowStartEx GTM_FollowStartEx
#define GT_FollowSwitchEx GTM_FollowSwitchEx
#define GT_SetFollowMemoryEx GTM_SetFollowMemoryEx
#define GT_GetFollowMemoryEx GTM_GetFollowMemoryEx
#define GT_GetFollowStatusEx GTM_GetFollowStatusEx
#define GT_FollowSwitchNowEx GTM_FollowSwitchNowEx
#define GT_FollowDoBitEx GTM_FollowDoBitEx
#define GT_FollowDelayEx GTM_FollowDelayEx
#define GT_FollowDiBitEx GTM_FollowDiBitEx
#define GT_FollowDataPercent2Ex GTM_FollowDataPercent2Ex
#define GT_GetFollowDataPercent2Ex GTM_GetFollowDataPercent2Ex

/* Session */
GT_API GT_Open(short cardNum, short channel GT_DEFAULT(0), short param GT_DEFAULT(1));
GT_API GT_Close(short cardNum);
GT_API GT_GetLastReason(short cardNum, char *text, short size);
GT_API GT_Reset(short cardNum);
GT_API GT_LoadConfig(short cardNum, const char *file);
GT_API GT_ClrSts(short cardNum, short axis, short count GT_DEFAULT(1));
GT_API GT_GetVersion(short cardNum, char **version);
GT_API GT_GetClock(short cardNum, unsigned long *clock, unsigned long *loop GT_DEFAULT(NULL));
GT_API GT_SetTick(short cardNum, long tickUs);
GT_API GT_SetLinkLoss(short cardNum, long timeMs, short stopAll);

/* Axes */
GT_API GT_AxisOn(short cardNum, short axis);
GT_API GT_AxisOff(short cardNum, short axis);
GT_API GT_Stop(short cardNum, long mask, long option);
GT_API GT_ZeroPos(short cardNum, short axis, short count GT_DEFAULT(1));
GT_API GT_SetPrfPos(short cardNum, short profile, long pos);
GT_API GT_SynchAxisPos(short cardNum, long mask);
GT_API GT_SetStopDec(short cardNum, short profile, double decSmoothStop, double decAbruptStop);
GT_API GT_GetStopDec(short cardNum, short profile, double *decSmoothStop, double *decAbruptStop);
GT_API GT_SetAxisBand(short cardNum, short axis, long band, long time);
GT_API GT_GetAxisBand(short cardNum, short axis, long *band, long *time);
GT_API GT_GetSts(short cardNum, short axis, long *sts, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetPrfPos(short cardNum, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetPrfVel(short cardNum, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetPrfAcc(short cardNum, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetPrfMode(short cardNum, short profile, long *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetEncPos(short cardNum, short encoder, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetEncVel(short cardNum, short encoder, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_SetEncPos(short cardNum, short encoder, long pos);
GT_API GT_SetSoftLimit(short cardNum, short axis, long positive, long negative);
GT_API GT_GetSoftLimit(short cardNum, short axis, long *positive, long *negative);
GT_API GT_LmtsOn(short cardNum, short axis, short limitType GT_DEFAULT(-1));
GT_API GT_LmtsOff(short cardNum, short axis, short limitType GT_DEFAULT(-1));
GT_API GT_LmtSns(short cardNum, unsigned short sense);
GT_API GT_AlarmOn(short cardNum, short axis);
GT_API GT_AlarmOff(short cardNum, short axis);
GT_API GT_SetPosErr(short cardNum, short control, long error);
GT_API GT_GetPosErr(short cardNum, short control, long *error);
GT_API GT_SetCaptureMode(short cardNum, short encoder, short mode);
GT_API GT_GetCaptureStatus(short cardNum, short encoder, short *status, long *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));

/* Trap and Jog */
GT_API GT_PrfTrap(short cardNum, short profile);
GT_API GT_SetTrapPrm(short cardNum, short profile, TTrapPrm *prm);
GT_API GT_GetTrapPrm(short cardNum, short profile, TTrapPrm *prm);
GT_API GT_PrfJog(short cardNum, short profile);
GT_API GT_SetJogPrm(short cardNum, short profile, TJogPrm *prm);
GT_API GT_GetJogPrm(short cardNum, short profile, TJogPrm *prm);
GT_API GT_SetPos(short cardNum, short profile, long pos);
GT_API GT_GetPos(short cardNum, short profile, long *pos);
GT_API GT_SetVel(short cardNum, short profile, double vel);
GT_API GT_GetVel(short cardNum, short profile, double *vel);
GT_API GT_Update(short cardNum, long mask);

/* Digital and analog inputs and outputs */
GT_API GT_GetDi(short cardNum, short diType, long *value);
GT_API GT_SetDo(short cardNum, short doType, long value);
GT_API GT_GetDo(short cardNum, short doType, long *value);
GT_API GT_SetDoBit(short cardNum, short doType, short index, short value);
GT_API GT_SetDac(short cardNum, short dac, short *value, short count GT_DEFAULT(1));
GT_API GT_GetDac(short cardNum, short dac, short *value, short count GT_DEFAULT(1));
GT_API GT_GetAdc(short cardNum, short adc, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));

/* Laser */
GT_API GT_SetAxisMode(short cardNum, short axis, short mode);
GT_API GT_LaserOn(short cardNum, short channel GT_DEFAULT(0));
GT_API GT_LaserOff(short cardNum, short channel GT_DEFAULT(0));
GT_API GT_LaserOnStatus(short cardNum, short *value, short channel GT_DEFAULT(0));
GT_API GT_SetHSIOOpt(short cardNum, unsigned short value, short channel GT_DEFAULT(0));
GT_API GT_GetHSIOOpt(short cardNum, unsigned short *value, short channel GT_DEFAULT(0));
GT_API GT_LaserPowerMode(short cardNum, short laserPowerMode, double maxValue, double minValue, short channel GT_DEFAULT(0), short delaymode GT_DEFAULT(0));
GT_API GT_LaserPrfCmd(short cardNum, double outputCmd, short channel GT_DEFAULT(0));
GT_API GT_LaserOutFrq(short cardNum, double outFrq, short channel GT_DEFAULT(0));
GT_API GT_SetPulseWidth(short cardNum, unsigned long width, short channel GT_DEFAULT(0));
GT_API GT_SetWaitPulse(short cardNum, unsigned short mode, double waitPulseFrq, double waitPulseDuty, short channel GT_DEFAULT(0));
GT_API GT_SetWaitPulseEx(short cardNum, unsigned short mode, double waitPulseFrq, double waitPulseDuty);
GT_API GT_SetPreVltg(short cardNum, unsigned short mode, double voltageValue, short channel GT_DEFAULT(0));
GT_API GT_SetLevelDelay(short cardNum, unsigned short offDelay, unsigned short onDelay, short channel GT_DEFAULT(0));
GT_API GT_EnaFPK(short cardNum, unsigned short time1, unsigned short time2, unsigned short laserOffDelay, short channel GT_DEFAULT(0));
GT_API GT_DisFPK(short cardNum, short channel GT_DEFAULT(0));
GT_API GT_SetLaserMode(short cardNum, short mode);
GT_API GT_ZeroLaserOnTime(short cardNum, short channel);
GT_API GT_GetLaserOnTime(short cardNum, short channel, unsigned long *time);
GT_API GT_SetLaserCrdMap(short cardNum, short channel, short map);
GT_API GT_GetLaserCrdMap(short cardNum, short channel, short *map);
GT_API GT_GetLaserPower(short cardNum, short channel, double *power);
GT_API GT_GetLaserFault(short cardNum, short channel, short *cause);
GT_API GT_ClrLaserFault(short cardNum, short channel);

/* Coordinate systems */
GT_API GT_SetCrdPrm(short cardNum, short crd, TCrdPrm *crdPrm);
GT_API GT_GetCrdPrm(short cardNum, short crd, TCrdPrm *crdPrm);
GT_API GT_CrdClear(short cardNum, short crd, short fifo GT_DEFAULT(0));
GT_API GT_CrdSpace(short cardNum, short crd, long *space, short fifo GT_DEFAULT(0));
GT_API GT_CrdStart(short cardNum, short mask, short option GT_DEFAULT(0));
GT_API GT_CrdStop(short cardNum, long mask, long option GT_DEFAULT(0));
GT_API GT_CrdStatus(short cardNum, short crd, short *run, long *segment, short fifo GT_DEFAULT(0));
GT_API GT_GetCrdPos(short cardNum, short crd, double *pos);
GT_API GT_GetCrdVel(short cardNum, short crd, double *synVel);
GT_API GT_GetRemainderSegNum(short cardNum, short crd, long *segment, short fifo GT_DEFAULT(0));
GT_API GT_SetCrdStopDec(short cardNum, short crd, double decSmoothStop, double decAbruptStop);
GT_API GT_SetOverride(short cardNum, short crd, double synVelRatio);
GT_API GT_InitLookAhead(short cardNum, short crd, short fifo, double T, double accMax, short n, TCrdData *lookAheadBuf GT_DEFAULT(NULL));
GT_API GT_SetCrdLimit(short cardNum, short crd, short coordinate, double velMax, double accMax);
GT_API GT_GetCrdLimit(short cardNum, short crd, short coordinate, double *velMax, double *accMax);
GT_API GT_CrdData(short cardNum, short crd, TCrdData *crdData, short fifo GT_DEFAULT(0));
GT_API GT_LnXY(short cardNum, short crd, long x, long y, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_LnXYZ(short cardNum, short crd, long x, long y, long z, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_LnXYZA(short cardNum, short crd, long x, long y, long z, long a, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_LnXYG0(short cardNum, short crd, long x, long y, double synVel, double synAcc, short fifo GT_DEFAULT(0));
GT_API GT_ArcXYR(short cardNum, short crd, long x, long y, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcXYC(short cardNum, short crd, long x, long y, double xCenter, double yCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcYZR(short cardNum, short crd, long y, long z, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcYZC(short cardNum, short crd, long y, long z, double yCenter, double zCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcZXR(short cardNum, short crd, long z, long x, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcZXC(short cardNum, short crd, long z, long x, double zCenter, double xCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_BufDelay(short cardNum, short crd, unsigned short delayTime, short fifo GT_DEFAULT(0));
GT_API GT_BufIO(short cardNum, short crd, unsigned short doType, unsigned short doMask, unsigned short doValue, short fifo GT_DEFAULT(0));
GT_API GT_BufDoBit(short cardNum, short crd, unsigned short doType, unsigned short index, short value, short fifo GT_DEFAULT(0));
GT_API GT_BufDA(short cardNum, short crd, short chn, short daValue, short fifo GT_DEFAULT(0));
GT_API GT_BufMove(short cardNum, short crd, short moveAxis, long pos, double vel, double acc, short modal, short fifo GT_DEFAULT(0));
GT_API GT_BufGear(short cardNum, short crd, short gearAxis, long pos, short fifo GT_DEFAULT(0));

/* Buffered laser commands */
GT_API GT_BufLaserOn(short cardNum, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserOff(short cardNum, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserPrfCmd(short cardNum, short crd, double laserPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserPrfFollow(short cardNum, short crd, double ratio, long minPower, long maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserFollowMode(short cardNum, short crd, short source GT_DEFAULT(0), short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0), double startPower GT_DEFAULT(GT_NOT_GIVEN));
GT_API GT_BufLaserFollowRatio(short cardNum, short crd, double ratio, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserFollowTable(short cardNum, short crd, short tableId, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserFollowOff(short cardNum, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_SetLaserFollowTable(short cardNum, short tableId, long count, double *vel, double *power, short channel GT_DEFAULT(0));

/* Laser power by distance */
GT_API GT_SetLaserDisMode(short cardNum, short mode, short source, long *pos GT_DEFAULT(NULL), double *scale GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
GT_API GT_SetLaserDisRatio(short cardNum, double *ratio, double minPower, double maxPower, short channel GT_DEFAULT(0));
#ifdef __cplusplus
static inline short GT_SetLaserDisRatio(short cardNum, double *ratio, short channel = 0)
{
    return GT_SetLaserDisRatio(cardNum, ratio, GT_NOT_GIVEN, GT_NOT_GIVEN, channel);
}
#endif
GT_API GT_SetLaserDisTable1D(short cardNum, short count, double *ratio, long *pos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
GT_API GT_SetLaserDisTable2D(short cardNum, short *axisIndex, short *count, double *ratio, long *xPos, long *yPos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));

/* PT */
GT_API GT_PrfPt(short cardNum, short profile, short mode GT_DEFAULT(0));
GT_API GT_PtSpace(short cardNum, short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GT_PtData(short cardNum, short profile, double pos, long time, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_PtClear(short cardNum, short profile, short fifo GT_DEFAULT(0));
GT_API GT_SetPtLoop(short cardNum, short profile, long loop);
GT_API GT_GetPtLoop(short cardNum, short profile, long *loop);
GT_API GT_SetPtMemory(short cardNum, short profile, short memory);
GT_API GT_GetPtMemory(short cardNum, short profile, short *memory);
GT_API GT_PtStart(short cardNum, long mask, long option GT_DEFAULT(0));
GT_API GT_PtStartPro(short cardNum, short *axis, short *option, short count);

/* PVT */
GT_API GT_PrfPvt(short cardNum, short profile);
GT_API GT_SetPvtLoop(short cardNum, short profile, long loop);
GT_API GT_GetPvtLoop(short cardNum, short profile, long *loopCount, long *loop);
GT_API GT_PvtStatus(short cardNum, short profile, short *tableId, double *time, short count GT_DEFAULT(1));
GT_API GT_PvtStart(short cardNum, long mask);
GT_API GT_PvtTableSelect(short cardNum, short profile, short tableId);
GT_API GT_PvtTable(short cardNum, short tableId, long count, double *time, double *pos, double *vel);
GT_API GT_PvtTableEx(short cardNum, short tableId, long count, double *time, double *pos, double *velBegin, double *velEnd);
GT_API GT_PvtTableComplete(short cardNum, short tableId, long count, double *time, double *pos, double *a, double *b, double *c, double velBegin GT_DEFAULT(0), double velEnd GT_DEFAULT(0));
GT_API GT_PvtTablePercent(short cardNum, short tableId, long count, double *time, double *pos, double *percent, double velBegin GT_DEFAULT(0));
GT_API GT_PvtPercentCalculate(short cardNum, long count, double *time, double *pos, double *percent, double velBegin, double *vel);
GT_API GT_PvtTableContinuous(short cardNum, short tableId, long count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double timeBegin);
GT_API GT_PvtContinuousCalculate(short cardNum, long count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double *time);

/* Follow */
GT_API GT_PrfFollow(short cardNum, short profile, short dir GT_DEFAULT(0));
GT_API GT_SetFollowMaster(short cardNum, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
GT_API GT_GetFollowMaster(short cardNum, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
GT_API GT_SetFollowLoop(short cardNum, short profile, long loop);
GT_API GT_GetFollowLoop(short cardNum, short profile, long *loop);
GT_API GT_SetFollowEvent(short cardNum, short profile, short event, short masterDir, long pos GT_DEFAULT(0));
GT_API GT_GetFollowEvent(short cardNum, short profile, short *event, short *masterDir, long *pos);
GT_API GT_FollowSpace(short cardNum, short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GT_FollowData(short cardNum, short profile, long masterSegment, double slaveSegment, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_FollowClear(short cardNum, short profile, short fifo GT_DEFAULT(0));
GT_API GT_FollowStart(short cardNum, long mask, long option GT_DEFAULT(0));
GT_API GT_FollowSwitch(short cardNum, long mask);
GT_API GT_SetFollowMemory(short cardNum, short profile, short memory);
GT_API GT_GetFollowMemory(short cardNum, short profile, short *memory);
GT_API GT_GetFollowStatus(short cardNum, short profile, short *fifoNum, short *switchStatus);

/* FollowEx */
GT_API GT_PrfFollowEx(short cardNum, short profile, short dir GT_DEFAULT(0));
GT_API GT_SetFollowMasterEx(short cardNum, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
GT_API GT_GetFollowMasterEx(short cardNum, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
GT_API GT_SetFollowLoopEx(short cardNum, short profile, long loop);
GT_API GT_GetFollowLoopEx(short cardNum, short profile, long *loop);
GT_API GT_SetFollowEventEx(short cardNum, short profile, short event, short masterDir, long pos GT_DEFAULT(0));
GT_API GT_GetFollowEventEx(short cardNum, short profile, short *event, short *masterDir, long *pos);
GT_API GT_FollowSpaceEx(short cardNum, short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GT_FollowDataPercentEx(short cardNum, short profile, double masterSegment, double slaveSegment, short type GT_DEFAULT(0), short percent GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_FollowClearEx(short cardNum, short profile, short fifo GT_DEFAULT(0));
GT_API GT_FollowStartEx(short cardNum, long mask, long option GT_DEFAULT(0));
GT_API GT_FollowSwitchEx(short cardNum, long mask);
GT_API GT_SetFollowMemoryEx(short cardNum, short profile, short memory);
GT_API GT_GetFollowMemoryEx(short cardNum, short profile, short *memory);
GT_API GT_GetFollowStatusEx(short cardNum, short profile, short *fifoNum, short *switchStatus);
GT_API GT_FollowSwitchNowEx(short cardNum, short profile, short method, short buffer GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_FollowDoBitEx(short cardNum, short profile, short doType, short index, short value, short fifo GT_DEFAULT(0));
GT_API GT_FollowDelayEx(short cardNum, short profile, unsigned long delayTime, short fifo GT_DEFAULT(0));
GT_API GT_FollowDiBitEx(short cardNum, short profile, short diType, short index, short value, unsigned long time GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_FollowDataPercent2Ex(short cardNum, short profile, double masterSegment, double slaveSegment, double velBeginRatio, double velEndRatio, short percent GT_DEFAULT(100), short *percent1 GT_DEFAULT(NULL), short fifo GT_DEFAULT(0));
GT_API GT_GetFollowDataPercent2Ex(short cardNum, double masterPos, double v1, double v2, double p, double p1, double *slavePos);

#endif
