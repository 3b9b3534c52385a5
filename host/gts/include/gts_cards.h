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

typedef struct TPid {
    double kp;
    double ki;
    double kd;
    double kvff;
    double kaff;
    long integralLimit;
    long derivativeLimit;
    short limit;
} TPid;

typedef struct THomePrm {
    short mode;
    short moveDir;
    short indexDir;
    short edge;
    short triggerIndex;
    short pad1[3];
    double velHigh;
    double velLow;
    double acc;
    double dec;
    short smoothTime;
    short pad2[3];
    long homeOffset;
    long searchHomeDistance;
    long searchIndexDistance;
    long escapeStep;
    long pad3[2];
} THomePrm;

typedef struct THomeStatus {
    short run;
    short stage;
    short error;
    short pad1;
    long capturePos;
    long targetPos;
} THomeStatus;

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
#define GEAR_MASTER_ENCODER 1
#define GEAR_MASTER_PROFILE 2
#define GEAR_MASTER_AXIS 3
#define GEAR_MASTER_AU_ENCODER 4
#define GEAR_MASTER_ENCODER_OTHER 101
#define GEAR_MASTER_AXIS_OTHER 103
#define GEAR_EVENT_START 1
#define GEAR_EVENT_PASS 2
#define GEAR_EVENT_AREA 5
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
#define MC_MPG 6
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
#define MC_INTERLOCK 90
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
#define CRD_OPERATION_TYPE_LASER_ON 2
#define CRD_OPERATION_TYPE_LASER_OFF 3
#define CRD_OPERATION_TYPE_LASER_CMD 5
#define CRD_OPERATION_TYPE_LASER_FOLLOW_RATIO 6
#define CRD_OPERATION_TYPE_LASER_FOLLOW_MODE 25
#define CRD_OPERATION_TYPE_LASER_FOLLOW_OFF 26
#define CRD_OPERATION_TYPE_LASER_FOLLOW_SPLINE 28
#define CRD_MAX 2
#define CRD_FIFO_MAX 4096
#define INTERPOLATION_AXIS_MAX 8
#define CHANNEL_HOST 0
#define CHANNEL_UART 1
#define CHANNEL_SIM 2
#define CHANNEL_ETHER 3
#define CHANNEL_RS232 4
#define CHANNEL_PCIE 5
#define CHANNEL_RINGNET 6

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
#define GT_GetLinkLoss GTM_GetLinkLoss
#define GT_SetInterlock GTM_SetInterlock
#define GT_Abort GTM_Abort
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
#define GT_GetStopReason GTM_GetStopReason
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
#define GT_GetDiEx GTM_GetDiEx
#define GT_SetDoEx GTM_SetDoEx
#define GT_GetDoEx GTM_GetDoEx
#define GT_SetDoBit GTM_SetDoBit
#define GT_SetDoBitReverse GTM_SetDoBitReverse
#define GT_GetDiReverseCount GTM_GetDiReverseCount
#define GT_SetDiReverseCount GTM_SetDiReverseCount
#define GT_SetDac GTM_SetDac
#define GT_GetDac GTM_GetDac
#define GT_GetAdc GTM_GetAdc
#define GT_SimInput GTM_SimInput
#define GT_SimAdc GTM_SimAdc
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
#define GT_GetCrdStopReason GTM_GetCrdStopReason
#define GT_GetCrdPos GTM_GetCrdPos
#define GT_GetCrdVel GTM_GetCrdVel
#define GT_GetRemainderSegNum GTM_GetRemainderSegNum
#define GT_SetCrdStopDec GTM_SetCrdStopDec
#define GT_SetOverride GTM_SetOverride
#define GT_SetLaserFollowFilter GTM_SetLaserFollowFilter
#define GT_GetLaserFollowFilter GTM_GetLaserFollowFilter
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
#define GT_PrfGear GTM_PrfGear
#define GT_SetGearMaster GTM_SetGearMaster
#define GT_GetGearMaster GTM_GetGearMaster
#define GT_SetGearRatio GTM_SetGearRatio
#define GT_GetGearRatio GTM_GetGearRatio
#define GT_GearStart GTM_GearStart
#define GT_SetGearEvent GTM_SetGearEvent
#define GT_GetGearEvent GTM_GetGearEvent
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
#define GT_GetDiRaw GTM_GetDiRaw
#define GT_Delay GTM_Delay
#define GT_DelayHighPrecision GTM_DelayHighPrecision
#define GT_GetClockHighPrecision GTM_GetClockHighPrecision
#define GT_SetPid GTM_SetPid
#define GT_GetPid GTM_GetPid
#define GT_SetControlFilter GTM_SetControlFilter
#define GT_GetControlFilter GTM_GetControlFilter
#define GT_SetKvffFilter GTM_SetKvffFilter
#define GT_GetKvffFilter GTM_GetKvffFilter
#define GT_SetAxisPrfVelFilter GTM_SetAxisPrfVelFilter
#define GT_GetAxisPrfVelFilter GTM_GetAxisPrfVelFilter
#define GT_SetAxisEncVelFilter GTM_SetAxisEncVelFilter
#define GT_GetAxisEncVelFilter GTM_GetAxisEncVelFilter
#define GT_SetProfileScale GTM_SetProfileScale
#define GT_GetProfileScale GTM_GetProfileScale
#define GT_SetEncoderScale GTM_SetEncoderScale
#define GT_GetEncoderScale GTM_GetEncoderScale
#define GT_SetMtrBias GTM_SetMtrBias
#define GT_GetMtrBias GTM_GetMtrBias
#define GT_SetMtrLmt GTM_SetMtrLmt
#define GT_GetMtrLmt GTM_GetMtrLmt
#define GT_SetAdcFilter GTM_SetAdcFilter
#define GT_CtrlMode GTM_CtrlMode
#define GT_EncOn GTM_EncOn
#define GT_EncOff GTM_EncOff
#define GT_StepDir GTM_StepDir
#define GT_StepPulse GTM_StepPulse
#define GT_EncSns GTM_EncSns
#define GT_GpiSns GTM_GpiSns
#define GT_ExtModuleInit GTM_ExtModuleInit
#define GT_SetExtDo GTM_SetExtDo
#define GT_SetExtDoBit GTM_SetExtDoBit
#define GT_GetExtDo GTM_GetExtDo
#define GT_GetExtDoBit GTM_GetExtDoBit
#define GT_GetExtDi GTM_GetExtDi
#define GT_GetExtDiBit GTM_GetExtDiBit
#define GT_SetExtAo GTM_SetExtAo
#define GT_GetExtAi GTM_GetExtAi
#define GT_OpenExtMdl GTM_OpenExtMdl
#define GT_CloseExtMdl GTM_CloseExtMdl
#define GT_ResetExtMdl GTM_ResetExtMdl
#define GT_LoadExtConfig GTM_LoadExtConfig
#define GT_SetExtIoValue GTM_SetExtIoValue
#define GT_GetExtIoValue GTM_GetExtIoValue
#define GT_SetExtIoBit GTM_SetExtIoBit
#define GT_GetExtIoBit GTM_GetExtIoBit
#define GT_GetExtAdValue GTM_GetExtAdValue
#define GT_GetExtAdVoltage GTM_GetExtAdVoltage
#define GT_SetExtDaValue GTM_SetExtDaValue
#define GT_SetExtDaVoltage GTM_SetExtDaVoltage
#define GT_HandwheelInit GTM_HandwheelInit
#define GT_SetHandwheelStopDec GTM_SetHandwheelStopDec
#define GT_StartHandwheel GTM_StartHandwheel
#define GT_EndHandwheel GTM_EndHandwheel
#define GT_SetLeadScrewComp GTM_SetLeadScrewComp
#define GT_EnableLeadScrewComp GTM_EnableLeadScrewComp
#define GT_SetBacklash GTM_SetBacklash
#define GT_GetBacklash GTM_GetBacklash
#define GT_GoHome GTM_GoHome
#define GT_GetHomePrm GTM_GetHomePrm
#define GT_GetHomeStatus GTM_GetHomeStatus
#define GT_HomeInit GTM_HomeInit
#define GT_PrfCam GTM_PrfCam
#define GT_CamStart GTM_CamStart

/* Session */
/* Opens the controller that the environment names. */
GT_API GT_Open(short cardNum, short channel GT_DEFAULT(0), short param GT_DEFAULT(1));
/* Aborts (GT_Abort) and closes the controller. */
GT_API GT_Close(short cardNum);
/* The text of the calling thread's last failure, cut to size. */
GT_API GT_GetLastReason(short cardNum, char *text, short size);
/* Puts the axes, tables and lasers of the core into power-on state. */
GT_API GT_Reset(short cardNum);
/* Reads limits, alarms, stop decelerations and bands from a file. */
GT_API GT_LoadConfig(short cardNum, const char *file);
/* Clears latched status bits of count axes, and faults of lasers that they gate. */
GT_API GT_ClrSts(short cardNum, short axis, short count GT_DEFAULT(1));
/* The controller's version, board, profile and family as a text. */
GT_API GT_GetVersion(short cardNum, char **version);
/* Controller time in ms, and servo ticks since power-on. */
GT_API GT_GetClock(short cardNum, unsigned long *clock, unsigned long *loop GT_DEFAULT(NULL));
/* Sets the servo tick in us, at standstill. */
GT_API GT_SetTick(short cardNum, long tickUs);
/* After how many ms without the host the link counts as lost, and whether all motion stops then. */
GT_API GT_SetLinkLoss(short cardNum, long timeMs, short stopAll);
/* After how many ms the link counts as lost, 0 never, and whether all motion stops then. */
GT_API GT_GetLinkLoss(short cardNum, double *ms, short *stopAll);
/* What motion does on the interlock input: 0 continues with light off, 1 as at link loss, 2 stops abruptly. */
GT_API GT_SetInterlock(short cardNum, short motion);
/* Shuts off every laser at once and stops all motion smoothly. */
GT_API GT_Abort(short cardNum);

/* Axes */
/* Switches the servo on. */
GT_API GT_AxisOn(short cardNum, short axis);
/* Switches the servo off; an axis in motion stops abruptly. */
GT_API GT_AxisOff(short cardNum, short axis);
/* Stops axes and coordinate systems, smoothly or (option) abruptly. */
GT_API GT_Stop(short cardNum, long mask, long option);
/* Sets the positions of count axes at rest to 0. */
GT_API GT_ZeroPos(short cardNum, short axis, short count GT_DEFAULT(1));
/* Sets the planned position, pulses. */
GT_API GT_SetPrfPos(short cardNum, short profile, long pos);
/* Changes nothing: an axis reads what its profile and its encoder read, also after SetPrfPos. */
GT_API GT_SynchAxisPos(short cardNum, long mask);
/* Sets the decelerations of smooth and abrupt stops, pulse/ms^2. */
GT_API GT_SetStopDec(short cardNum, short profile, double decSmoothStop, double decAbruptStop);
/* The decelerations of smooth and abrupt stops, pulse/ms^2. */
GT_API GT_GetStopDec(short cardNum, short profile, double *decSmoothStop, double *decAbruptStop);
/* Sets the in-position band in pulses, and its time in 250 us units. */
GT_API GT_SetAxisBand(short cardNum, short axis, long band, long time);
/* The in-position band in pulses, and its time in 250 us units. */
GT_API GT_GetAxisBand(short cardNum, short axis, long *band, long *time);
/* Status words of count axes, of one tick. */
GT_API GT_GetSts(short cardNum, short axis, long *sts, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
/* Why the axis stopped last, as a number and as a text cut to size. */
GT_API GT_GetStopReason(short cardNum, short axis, short *reason, char *text GT_DEFAULT(NULL), short size GT_DEFAULT(0));
/* Planned positions of count axes in pulses, of one tick. */
GT_API GT_GetPrfPos(short cardNum, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
/* Planned velocities of count axes in pulse/ms, of one tick. */
GT_API GT_GetPrfVel(short cardNum, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
/* Planned accelerations of count axes in pulse/ms^2, of one tick. */
GT_API GT_GetPrfAcc(short cardNum, short profile, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
/* Modes of count axes: 0 Trap, 1 Jog, 2 PT, 4 Follow, 5 Crd, 6 PVT, 10 FollowEx. */
GT_API GT_GetPrfMode(short cardNum, short profile, long *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
/* Encoder positions of count axes in pulses, of one tick. */
GT_API GT_GetEncPos(short cardNum, short encoder, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
/* Encoder velocities of count axes in pulse/ms, of one tick. */
GT_API GT_GetEncVel(short cardNum, short encoder, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
/* Sets an encoder's position, pulses. */
GT_API GT_SetEncPos(short cardNum, short encoder, long pos);
/* Sets software limits in pulses; 0x7fffffff and 0x80000000 are off. */
GT_API GT_SetSoftLimit(short cardNum, short axis, long positive, long negative);
/* The software limits in pulses. */
GT_API GT_GetSoftLimit(short cardNum, short axis, long *positive, long *negative);
/* Enables limit switches: 0 positive, 1 negative, -1 both. */
GT_API GT_LmtsOn(short cardNum, short axis, short limitType GT_DEFAULT(-1));
/* Disables limit switches: 0 positive, 1 negative, -1 both. */
GT_API GT_LmtsOff(short cardNum, short axis, short limitType GT_DEFAULT(-1));
/* Sets the active level of limit switches, two bits an axis. */
GT_API GT_LmtSns(short cardNum, unsigned short sense);
/* Enables the drive alarm. */
GT_API GT_AlarmOn(short cardNum, short axis);
/* Disables the drive alarm. */
GT_API GT_AlarmOff(short cardNum, short axis);
/* Sets the following-error limit, pulses. */
GT_API GT_SetPosErr(short cardNum, short control, long error);
/* The following-error limit, pulses. */
GT_API GT_GetPosErr(short cardNum, short control, long *error);
/* Arms a capture of home (1) or index (2). */
GT_API GT_SetCaptureMode(short cardNum, short encoder, short mode);
/* Whether captures of count encoders have come, and where. */
GT_API GT_GetCaptureStatus(short cardNum, short encoder, short *status, long *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));

/* Trap and Jog */
/* Puts an axis into Trap mode (point to point). */
GT_API GT_PrfTrap(short cardNum, short profile);
/* Sets acceleration, deceleration, start velocity and smoothing of Trap. */
GT_API GT_SetTrapPrm(short cardNum, short profile, TTrapPrm *prm);
/* Acceleration, deceleration, start velocity and smoothing of Trap. */
GT_API GT_GetTrapPrm(short cardNum, short profile, TTrapPrm *prm);
/* Puts an axis into Jog mode (steady velocity). */
GT_API GT_PrfJog(short cardNum, short profile);
/* Sets acceleration, deceleration and smoothing of Jog. */
GT_API GT_SetJogPrm(short cardNum, short profile, TJogPrm *prm);
/* Acceleration, deceleration and smoothing of Jog. */
GT_API GT_GetJogPrm(short cardNum, short profile, TJogPrm *prm);
/* Sets the target of Trap, pulses. */
GT_API GT_SetPos(short cardNum, short profile, long pos);
/* The target of Trap, pulses. */
GT_API GT_GetPos(short cardNum, short profile, long *pos);
/* Sets the velocity of Trap or Jog, pulse/ms. */
GT_API GT_SetVel(short cardNum, short profile, double vel);
/* The velocity of Trap or Jog, pulse/ms. */
GT_API GT_GetVel(short cardNum, short profile, double *vel);
/* Starts axes in Trap or Jog, or gives them their new targets, all on one tick. */
GT_API GT_Update(short cardNum, long mask);

/* Digital and analog inputs and outputs */
/* Levels of the digital inputs of a type as bits, as they are at the terminals: no sense (LmtSns) is applied. */
GT_API GT_GetDi(short cardNum, short diType, long *value);
/* Sets the digital outputs of a type, the first 32 of the general ones. */
GT_API GT_SetDo(short cardNum, short doType, long value);
/* Digital outputs of a type as bits, the first 32 of the general ones. */
GT_API GT_GetDo(short cardNum, short doType, long *value);
/* As GetDi in count words of 32: bit 0 of the second word is input 33. */
GT_API GT_GetDiEx(short cardNum, short diType, long *value, short count GT_DEFAULT(1));
/* As SetDo in count words of 32: bit 0 of the second word is output 33. Further outputs stay. */
GT_API GT_SetDoEx(short cardNum, short doType, long *value, short count GT_DEFAULT(1));
/* As GetDo in count words of 32. */
GT_API GT_GetDoEx(short cardNum, short doType, long *value, short count GT_DEFAULT(1));
/* Sets one digital output, counted from 1. */
GT_API GT_SetDoBit(short cardNum, short doType, short index, short value);
/* An output gets a level for a time in units of 250 us, and then the other one; 16 at a time. */
GT_API GT_SetDoBitReverse(short cardNum, short doType, short doIndex, short value, short reverseTime);
/* Edges of an input, or of count from one on, both directions, counted in every servo tick. */
GT_API GT_GetDiReverseCount(short cardNum, short diType, short diIndex, unsigned long *reverseCount, short count GT_DEFAULT(1));
/* Sets these counts; they go on from there. */
GT_API GT_SetDiReverseCount(short cardNum, short diType, short diIndex, unsigned long *reverseCount, short count GT_DEFAULT(1));
/* Sets count analog outputs, -32768 to 32767 for -10 to 10 V. */
GT_API GT_SetDac(short cardNum, short dac, short *value, short count GT_DEFAULT(1));
/* Values of count analog outputs. */
GT_API GT_GetDac(short cardNum, short dac, short *value, short count GT_DEFAULT(1));
/* Voltages of count analog inputs. */
GT_API GT_GetAdc(short cardNum, short adc, double *value, short count GT_DEFAULT(1), unsigned long *clock GT_DEFAULT(NULL));
/* Sets a digital input of the virtual or the emulated board: its level at the terminal, before sense. A real board returns 1. */
GT_API GT_SimInput(short cardNum, short diType, short index, short level);
/* Sets an analog input of the virtual or the emulated board, -12.5 to 12.5 V. A real board returns 1. */
GT_API GT_SimAdc(short cardNum, short adc, double volts);

/* Laser */
/* Gives axis connector 7 or 8 to step pulses (0) or to a laser (1); GUS family. */
GT_API GT_SetAxisMode(short cardNum, short axis, short mode);
/* Switches a laser on. */
GT_API GT_LaserOn(short cardNum, short channel GT_DEFAULT(0));
/* Switches a laser off. */
GT_API GT_LaserOff(short cardNum, short channel GT_DEFAULT(0));
/* Whether a laser is switched on. */
GT_API GT_LaserOnStatus(short cardNum, short *value, short channel GT_DEFAULT(0));
/* Switches a laser on (1) or off (0). */
GT_API GT_SetHSIOOpt(short cardNum, unsigned short value, short channel GT_DEFAULT(0));
/* Whether a laser is switched on. */
GT_API GT_GetHSIOOpt(short cardNum, unsigned short *value, short channel GT_DEFAULT(0));
/* How power is output: 0 duty, 1 frequency, 2 voltage, 3 duty with the switch held; and its bounds. */
GT_API GT_LaserPowerMode(short cardNum, short laserPowerMode, double maxValue, double minValue, short channel GT_DEFAULT(0), short delaymode GT_DEFAULT(0));
/* Sets the direct power, in the mode's unit. */
GT_API GT_LaserPrfCmd(short cardNum, double outputCmd, short channel GT_DEFAULT(0));
/* Sets the carrier of the duty modes, kHz. */
GT_API GT_LaserOutFrq(short cardNum, double outFrq, short channel GT_DEFAULT(0));
/* Sets the pulse width of the frequency mode, us. */
GT_API GT_SetPulseWidth(short cardNum, unsigned long width, short channel GT_DEFAULT(0));
/* Sets standby pulses of one channel: on or off, kHz, %. */
GT_API GT_SetWaitPulse(short cardNum, unsigned short mode, double waitPulseFrq, double waitPulseDuty, short channel GT_DEFAULT(0));
/* Sets standby pulses of both channels: on or off, kHz, %. */
GT_API GT_SetWaitPulseEx(short cardNum, unsigned short mode, double waitPulseFrq, double waitPulseDuty);
/* Sets the voltage of the analog mode while there is no light. */
GT_API GT_SetPreVltg(short cardNum, unsigned short mode, double voltageValue, short channel GT_DEFAULT(0));
/* Sets the delays of switching off and on, us. */
GT_API GT_SetLevelDelay(short cardNum, unsigned short offDelay, unsigned short onDelay, short channel GT_DEFAULT(0));
/* Enables first-pulse suppression with its three times, us. */
GT_API GT_EnaFPK(short cardNum, unsigned short time1, unsigned short time2, unsigned short laserOffDelay, short channel GT_DEFAULT(0));
/* Disables first-pulse suppression. */
GT_API GT_DisFPK(short cardNum, short channel GT_DEFAULT(0));
/* Chooses the frequency range: 1 to 24 kHz, 0 to 96 kHz; LSR family. */
GT_API GT_SetLaserMode(short cardNum, short mode);
/* Sets a channel's on-time to 0. */
GT_API GT_ZeroLaserOnTime(short cardNum, short channel);
/* A channel's on-time in 250 us units. */
GT_API GT_GetLaserOnTime(short cardNum, short channel, unsigned long *time);
/* Sets for which coordinate systems a failure shuts a channel off, as bits. */
GT_API GT_SetLaserCrdMap(short cardNum, short channel, short map);
/* For which coordinate systems a failure shuts a channel off. */
GT_API GT_GetLaserCrdMap(short cardNum, short channel, short *map);
/* The power that is output now, in the mode's unit. */
GT_API GT_GetLaserPower(short cardNum, short channel, double *power);
/* Why a channel is kept dark, 0 if it is not. */
GT_API GT_GetLaserFault(short cardNum, short channel, short *cause);
/* Clears a channel's fault whose cause is over. */
GT_API GT_ClrLaserFault(short cardNum, short channel);

/* Coordinate systems */
/* Sets up a coordinate system: axes, origin, greatest speed and acceleration. */
GT_API GT_SetCrdPrm(short cardNum, short crd, TCrdPrm *crdPrm);
/* The parameters of a coordinate system. */
GT_API GT_GetCrdPrm(short cardNum, short crd, TCrdPrm *crdPrm);
/* Clears a FIFO of a coordinate system. */
GT_API GT_CrdClear(short cardNum, short crd, short fifo GT_DEFAULT(0));
/* Free slots of a FIFO of a coordinate system. */
GT_API GT_CrdSpace(short cardNum, short crd, long *space, short fifo GT_DEFAULT(0));
/* Starts coordinate systems (bit k - 1 of mask is crd k); option bits take FIFO 1. */
GT_API GT_CrdStart(short cardNum, short mask, short option GT_DEFAULT(0));
/* Stops coordinate systems, smoothly or (option) abruptly. */
GT_API GT_CrdStop(short cardNum, long mask, long option GT_DEFAULT(0));
/* Whether a coordinate system runs, and how many segments are done. */
GT_API GT_CrdStatus(short cardNum, short crd, short *run, long *segment, short fifo GT_DEFAULT(0));
/* Why the coordinate system stopped last, as a number and as a text cut to size. */
GT_API GT_GetCrdStopReason(short cardNum, short crd, short *reason, char *text GT_DEFAULT(NULL), short size GT_DEFAULT(0));
/* Coordinates, pulses: one for each dimension. */
GT_API GT_GetCrdPos(short cardNum, short crd, double *pos);
/* Speed along the path, pulse/ms. */
GT_API GT_GetCrdVel(short cardNum, short crd, double *synVel);
/* Segments of a FIFO that are not done. */
GT_API GT_GetRemainderSegNum(short cardNum, short crd, long *segment, short fifo GT_DEFAULT(0));
/* Sets the decelerations of smooth and abrupt stops along the path, pulse/ms^2. */
GT_API GT_SetCrdStopDec(short cardNum, short crd, double decSmoothStop, double decAbruptStop);
/* Sets the share of the programmed speed that is run, above 0 to 1. */
GT_API GT_SetOverride(short cardNum, short crd, double synVelRatio);
/* Sets the time constant, ms, of the filter of the encoder speed that lasers follow; 0: none. After SetCrdPrm it is 1. */
GT_API GT_SetLaserFollowFilter(short cardNum, short crd, double time);
/* The time constant of the filter of the encoder speed that lasers follow, ms. */
GT_API GT_GetLaserFollowFilter(short cardNum, short crd, double *time);
/* Switches look-ahead of a FIFO on: corner time in ms, greatest acceleration, segments. */
GT_API GT_InitLookAhead(short cardNum, short crd, short fifo, double T, double accMax, short n, TCrdData *lookAheadBuf GT_DEFAULT(NULL));
/* Sets the limits of one coordinate for look-ahead, pulse/ms and pulse/ms^2; 0 is none. */
GT_API GT_SetCrdLimit(short cardNum, short crd, short coordinate, double velMax, double accMax);
/* The limits of one coordinate for look-ahead. */
GT_API GT_GetCrdLimit(short cardNum, short crd, short coordinate, double *velMax, double *accMax);
/* In a path: one motion as a struct; NULL sends what the look-ahead holds. */
GT_API GT_CrdData(short cardNum, short crd, TCrdData *crdData, short fifo GT_DEFAULT(0));
/* In a path: a line in X and Y. */
GT_API GT_LnXY(short cardNum, short crd, long x, long y, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X, Y and Z. */
GT_API GT_LnXYZ(short cardNum, short crd, long x, long y, long z, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X, Y, Z and A. */
GT_API GT_LnXYZA(short cardNum, short crd, long x, long y, long z, long a, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X and Y that ends at rest. */
GT_API GT_LnXYG0(short cardNum, short crd, long x, long y, double synVel, double synAcc, short fifo GT_DEFAULT(0));
/* In a path: an arc in XY by its radius; circleDir 0 clockwise, 1 counter-clockwise. */
GT_API GT_ArcXYR(short cardNum, short crd, long x, long y, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in XY by its centre, counted from its start; end on start is a full circle. */
GT_API GT_ArcXYC(short cardNum, short crd, long x, long y, double xCenter, double yCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in YZ by its radius. */
GT_API GT_ArcYZR(short cardNum, short crd, long y, long z, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in YZ by its centre, counted from its start. */
GT_API GT_ArcYZC(short cardNum, short crd, long y, long z, double yCenter, double zCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in ZX by its radius. */
GT_API GT_ArcZXR(short cardNum, short crd, long z, long x, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in ZX by its centre, counted from its start. */
GT_API GT_ArcZXC(short cardNum, short crd, long z, long x, double zCenter, double xCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: waits at rest, ms. */
GT_API GT_BufDelay(short cardNum, short crd, unsigned short delayTime, short fifo GT_DEFAULT(0));
/* In a path: sets digital outputs of a mask. */
GT_API GT_BufIO(short cardNum, short crd, unsigned short doType, unsigned short doMask, unsigned short doValue, short fifo GT_DEFAULT(0));
/* In a path: sets one digital output. */
GT_API GT_BufDoBit(short cardNum, short crd, unsigned short doType, unsigned short index, short value, short fifo GT_DEFAULT(0));
/* In a path: sets an analog output. */
GT_API GT_BufDA(short cardNum, short crd, short chn, short daValue, short fifo GT_DEFAULT(0));
/* In a path: moves another axis; modal 1 waits for its end. */
GT_API GT_BufMove(short cardNum, short crd, short moveAxis, long pos, double vel, double acc, short modal, short fifo GT_DEFAULT(0));
/* In a path: the next segment takes another axis along by so many pulses. */
GT_API GT_BufGear(short cardNum, short crd, short gearAxis, long pos, short fifo GT_DEFAULT(0));

/* Buffered laser commands */
/* In a path: switches a laser on. */
GT_API GT_BufLaserOn(short cardNum, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: switches a laser off. */
GT_API GT_BufLaserOff(short cardNum, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: sets the direct power. */
GT_API GT_BufLaserPrfCmd(short cardNum, short crd, double laserPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: from here the power follows the planned path speed, ratio times it, within its bounds. */
GT_API GT_BufLaserPrfFollow(short cardNum, short crd, double ratio, long minPower, long maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: whether the power follows planned (0) or encoder (1) speed, and the power at the start. */
GT_API GT_BufLaserFollowMode(short cardNum, short crd, short source GT_DEFAULT(0), short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0), double startPower GT_DEFAULT(GT_NOT_GIVEN));
/* In a path: from here the power follows the path speed, ratio times it, within its bounds. */
GT_API GT_BufLaserFollowRatio(short cardNum, short crd, double ratio, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: from here the power follows the path speed by a table. */
GT_API GT_BufLaserFollowTable(short cardNum, short crd, short tableId, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: the power follows the speed no more. */
GT_API GT_BufLaserFollowOff(short cardNum, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* Sets a table of power against path speed. */
GT_API GT_SetLaserFollowTable(short cardNum, short tableId, long count, double *vel, double *power, short channel GT_DEFAULT(0));

/* Laser power by distance */
/* Switches power by distance on or off, with reference positions and scales of axes 1 to 4. */
GT_API GT_SetLaserDisMode(short cardNum, short mode, short source, long *pos GT_DEFAULT(NULL), double *scale GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
/* Sets the ratios of power by distance, and its bounds. */
GT_API GT_SetLaserDisRatio(short cardNum, double *ratio, double minPower, double maxPower, short channel GT_DEFAULT(0));
#ifdef __cplusplus
static inline short GT_SetLaserDisRatio(short cardNum, double *ratio, short channel = 0)
{
    return GT_SetLaserDisRatio(cardNum, ratio, GT_NOT_GIVEN, GT_NOT_GIVEN, channel);
}
#endif
/* Sets ratios by position for each of axes 1 to 4. */
GT_API GT_SetLaserDisTable1D(short cardNum, short count, double *ratio, long *pos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
/* Sets ratios by the positions of two axes. */
GT_API GT_SetLaserDisTable2D(short cardNum, short *axisIndex, short *count, double *ratio, long *xPos, long *yPos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));

/* PT */
/* Puts an axis into PT mode: static or dynamic FIFO. */
GT_API GT_PrfPt(short cardNum, short profile, short mode GT_DEFAULT(0));
/* Free slots of a PT FIFO. */
GT_API GT_PtSpace(short cardNum, short profile, short *space, short fifo GT_DEFAULT(0));
/* A PT segment: end position in pulses, end time in ms, type. */
GT_API GT_PtData(short cardNum, short profile, double pos, long time, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a PT FIFO. */
GT_API GT_PtClear(short cardNum, short profile, short fifo GT_DEFAULT(0));
/* Sets how many passes run; 0 for ever. */
GT_API GT_SetPtLoop(short cardNum, short profile, long loop);
/* Passes that were completed. */
GT_API GT_GetPtLoop(short cardNum, short profile, long *loop);
/* Sets the size of PT FIFOs: 0 for 32 segments, 1 for 1024. */
GT_API GT_SetPtMemory(short cardNum, short profile, short memory);
/* The size of PT FIFOs. */
GT_API GT_GetPtMemory(short cardNum, short profile, short *memory);
/* Starts axes in PT, all on one tick; option bits take FIFO 1. */
GT_API GT_PtStart(short cardNum, long mask, long option GT_DEFAULT(0));
/* Starts axes in PT by lists of axes and FIFOs. */
GT_API GT_PtStartPro(short cardNum, short *axis, short *option, short count);

/* PVT */
/* Puts an axis into PVT mode. */
GT_API GT_PrfPvt(short cardNum, short profile);
/* Sets how many passes run; 0 for ever. */
GT_API GT_SetPvtLoop(short cardNum, short profile, long loop);
/* Passes that were completed, and to run. */
GT_API GT_GetPvtLoop(short cardNum, short profile, long *loopCount, long *loop);
/* Tables in force of count axes, and times in them. */
GT_API GT_PvtStatus(short cardNum, short profile, short *tableId, double *time, short count GT_DEFAULT(1));
/* Starts axes in PVT, all on one tick. */
GT_API GT_PvtStart(short cardNum, long mask);
/* Chooses an axis's table; while it runs, from the next pass on. */
GT_API GT_PvtTableSelect(short cardNum, short profile, short tableId);
/* Fills a table with times, positions and velocities. */
GT_API GT_PvtTable(short cardNum, short tableId, long count, double *time, double *pos, double *vel);
/* Fills a table with velocities at the begin and the end of each segment; a point where they differ takes two of 1024 points. */
GT_API GT_PvtTableEx(short cardNum, short tableId, long count, double *time, double *pos, double *velBegin, double *velEnd);
/* Fills a table whose acceleration is continuous. */
GT_API GT_PvtTableComplete(short cardNum, short tableId, long count, double *time, double *pos, double *a, double *b, double *c, double velBegin GT_DEFAULT(0), double velEnd GT_DEFAULT(0));
/* Fills a table with percentages of S-shape. */
GT_API GT_PvtTablePercent(short cardNum, short tableId, long count, double *time, double *pos, double *percent, double velBegin GT_DEFAULT(0));
/* The velocities of a Percent table. */
GT_API GT_PvtPercentCalculate(short cardNum, long count, double *time, double *pos, double *percent, double velBegin, double *vel);
/* Fills a table by positions, velocities and limits; the controller finds the times. */
GT_API GT_PvtTableContinuous(short cardNum, short tableId, long count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double timeBegin);
/* The times of a Continuous table. */
GT_API GT_PvtContinuousCalculate(short cardNum, long count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double *time);
/* Puts an axis into Gear mode: direction of the master 0 both, 1, -1. */
GT_API GT_PrfGear(short cardNum, short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GT_SetGearMaster(short cardNum, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GT_GetGearMaster(short cardNum, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets the ratio slaveEven/masterEven of the next GearStart, reached over masterSlope pulses of the master; 0 at once. */
GT_API GT_SetGearRatio(short cardNum, short profile, long masterEven, long slaveEven, long masterSlope GT_DEFAULT(0));
/* The ratio that SetGearRatio has set. */
GT_API GT_GetGearRatio(short cardNum, short profile, long *masterEven, long *slaveEven, long *masterSlope GT_DEFAULT(NULL));
/* Starts axes in Gear; one that runs takes the ratio that was set last. */
GT_API GT_GearStart(short cardNum, long mask);
/* Sets when the gear begins: 1 at once, 2 when the master crosses position startPara1, upwards (startPara0 1) or downwards (-1). */
GT_API GT_SetGearEvent(short cardNum, short profile, short event, long startPara0, long startPara1);
/* When the gear begins. */
GT_API GT_GetGearEvent(short cardNum, short profile, short *event, long *startPara0, long *startPara1);

/* Follow */
/* Puts an axis into Follow mode: direction of the master 0 both, 1, -1. */
GT_API GT_PrfFollow(short cardNum, short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GT_SetFollowMaster(short cardNum, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GT_GetFollowMaster(short cardNum, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets how many passes run; 0 for ever. */
GT_API GT_SetFollowLoop(short cardNum, short profile, long loop);
/* Passes that were completed. */
GT_API GT_GetFollowLoop(short cardNum, short profile, long *loop);
/* Sets when following begins: at once, or when the master, not there yet, comes to a position. */
GT_API GT_SetFollowEvent(short cardNum, short profile, short event, short masterDir, long pos GT_DEFAULT(0));
/* When following begins. */
GT_API GT_GetFollowEvent(short cardNum, short profile, short *event, short *masterDir, long *pos);
/* Free slots of a Follow FIFO. */
GT_API GT_FollowSpace(short cardNum, short profile, short *space, short fifo GT_DEFAULT(0));
/* A Follow segment: displacement of the master, displacement of the slave, type. */
GT_API GT_FollowData(short cardNum, short profile, long masterSegment, double slaveSegment, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a Follow FIFO. */
GT_API GT_FollowClear(short cardNum, short profile, short fifo GT_DEFAULT(0));
/* Starts axes in Follow; option bits take FIFO 1. */
GT_API GT_FollowStart(short cardNum, long mask, long option GT_DEFAULT(0));
/* Goes over to the other FIFO when the pass has ended. */
GT_API GT_FollowSwitch(short cardNum, long mask);
/* Sets the size of Follow FIFOs: 0 for 16 segments, 1 for 512. */
GT_API GT_SetFollowMemory(short cardNum, short profile, short memory);
/* The size of Follow FIFOs. */
GT_API GT_GetFollowMemory(short cardNum, short profile, short *memory);
/* The FIFO in force, and whether a switch waits. */
GT_API GT_GetFollowStatus(short cardNum, short profile, short *fifoNum, short *switchStatus);

/* FollowEx */
/* Puts an axis into FollowEx mode: direction of the master 0 both, 1, -1. */
GT_API GT_PrfFollowEx(short cardNum, short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GT_SetFollowMasterEx(short cardNum, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GT_GetFollowMasterEx(short cardNum, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets how many passes run; 0 for ever. */
GT_API GT_SetFollowLoopEx(short cardNum, short profile, long loop);
/* Passes that were completed. */
GT_API GT_GetFollowLoopEx(short cardNum, short profile, long *loop);
/* Sets when following begins: at once, or when the master, not there yet, comes to a position. */
GT_API GT_SetFollowEventEx(short cardNum, short profile, short event, short masterDir, long pos GT_DEFAULT(0));
/* When following begins. */
GT_API GT_GetFollowEventEx(short cardNum, short profile, short *event, short *masterDir, long *pos);
/* Free slots of a FollowEx FIFO. */
GT_API GT_FollowSpaceEx(short cardNum, short profile, short *space, short fifo GT_DEFAULT(0));
/* A FollowEx segment with a percentage of S-shape. */
GT_API GT_FollowDataPercentEx(short cardNum, short profile, double masterSegment, double slaveSegment, short type GT_DEFAULT(0), short percent GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a FollowEx FIFO. */
GT_API GT_FollowClearEx(short cardNum, short profile, short fifo GT_DEFAULT(0));
/* Starts axes in FollowEx; option bits take FIFO 1. */
GT_API GT_FollowStartEx(short cardNum, long mask, long option GT_DEFAULT(0));
/* Goes over to the other FIFO when the pass has ended. */
GT_API GT_FollowSwitchEx(short cardNum, long mask);
/* Sets the size of FollowEx FIFOs: 0 for 16 segments, 1 for 512. */
GT_API GT_SetFollowMemoryEx(short cardNum, short profile, short memory);
/* The size of FollowEx FIFOs. */
GT_API GT_GetFollowMemoryEx(short cardNum, short profile, short *memory);
/* The FIFO in force, and whether a switch waits. */
GT_API GT_GetFollowStatusEx(short cardNum, short profile, short *fifoNum, short *switchStatus);
/* Goes over at once, by segment or by table; or as an entry of a FIFO. */
GT_API GT_FollowSwitchNowEx(short cardNum, short profile, short method, short buffer GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: sets a digital output. */
GT_API GT_FollowDoBitEx(short cardNum, short profile, short doType, short index, short value, short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: the slave is at standstill for so many 250 us. */
GT_API GT_FollowDelayEx(short cardNum, short profile, unsigned long delayTime, short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: the slave is at standstill until an input has a level, or a time in ms is over. */
GT_API GT_FollowDiBitEx(short cardNum, short profile, short diType, short index, short value, unsigned long time GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* A FollowEx segment with velocity ratios at begin and end. */
GT_API GT_FollowDataPercent2Ex(short cardNum, short profile, double masterSegment, double slaveSegment, double velBeginRatio, double velEndRatio, short percent GT_DEFAULT(100), short *percent1 GT_DEFAULT(NULL), short fifo GT_DEFAULT(0));
/* The displacement of such a segment, for a share of S-shape in its first half. */
GT_API GT_GetFollowDataPercent2Ex(short cardNum, double masterPos, double v1, double v2, double p, double p1, double *slavePos);

/* Beyond the manuals: what is kept changes nothing, what is refused returns 1 (docs/api.md) */
/* Levels at the terminals; what GetDi returns, which no sense changes. */
GT_API GT_GetDiRaw(short cardNum, short diType, long *value);
/* Waits for so many ms of the controller's time. */
GT_API GT_Delay(short cardNum, unsigned short time);
/* Waits for so many 250 us of the controller's time. */
GT_API GT_DelayHighPrecision(short cardNum, unsigned short time);
/* Controller time in 125 us since power-on. */
GT_API GT_GetClockHighPrecision(short cardNum, unsigned long *clock);
/* Kept: gains of a position loop; there is no loop. */
GT_API GT_SetPid(short cardNum, short control, short index, TPid *pid);
/* The gains that SetPid has set. */
GT_API GT_GetPid(short cardNum, short control, short index, TPid *pid);
/* Kept: which set of gains is in force. */
GT_API GT_SetControlFilter(short cardNum, short control, short index);
/* The set of gains that SetControlFilter has chosen. */
GT_API GT_GetControlFilter(short cardNum, short control, short *index);
/* Kept: filter of the velocity feed-forward. */
GT_API GT_SetKvffFilter(short cardNum, short control, short kvffFilterExp, double accMax);
/* The filter that SetKvffFilter has set. */
GT_API GT_GetKvffFilter(short cardNum, short control, short *kvffFilterExp, double *accMax);
/* Kept: filter of the planned velocity that is shown. */
GT_API GT_SetAxisPrfVelFilter(short cardNum, short axis, short filterNumExp);
/* The filter that SetAxisPrfVelFilter has set. */
GT_API GT_GetAxisPrfVelFilter(short cardNum, short axis, short *filterNumExp);
/* Kept: filter of the encoder's velocity that is shown. */
GT_API GT_SetAxisEncVelFilter(short cardNum, short axis, short filterNumExp);
/* The filter that SetAxisEncVelFilter has set. */
GT_API GT_GetAxisEncVelFilter(short cardNum, short axis, short *filterNumExp);
/* Kept: the axis' scale of its profile; positions stay those of the profile. */
GT_API GT_SetProfileScale(short cardNum, short axis, short alpha, short beta);
/* The scale that SetProfileScale has set. */
GT_API GT_GetProfileScale(short cardNum, short axis, short *alpha, short *beta);
/* Kept: the axis' scale of its encoder; positions stay those of the encoder. */
GT_API GT_SetEncoderScale(short cardNum, short axis, short alpha, short beta);
/* The scale that SetEncoderScale has set. */
GT_API GT_GetEncoderScale(short cardNum, short axis, short *alpha, short *beta);
/* Kept: offset of a motor's analog output; no loop drives it. */
GT_API GT_SetMtrBias(short cardNum, short dac, short bias);
/* The offset that SetMtrBias has set. */
GT_API GT_GetMtrBias(short cardNum, short dac, short *bias);
/* Kept: limit of a motor's analog output; no loop drives it. */
GT_API GT_SetMtrLmt(short cardNum, short dac, short limit);
/* The limit that SetMtrLmt has set. */
GT_API GT_GetMtrLmt(short cardNum, short dac, short *limit);
/* Kept: filter of an analog input. */
GT_API GT_SetAdcFilter(short cardNum, short adc, short filterTime);
/* 1: pulses, which is so. 0, an analog output: kept, there is no loop. */
GT_API GT_CtrlMode(short cardNum, short axis, short mode);
/* Done: it reads its input. */
GT_API GT_EncOn(short cardNum, short encoder);
/* Refused: an encoder reads its input. */
GT_API GT_EncOff(short cardNum, short encoder);
/* Done: step and direction. */
GT_API GT_StepDir(short cardNum, short step);
/* Refused: pulses are step and direction. */
GT_API GT_StepPulse(short cardNum, short step);
/* 0 is so; an encoder that counts the other way round is refused. */
GT_API GT_EncSns(short cardNum, unsigned short sense);
/* 0 is so; general inputs are not inverted. */
GT_API GT_GpiSns(short cardNum, unsigned short sense);
/* Refused: no extension modules. */
GT_API GT_ExtModuleInit(short cardNum, short method GT_DEFAULT(0));
/* Refused: no extension modules. */
GT_API GT_SetExtDo(short cardNum, short index, long value);
/* Refused: no extension modules. */
GT_API GT_SetExtDoBit(short cardNum, short index, short value);
/* Refused: no extension modules. */
GT_API GT_GetExtDo(short cardNum, short index, long *value);
/* Refused: no extension modules. */
GT_API GT_GetExtDoBit(short cardNum, short index, short *value);
/* Refused: no extension modules. */
GT_API GT_GetExtDi(short cardNum, short index, long *value);
/* Refused: no extension modules. */
GT_API GT_GetExtDiBit(short cardNum, short index, short *value);
/* Refused: no extension modules. */
GT_API GT_SetExtAo(short cardNum, short index, double value);
/* Refused: no extension modules. */
GT_API GT_GetExtAi(short cardNum, short index, double *value);
/* Refused: no extension modules. */
GT_API GT_OpenExtMdl(short cardNum, const char *file GT_DEFAULT(NULL));
/* Refused: no extension modules. */
GT_API GT_CloseExtMdl(short cardNum);
/* Refused: no extension modules. */
GT_API GT_ResetExtMdl(short cardNum);
/* Refused: no extension modules. */
GT_API GT_LoadExtConfig(short cardNum, const char *file);
/* Refused: no extension modules. */
GT_API GT_SetExtIoValue(short cardNum, short mdl, unsigned short value);
/* Refused: no extension modules. */
GT_API GT_GetExtIoValue(short cardNum, short mdl, unsigned short *value);
/* Refused: no extension modules. */
GT_API GT_SetExtIoBit(short cardNum, short mdl, short index, unsigned short value);
/* Refused: no extension modules. */
GT_API GT_GetExtIoBit(short cardNum, short mdl, short index, unsigned short *value);
/* Refused: no extension modules. */
GT_API GT_GetExtAdValue(short cardNum, short mdl, short chn, unsigned short *value);
/* Refused: no extension modules. */
GT_API GT_GetExtAdVoltage(short cardNum, short mdl, short chn, double *value);
/* Refused: no extension modules. */
GT_API GT_SetExtDaValue(short cardNum, short mdl, short chn, unsigned short value);
/* Refused: no extension modules. */
GT_API GT_SetExtDaVoltage(short cardNum, short mdl, short chn, double value);
/* Refused: no handwheel input. */
GT_API GT_HandwheelInit(short cardNum);
/* Refused: no handwheel input. */
GT_API GT_SetHandwheelStopDec(short cardNum, short profile, double decSmoothStop, double decAbruptStop);
/* Refused: no handwheel input. */
GT_API GT_StartHandwheel(short cardNum, short profile, short master, short masterEven, short slaveEven, short intervalTime, double acc, double dec, double vel, short stopWaitTime);
/* Refused: no handwheel input. */
GT_API GT_EndHandwheel(short cardNum, short profile);
/* Refused: no compensation. */
GT_API GT_SetLeadScrewComp(short cardNum, short axis, short n, long startPos, long lenPos, long *compPos, long *compNeg);
/* Refused: no compensation. */
GT_API GT_EnableLeadScrewComp(short cardNum, short axis, short mode);
/* Refused: no compensation. */
GT_API GT_SetBacklash(short cardNum, short axis, long compValue, double compChangeValue, long compDir);
/* Refused: no compensation. */
GT_API GT_GetBacklash(short cardNum, short axis, long *compValue, double *compChangeValue, long *compDir);
/* Homes an axis in Trap mode by limit, home and index; the origin is 0 from then on. */
GT_API GT_GoHome(short cardNum, short axis, THomePrm *prm);
/* The parameters of the last GoHome of an axis. */
GT_API GT_GetHomePrm(short cardNum, short axis, THomePrm *prm);
/* Whether an axis is on its way home, at which stage, and what went wrong. */
GT_API GT_GetHomeStatus(short cardNum, short axis, THomeStatus *status);
/* Done: homing needs no start. */
GT_API GT_HomeInit(short cardNum);
/* Refused: no Cam. */
GT_API GT_PrfCam(short cardNum, short profile);
/* Refused: no Cam. */
GT_API GT_CamStart(short cardNum, long mask);

#endif
