import os

import beamtick as gts

state = {"gtn": False}


def flat(value):
    if value is None or isinstance(value, str):
        return []
    if isinstance(value, (list, tuple)):
        return [number for part in value for number in flat(part)]
    return [repr(value)] if isinstance(value, (int, float)) else []


def begin(gtn, tick_us):
    state["gtn"] = gtn
    if gtn:
        gts.GTN_Open(5, 1)
        gts.GTN_SetTick(1, tick_us)
    else:
        gts.GT_Open(0, 1)
        gts.GT_SetTick(tick_us)


def end():
    gts.GTN_Close() if state["gtn"] else gts.GT_Close()
    print("end")


def tick():
    return (gts.GTN_GetClock(1) if state["gtn"] else gts.GT_GetClock())[1]


def sleep(step, ms):
    print(step, tick(), "0||")
    gts.sleep(ms)


def wait(step, core, patience, axes):
    print(step, tick(), "0||")
    for _ in range(patience):
        sts = gts.GTN_GetSts(core, 1, 8) if state["gtn"] else gts.GT_GetSts(1, 8)
        if not any(axes >> axis & 1 and word & 1 << 10 for axis, word in enumerate(sts)):
            break
        gts.sleep(1)


def call(step, function, *values):
    now = tick()
    try:
        print(step, " ", now, " 0|", " ".join(flat(function(*values))), "|", sep="")
    except gts.GtsError as error:
        print(step, " ", now, " ", error.code, "||", error.reason, sep="")


