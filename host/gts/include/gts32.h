/* gts32.h, for libgts32, whose long has 32 bits everywhere: one card, as GT_x(...) for its first core and GTN_x(core, ...).
 * Generated from the table of functions by `cargo xtask c-api`: change that, not this.
 * docs/c.md says what the library does; return values are those of the manuals. */
#ifndef BEAMTICK_GTS32_H
#define BEAMTICK_GTS32_H

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
    int originPos[8];
} TCrdPrm;

typedef struct TCrdData {
    short motionType;
    short circlePlat;
    int pos[8];
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
    int integralLimit;
    int derivativeLimit;
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
    int homeOffset;
    int searchHomeDistance;
    int searchIndexDistance;
    int escapeStep;
    int pad3[2];
} THomePrm;

typedef struct THomeStatus {
    short run;
    short stage;
    short error;
    short pad1;
    int capturePos;
    int targetPos;
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

/* ---- GT_: the first core of the card ------------------------------------------------------ */

/* Session */
/* Opens the controller that the environment names. */
GT_API GT_Open(short channel GT_DEFAULT(0), short param GT_DEFAULT(1));
/* Aborts (GT_Abort) and closes the controller. */
GT_API GT_Close(void);
/* The text of the calling thread's last failure, cut to size. */
GT_API GT_GetLastReason(char *text, short size);
/* Puts the axes, tables and lasers of the core into power-on state. */
GT_API GT_Reset(void);
/* Reads limits, alarms, stop decelerations and bands from a file. */
GT_API GT_LoadConfig(const char *file);
/* Clears latched status bits of count axes, and faults of lasers that they gate. */
GT_API GT_ClrSts(short axis, short count GT_DEFAULT(1));
/* The controller's version, board, profile and family as a text. */
GT_API GT_GetVersion(char **version);
/* Controller time in ms, and servo ticks since power-on. */
GT_API GT_GetClock(unsigned int *clock, unsigned int *loop GT_DEFAULT(NULL));
/* Sets the servo tick in us, at standstill. */
GT_API GT_SetTick(int tickUs);
/* After how many ms without the host the link counts as lost, and whether all motion stops then. */
GT_API GT_SetLinkLoss(int timeMs, short stopAll);
/* After how many ms the link counts as lost, 0 never, and whether all motion stops then. */
GT_API GT_GetLinkLoss(double *ms, short *stopAll);
/* What motion does on the interlock input: 0 continues with light off, 1 as at link loss, 2 stops abruptly. */
GT_API GT_SetInterlock(short motion);
/* Shuts off every laser at once and stops all motion smoothly. */
GT_API GT_Abort(void);

/* Axes */
/* Switches the servo on. */
GT_API GT_AxisOn(short axis);
/* Switches the servo off; an axis in motion stops abruptly. */
GT_API GT_AxisOff(short axis);
/* Stops axes and coordinate systems, smoothly or (option) abruptly. */
GT_API GT_Stop(int mask, int option);
/* Sets the positions of count axes at rest to 0. */
GT_API GT_ZeroPos(short axis, short count GT_DEFAULT(1));
/* Sets the planned position, pulses. */
GT_API GT_SetPrfPos(short profile, int pos);
/* Changes nothing: an axis reads what its profile and its encoder read, also after SetPrfPos. */
GT_API GT_SynchAxisPos(int mask);
/* Sets the decelerations of smooth and abrupt stops, pulse/ms^2. */
GT_API GT_SetStopDec(short profile, double decSmoothStop, double decAbruptStop);
/* The decelerations of smooth and abrupt stops, pulse/ms^2. */
GT_API GT_GetStopDec(short profile, double *decSmoothStop, double *decAbruptStop);
/* Sets the in-position band in pulses, and its time in 250 us units. */
GT_API GT_SetAxisBand(short axis, int band, int time);
/* The in-position band in pulses, and its time in 250 us units. */
GT_API GT_GetAxisBand(short axis, int *band, int *time);
/* Status words of count axes, of one tick. */
GT_API GT_GetSts(short axis, int *sts, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Why the axis stopped last, as a number and as a text cut to size. */
GT_API GT_GetStopReason(short axis, short *reason, char *text GT_DEFAULT(NULL), short size GT_DEFAULT(0));
/* Planned positions of count axes in pulses, of one tick. */
GT_API GT_GetPrfPos(short profile, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Planned velocities of count axes in pulse/ms, of one tick. */
GT_API GT_GetPrfVel(short profile, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Planned accelerations of count axes in pulse/ms^2, of one tick. */
GT_API GT_GetPrfAcc(short profile, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Modes of count axes: 0 Trap, 1 Jog, 2 PT, 4 Follow, 5 Crd, 6 PVT, 10 FollowEx. */
GT_API GT_GetPrfMode(short profile, int *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Encoder positions of count axes in pulses, of one tick. */
GT_API GT_GetEncPos(short encoder, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Encoder velocities of count axes in pulse/ms, of one tick. */
GT_API GT_GetEncVel(short encoder, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Sets an encoder's position, pulses. */
GT_API GT_SetEncPos(short encoder, int pos);
/* Sets software limits in pulses; 0x7fffffff and 0x80000000 are off. */
GT_API GT_SetSoftLimit(short axis, int positive, int negative);
/* The software limits in pulses. */
GT_API GT_GetSoftLimit(short axis, int *positive, int *negative);
/* Enables limit switches: 0 positive, 1 negative, -1 both. */
GT_API GT_LmtsOn(short axis, short limitType GT_DEFAULT(-1));
/* Disables limit switches: 0 positive, 1 negative, -1 both. */
GT_API GT_LmtsOff(short axis, short limitType GT_DEFAULT(-1));
/* Sets the active level of limit switches, two bits an axis. */
GT_API GT_LmtSns(unsigned short sense);
/* Enables the drive alarm. */
GT_API GT_AlarmOn(short axis);
/* Disables the drive alarm. */
GT_API GT_AlarmOff(short axis);
/* Sets the following-error limit, pulses. */
GT_API GT_SetPosErr(short control, int error);
/* The following-error limit, pulses. */
GT_API GT_GetPosErr(short control, int *error);
/* Arms a capture of home (1) or index (2). */
GT_API GT_SetCaptureMode(short encoder, short mode);
/* Whether captures of count encoders have come, and where. */
GT_API GT_GetCaptureStatus(short encoder, short *status, int *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));

/* Trap and Jog */
/* Puts an axis into Trap mode (point to point). */
GT_API GT_PrfTrap(short profile);
/* Sets acceleration, deceleration, start velocity and smoothing of Trap. */
GT_API GT_SetTrapPrm(short profile, TTrapPrm *prm);
/* Acceleration, deceleration, start velocity and smoothing of Trap. */
GT_API GT_GetTrapPrm(short profile, TTrapPrm *prm);
/* Puts an axis into Jog mode (steady velocity). */
GT_API GT_PrfJog(short profile);
/* Sets acceleration, deceleration and smoothing of Jog. */
GT_API GT_SetJogPrm(short profile, TJogPrm *prm);
/* Acceleration, deceleration and smoothing of Jog. */
GT_API GT_GetJogPrm(short profile, TJogPrm *prm);
/* Sets the target of Trap, pulses. */
GT_API GT_SetPos(short profile, int pos);
/* The target of Trap, pulses. */
GT_API GT_GetPos(short profile, int *pos);
/* Sets the velocity of Trap or Jog, pulse/ms. */
GT_API GT_SetVel(short profile, double vel);
/* The velocity of Trap or Jog, pulse/ms. */
GT_API GT_GetVel(short profile, double *vel);
/* Starts axes in Trap or Jog, or gives them their new targets, all on one tick. */
GT_API GT_Update(int mask);

/* Digital and analog inputs and outputs */
/* Levels of the digital inputs of a type as bits, as they are at the terminals: no sense (LmtSns) is applied. */
GT_API GT_GetDi(short diType, int *value);
/* Sets the digital outputs of a type, the first 32 of the general ones. */
GT_API GT_SetDo(short doType, int value);
/* Digital outputs of a type as bits, the first 32 of the general ones. */
GT_API GT_GetDo(short doType, int *value);
/* As GetDi in count words of 32: bit 0 of the second word is input 33. */
GT_API GT_GetDiEx(short diType, int *value, short count GT_DEFAULT(1));
/* As SetDo in count words of 32: bit 0 of the second word is output 33. Further outputs stay. */
GT_API GT_SetDoEx(short doType, int *value, short count GT_DEFAULT(1));
/* As GetDo in count words of 32. */
GT_API GT_GetDoEx(short doType, int *value, short count GT_DEFAULT(1));
/* Sets one digital output, counted from 1. */
GT_API GT_SetDoBit(short doType, short index, short value);
/* An output gets a level for a time in units of 250 us, and then the other one; 16 at a time. */
GT_API GT_SetDoBitReverse(short doType, short doIndex, short value, short reverseTime);
/* Edges of an input, or of count from one on, both directions, counted in every servo tick. */
GT_API GT_GetDiReverseCount(short diType, short diIndex, unsigned int *reverseCount, short count GT_DEFAULT(1));
/* Sets these counts; they go on from there. */
GT_API GT_SetDiReverseCount(short diType, short diIndex, unsigned int *reverseCount, short count GT_DEFAULT(1));
/* Sets count analog outputs, -32768 to 32767 for -10 to 10 V. */
GT_API GT_SetDac(short dac, short *value, short count GT_DEFAULT(1));
/* Values of count analog outputs. */
GT_API GT_GetDac(short dac, short *value, short count GT_DEFAULT(1));
/* Voltages of count analog inputs. */
GT_API GT_GetAdc(short adc, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Sets a digital input of the virtual or the emulated board: its level at the terminal, before sense. A real board returns 1. */
GT_API GT_SimInput(short diType, short index, short level);
/* Sets an analog input of the virtual or the emulated board, -12.5 to 12.5 V. A real board returns 1. */
GT_API GT_SimAdc(short adc, double volts);

/* Laser */
/* Gives axis connector 7 or 8 to step pulses (0) or to a laser (1); GUS family. */
GT_API GT_SetAxisMode(short axis, short mode);
/* Switches a laser on. */
GT_API GT_LaserOn(short channel GT_DEFAULT(0));
/* Switches a laser off. */
GT_API GT_LaserOff(short channel GT_DEFAULT(0));
/* Whether a laser is switched on. */
GT_API GT_LaserOnStatus(short *value, short channel GT_DEFAULT(0));
/* Switches a laser on (1) or off (0). */
GT_API GT_SetHSIOOpt(unsigned short value, short channel GT_DEFAULT(0));
/* Whether a laser is switched on. */
GT_API GT_GetHSIOOpt(unsigned short *value, short channel GT_DEFAULT(0));
/* How power is output: 0 duty, 1 frequency, 2 voltage, 3 duty with the switch held; and its bounds. */
GT_API GT_LaserPowerMode(short laserPowerMode, double maxValue, double minValue, short channel GT_DEFAULT(0), short delaymode GT_DEFAULT(0));
/* Sets the direct power, in the mode's unit. */
GT_API GT_LaserPrfCmd(double outputCmd, short channel GT_DEFAULT(0));
/* Sets the carrier of the duty modes, kHz. */
GT_API GT_LaserOutFrq(double outFrq, short channel GT_DEFAULT(0));
/* Sets the pulse width of the frequency mode, us. */
GT_API GT_SetPulseWidth(unsigned int width, short channel GT_DEFAULT(0));
/* Sets standby pulses of one channel: on or off, kHz, %. */
GT_API GT_SetWaitPulse(unsigned short mode, double waitPulseFrq, double waitPulseDuty, short channel GT_DEFAULT(0));
/* Sets standby pulses of both channels: on or off, kHz, %. */
GT_API GT_SetWaitPulseEx(unsigned short mode, double waitPulseFrq, double waitPulseDuty);
/* Sets the voltage of the analog mode while there is no light. */
GT_API GT_SetPreVltg(unsigned short mode, double voltageValue, short channel GT_DEFAULT(0));
/* Sets the delays of switching off and on, us. */
GT_API GT_SetLevelDelay(unsigned short offDelay, unsigned short onDelay, short channel GT_DEFAULT(0));
/* Enables first-pulse suppression with its three times, us. */
GT_API GT_EnaFPK(unsigned short time1, unsigned short time2, unsigned short laserOffDelay, short channel GT_DEFAULT(0));
/* Disables first-pulse suppression. */
GT_API GT_DisFPK(short channel GT_DEFAULT(0));
/* Chooses the frequency range: 1 to 24 kHz, 0 to 96 kHz; LSR family. */
GT_API GT_SetLaserMode(short mode);
/* Sets a channel's on-time to 0. */
GT_API GT_ZeroLaserOnTime(short channel);
/* A channel's on-time in 250 us units. */
GT_API GT_GetLaserOnTime(short channel, unsigned int *time);
/* Sets for which coordinate systems a failure shuts a channel off, as bits. */
GT_API GT_SetLaserCrdMap(short channel, short map);
/* For which coordinate systems a failure shuts a channel off. */
GT_API GT_GetLaserCrdMap(short channel, short *map);
/* The power that is output now, in the mode's unit. */
GT_API GT_GetLaserPower(short channel, double *power);
/* Why a channel is kept dark, 0 if it is not. */
GT_API GT_GetLaserFault(short channel, short *cause);
/* Clears a channel's fault whose cause is over. */
GT_API GT_ClrLaserFault(short channel);

/* Coordinate systems */
/* Sets up a coordinate system: axes, origin, greatest speed and acceleration. */
GT_API GT_SetCrdPrm(short crd, TCrdPrm *crdPrm);
/* The parameters of a coordinate system. */
GT_API GT_GetCrdPrm(short crd, TCrdPrm *crdPrm);
/* Clears a FIFO of a coordinate system. */
GT_API GT_CrdClear(short crd, short fifo GT_DEFAULT(0));
/* Free slots of a FIFO of a coordinate system. */
GT_API GT_CrdSpace(short crd, int *space, short fifo GT_DEFAULT(0));
/* Starts coordinate systems (bit k - 1 of mask is crd k); option bits take FIFO 1. */
GT_API GT_CrdStart(short mask, short option GT_DEFAULT(0));
/* Stops coordinate systems, smoothly or (option) abruptly. */
GT_API GT_CrdStop(int mask, int option GT_DEFAULT(0));
/* Whether a coordinate system runs, and how many segments are done. */
GT_API GT_CrdStatus(short crd, short *run, int *segment, short fifo GT_DEFAULT(0));
/* Why the coordinate system stopped last, as a number and as a text cut to size. */
GT_API GT_GetCrdStopReason(short crd, short *reason, char *text GT_DEFAULT(NULL), short size GT_DEFAULT(0));
/* Coordinates, pulses: one for each dimension. */
GT_API GT_GetCrdPos(short crd, double *pos);
/* Speed along the path, pulse/ms. */
GT_API GT_GetCrdVel(short crd, double *synVel);
/* Segments of a FIFO that are not done. */
GT_API GT_GetRemainderSegNum(short crd, int *segment, short fifo GT_DEFAULT(0));
/* Sets the decelerations of smooth and abrupt stops along the path, pulse/ms^2. */
GT_API GT_SetCrdStopDec(short crd, double decSmoothStop, double decAbruptStop);
/* Sets the share of the programmed speed that is run, above 0 to 1. */
GT_API GT_SetOverride(short crd, double synVelRatio);
/* Sets the time constant, ms, of the filter of the encoder speed that lasers follow; 0: none. After SetCrdPrm it is 1. */
GT_API GT_SetLaserFollowFilter(short crd, double time);
/* The time constant of the filter of the encoder speed that lasers follow, ms. */
GT_API GT_GetLaserFollowFilter(short crd, double *time);
/* Switches look-ahead of a FIFO on: corner time in ms, greatest acceleration, segments. */
GT_API GT_InitLookAhead(short crd, short fifo, double T, double accMax, short n, TCrdData *lookAheadBuf GT_DEFAULT(NULL));
/* Sets the limits of one coordinate for look-ahead, pulse/ms and pulse/ms^2; 0 is none. */
GT_API GT_SetCrdLimit(short crd, short coordinate, double velMax, double accMax);
/* The limits of one coordinate for look-ahead. */
GT_API GT_GetCrdLimit(short crd, short coordinate, double *velMax, double *accMax);
/* In a path: one motion as a struct; NULL sends what the look-ahead holds. */
GT_API GT_CrdData(short crd, TCrdData *crdData, short fifo GT_DEFAULT(0));
/* In a path: a line in X and Y. */
GT_API GT_LnXY(short crd, int x, int y, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X, Y and Z. */
GT_API GT_LnXYZ(short crd, int x, int y, int z, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X, Y, Z and A. */
GT_API GT_LnXYZA(short crd, int x, int y, int z, int a, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X and Y that ends at rest. */
GT_API GT_LnXYG0(short crd, int x, int y, double synVel, double synAcc, short fifo GT_DEFAULT(0));
/* In a path: an arc in XY by its radius; circleDir 0 clockwise, 1 counter-clockwise. */
GT_API GT_ArcXYR(short crd, int x, int y, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in XY by its centre, counted from its start; end on start is a full circle. */
GT_API GT_ArcXYC(short crd, int x, int y, double xCenter, double yCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in YZ by its radius. */
GT_API GT_ArcYZR(short crd, int y, int z, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in YZ by its centre, counted from its start. */
GT_API GT_ArcYZC(short crd, int y, int z, double yCenter, double zCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in ZX by its radius. */
GT_API GT_ArcZXR(short crd, int z, int x, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in ZX by its centre, counted from its start. */
GT_API GT_ArcZXC(short crd, int z, int x, double zCenter, double xCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: waits at rest, ms. */
GT_API GT_BufDelay(short crd, unsigned short delayTime, short fifo GT_DEFAULT(0));
/* In a path: sets digital outputs of a mask. */
GT_API GT_BufIO(short crd, unsigned short doType, unsigned short doMask, unsigned short doValue, short fifo GT_DEFAULT(0));
/* In a path: sets one digital output. */
GT_API GT_BufDoBit(short crd, unsigned short doType, unsigned short index, short value, short fifo GT_DEFAULT(0));
/* In a path: sets an analog output. */
GT_API GT_BufDA(short crd, short chn, short daValue, short fifo GT_DEFAULT(0));
/* In a path: moves another axis; modal 1 waits for its end. */
GT_API GT_BufMove(short crd, short moveAxis, int pos, double vel, double acc, short modal, short fifo GT_DEFAULT(0));
/* In a path: the next segment takes another axis along by so many pulses. */
GT_API GT_BufGear(short crd, short gearAxis, int pos, short fifo GT_DEFAULT(0));

/* Buffered laser commands */
/* In a path: switches a laser on. */
GT_API GT_BufLaserOn(short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: switches a laser off. */
GT_API GT_BufLaserOff(short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: sets the direct power. */
GT_API GT_BufLaserPrfCmd(short crd, double laserPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: from here the power follows the planned path speed, ratio times it, within its bounds. */
GT_API GT_BufLaserPrfFollow(short crd, double ratio, int minPower, int maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: whether the power follows planned (0) or encoder (1) speed, and the power at the start. */
GT_API GT_BufLaserFollowMode(short crd, short source GT_DEFAULT(0), short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0), double startPower GT_DEFAULT(GT_NOT_GIVEN));
/* In a path: from here the power follows the path speed, ratio times it, within its bounds. */
GT_API GT_BufLaserFollowRatio(short crd, double ratio, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: from here the power follows the path speed by a table. */
GT_API GT_BufLaserFollowTable(short crd, short tableId, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: the power follows the speed no more. */
GT_API GT_BufLaserFollowOff(short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* Sets a table of power against path speed. */
GT_API GT_SetLaserFollowTable(short tableId, int count, double *vel, double *power, short channel GT_DEFAULT(0));

/* Laser power by distance */
/* Switches power by distance on or off, with reference positions and scales of axes 1 to 4. */
GT_API GT_SetLaserDisMode(short mode, short source, int *pos GT_DEFAULT(NULL), double *scale GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
/* Sets the ratios of power by distance, and its bounds. */
GT_API GT_SetLaserDisRatio(double *ratio, double minPower, double maxPower, short channel GT_DEFAULT(0));
#ifdef __cplusplus
static inline short GT_SetLaserDisRatio(double *ratio, short channel = 0)
{
    return GT_SetLaserDisRatio(ratio, GT_NOT_GIVEN, GT_NOT_GIVEN, channel);
}
#endif
/* Sets ratios by position for each of axes 1 to 4. */
GT_API GT_SetLaserDisTable1D(short count, double *ratio, int *pos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
/* Sets ratios by the positions of two axes. */
GT_API GT_SetLaserDisTable2D(short *axisIndex, short *count, double *ratio, int *xPos, int *yPos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));

/* PT */
/* Puts an axis into PT mode: static or dynamic FIFO. */
GT_API GT_PrfPt(short profile, short mode GT_DEFAULT(0));
/* Free slots of a PT FIFO. */
GT_API GT_PtSpace(short profile, short *space, short fifo GT_DEFAULT(0));
/* A PT segment: end position in pulses, end time in ms, type. */
GT_API GT_PtData(short profile, double pos, int time, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a PT FIFO. */
GT_API GT_PtClear(short profile, short fifo GT_DEFAULT(0));
/* Sets how many passes run; 0 for ever. */
GT_API GT_SetPtLoop(short profile, int loop);
/* Passes that were completed. */
GT_API GT_GetPtLoop(short profile, int *loop);
/* Sets the size of PT FIFOs: 0 for 32 segments, 1 for 1024. */
GT_API GT_SetPtMemory(short profile, short memory);
/* The size of PT FIFOs. */
GT_API GT_GetPtMemory(short profile, short *memory);
/* Starts axes in PT, all on one tick; option bits take FIFO 1. */
GT_API GT_PtStart(int mask, int option GT_DEFAULT(0));
/* Starts axes in PT by lists of axes and FIFOs. */
GT_API GT_PtStartPro(short *axis, short *option, short count);

/* PVT */
/* Puts an axis into PVT mode. */
GT_API GT_PrfPvt(short profile);
/* Sets how many passes run; 0 for ever. */
GT_API GT_SetPvtLoop(short profile, int loop);
/* Passes that were completed, and to run. */
GT_API GT_GetPvtLoop(short profile, int *loopCount, int *loop);
/* Tables in force of count axes, and times in them. */
GT_API GT_PvtStatus(short profile, short *tableId, double *time, short count GT_DEFAULT(1));
/* Starts axes in PVT, all on one tick. */
GT_API GT_PvtStart(int mask);
/* Chooses an axis's table; while it runs, from the next pass on. */
GT_API GT_PvtTableSelect(short profile, short tableId);
/* Fills a table with times, positions and velocities. */
GT_API GT_PvtTable(short tableId, int count, double *time, double *pos, double *vel);
/* Fills a table with velocities at the begin and the end of each segment; a point where they differ takes two of 1024 points. */
GT_API GT_PvtTableEx(short tableId, int count, double *time, double *pos, double *velBegin, double *velEnd);
/* Fills a table whose acceleration is continuous. */
GT_API GT_PvtTableComplete(short tableId, int count, double *time, double *pos, double *a, double *b, double *c, double velBegin GT_DEFAULT(0), double velEnd GT_DEFAULT(0));
/* Fills a table with percentages of S-shape. */
GT_API GT_PvtTablePercent(short tableId, int count, double *time, double *pos, double *percent, double velBegin GT_DEFAULT(0));
/* The velocities of a Percent table. */
GT_API GT_PvtPercentCalculate(int count, double *time, double *pos, double *percent, double velBegin, double *vel);
/* Fills a table by positions, velocities and limits; the controller finds the times. */
GT_API GT_PvtTableContinuous(short tableId, int count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double timeBegin);
/* The times of a Continuous table. */
GT_API GT_PvtContinuousCalculate(int count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double *time);
/* Puts an axis into Gear mode: direction of the master 0 both, 1, -1. */
GT_API GT_PrfGear(short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GT_SetGearMaster(short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GT_GetGearMaster(short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets the ratio slaveEven/masterEven of the next GearStart, reached over masterSlope pulses of the master; 0 at once. */
GT_API GT_SetGearRatio(short profile, int masterEven, int slaveEven, int masterSlope GT_DEFAULT(0));
/* The ratio that SetGearRatio has set. */
GT_API GT_GetGearRatio(short profile, int *masterEven, int *slaveEven, int *masterSlope GT_DEFAULT(NULL));
/* Starts axes in Gear; one that runs takes the ratio that was set last. */
GT_API GT_GearStart(int mask);
/* Sets when the gear begins: 1 at once, 2 when the master crosses position startPara1, upwards (startPara0 1) or downwards (-1). */
GT_API GT_SetGearEvent(short profile, short event, int startPara0, int startPara1);
/* When the gear begins. */
GT_API GT_GetGearEvent(short profile, short *event, int *startPara0, int *startPara1);

/* Follow */
/* Puts an axis into Follow mode: direction of the master 0 both, 1, -1. */
GT_API GT_PrfFollow(short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GT_SetFollowMaster(short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GT_GetFollowMaster(short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets how many passes run; 0 for ever. */
GT_API GT_SetFollowLoop(short profile, int loop);
/* Passes that were completed. */
GT_API GT_GetFollowLoop(short profile, int *loop);
/* Sets when following begins: at once, or when the master, not there yet, comes to a position. */
GT_API GT_SetFollowEvent(short profile, short event, short masterDir, int pos GT_DEFAULT(0));
/* When following begins. */
GT_API GT_GetFollowEvent(short profile, short *event, short *masterDir, int *pos);
/* Free slots of a Follow FIFO. */
GT_API GT_FollowSpace(short profile, short *space, short fifo GT_DEFAULT(0));
/* A Follow segment: displacement of the master, displacement of the slave, type. */
GT_API GT_FollowData(short profile, int masterSegment, double slaveSegment, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a Follow FIFO. */
GT_API GT_FollowClear(short profile, short fifo GT_DEFAULT(0));
/* Starts axes in Follow; option bits take FIFO 1. */
GT_API GT_FollowStart(int mask, int option GT_DEFAULT(0));
/* Goes over to the other FIFO when the pass has ended. */
GT_API GT_FollowSwitch(int mask);
/* Sets the size of Follow FIFOs: 0 for 16 segments, 1 for 512. */
GT_API GT_SetFollowMemory(short profile, short memory);
/* The size of Follow FIFOs. */
GT_API GT_GetFollowMemory(short profile, short *memory);
/* The FIFO in force, and whether a switch waits. */
GT_API GT_GetFollowStatus(short profile, short *fifoNum, short *switchStatus);

/* FollowEx */
/* Puts an axis into FollowEx mode: direction of the master 0 both, 1, -1. */
GT_API GT_PrfFollowEx(short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GT_SetFollowMasterEx(short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GT_GetFollowMasterEx(short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets how many passes run; 0 for ever. */
GT_API GT_SetFollowLoopEx(short profile, int loop);
/* Passes that were completed. */
GT_API GT_GetFollowLoopEx(short profile, int *loop);
/* Sets when following begins: at once, or when the master, not there yet, comes to a position. */
GT_API GT_SetFollowEventEx(short profile, short event, short masterDir, int pos GT_DEFAULT(0));
/* When following begins. */
GT_API GT_GetFollowEventEx(short profile, short *event, short *masterDir, int *pos);
/* Free slots of a FollowEx FIFO. */
GT_API GT_FollowSpaceEx(short profile, short *space, short fifo GT_DEFAULT(0));
/* A FollowEx segment with a percentage of S-shape. */
GT_API GT_FollowDataPercentEx(short profile, double masterSegment, double slaveSegment, short type GT_DEFAULT(0), short percent GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a FollowEx FIFO. */
GT_API GT_FollowClearEx(short profile, short fifo GT_DEFAULT(0));
/* Starts axes in FollowEx; option bits take FIFO 1. */
GT_API GT_FollowStartEx(int mask, int option GT_DEFAULT(0));
/* Goes over to the other FIFO when the pass has ended. */
GT_API GT_FollowSwitchEx(int mask);
/* Sets the size of FollowEx FIFOs: 0 for 16 segments, 1 for 512. */
GT_API GT_SetFollowMemoryEx(short profile, short memory);
/* The size of FollowEx FIFOs. */
GT_API GT_GetFollowMemoryEx(short profile, short *memory);
/* The FIFO in force, and whether a switch waits. */
GT_API GT_GetFollowStatusEx(short profile, short *fifoNum, short *switchStatus);
/* Goes over at once, by segment or by table; or as an entry of a FIFO. */
GT_API GT_FollowSwitchNowEx(short profile, short method, short buffer GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: sets a digital output. */
GT_API GT_FollowDoBitEx(short profile, short doType, short index, short value, short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: the slave is at standstill for so many 250 us. */
GT_API GT_FollowDelayEx(short profile, unsigned int delayTime, short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: the slave is at standstill until an input has a level, or a time in ms is over. */
GT_API GT_FollowDiBitEx(short profile, short diType, short index, short value, unsigned int time GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* A FollowEx segment with velocity ratios at begin and end. */
GT_API GT_FollowDataPercent2Ex(short profile, double masterSegment, double slaveSegment, double velBeginRatio, double velEndRatio, short percent GT_DEFAULT(100), short *percent1 GT_DEFAULT(NULL), short fifo GT_DEFAULT(0));
/* The displacement of such a segment, for a share of S-shape in its first half. */
GT_API GT_GetFollowDataPercent2Ex(double masterPos, double v1, double v2, double p, double p1, double *slavePos);

/* Beyond the manuals: what is kept changes nothing, what is refused returns 1 (docs/api.md) */
/* Levels at the terminals; what GetDi returns, which no sense changes. */
GT_API GT_GetDiRaw(short diType, int *value);
/* Waits for so many ms of the controller's time. */
GT_API GT_Delay(unsigned short time);
/* Waits for so many 250 us of the controller's time. */
GT_API GT_DelayHighPrecision(unsigned short time);
/* Controller time in 125 us since power-on. */
GT_API GT_GetClockHighPrecision(unsigned int *clock);
/* Kept: gains of a position loop; there is no loop. */
GT_API GT_SetPid(short control, short index, TPid *pid);
/* The gains that SetPid has set. */
GT_API GT_GetPid(short control, short index, TPid *pid);
/* Kept: which set of gains is in force. */
GT_API GT_SetControlFilter(short control, short index);
/* The set of gains that SetControlFilter has chosen. */
GT_API GT_GetControlFilter(short control, short *index);
/* Kept: filter of the velocity feed-forward. */
GT_API GT_SetKvffFilter(short control, short kvffFilterExp, double accMax);
/* The filter that SetKvffFilter has set. */
GT_API GT_GetKvffFilter(short control, short *kvffFilterExp, double *accMax);
/* Kept: filter of the planned velocity that is shown. */
GT_API GT_SetAxisPrfVelFilter(short axis, short filterNumExp);
/* The filter that SetAxisPrfVelFilter has set. */
GT_API GT_GetAxisPrfVelFilter(short axis, short *filterNumExp);
/* Kept: filter of the encoder's velocity that is shown. */
GT_API GT_SetAxisEncVelFilter(short axis, short filterNumExp);
/* The filter that SetAxisEncVelFilter has set. */
GT_API GT_GetAxisEncVelFilter(short axis, short *filterNumExp);
/* Kept: the axis' scale of its profile; positions stay those of the profile. */
GT_API GT_SetProfileScale(short axis, short alpha, short beta);
/* The scale that SetProfileScale has set. */
GT_API GT_GetProfileScale(short axis, short *alpha, short *beta);
/* Kept: the axis' scale of its encoder; positions stay those of the encoder. */
GT_API GT_SetEncoderScale(short axis, short alpha, short beta);
/* The scale that SetEncoderScale has set. */
GT_API GT_GetEncoderScale(short axis, short *alpha, short *beta);
/* Kept: offset of a motor's analog output; no loop drives it. */
GT_API GT_SetMtrBias(short dac, short bias);
/* The offset that SetMtrBias has set. */
GT_API GT_GetMtrBias(short dac, short *bias);
/* Kept: limit of a motor's analog output; no loop drives it. */
GT_API GT_SetMtrLmt(short dac, short limit);
/* The limit that SetMtrLmt has set. */
GT_API GT_GetMtrLmt(short dac, short *limit);
/* Kept: filter of an analog input. */
GT_API GT_SetAdcFilter(short adc, short filterTime);
/* 1: pulses, which is so. 0, an analog output: kept, there is no loop. */
GT_API GT_CtrlMode(short axis, short mode);
/* Done: it reads its input. */
GT_API GT_EncOn(short encoder);
/* Refused: an encoder reads its input. */
GT_API GT_EncOff(short encoder);
/* Done: step and direction. */
GT_API GT_StepDir(short step);
/* Refused: pulses are step and direction. */
GT_API GT_StepPulse(short step);
/* 0 is so; an encoder that counts the other way round is refused. */
GT_API GT_EncSns(unsigned short sense);
/* 0 is so; general inputs are not inverted. */
GT_API GT_GpiSns(unsigned short sense);
/* Refused: no extension modules. */
GT_API GT_ExtModuleInit(short method GT_DEFAULT(0));
/* Refused: no extension modules. */
GT_API GT_SetExtDo(short index, int value);
/* Refused: no extension modules. */
GT_API GT_SetExtDoBit(short index, short value);
/* Refused: no extension modules. */
GT_API GT_GetExtDo(short index, int *value);
/* Refused: no extension modules. */
GT_API GT_GetExtDoBit(short index, short *value);
/* Refused: no extension modules. */
GT_API GT_GetExtDi(short index, int *value);
/* Refused: no extension modules. */
GT_API GT_GetExtDiBit(short index, short *value);
/* Refused: no extension modules. */
GT_API GT_SetExtAo(short index, double value);
/* Refused: no extension modules. */
GT_API GT_GetExtAi(short index, double *value);
/* Refused: no extension modules. */
GT_API GT_OpenExtMdl(const char *file GT_DEFAULT(NULL));
/* Refused: no extension modules. */
GT_API GT_CloseExtMdl(void);
/* Refused: no extension modules. */
GT_API GT_ResetExtMdl(void);
/* Refused: no extension modules. */
GT_API GT_LoadExtConfig(const char *file);
/* Refused: no extension modules. */
GT_API GT_SetExtIoValue(short mdl, unsigned short value);
/* Refused: no extension modules. */
GT_API GT_GetExtIoValue(short mdl, unsigned short *value);
/* Refused: no extension modules. */
GT_API GT_SetExtIoBit(short mdl, short index, unsigned short value);
/* Refused: no extension modules. */
GT_API GT_GetExtIoBit(short mdl, short index, unsigned short *value);
/* Refused: no extension modules. */
GT_API GT_GetExtAdValue(short mdl, short chn, unsigned short *value);
/* Refused: no extension modules. */
GT_API GT_GetExtAdVoltage(short mdl, short chn, double *value);
/* Refused: no extension modules. */
GT_API GT_SetExtDaValue(short mdl, short chn, unsigned short value);
/* Refused: no extension modules. */
GT_API GT_SetExtDaVoltage(short mdl, short chn, double value);
/* Refused: no handwheel input. */
GT_API GT_HandwheelInit(void);
/* Refused: no handwheel input. */
GT_API GT_SetHandwheelStopDec(short profile, double decSmoothStop, double decAbruptStop);
/* Refused: no handwheel input. */
GT_API GT_StartHandwheel(short profile, short master, short masterEven, short slaveEven, short intervalTime, double acc, double dec, double vel, short stopWaitTime);
/* Refused: no handwheel input. */
GT_API GT_EndHandwheel(short profile);
/* Refused: no compensation. */
GT_API GT_SetLeadScrewComp(short axis, short n, int startPos, int lenPos, int *compPos, int *compNeg);
/* Refused: no compensation. */
GT_API GT_EnableLeadScrewComp(short axis, short mode);
/* Refused: no compensation. */
GT_API GT_SetBacklash(short axis, int compValue, double compChangeValue, int compDir);
/* Refused: no compensation. */
GT_API GT_GetBacklash(short axis, int *compValue, double *compChangeValue, int *compDir);
/* Homes an axis in Trap mode by limit, home and index; the origin is 0 from then on. */
GT_API GT_GoHome(short axis, THomePrm *prm);
/* The parameters of the last GoHome of an axis. */
GT_API GT_GetHomePrm(short axis, THomePrm *prm);
/* Whether an axis is on its way home, at which stage, and what went wrong. */
GT_API GT_GetHomeStatus(short axis, THomeStatus *status);
/* Done: homing needs no start. */
GT_API GT_HomeInit(void);
/* Refused: no Cam. */
GT_API GT_PrfCam(short profile);
/* Refused: no Cam. */
GT_API GT_CamStart(int mask);

/* ---- GTN_: the core comes first ----------------------------------------------------------- */

/* Session */
/* Opens the controller that the environment names. */
GT_API GTN_Open(short channel GT_DEFAULT(0), short param GT_DEFAULT(1));
/* Aborts (GT_Abort) and closes the controller. */
GT_API GTN_Close(void);
/* The text of the calling thread's last failure, cut to size. */
GT_API GTN_GetLastReason(short core, char *text, short size);
/* Puts the axes, tables and lasers of the core into power-on state. */
GT_API GTN_Reset(short core);
/* Reads limits, alarms, stop decelerations and bands from a file. */
GT_API GTN_LoadConfig(short core, const char *file);
/* Clears latched status bits of count axes, and faults of lasers that they gate. */
GT_API GTN_ClrSts(short core, short axis, short count GT_DEFAULT(1));
/* The controller's version, board, profile and family as a text. */
GT_API GTN_GetVersion(short core, char **version);
/* Controller time in ms, and servo ticks since power-on. */
GT_API GTN_GetClock(short core, unsigned int *clock, unsigned int *loop GT_DEFAULT(NULL));
/* Sets the servo tick in us, at standstill. */
GT_API GTN_SetTick(short core, int tickUs);
/* After how many ms without the host the link counts as lost, and whether all motion stops then. */
GT_API GTN_SetLinkLoss(short core, int timeMs, short stopAll);
/* After how many ms the link counts as lost, 0 never, and whether all motion stops then. */
GT_API GTN_GetLinkLoss(short core, double *ms, short *stopAll);
/* What motion does on the interlock input: 0 continues with light off, 1 as at link loss, 2 stops abruptly. */
GT_API GTN_SetInterlock(short core, short motion);
/* Shuts off every laser at once and stops all motion smoothly. */
GT_API GTN_Abort(short core);

/* Axes */
/* Switches the servo on. */
GT_API GTN_AxisOn(short core, short axis);
/* Switches the servo off; an axis in motion stops abruptly. */
GT_API GTN_AxisOff(short core, short axis);
/* Stops axes and coordinate systems, smoothly or (option) abruptly. */
GT_API GTN_Stop(short core, int mask, int option);
/* Sets the positions of count axes at rest to 0. */
GT_API GTN_ZeroPos(short core, short axis, short count GT_DEFAULT(1));
/* Sets the planned position, pulses. */
GT_API GTN_SetPrfPos(short core, short profile, int pos);
/* Changes nothing: an axis reads what its profile and its encoder read, also after SetPrfPos. */
GT_API GTN_SynchAxisPos(short core, int mask);
/* Sets the decelerations of smooth and abrupt stops, pulse/ms^2. */
GT_API GTN_SetStopDec(short core, short profile, double decSmoothStop, double decAbruptStop);
/* The decelerations of smooth and abrupt stops, pulse/ms^2. */
GT_API GTN_GetStopDec(short core, short profile, double *decSmoothStop, double *decAbruptStop);
/* Sets the in-position band in pulses, and its time in 250 us units. */
GT_API GTN_SetAxisBand(short core, short axis, int band, int time);
/* The in-position band in pulses, and its time in 250 us units. */
GT_API GTN_GetAxisBand(short core, short axis, int *band, int *time);
/* Status words of count axes, of one tick. */
GT_API GTN_GetSts(short core, short axis, int *sts, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Why the axis stopped last, as a number and as a text cut to size. */
GT_API GTN_GetStopReason(short core, short axis, short *reason, char *text GT_DEFAULT(NULL), short size GT_DEFAULT(0));
/* Planned positions of count axes in pulses, of one tick. */
GT_API GTN_GetPrfPos(short core, short profile, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Planned velocities of count axes in pulse/ms, of one tick. */
GT_API GTN_GetPrfVel(short core, short profile, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Planned accelerations of count axes in pulse/ms^2, of one tick. */
GT_API GTN_GetPrfAcc(short core, short profile, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Modes of count axes: 0 Trap, 1 Jog, 2 PT, 4 Follow, 5 Crd, 6 PVT, 10 FollowEx. */
GT_API GTN_GetPrfMode(short core, short profile, int *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Encoder positions of count axes in pulses, of one tick. */
GT_API GTN_GetEncPos(short core, short encoder, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Encoder velocities of count axes in pulse/ms, of one tick. */
GT_API GTN_GetEncVel(short core, short encoder, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Sets an encoder's position, pulses. */
GT_API GTN_SetEncPos(short core, short encoder, int pos);
/* Sets software limits in pulses; 0x7fffffff and 0x80000000 are off. */
GT_API GTN_SetSoftLimit(short core, short axis, int positive, int negative);
/* The software limits in pulses. */
GT_API GTN_GetSoftLimit(short core, short axis, int *positive, int *negative);
/* Enables limit switches: 0 positive, 1 negative, -1 both. */
GT_API GTN_LmtsOn(short core, short axis, short limitType GT_DEFAULT(-1));
/* Disables limit switches: 0 positive, 1 negative, -1 both. */
GT_API GTN_LmtsOff(short core, short axis, short limitType GT_DEFAULT(-1));
/* Sets the active level of limit switches, two bits an axis. */
GT_API GTN_LmtSns(short core, unsigned short sense);
/* Enables the drive alarm. */
GT_API GTN_AlarmOn(short core, short axis);
/* Disables the drive alarm. */
GT_API GTN_AlarmOff(short core, short axis);
/* Sets the following-error limit, pulses. */
GT_API GTN_SetPosErr(short core, short control, int error);
/* The following-error limit, pulses. */
GT_API GTN_GetPosErr(short core, short control, int *error);
/* Arms a capture of home (1) or index (2). */
GT_API GTN_SetCaptureMode(short core, short encoder, short mode);
/* Whether captures of count encoders have come, and where. */
GT_API GTN_GetCaptureStatus(short core, short encoder, short *status, int *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));

/* Trap and Jog */
/* Puts an axis into Trap mode (point to point). */
GT_API GTN_PrfTrap(short core, short profile);
/* Sets acceleration, deceleration, start velocity and smoothing of Trap. */
GT_API GTN_SetTrapPrm(short core, short profile, TTrapPrm *prm);
/* Acceleration, deceleration, start velocity and smoothing of Trap. */
GT_API GTN_GetTrapPrm(short core, short profile, TTrapPrm *prm);
/* Puts an axis into Jog mode (steady velocity). */
GT_API GTN_PrfJog(short core, short profile);
/* Sets acceleration, deceleration and smoothing of Jog. */
GT_API GTN_SetJogPrm(short core, short profile, TJogPrm *prm);
/* Acceleration, deceleration and smoothing of Jog. */
GT_API GTN_GetJogPrm(short core, short profile, TJogPrm *prm);
/* Sets the target of Trap, pulses. */
GT_API GTN_SetPos(short core, short profile, int pos);
/* The target of Trap, pulses. */
GT_API GTN_GetPos(short core, short profile, int *pos);
/* Sets the velocity of Trap or Jog, pulse/ms. */
GT_API GTN_SetVel(short core, short profile, double vel);
/* The velocity of Trap or Jog, pulse/ms. */
GT_API GTN_GetVel(short core, short profile, double *vel);
/* Starts axes in Trap or Jog, or gives them their new targets, all on one tick. */
GT_API GTN_Update(short core, int mask);

/* Digital and analog inputs and outputs */
/* Levels of the digital inputs of a type as bits, as they are at the terminals: no sense (LmtSns) is applied. */
GT_API GTN_GetDi(short core, short diType, int *value);
/* Sets the digital outputs of a type, the first 32 of the general ones. */
GT_API GTN_SetDo(short core, short doType, int value);
/* Digital outputs of a type as bits, the first 32 of the general ones. */
GT_API GTN_GetDo(short core, short doType, int *value);
/* As GetDi in count words of 32: bit 0 of the second word is input 33. */
GT_API GTN_GetDiEx(short core, short diType, int *value, short count GT_DEFAULT(1));
/* As SetDo in count words of 32: bit 0 of the second word is output 33. Further outputs stay. */
GT_API GTN_SetDoEx(short core, short doType, int *value, short count GT_DEFAULT(1));
/* As GetDo in count words of 32. */
GT_API GTN_GetDoEx(short core, short doType, int *value, short count GT_DEFAULT(1));
/* Sets one digital output, counted from 1. */
GT_API GTN_SetDoBit(short core, short doType, short index, short value);
/* An output gets a level for a time in units of 250 us, and then the other one; 16 at a time. */
GT_API GTN_SetDoBitReverse(short core, short doType, short doIndex, short value, short reverseTime);
/* Edges of an input, or of count from one on, both directions, counted in every servo tick. */
GT_API GTN_GetDiReverseCount(short core, short diType, short diIndex, unsigned int *reverseCount, short count GT_DEFAULT(1));
/* Sets these counts; they go on from there. */
GT_API GTN_SetDiReverseCount(short core, short diType, short diIndex, unsigned int *reverseCount, short count GT_DEFAULT(1));
/* Sets count analog outputs, -32768 to 32767 for -10 to 10 V. */
GT_API GTN_SetDac(short core, short dac, short *value, short count GT_DEFAULT(1));
/* Values of count analog outputs. */
GT_API GTN_GetDac(short core, short dac, short *value, short count GT_DEFAULT(1));
/* Voltages of count analog inputs. */
GT_API GTN_GetAdc(short core, short adc, double *value, short count GT_DEFAULT(1), unsigned int *clock GT_DEFAULT(NULL));
/* Sets a digital input of the virtual or the emulated board: its level at the terminal, before sense. A real board returns 1. */
GT_API GTN_SimInput(short core, short diType, short index, short level);
/* Sets an analog input of the virtual or the emulated board, -12.5 to 12.5 V. A real board returns 1. */
GT_API GTN_SimAdc(short core, short adc, double volts);

/* Laser */
/* Gives axis connector 7 or 8 to step pulses (0) or to a laser (1); GUS family. */
GT_API GTN_SetAxisMode(short core, short axis, short mode);
/* Switches a laser on. */
GT_API GTN_LaserOn(short core, short channel GT_DEFAULT(0));
/* Switches a laser off. */
GT_API GTN_LaserOff(short core, short channel GT_DEFAULT(0));
/* Whether a laser is switched on. */
GT_API GTN_LaserOnStatus(short core, short *value, short channel GT_DEFAULT(0));
/* Switches a laser on (1) or off (0). */
GT_API GTN_SetHSIOOpt(short core, unsigned short value, short channel GT_DEFAULT(0));
/* Whether a laser is switched on. */
GT_API GTN_GetHSIOOpt(short core, unsigned short *value, short channel GT_DEFAULT(0));
/* How power is output: 0 duty, 1 frequency, 2 voltage, 3 duty with the switch held; and its bounds. */
GT_API GTN_LaserPowerMode(short core, short laserPowerMode, double maxValue, double minValue, short channel GT_DEFAULT(0));
/* Sets the direct power, in the mode's unit. */
GT_API GTN_LaserPrfCmd(short core, double outputCmd, short channel GT_DEFAULT(0));
/* Sets the carrier of the duty modes, kHz. */
GT_API GTN_LaserOutFrq(short core, double outFrq, short channel GT_DEFAULT(0));
/* Sets the pulse width of the frequency mode, us. */
GT_API GTN_SetPulseWidth(short core, unsigned short width, short channel GT_DEFAULT(0));
/* Sets standby pulses of one channel: on or off, kHz, %. */
GT_API GTN_SetWaitPulse(short core, unsigned short mode, double waitPulseFrq, double waitPulseDuty, short channel GT_DEFAULT(0));
/* Sets standby pulses of both channels: on or off, kHz, %. */
GT_API GTN_SetWaitPulseEx(short core, unsigned short mode, double waitPulseFrq, double waitPulseDuty);
/* Sets the voltage of the analog mode while there is no light. */
GT_API GTN_SetPreVltg(short core, unsigned short mode, double voltageValue, short channel GT_DEFAULT(0));
/* Sets the delays of switching off and on, us. */
GT_API GTN_SetLevelDelay(short core, unsigned int offDelay, unsigned int onDelay, short channel GT_DEFAULT(0));
/* Enables first-pulse suppression with its three times, us. */
GT_API GTN_EnaFPK(short core, unsigned short time1, unsigned short time2, unsigned short laserOffDelay, short channel GT_DEFAULT(0));
/* Disables first-pulse suppression. */
GT_API GTN_DisFPK(short core, short channel GT_DEFAULT(0));
/* Chooses the frequency range: 1 to 24 kHz, 0 to 96 kHz; LSR family. */
GT_API GTN_SetLaserMode(short core, short mode);
/* Sets a channel's on-time to 0. */
GT_API GTN_ZeroLaserOnTime(short core, short channel);
/* A channel's on-time in 250 us units. */
GT_API GTN_GetLaserOnTime(short core, short channel, unsigned int *time);
/* Sets for which coordinate systems a failure shuts a channel off, as bits. */
GT_API GTN_SetLaserCrdMap(short core, short channel, short map);
/* For which coordinate systems a failure shuts a channel off. */
GT_API GTN_GetLaserCrdMap(short core, short channel, short *map);
/* The power that is output now, in the mode's unit. */
GT_API GTN_GetLaserPower(short core, short channel, double *power);
/* Why a channel is kept dark, 0 if it is not. */
GT_API GTN_GetLaserFault(short core, short channel, short *cause);
/* Clears a channel's fault whose cause is over. */
GT_API GTN_ClrLaserFault(short core, short channel);

/* Coordinate systems */
/* Sets up a coordinate system: axes, origin, greatest speed and acceleration. */
GT_API GTN_SetCrdPrm(short core, short crd, TCrdPrm *crdPrm);
/* The parameters of a coordinate system. */
GT_API GTN_GetCrdPrm(short core, short crd, TCrdPrm *crdPrm);
/* Clears a FIFO of a coordinate system. */
GT_API GTN_CrdClear(short core, short crd, short fifo GT_DEFAULT(0));
/* Free slots of a FIFO of a coordinate system. */
GT_API GTN_CrdSpace(short core, short crd, int *space, short fifo GT_DEFAULT(0));
/* Starts coordinate systems (bit k - 1 of mask is crd k); option bits take FIFO 1. */
GT_API GTN_CrdStart(short core, short mask, short option GT_DEFAULT(0));
/* Stops coordinate systems, smoothly or (option) abruptly. */
GT_API GTN_CrdStop(short core, int mask, int option GT_DEFAULT(0));
/* Whether a coordinate system runs, and how many segments are done. */
GT_API GTN_CrdStatus(short core, short crd, short *run, int *segment, short fifo GT_DEFAULT(0));
/* Why the coordinate system stopped last, as a number and as a text cut to size. */
GT_API GTN_GetCrdStopReason(short core, short crd, short *reason, char *text GT_DEFAULT(NULL), short size GT_DEFAULT(0));
/* Coordinates, pulses: one for each dimension. */
GT_API GTN_GetCrdPos(short core, short crd, double *pos);
/* Speed along the path, pulse/ms. */
GT_API GTN_GetCrdVel(short core, short crd, double *synVel);
/* Segments of a FIFO that are not done. */
GT_API GTN_GetRemainderSegNum(short core, short crd, int *segment, short fifo GT_DEFAULT(0));
/* Sets the decelerations of smooth and abrupt stops along the path, pulse/ms^2. */
GT_API GTN_SetCrdStopDec(short core, short crd, double decSmoothStop, double decAbruptStop);
/* Sets the share of the programmed speed that is run, above 0 to 1. */
GT_API GTN_SetOverride(short core, short crd, double synVelRatio);
/* Sets the time constant, ms, of the filter of the encoder speed that lasers follow; 0: none. After SetCrdPrm it is 1. */
GT_API GTN_SetLaserFollowFilter(short core, short crd, double time);
/* The time constant of the filter of the encoder speed that lasers follow, ms. */
GT_API GTN_GetLaserFollowFilter(short core, short crd, double *time);
/* Switches look-ahead of a FIFO on: corner time in ms, greatest acceleration, segments. */
GT_API GTN_InitLookAhead(short core, short crd, short fifo, double T, double accMax, short n, TCrdData *lookAheadBuf GT_DEFAULT(NULL));
/* Sets the limits of one coordinate for look-ahead, pulse/ms and pulse/ms^2; 0 is none. */
GT_API GTN_SetCrdLimit(short core, short crd, short coordinate, double velMax, double accMax);
/* The limits of one coordinate for look-ahead. */
GT_API GTN_GetCrdLimit(short core, short crd, short coordinate, double *velMax, double *accMax);
/* In a path: one motion as a struct; NULL sends what the look-ahead holds. */
GT_API GTN_CrdData(short core, short crd, TCrdData *crdData, short fifo GT_DEFAULT(0));
/* In a path: a line in X and Y. */
GT_API GTN_LnXY(short core, short crd, int x, int y, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X, Y and Z. */
GT_API GTN_LnXYZ(short core, short crd, int x, int y, int z, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X, Y, Z and A. */
GT_API GTN_LnXYZA(short core, short crd, int x, int y, int z, int a, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: a line in X and Y that ends at rest. */
GT_API GTN_LnXYG0(short core, short crd, int x, int y, double synVel, double synAcc, short fifo GT_DEFAULT(0));
/* In a path: an arc in XY by its radius; circleDir 0 clockwise, 1 counter-clockwise. */
GT_API GTN_ArcXYR(short core, short crd, int x, int y, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in XY by its centre, counted from its start; end on start is a full circle. */
GT_API GTN_ArcXYC(short core, short crd, int x, int y, double xCenter, double yCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in YZ by its radius. */
GT_API GTN_ArcYZR(short core, short crd, int y, int z, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in YZ by its centre, counted from its start. */
GT_API GTN_ArcYZC(short core, short crd, int y, int z, double yCenter, double zCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in ZX by its radius. */
GT_API GTN_ArcZXR(short core, short crd, int z, int x, double radius, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: an arc in ZX by its centre, counted from its start. */
GT_API GTN_ArcZXC(short core, short crd, int z, int x, double zCenter, double xCenter, short circleDir, double synVel, double synAcc, double velEnd GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a path: waits at rest, ms. */
GT_API GTN_BufDelay(short core, short crd, unsigned short delayTime, short fifo GT_DEFAULT(0));
/* In a path: sets digital outputs of a mask. */
GT_API GTN_BufIO(short core, short crd, unsigned short doType, unsigned short doMask, unsigned short doValue, short fifo GT_DEFAULT(0));
/* In a path: sets one digital output. */
GT_API GTN_BufDoBit(short core, short crd, unsigned short doType, unsigned short index, short value, short fifo GT_DEFAULT(0));
/* In a path: sets an analog output. */
GT_API GTN_BufDA(short core, short crd, short chn, short daValue, short fifo GT_DEFAULT(0));
/* In a path: moves another axis; modal 1 waits for its end. */
GT_API GTN_BufMove(short core, short crd, short moveAxis, int pos, double vel, double acc, short modal, short fifo GT_DEFAULT(0));
/* In a path: the next segment takes another axis along by so many pulses. */
GT_API GTN_BufGear(short core, short crd, short gearAxis, int pos, short fifo GT_DEFAULT(0));

/* Buffered laser commands */
/* In a path: switches a laser on. */
GT_API GTN_BufLaserOn(short core, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: switches a laser off. */
GT_API GTN_BufLaserOff(short core, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: sets the direct power. */
GT_API GTN_BufLaserPrfCmd(short core, short crd, double laserPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: from here the power follows the planned path speed, ratio times it, within its bounds. */
GT_API GTN_BufLaserPrfFollow(short core, short crd, double ratio, int minPower, int maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: whether the power follows planned (0) or encoder (1) speed, and the power at the start. */
GT_API GTN_BufLaserFollowMode(short core, short crd, short source GT_DEFAULT(0), short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0), double startPower GT_DEFAULT(GT_NOT_GIVEN));
/* In a path: from here the power follows the path speed, ratio times it, within its bounds. */
GT_API GTN_BufLaserFollowRatio(short core, short crd, double ratio, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: from here the power follows the path speed by a table. */
GT_API GTN_BufLaserFollowTable(short core, short crd, short tableId, double minPower, double maxPower, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* In a path: the power follows the speed no more. */
GT_API GTN_BufLaserFollowOff(short core, short crd, short fifo GT_DEFAULT(0), short channel GT_DEFAULT(0));
/* Sets a table of power against path speed. */
GT_API GTN_SetLaserFollowTable(short core, short tableId, int count, double *vel, double *power, short channel GT_DEFAULT(0));

/* Laser power by distance */
/* Switches power by distance on or off, with reference positions and scales of axes 1 to 4. */
GT_API GTN_SetLaserDisMode(short core, short mode, short source, int *pos GT_DEFAULT(NULL), double *scale GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
/* Sets the ratios of power by distance, and its bounds. */
GT_API GTN_SetLaserDisRatio(short core, double *ratio, double minPower, double maxPower, short channel GT_DEFAULT(0));
#ifdef __cplusplus
static inline short GTN_SetLaserDisRatio(short core, double *ratio, short channel = 0)
{
    return GTN_SetLaserDisRatio(core, ratio, GT_NOT_GIVEN, GT_NOT_GIVEN, channel);
}
#endif
/* Sets ratios by position for each of axes 1 to 4. */
GT_API GTN_SetLaserDisTable1D(short core, short count, double *ratio, int *pos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));
/* Sets ratios by the positions of two axes. */
GT_API GTN_SetLaserDisTable2D(short core, short *axisIndex, short *count, double *ratio, int *xPos, int *yPos, double minPower, double maxPower, double *limitPower GT_DEFAULT(NULL), short channel GT_DEFAULT(0));

/* PT */
/* Puts an axis into PT mode: static or dynamic FIFO. */
GT_API GTN_PrfPt(short core, short profile, short mode GT_DEFAULT(0));
/* Free slots of a PT FIFO. */
GT_API GTN_PtSpace(short core, short profile, short *space, short fifo GT_DEFAULT(0));
/* A PT segment: end position in pulses, end time in ms, type. */
GT_API GTN_PtData(short core, short profile, double pos, int time, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a PT FIFO. */
GT_API GTN_PtClear(short core, short profile, short fifo GT_DEFAULT(0));
/* Sets how many passes run; 0 for ever. */
GT_API GTN_SetPtLoop(short core, short profile, int loop);
/* Passes that were completed. */
GT_API GTN_GetPtLoop(short core, short profile, int *loop);
/* Sets the size of PT FIFOs: 0 for 32 segments, 1 for 1024. */
GT_API GTN_SetPtMemory(short core, short profile, short memory);
/* The size of PT FIFOs. */
GT_API GTN_GetPtMemory(short core, short profile, short *memory);
/* Starts axes in PT, all on one tick; option bits take FIFO 1. */
GT_API GTN_PtStart(short core, int mask, int option GT_DEFAULT(0));
/* Starts axes in PT by lists of axes and FIFOs. */
GT_API GTN_PtStartPro(short core, short *axis, short *option, short count);

/* PVT */
/* Puts an axis into PVT mode. */
GT_API GTN_PrfPvt(short core, short profile);
/* Sets how many passes run; 0 for ever. */
GT_API GTN_SetPvtLoop(short core, short profile, int loop);
/* Passes that were completed, and to run. */
GT_API GTN_GetPvtLoop(short core, short profile, int *loopCount, int *loop);
/* Tables in force of count axes, and times in them. */
GT_API GTN_PvtStatus(short core, short profile, short *tableId, double *time, short count GT_DEFAULT(1));
/* Starts axes in PVT, all on one tick. */
GT_API GTN_PvtStart(short core, int mask);
/* Chooses an axis's table; while it runs, from the next pass on. */
GT_API GTN_PvtTableSelect(short core, short profile, short tableId);
/* Fills a table with times, positions and velocities. */
GT_API GTN_PvtTable(short core, short tableId, int count, double *time, double *pos, double *vel);
/* Fills a table with velocities at the begin and the end of each segment; a point where they differ takes two of 1024 points. */
GT_API GTN_PvtTableEx(short core, short tableId, int count, double *time, double *pos, double *velBegin, double *velEnd);
/* Fills a table whose acceleration is continuous. */
GT_API GTN_PvtTableComplete(short core, short tableId, int count, double *time, double *pos, double *a, double *b, double *c, double velBegin GT_DEFAULT(0), double velEnd GT_DEFAULT(0));
/* Fills a table with percentages of S-shape. */
GT_API GTN_PvtTablePercent(short core, short tableId, int count, double *time, double *pos, double *percent, double velBegin GT_DEFAULT(0));
/* The velocities of a Percent table. */
GT_API GTN_PvtPercentCalculate(short core, int count, double *time, double *pos, double *percent, double velBegin, double *vel);
/* Fills a table by positions, velocities and limits; the controller finds the times. */
GT_API GTN_PvtTableContinuous(short core, short tableId, int count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double timeBegin);
/* The times of a Continuous table. */
GT_API GTN_PvtContinuousCalculate(short core, int count, double *pos, double *vel, double *percent, double *velMax, double *acc, double *dec, double *time);
/* Puts an axis into Gear mode: direction of the master 0 both, 1, -1. */
GT_API GTN_PrfGear(short core, short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GTN_SetGearMaster(short core, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GTN_GetGearMaster(short core, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets the ratio slaveEven/masterEven of the next GearStart, reached over masterSlope pulses of the master; 0 at once. */
GT_API GTN_SetGearRatio(short core, short profile, int masterEven, int slaveEven, int masterSlope GT_DEFAULT(0));
/* The ratio that SetGearRatio has set. */
GT_API GTN_GetGearRatio(short core, short profile, int *masterEven, int *slaveEven, int *masterSlope GT_DEFAULT(NULL));
/* Starts axes in Gear; one that runs takes the ratio that was set last. */
GT_API GTN_GearStart(short core, int mask);
/* Sets when the gear begins: 1 at once, 2 when the master crosses position startPara1, upwards (startPara0 1) or downwards (-1). */
GT_API GTN_SetGearEvent(short core, short profile, short event, int startPara0, int startPara1);
/* When the gear begins. */
GT_API GTN_GetGearEvent(short core, short profile, short *event, int *startPara0, int *startPara1);

/* Follow */
/* Puts an axis into Follow mode: direction of the master 0 both, 1, -1. */
GT_API GTN_PrfFollow(short core, short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GTN_SetFollowMaster(short core, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GTN_GetFollowMaster(short core, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets how many passes run; 0 for ever. */
GT_API GTN_SetFollowLoop(short core, short profile, int loop);
/* Passes that were completed. */
GT_API GTN_GetFollowLoop(short core, short profile, int *loop);
/* Sets when following begins: at once, or when the master, not there yet, comes to a position. */
GT_API GTN_SetFollowEvent(short core, short profile, short event, short masterDir, int pos GT_DEFAULT(0));
/* When following begins. */
GT_API GTN_GetFollowEvent(short core, short profile, short *event, short *masterDir, int *pos);
/* Free slots of a Follow FIFO. */
GT_API GTN_FollowSpace(short core, short profile, short *space, short fifo GT_DEFAULT(0));
/* A Follow segment: displacement of the master, displacement of the slave, type. */
GT_API GTN_FollowData(short core, short profile, int masterSegment, double slaveSegment, short type GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a Follow FIFO. */
GT_API GTN_FollowClear(short core, short profile, short fifo GT_DEFAULT(0));
/* Starts axes in Follow; option bits take FIFO 1. */
GT_API GTN_FollowStart(short core, int mask, int option GT_DEFAULT(0));
/* Goes over to the other FIFO when the pass has ended. */
GT_API GTN_FollowSwitch(short core, int mask);
/* Sets the size of Follow FIFOs: 0 for 16 segments, 1 for 512. */
GT_API GTN_SetFollowMemory(short core, short profile, short memory);
/* The size of Follow FIFOs. */
GT_API GTN_GetFollowMemory(short core, short profile, short *memory);
/* The FIFO in force, and whether a switch waits. */
GT_API GTN_GetFollowStatus(short core, short profile, short *fifoNum, short *switchStatus);

/* FollowEx */
/* Puts an axis into FollowEx mode: direction of the master 0 both, 1, -1. */
GT_API GTN_PrfFollowEx(short core, short profile, short dir GT_DEFAULT(0));
/* Sets an axis's master: its number, type and item. */
GT_API GTN_SetFollowMasterEx(short core, short profile, short masterIndex, short masterType GT_DEFAULT(2), short masterItem GT_DEFAULT(0));
/* An axis's master: its number, type and item. */
GT_API GTN_GetFollowMasterEx(short core, short profile, short *masterIndex, short *masterType GT_DEFAULT(NULL), short *masterItem GT_DEFAULT(NULL));
/* Sets how many passes run; 0 for ever. */
GT_API GTN_SetFollowLoopEx(short core, short profile, int loop);
/* Passes that were completed. */
GT_API GTN_GetFollowLoopEx(short core, short profile, int *loop);
/* Sets when following begins: at once, or when the master, not there yet, comes to a position. */
GT_API GTN_SetFollowEventEx(short core, short profile, short event, short masterDir, int pos GT_DEFAULT(0));
/* When following begins. */
GT_API GTN_GetFollowEventEx(short core, short profile, short *event, short *masterDir, int *pos);
/* Free slots of a FollowEx FIFO. */
GT_API GTN_FollowSpaceEx(short core, short profile, short *space, short fifo GT_DEFAULT(0));
/* A FollowEx segment with a percentage of S-shape. */
GT_API GTN_FollowDataPercentEx(short core, short profile, double masterSegment, double slaveSegment, short type GT_DEFAULT(0), short percent GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* Clears a FollowEx FIFO. */
GT_API GTN_FollowClearEx(short core, short profile, short fifo GT_DEFAULT(0));
/* Starts axes in FollowEx; option bits take FIFO 1. */
GT_API GTN_FollowStartEx(short core, int mask, int option GT_DEFAULT(0));
/* Goes over to the other FIFO when the pass has ended. */
GT_API GTN_FollowSwitchEx(short core, int mask);
/* Sets the size of FollowEx FIFOs: 0 for 16 segments, 1 for 512. */
GT_API GTN_SetFollowMemoryEx(short core, short profile, short memory);
/* The size of FollowEx FIFOs. */
GT_API GTN_GetFollowMemoryEx(short core, short profile, short *memory);
/* The FIFO in force, and whether a switch waits. */
GT_API GTN_GetFollowStatusEx(short core, short profile, short *fifoNum, short *switchStatus);
/* Goes over at once, by segment or by table; or as an entry of a FIFO. */
GT_API GTN_FollowSwitchNowEx(short core, short profile, short method, short buffer GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: sets a digital output. */
GT_API GTN_FollowDoBitEx(short core, short profile, short doType, short index, short value, short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: the slave is at standstill for so many 250 us. */
GT_API GTN_FollowDelayEx(short core, short profile, unsigned int delayTime, short fifo GT_DEFAULT(0));
/* In a FollowEx FIFO: the slave is at standstill until an input has a level, or a time in ms is over. */
GT_API GTN_FollowDiBitEx(short core, short profile, short diType, short index, short value, unsigned int time GT_DEFAULT(0), short fifo GT_DEFAULT(0));
/* A FollowEx segment with velocity ratios at begin and end. */
GT_API GTN_FollowDataPercent2Ex(short core, short profile, double masterSegment, double slaveSegment, double velBeginRatio, double velEndRatio, short percent GT_DEFAULT(100), short *percent1 GT_DEFAULT(NULL), short fifo GT_DEFAULT(0));
/* The displacement of such a segment, for a share of S-shape in its first half. */
GT_API GTN_GetFollowDataPercent2Ex(short core, double masterPos, double v1, double v2, double p, double p1, double *slavePos);

/* Beyond the manuals: what is kept changes nothing, what is refused returns 1 (docs/api.md) */
/* Levels at the terminals; what GetDi returns, which no sense changes. */
GT_API GTN_GetDiRaw(short core, short diType, int *value);
/* Waits for so many ms of the controller's time. */
GT_API GTN_Delay(short core, unsigned short time);
/* Waits for so many 250 us of the controller's time. */
GT_API GTN_DelayHighPrecision(short core, unsigned short time);
/* Controller time in 125 us since power-on. */
GT_API GTN_GetClockHighPrecision(short core, unsigned int *clock);
/* Kept: gains of a position loop; there is no loop. */
GT_API GTN_SetPid(short core, short control, short index, TPid *pid);
/* The gains that SetPid has set. */
GT_API GTN_GetPid(short core, short control, short index, TPid *pid);
/* Kept: which set of gains is in force. */
GT_API GTN_SetControlFilter(short core, short control, short index);
/* The set of gains that SetControlFilter has chosen. */
GT_API GTN_GetControlFilter(short core, short control, short *index);
/* Kept: filter of the velocity feed-forward. */
GT_API GTN_SetKvffFilter(short core, short control, short kvffFilterExp, double accMax);
/* The filter that SetKvffFilter has set. */
GT_API GTN_GetKvffFilter(short core, short control, short *kvffFilterExp, double *accMax);
/* Kept: filter of the planned velocity that is shown. */
GT_API GTN_SetAxisPrfVelFilter(short core, short axis, short filterNumExp);
/* The filter that SetAxisPrfVelFilter has set. */
GT_API GTN_GetAxisPrfVelFilter(short core, short axis, short *filterNumExp);
/* Kept: filter of the encoder's velocity that is shown. */
GT_API GTN_SetAxisEncVelFilter(short core, short axis, short filterNumExp);
/* The filter that SetAxisEncVelFilter has set. */
GT_API GTN_GetAxisEncVelFilter(short core, short axis, short *filterNumExp);
/* Kept: the axis' scale of its profile; positions stay those of the profile. */
GT_API GTN_SetProfileScale(short core, short axis, short alpha, short beta);
/* The scale that SetProfileScale has set. */
GT_API GTN_GetProfileScale(short core, short axis, short *alpha, short *beta);
/* Kept: the axis' scale of its encoder; positions stay those of the encoder. */
GT_API GTN_SetEncoderScale(short core, short axis, short alpha, short beta);
/* The scale that SetEncoderScale has set. */
GT_API GTN_GetEncoderScale(short core, short axis, short *alpha, short *beta);
/* Kept: offset of a motor's analog output; no loop drives it. */
GT_API GTN_SetMtrBias(short core, short dac, short bias);
/* The offset that SetMtrBias has set. */
GT_API GTN_GetMtrBias(short core, short dac, short *bias);
/* Kept: limit of a motor's analog output; no loop drives it. */
GT_API GTN_SetMtrLmt(short core, short dac, short limit);
/* The limit that SetMtrLmt has set. */
GT_API GTN_GetMtrLmt(short core, short dac, short *limit);
/* Kept: filter of an analog input. */
GT_API GTN_SetAdcFilter(short core, short adc, short filterTime);
/* 1: pulses, which is so. 0, an analog output: kept, there is no loop. */
GT_API GTN_CtrlMode(short core, short axis, short mode);
/* Done: it reads its input. */
GT_API GTN_EncOn(short core, short encoder);
/* Refused: an encoder reads its input. */
GT_API GTN_EncOff(short core, short encoder);
/* Done: step and direction. */
GT_API GTN_StepDir(short core, short step);
/* Refused: pulses are step and direction. */
GT_API GTN_StepPulse(short core, short step);
/* 0 is so; an encoder that counts the other way round is refused. */
GT_API GTN_EncSns(short core, unsigned short sense);
/* 0 is so; general inputs are not inverted. */
GT_API GTN_GpiSns(short core, unsigned short sense);
/* Refused: no extension modules. */
GT_API GTN_ExtModuleInit(short core, short method GT_DEFAULT(0));
/* Refused: no extension modules. */
GT_API GTN_SetExtDo(short core, short index, int value);
/* Refused: no extension modules. */
GT_API GTN_SetExtDoBit(short core, short index, short value);
/* Refused: no extension modules. */
GT_API GTN_GetExtDo(short core, short index, int *value);
/* Refused: no extension modules. */
GT_API GTN_GetExtDoBit(short core, short index, short *value);
/* Refused: no extension modules. */
GT_API GTN_GetExtDi(short core, short index, int *value);
/* Refused: no extension modules. */
GT_API GTN_GetExtDiBit(short core, short index, short *value);
/* Refused: no extension modules. */
GT_API GTN_SetExtAo(short core, short index, double value);
/* Refused: no extension modules. */
GT_API GTN_GetExtAi(short core, short index, double *value);
/* Refused: no extension modules. */
GT_API GTN_OpenExtMdl(short core, const char *file GT_DEFAULT(NULL));
/* Refused: no extension modules. */
GT_API GTN_CloseExtMdl(short core);
/* Refused: no extension modules. */
GT_API GTN_ResetExtMdl(short core);
/* Refused: no extension modules. */
GT_API GTN_LoadExtConfig(short core, const char *file);
/* Refused: no extension modules. */
GT_API GTN_SetExtIoValue(short core, short mdl, unsigned short value);
/* Refused: no extension modules. */
GT_API GTN_GetExtIoValue(short core, short mdl, unsigned short *value);
/* Refused: no extension modules. */
GT_API GTN_SetExtIoBit(short core, short mdl, short index, unsigned short value);
/* Refused: no extension modules. */
GT_API GTN_GetExtIoBit(short core, short mdl, short index, unsigned short *value);
/* Refused: no extension modules. */
GT_API GTN_GetExtAdValue(short core, short mdl, short chn, unsigned short *value);
/* Refused: no extension modules. */
GT_API GTN_GetExtAdVoltage(short core, short mdl, short chn, double *value);
/* Refused: no extension modules. */
GT_API GTN_SetExtDaValue(short core, short mdl, short chn, unsigned short value);
/* Refused: no extension modules. */
GT_API GTN_SetExtDaVoltage(short core, short mdl, short chn, double value);
/* Refused: no handwheel input. */
GT_API GTN_HandwheelInit(short core);
/* Refused: no handwheel input. */
GT_API GTN_SetHandwheelStopDec(short core, short profile, double decSmoothStop, double decAbruptStop);
/* Refused: no handwheel input. */
GT_API GTN_StartHandwheel(short core, short profile, short master, short masterEven, short slaveEven, short intervalTime, double acc, double dec, double vel, short stopWaitTime);
/* Refused: no handwheel input. */
GT_API GTN_EndHandwheel(short core, short profile);
/* Refused: no compensation. */
GT_API GTN_SetLeadScrewComp(short core, short axis, short n, int startPos, int lenPos, int *compPos, int *compNeg);
/* Refused: no compensation. */
GT_API GTN_EnableLeadScrewComp(short core, short axis, short mode);
/* Refused: no compensation. */
GT_API GTN_SetBacklash(short core, short axis, int compValue, double compChangeValue, int compDir);
/* Refused: no compensation. */
GT_API GTN_GetBacklash(short core, short axis, int *compValue, double *compChangeValue, int *compDir);
/* Homes an axis in Trap mode by limit, home and index; the origin is 0 from then on. */
GT_API GTN_GoHome(short core, short axis, THomePrm *prm);
/* The parameters of the last GoHome of an axis. */
GT_API GTN_GetHomePrm(short core, short axis, THomePrm *prm);
/* Whether an axis is on its way home, at which stage, and what went wrong. */
GT_API GTN_GetHomeStatus(short core, short axis, THomeStatus *status);
/* Done: homing needs no start. */
GT_API GTN_HomeInit(short core);
/* Refused: no Cam. */
GT_API GTN_PrfCam(short core, short profile);
/* Refused: no Cam. */
GT_API GTN_CamStart(short core, int mask);

#endif
