/* gts.h: one card, as GT_x(...) for its first core and GTN_x(core, ...).
 * Generated from the table of functions by `cargo xtask c-api`: change that, not this.
 * docs/c.md says what the library does; return values are those of the manuals. */
#ifndef BEAMTICK_GTS_H
#define BEAMTICK_GTS_H

#ifdef BEAMTICK_GTS_CARDS_H
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

/* ---- GT_: the first core of the card ------------------------------------------------------ */

/* Session */
GT_API GT_Open(short channel GT_DEFAULT(0), short param GT_DEFAULT(1));
GT_API GT_Close(void);
GT_API GT_GetLastReason(char *text, short size);
GT_API GT_Reset(void);
GT_API GT_LoadConfig(const char *file);
GT_API GT_ClrSts(short axis, short count GT_DEFAULT(1));
GT_API GT_GetVersion(char **version);
GT_API GT_GetClock(unsigned long *clock, unsigned long *loop GT_DEFAULT(NULL));
GT_API GT_SetTick(long tickUs);
GT_API GT_SetLinkLoss(long timeMs, short stopAll);

/* Axes */
GT_API GT_AxisOn(short axis);
GT_API GT_AxisOff(short axis);
GT_API GT_Stop(long mask, long option);
GT_API GT_ZeroPos(short axis, short count GT_DEFAULT(1));
GT_API GT_SetPrfPos(short profile, long pos);
GT_API GT_SynchAxisPos(long mask);
GT_API GT_SetStopDec(short profile, double decSmoothStop, double decAbruptStop);
GT_API GT_GetStopDec(short profile, double *decSmoothStop, double *decAbruptStop);
GT_API GT_SetAxisBand(short axis, long band, long time);
GT_API GT_GetAxisBand(short axis, long *band, long *time);
GT_API GT_GetSts(short axis, long *sts, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetPrfPos(short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetPrfVel(short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetPrfAcc(short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetPrfMode(short profile, long *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetEncPos(short encoder, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_GetEncVel(short encoder, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GT_SetEncPos(short encoder, long pos);
GT_API GT_SetSoftLimit(short axis, long positive, long negative);
GT_API GT_GetSoftLimit(short axis, long *positive, long *negative);
GT_API GT_LmtsOn(short axis, short limitType GT_DEFAULT(-1));
GT_API GT_LmtsOff(short axis, short limitType GT_DEFAULT(-1));
GT_API GT_LmtSns(unsigned short sense);
GT_API GT_AlarmOn(short axis);
GT_API GT_AlarmOff(short axis);
GT_API GT_SetPosErr(short control, long error);
GT_API GT_GetPosErr(short control, long *error);
GT_API GT_SetCaptureMode(short encoder, short mode);
GT_API GT_GetCaptureStatus(short encoder, short *status, long *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));

/* Trap and Jog */
GT_API GT_PrfTrap(short profile);
GT_API GT_SetTrapPrm(short profile, TTrapPrm *prm);
GT_API GT_GetTrapPrm(short profile, TTrapPrm *prm);
GT_API GT_PrfJog(short profile);
GT_API GT_SetJogPrm(short profile, TJogPrm *prm);
GT_API GT_GetJogPrm(short profile, TJogPrm *prm);
GT_API GT_SetPos(short profile, long pos);
GT_API GT_GetPos(short profile, long *pos);
GT_API GT_SetVel(short profile, double vel);
GT_API GT_GetVel(short profile, double *vel);
GT_API GT_Update(long mask);

/* Digital and analog inputs and outputs */
GT_API GT_GetDi(short diType, long *value);
GT_API GT_SetDo(short doType, long value);
GT_API GT_GetDo(short doType, long *value);
GT_API GT_SetDoBit(short doType, short index, short value);
GT_API GT_SetDac(short dac, short *value, short count GT_DEFAULT(1));
GT_API GT_GetDac(short dac, short *value, short count GT_DEFAULT(1));
GT_API GT_GetAdc(short adc, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));

/* Laser */
GT_API GT_SetAxisMode(short axis, short mode);
GT_API GT_LaserOn(short channel GT_DEFAULT(0));
GT_API GT_LaserOff(short channel GT_DEFAULT(0));
GT_API GT_LaserOnStatus(short *value, short channel GT_DEFAULT(0));
GT_API GT_SetHSIOOpt(unsigned short value, short channel GT_DEFAULT(0));
GT_API GT_GetHSIOOpt(unsigned short *value, short channel GT_DEFAULT(0));
GT_API GT_LaserPowerMode(short laserPowerMode, double maxValue, double minValue, short channel GT_DEFAULT(0), short delaymode GT_DEFAULT(0));
GT_API GT_LaserPrfCmd(double outputCmd, short channel GT_DEFAULT(0));
GT_API GT_LaserOutFrq(double outFrq, short channel GT_DEFAULT(0));
GT_API GT_SetPulseWidth(unsigned long width, short channel GT_DEFAULT(0));
GT_API GT_SetWaitPulse(unsigned short mode, double waitPulseFrq, double waitPulseDuty, short channel GT_DEFAULT(0));
GT_API GT_SetWaitPulseEx(unsigned short mode, double waitPulseFrq, double waitPulseDuty);
GT_API GT_SetPreVltg(unsigned short mode, double voltageValue, short channel GT_DEFAULT(0));
GT_API GT_SetLevelDelay(unsigned short offDelay, unsigned short onDelay, short channel GT_DEFAULT(0));
GT_API GT_EnaFPK(unsigned short time1, unsigned short time2, unsigned short laserOffDelay, short channel GT_DEFAULT(0));
GT_API GT_DisFPK(short channel GT_DEFAULT(0));
GT_API GT_SetLaserMode(short mode);
GT_API GT_ZeroLaserOnTime(short channel);
GT_API GT_GetLaserOnTime(short channel, unsigned long *time);
GT_API GT_SetLaserCrdMap(short channel, short map);
GT_API GT_GetLaserCrdMap(short channel, short *map);
GT_API GT_GetLaserPower(short channel, double *power);
GT_API GT_GetLaserFault(short channel, short *cause);
GT_API GT_ClrLaserFault(short channel);

/* Coordinate systems */
GT_API GT_SetCrdPrm(short crd, TCrdPrm *crdPrm);
GT_API GT_GetCrdPrm(short crd, TCrdPrm *crdPrm);
GT_API GT_CrdClear(short crd, short fifo GT_DEFAULT(0));
GT_API GT_CrdSpace(short crd, long *space, short fifo GT_DEFAULT(0));
GT_API GT_CrdStart(short mask, short option GT_DEFAULT(0));
GT_API GT_CrdStop(long mask, long option GT_DEFAULT(0));
GT_API GT_CrdStatus(short crd, short *run, long *segment, short fifo GT_DEFAULT(0));
GT_API GT_GetCrdPos(short crd, double *pos);
GT_API GT_GetCrdVel(short crd, double *synVel);
GT_API GT_GetRemainderSegNum(short crd, long *segment, short fifo GT_DEFAULT(0));
GT_API GT_SetCrdStopDec(short crd, double decSmoothStop, double decAbruptStop);
GT_API GT_SetOverride(short crd, double synVelRatio);
GT_API GT_InitLookAhead(short crd, short fifo, double T, double accMax, short n, TCrdData *lookAheadBuf GT_DEFAULT(NULL));
GT_API GT_SetCrdLimit(short crd, short coordinate, double velMax, double accMax);
GT_API GT_GetCrdLimit(short crd, short coordinate, double *velMax, double *accMax);
GT_API GT_CrdData(short crd, TCrdData *crdData, short fifo GT_DEFAULT(0));
GT_API GT_LnXY(short crd, long x, long y, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_LnXYZ(short crd, long x, long y, long z, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_LnXYZA(short crd, long x, long y, long z, long a, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_LnXYG0(short crd, long x, long y, double synVel, double synAcc, short fifo GT_DEFAULT(0));
GT_API GT_ArcXYR(short crd, long x, long y, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcXYC(short crd, long x, long y, double xCenter, double yCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcYZR(short crd, long y, long z, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcYZC(short crd, long y, long z, double yCenter, double zCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcZXR(short crd, long z, long x, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_ArcZXC(short crd, long z, long x, double zCenter, double xCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_BufDelay(short crd, unsigned short delayTime, short fifo GT_DEFAULT(0));
GT_API GT_BufIO(short crd, unsigned short doType, unsigned short doMask, unsigned short doValue, short fifo GT_DEFAULT(0));
GT_API GT_BufDoBit(short crd, unsigned short doType, unsigned short index, short value, short fifo GT_DEFAULT(0));
GT_API GT_BufDA(short crd, short chn, short daValue, short fifo GT_DEFAULT(0));
GT_API GT_BufMove(short crd, short moveAxis, long pos, double vel, double acc, short modal, short fifo GT_DEFAULT(0));
GT_API GT_BufGear(short crd, short gearAxis, long pos, short fifo GT_DEFAULT(0));

/* Buffered laser commands */
GT_API GT_BufLaserOn(short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserOff(short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserPrfCmd(short crd, double laserPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserPrfFollow(short crd, double ratio, long minPower, long maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserFollowMode(short crd, short source GT_DEFAULT(0), short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0), double startPower GT_DEFAULT(GT_NOT_GIVEN));
GT_API GT_BufLaserFollowRatio(short crd, double ratio, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserFollowTable(short crd, short tableId, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_BufLaserFollowOff(short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GT_SetLaserFollowTable(short tableId, long count, double *vel, double *power, short channel GT_DEFAULT(0));

/* Laser power by distance */
GT_API GT_SetLaserDisMode(short mode, short source, long *pos GT_DEFAULT(NULL), double *scale GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
GT_API GT_SetLaserDisRatio(double *ratio, double minPower, double maxPower, short channel GT_DEFAULT(0));
#ifdef __cplusplus
static inline short GT_SetLaserDisRatio(double *ratio, short channel = 0)
{
    return GT_SetLaserDisRatio(ratio, GT_NOT_GIVEN, GT_NOT_GIVEN, channel);
}
#endif
GT_API GT_SetLaserDisTable1D(short count, double *ratio, long *pos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
GT_API GT_SetLaserDisTable2D(short *axisIndex, short *count, double *ratio, long *xPos, long *yPos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));

/* PT */
GT_API GT_PrfPt(short profile, short mode GT_DEFAULT(0));
GT_API GT_PtSpace(short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GT_PtData(short profile, double pos, long time, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_PtClear(short profile, short fifo GT_DEFAULT(0));
GT_API GT_SetPtLoop(short profile, long loop);
GT_API GT_GetPtLoop(short profile, long *loop);
GT_API GT_SetPtMemory(short profile, short memory);
GT_API GT_GetPtMemory(short profile, short *memory);
GT_API GT_PtStart(long mask, long option GT_DEFAULT(0));
GT_API GT_PtStartPro(short *axis, short *option, short count);

/* PVT */
GT_API GT_PrfPvt(short profile);
GT_API GT_SetPvtLoop(short profile, long loop);
GT_API GT_GetPvtLoop(short profile, long *loopCount, long *loop);
GT_API GT_PvtStatus(short profile, short *tableId, double *time, short count GT_DEFAULT(1));
GT_API GT_PvtStart(long mask);
GT_API GT_PvtTableSelect(short profile, short tableId);
GT_API GT_PvtTable(short tableId, long count, double *time, double *pos, double *vel);
GT_API GT_PvtTableEx(short tableId, long count, double *time, double *pos, double *velBegin, double *velEnd);
GT_API GT_PvtTableComplete(short tableId, long count, double *time, double *pos, double *a, double *b, double *c, double velBegin GT_DEFAULT(0), double velEnd GT_DEFAULT(0));
GT_API GT_PvtTablePercent(short tableId, long count, double *time, double *pos, double *percent, double velBegin GT_DEFAULT(0));
GT_API GT_PvtPercentCalculate(long count, double *time, double *pos, double *percent, double velBegin, double *vel);
GT_API GT_PvtTableContinuous(short tableId, long count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double timeBegin);
GT_API GT_PvtContinuousCalculate(long count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double *time);

/* Follow */
GT_API GT_PrfFollow(short profile, short dir GT_DEFAULT(0));
GT_API GT_SetFollowMaster(short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
GT_API GT_GetFollowMaster(short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
GT_API GT_SetFollowLoop(short profile, long loop);
GT_API GT_GetFollowLoop(short profile, long *loop);
GT_API GT_SetFollowEvent(short profile, short event, short masterDir, long pos GT_DEFAULT(0));
GT_API GT_GetFollowEvent(short profile, short *event, short *masterDir, long *pos);
GT_API GT_FollowSpace(short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GT_FollowData(short profile, long masterSegment, double slaveSegment, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_FollowClear(short profile, short fifo GT_DEFAULT(0));
GT_API GT_FollowStart(long mask, long option GT_DEFAULT(0));
GT_API GT_FollowSwitch(long mask);
GT_API GT_SetFollowMemory(short profile, short memory);
GT_API GT_GetFollowMemory(short profile, short *memory);
GT_API GT_GetFollowStatus(short profile, short *fifoNum, short *switchStatus);

/* FollowEx */
GT_API GT_PrfFollowEx(short profile, short dir GT_DEFAULT(0));
GT_API GT_SetFollowMasterEx(short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
GT_API GT_GetFollowMasterEx(short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
GT_API GT_SetFollowLoopEx(short profile, long loop);
GT_API GT_GetFollowLoopEx(short profile, long *loop);
GT_API GT_SetFollowEventEx(short profile, short event, short masterDir, long pos GT_DEFAULT(0));
GT_API GT_GetFollowEventEx(short profile, short *event, short *masterDir, long *pos);
GT_API GT_FollowSpaceEx(short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GT_FollowDataPercentEx(short profile, double masterSegment, double slaveSegment, short type GT_DEFAULT(0), short percent GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_FollowClearEx(short profile, short fifo GT_DEFAULT(0));
GT_API GT_FollowStartEx(long mask, long option GT_DEFAULT(0));
GT_API GT_FollowSwitchEx(long mask);
GT_API GT_SetFollowMemoryEx(short profile, short memory);
GT_API GT_GetFollowMemoryEx(short profile, short *memory);
GT_API GT_GetFollowStatusEx(short profile, short *fifoNum, short *switchStatus);
GT_API GT_FollowSwitchNowEx(short profile, short method, short buffer GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_FollowDoBitEx(short profile, short doType, short index, short value, short fifo GT_DEFAULT(0));
GT_API GT_FollowDelayEx(short profile, unsigned long delayTime, short fifo GT_DEFAULT(0));
GT_API GT_FollowDiBitEx(short profile, short diType, short index, short value, unsigned long time GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GT_FollowDataPercent2Ex(short profile, double masterSegment, double slaveSegment, double velBeginRatio, double velEndRatio, short percent GT_DEFAULT(100), short *percent1 GT_DEFAULT(NULL), short fifo GT_DEFAULT(0));
GT_API GT_GetFollowDataPercent2Ex(double masterPos, double v1, double v2, double p, double p1, double *slavePos);

/* ---- GTN_: the core comes first ----------------------------------------------------------- */

/* Session */
GT_API GTN_Open(short channel GT_DEFAULT(0), short param GT_DEFAULT(1));
GT_API GTN_Close(void);
GT_API GTN_GetLastReason(short core, char *text, short size);
GT_API GTN_Reset(short core);
GT_API GTN_LoadConfig(short core, const char *file);
GT_API GTN_ClrSts(short core, short axis, short count GT_DEFAULT(1));
GT_API GTN_GetVersion(short core, char **version);
GT_API GTN_GetClock(short core, unsigned long *clock, unsigned long *loop GT_DEFAULT(NULL));
GT_API GTN_SetTick(short core, long tickUs);
GT_API GTN_SetLinkLoss(short core, long timeMs, short stopAll);

/* Axes */
GT_API GTN_AxisOn(short core, short axis);
GT_API GTN_AxisOff(short core, short axis);
GT_API GTN_Stop(short core, long mask, long option);
GT_API GTN_ZeroPos(short core, short axis, short count GT_DEFAULT(1));
GT_API GTN_SetPrfPos(short core, short profile, long pos);
GT_API GTN_SynchAxisPos(short core, long mask);
GT_API GTN_SetStopDec(short core, short profile, double decSmoothStop, double decAbruptStop);
GT_API GTN_GetStopDec(short core, short profile, double *decSmoothStop, double *decAbruptStop);
GT_API GTN_SetAxisBand(short core, short axis, long band, long time);
GT_API GTN_GetAxisBand(short core, short axis, long *band, long *time);
GT_API GTN_GetSts(short core, short axis, long *sts, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GTN_GetPrfPos(short core, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GTN_GetPrfVel(short core, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GTN_GetPrfAcc(short core, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GTN_GetPrfMode(short core, short profile, long *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GTN_GetEncPos(short core, short encoder, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GTN_GetEncVel(short core, short encoder, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
GT_API GTN_SetEncPos(short core, short encoder, long pos);
GT_API GTN_SetSoftLimit(short core, short axis, long positive, long negative);
GT_API GTN_GetSoftLimit(short core, short axis, long *positive, long *negative);
GT_API GTN_LmtsOn(short core, short axis, short limitType GT_DEFAULT(-1));
GT_API GTN_LmtsOff(short core, short axis, short limitType GT_DEFAULT(-1));
GT_API GTN_LmtSns(short core, unsigned short sense);
GT_API GTN_AlarmOn(short core, short axis);
GT_API GTN_AlarmOff(short core, short axis);
GT_API GTN_SetPosErr(short core, short control, long error);
GT_API GTN_GetPosErr(short core, short control, long *error);
GT_API GTN_SetCaptureMode(short core, short encoder, short mode);
GT_API GTN_GetCaptureStatus(short core, short encoder, short *status, long *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));

/* Trap and Jog */
GT_API GTN_PrfTrap(short core, short profile);
GT_API GTN_SetTrapPrm(short core, short profile, TTrapPrm *prm);
GT_API GTN_GetTrapPrm(short core, short profile, TTrapPrm *prm);
GT_API GTN_PrfJog(short core, short profile);
GT_API GTN_SetJogPrm(short core, short profile, TJogPrm *prm);
GT_API GTN_GetJogPrm(short core, short profile, TJogPrm *prm);
GT_API GTN_SetPos(short core, short profile, long pos);
GT_API GTN_GetPos(short core, short profile, long *pos);
GT_API GTN_SetVel(short core, short profile, double vel);
GT_API GTN_GetVel(short core, short profile, double *vel);
GT_API GTN_Update(short core, long mask);

/* Digital and analog inputs and outputs */
GT_API GTN_GetDi(short core, short diType, long *value);
GT_API GTN_SetDo(short core, short doType, long value);
GT_API GTN_GetDo(short core, short doType, long *value);
GT_API GTN_SetDoBit(short core, short doType, short index, short value);
GT_API GTN_SetDac(short core, short dac, short *value, short count GT_DEFAULT(1));
GT_API GTN_GetDac(short core, short dac, short *value, short count GT_DEFAULT(1));
GT_API GTN_GetAdc(short core, short adc, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));

/* Laser */
GT_API GTN_SetAxisMode(short core, short axis, short mode);
GT_API GTN_LaserOn(short core, short channel GT_DEFAULT(0));
GT_API GTN_LaserOff(short core, short channel GT_DEFAULT(0));
GT_API GTN_LaserOnStatus(short core, short *value, short channel GT_DEFAULT(0));
GT_API GTN_SetHSIOOpt(short core, unsigned short value, short channel GT_DEFAULT(0));
GT_API GTN_GetHSIOOpt(short core, unsigned short *value, short channel GT_DEFAULT(0));
GT_API GTN_LaserPowerMode(short core, short laserPowerMode, double maxValue, double minValue, short channel GT_DEFAULT(0));
GT_API GTN_LaserPrfCmd(short core, double outputCmd, short channel GT_DEFAULT(0));
GT_API GTN_LaserOutFrq(short core, double outFrq, short channel GT_DEFAULT(0));
GT_API GTN_SetPulseWidth(short core, unsigned short width, short channel GT_DEFAULT(0));
GT_API GTN_SetWaitPulse(short core, unsigned short mode, double waitPulseFrq, double waitPulseDuty, short channel GT_DEFAULT(0));
GT_API GTN_SetWaitPulseEx(short core, unsigned short mode, double waitPulseFrq, double waitPulseDuty);
GT_API GTN_SetPreVltg(short core, unsigned short mode, double voltageValue, short channel GT_DEFAULT(0));
GT_API GTN_SetLevelDelay(short core, unsigned long offDelay, unsigned long onDelay, short channel GT_DEFAULT(0));
GT_API GTN_EnaFPK(short core, unsigned short time1, unsigned short time2, unsigned short laserOffDelay, short channel GT_DEFAULT(0));
GT_API GTN_DisFPK(short core, short channel GT_DEFAULT(0));
GT_API GTN_SetLaserMode(short core, short mode);
GT_API GTN_ZeroLaserOnTime(short core, short channel);
GT_API GTN_GetLaserOnTime(short core, short channel, unsigned long *time);
GT_API GTN_SetLaserCrdMap(short core, short channel, short map);
GT_API GTN_GetLaserCrdMap(short core, short channel, short *map);
GT_API GTN_GetLaserPower(short core, short channel, double *power);
GT_API GTN_GetLaserFault(short core, short channel, short *cause);
GT_API GTN_ClrLaserFault(short core, short channel);

/* Coordinate systems */
GT_API GTN_SetCrdPrm(short core, short crd, TCrdPrm *crdPrm);
GT_API GTN_GetCrdPrm(short core, short crd, TCrdPrm *crdPrm);
GT_API GTN_CrdClear(short core, short crd, short fifo GT_DEFAULT(0));
GT_API GTN_CrdSpace(short core, short crd, long *space, short fifo GT_DEFAULT(0));
GT_API GTN_CrdStart(short core, short mask, short option GT_DEFAULT(0));
GT_API GTN_CrdStop(short core, long mask, long option GT_DEFAULT(0));
GT_API GTN_CrdStatus(short core, short crd, short *run, long *segment, short fifo GT_DEFAULT(0));
GT_API GTN_GetCrdPos(short core, short crd, double *pos);
GT_API GTN_GetCrdVel(short core, short crd, double *synVel);
GT_API GTN_GetRemainderSegNum(short core, short crd, long *segment, short fifo GT_DEFAULT(0));
GT_API GTN_SetCrdStopDec(short core, short crd, double decSmoothStop, double decAbruptStop);
GT_API GTN_SetOverride(short core, short crd, double synVelRatio);
GT_API GTN_InitLookAhead(short core, short crd, short fifo, double T, double accMax, short n, TCrdData *lookAheadBuf GT_DEFAULT(NULL));
GT_API GTN_SetCrdLimit(short core, short crd, short coordinate, double velMax, double accMax);
GT_API GTN_GetCrdLimit(short core, short crd, short coordinate, double *velMax, double *accMax);
GT_API GTN_CrdData(short core, short crd, TCrdData *crdData, short fifo GT_DEFAULT(0));
GT_API GTN_LnXY(short core, short crd, long x, long y, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_LnXYZ(short core, short crd, long x, long y, long z, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_LnXYZA(short core, short crd, long x, long y, long z, long a, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_LnXYG0(short core, short crd, long x, long y, double synVel, double synAcc, short fifo GT_DEFAULT(0));
GT_API GTN_ArcXYR(short core, short crd, long x, long y, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_ArcXYC(short core, short crd, long x, long y, double xCenter, double yCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_ArcYZR(short core, short crd, long y, long z, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_ArcYZC(short core, short crd, long y, long z, double yCenter, double zCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_ArcZXR(short core, short crd, long z, long x, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_ArcZXC(short core, short crd, long z, long x, double zCenter, double xCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_BufDelay(short core, short crd, unsigned short delayTime, short fifo GT_DEFAULT(0));
GT_API GTN_BufIO(short core, short crd, unsigned short doType, unsigned short doMask, unsigned short doValue, short fifo GT_DEFAULT(0));
GT_API GTN_BufDoBit(short core, short crd, unsigned short doType, unsigned short index, short value, short fifo GT_DEFAULT(0));
GT_API GTN_BufDA(short core, short crd, short chn, short daValue, short fifo GT_DEFAULT(0));
GT_API GTN_BufMove(short core, short crd, short moveAxis, long pos, double vel, double acc, short modal, short fifo GT_DEFAULT(0));
GT_API GTN_BufGear(short core, short crd, short gearAxis, long pos, short fifo GT_DEFAULT(0));

/* Buffered laser commands */
GT_API GTN_BufLaserOn(short core, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GTN_BufLaserOff(short core, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GTN_BufLaserPrfCmd(short core, short crd, double laserPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GTN_BufLaserPrfFollow(short core, short crd, double ratio, long minPower, long maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GTN_BufLaserFollowMode(short core, short crd, short source GT_DEFAULT(0), short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0), double startPower GT_DEFAULT(GT_NOT_GIVEN));
GT_API GTN_BufLaserFollowRatio(short core, short crd, double ratio, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GTN_BufLaserFollowTable(short core, short crd, short tableId, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GTN_BufLaserFollowOff(short core, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
GT_API GTN_SetLaserFollowTable(short core, short tableId, long count, double *vel, double *power, short channel GT_DEFAULT(0));

/* Laser power by distance */
GT_API GTN_SetLaserDisMode(short core, short mode, short source, long *pos GT_DEFAULT(NULL), double *scale GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
GT_API GTN_SetLaserDisRatio(short core, double *ratio, double minPower, double maxPower, short channel GT_DEFAULT(0));
#ifdef __cplusplus
static inline short GTN_SetLaserDisRatio(short core, double *ratio, short channel = 0)
{
    return GTN_SetLaserDisRatio(core, ratio, GT_NOT_GIVEN, GT_NOT_GIVEN, channel);
}
#endif
GT_API GTN_SetLaserDisTable1D(short core, short count, double *ratio, long *pos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
GT_API GTN_SetLaserDisTable2D(short core, short *axisIndex, short *count, double *ratio, long *xPos, long *yPos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));

/* PT */
GT_API GTN_PrfPt(short core, short profile, short mode GT_DEFAULT(0));
GT_API GTN_PtSpace(short core, short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GTN_PtData(short core, short profile, double pos, long time, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_PtClear(short core, short profile, short fifo GT_DEFAULT(0));
GT_API GTN_SetPtLoop(short core, short profile, long loop);
GT_API GTN_GetPtLoop(short core, short profile, long *loop);
GT_API GTN_SetPtMemory(short core, short profile, short memory);
GT_API GTN_GetPtMemory(short core, short profile, short *memory);
GT_API GTN_PtStart(short core, long mask, long option GT_DEFAULT(0));
GT_API GTN_PtStartPro(short core, short *axis, short *option, short count);

/* PVT */
GT_API GTN_PrfPvt(short core, short profile);
GT_API GTN_SetPvtLoop(short core, short profile, long loop);
GT_API GTN_GetPvtLoop(short core, short profile, long *loopCount, long *loop);
GT_API GTN_PvtStatus(short core, short profile, short *tableId, double *time, short count GT_DEFAULT(1));
GT_API GTN_PvtStart(short core, long mask);
GT_API GTN_PvtTableSelect(short core, short profile, short tableId);
GT_API GTN_PvtTable(short core, short tableId, long count, double *time, double *pos, double *vel);
GT_API GTN_PvtTableEx(short core, short tableId, long count, double *time, double *pos, double *velBegin, double *velEnd);
GT_API GTN_PvtTableComplete(short core, short tableId, long count, double *time, double *pos, double *a, double *b, double *c, double velBegin GT_DEFAULT(0), double velEnd GT_DEFAULT(0));
GT_API GTN_PvtTablePercent(short core, short tableId, long count, double *time, double *pos, double *percent, double velBegin GT_DEFAULT(0));
GT_API GTN_PvtPercentCalculate(short core, long count, double *time, double *pos, double *percent, double velBegin, double *vel);
GT_API GTN_PvtTableContinuous(short core, short tableId, long count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double timeBegin);
GT_API GTN_PvtContinuousCalculate(short core, long count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double *time);

/* Follow */
GT_API GTN_PrfFollow(short core, short profile, short dir GT_DEFAULT(0));
GT_API GTN_SetFollowMaster(short core, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
GT_API GTN_GetFollowMaster(short core, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
GT_API GTN_SetFollowLoop(short core, short profile, long loop);
GT_API GTN_GetFollowLoop(short core, short profile, long *loop);
GT_API GTN_SetFollowEvent(short core, short profile, short event, short masterDir, long pos GT_DEFAULT(0));
GT_API GTN_GetFollowEvent(short core, short profile, short *event, short *masterDir, long *pos);
GT_API GTN_FollowSpace(short core, short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GTN_FollowData(short core, short profile, long masterSegment, double slaveSegment, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_FollowClear(short core, short profile, short fifo GT_DEFAULT(0));
GT_API GTN_FollowStart(short core, long mask, long option GT_DEFAULT(0));
GT_API GTN_FollowSwitch(short core, long mask);
GT_API GTN_SetFollowMemory(short core, short profile, short memory);
GT_API GTN_GetFollowMemory(short core, short profile, short *memory);
GT_API GTN_GetFollowStatus(short core, short profile, short *fifoNum, short *switchStatus);

/* FollowEx */
GT_API GTN_PrfFollowEx(short core, short profile, short dir GT_DEFAULT(0));
GT_API GTN_SetFollowMasterEx(short core, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
GT_API GTN_GetFollowMasterEx(short core, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
GT_API GTN_SetFollowLoopEx(short core, short profile, long loop);
GT_API GTN_GetFollowLoopEx(short core, short profile, long *loop);
GT_API GTN_SetFollowEventEx(short core, short profile, short event, short masterDir, long pos GT_DEFAULT(0));
GT_API GTN_GetFollowEventEx(short core, short profile, short *event, short *masterDir, long *pos);
GT_API GTN_FollowSpaceEx(short core, short profile, short *space, short fifo GT_DEFAULT(0));
GT_API GTN_FollowDataPercentEx(short core, short profile, double masterSegment, double slaveSegment, short type GT_DEFAULT(0), short percent GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_FollowClearEx(short core, short profile, short fifo GT_DEFAULT(0));
GT_API GTN_FollowStartEx(short core, long mask, long option GT_DEFAULT(0));
GT_API GTN_FollowSwitchEx(short core, long mask);
GT_API GTN_SetFollowMemoryEx(short core, short profile, short memory);
GT_API GTN_GetFollowMemoryEx(short core, short profile, short *memory);
GT_API GTN_GetFollowStatusEx(short core, short profile, short *fifoNum, short *switchStatus);
GT_API GTN_FollowSwitchNowEx(short core, short profile, short method, short buffer GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_FollowDoBitEx(short core, short profile, short doType, short index, short value, short fifo GT_DEFAULT(0));
GT_API GTN_FollowDelayEx(short core, short profile, unsigned long delayTime, short fifo GT_DEFAULT(0));
GT_API GTN_FollowDiBitEx(short core, short profile, short diType, short index, short value, unsigned long time GT_DEFAULT(0), short fifo GT_DEFAULT(0));
GT_API GTN_FollowDataPercent2Ex(short core, short profile, double masterSegment, double slaveSegment, double velBeginRatio, double velEndRatio, short percent GT_DEFAULT(100), short *percent1 GT_DEFAULT(NULL), short fifo GT_DEFAULT(0));
GT_API GTN_GetFollowDataPercent2Ex(short core, double masterPos, double v1, double v2, double p, double p1, double *slavePos);

#endif
