"""libgts32 as C#, VB and Delphi call it: a long of 32 bits. Every value and struct lies at the end of a page that
nothing may touch, so that one byte more ends the process."""

import ctypes
import mmap
import os
import sys

library = ctypes.CDLL(sys.argv[1])
libc = ctypes.CDLL(None, use_errno=True)
PAGE = mmap.PAGESIZE
kept = []


def guarded(of):
    """A value whose last byte is the last before a page without access, filled with 0xa5."""
    area = mmap.mmap(-1, 2 * PAGE)
    start = ctypes.addressof(ctypes.c_char.from_buffer(area))
    assert libc.mprotect(ctypes.c_void_p(start + PAGE), ctypes.c_size_t(PAGE), 0) == 0, os.strerror(ctypes.get_errno())
    kept.append(area)
    ctypes.memset(start, 0xA5, PAGE)
    return of.from_address(start + PAGE - ctypes.sizeof(of))


def untouched(value):
    """Nothing before it was written either."""
    end = ctypes.addressof(value)
    start = end - end % PAGE
    assert ctypes.string_at(start, end - start) == b"\xa5" * (end - start), "written before the value"


def struct(name, size, *fields):
    made = type(name, (ctypes.Structure,), {"_fields_": list(fields)})
    assert ctypes.sizeof(made) == size, (name, ctypes.sizeof(made))
    return made


short, int32, uint32, double = ctypes.c_short, ctypes.c_int32, ctypes.c_uint32, ctypes.c_double
# By hand, as the declarations for Windows have them.
TTrapPrm = struct("TTrapPrm", 32, ("acc", double), ("dec", double), ("velStart", double), ("smoothTime", short))
TCrdPrm = struct("TCrdPrm", 80, ("dimension", short), ("profile", short * 8), ("synVelMax", double),
                 ("synAccMax", double), ("evenTime", short), ("setOriginFlag", short), ("originPos", int32 * 8))
TPid = struct("TPid", 56, ("kp", double), ("ki", double), ("kd", double), ("kvff", double), ("kaff", double),
              ("integralLimit", int32), ("derivativeLimit", int32), ("limit", short))

THomePrm = struct("THomePrm", 80, ("mode", short), ("moveDir", short), ("indexDir", short), ("edge", short),
                  ("triggerIndex", short), ("pad1", short * 3), ("velHigh", double), ("velLow", double), ("acc", double),
                  ("dec", double), ("smoothTime", short), ("pad2", short * 3), ("homeOffset", int32),
                  ("searchHomeDistance", int32), ("searchIndexDistance", int32), ("escapeStep", int32), ("pad3", int32 * 2))
THomeStatus = struct("THomeStatus", 16, ("run", short), ("stage", short), ("error", short), ("pad1", short),
                     ("capturePos", int32), ("targetPos", int32))


def call(name, *args):
    code = getattr(library, name)(*args)
    if code != 0:
        text = ctypes.create_string_buffer(200)
        library.GT_GetLastReason(text, short(200))
        raise SystemExit(f"{name} = {code}: {text.value.decode()}")


def filled(name, of, *before, after=()):
    value = guarded(of)
    call(name, *before, ctypes.byref(value), *after)
    untouched(value)
    return value


one = short(1)
call("GT_Open", short(0), short(1))
version = ctypes.c_char_p()
call("GT_GetVersion", ctypes.byref(version))
assert version.value.endswith(b"long of 32 bits"), version.value

call("GT_AxisOn", one)
call("GT_AxisOn", short(2))
call("GT_PrfTrap", one)
trap = filled("GT_GetTrapPrm", TTrapPrm, one)
trap.acc, trap.dec, trap.velStart, trap.smoothTime = 2, 2, 0, 0
call("GT_SetTrapPrm", one, ctypes.byref(trap))
call("GT_SetPos", one, int32(-123456))
call("GT_SetVel", one, double(500))
call("GT_Update", int32(1))
assert filled("GT_GetPos", int32, one).value == -123456
status = guarded(int32 * 8)
clock = guarded(uint32)
while True:
    call("GT_GetSts", one, ctypes.byref(status), short(8), ctypes.byref(clock))
    untouched(status)
    untouched(clock)
    if not status[0] & 0x400:
        break
assert filled("GT_GetPrfPos", double, one, after=(one, None)).value == -123456.0
assert filled("GT_GetPrfMode", int32, one, after=(one, None)).value == 0
call("GT_SetSoftLimit", one, int32(0x7FFFFFFF), int32(-0x80000000))
low = guarded(int32)
high = guarded(int32)
call("GT_GetSoftLimit", one, ctypes.byref(high), ctypes.byref(low))
assert (high.value, low.value) == (0x7FFFFFFF, -0x80000000)

crd = guarded(TCrdPrm)
ctypes.memset(ctypes.addressof(crd), 0, 80)
crd.dimension, crd.synVelMax, crd.synAccMax, crd.setOriginFlag = 2, 400, 4, 1
crd.profile[0], crd.profile[1], crd.originPos[0], crd.originPos[1] = 1, 2, -100000, 70000
call("GT_SetCrdPrm", one, ctypes.byref(crd))
back = filled("GT_GetCrdPrm", TCrdPrm, one)
assert list(back.originPos)[:2] == [-100000, 70000] and list(back.profile)[:2] == [1, 2], list(back.originPos)
call("GT_CrdClear", one, short(0))
call("GT_LnXY", one, int32(-5000), int32(3000), double(100), double(1), double(0), short(0))
assert filled("GT_CrdSpace", int32, one, after=(short(0),)).value > 0
call("GT_CrdStart", one, short(0))
run, segment = guarded(short), guarded(int32)
run.value = 1
while run.value:
    call("GT_CrdStatus", one, ctypes.byref(run), ctypes.byref(segment), short(0))
assert segment.value == 1
where = filled("GT_GetCrdPos", double * 4, one)
assert list(where)[:2] == [-5000.0, 3000.0], list(where)

pid = guarded(TPid)
pid.kp, pid.ki, pid.kd, pid.kvff, pid.kaff = 1, 2, 3, 4, 5
pid.integralLimit, pid.derivativeLimit, pid.limit = 6, 7, 8
call("GT_SetPid", one, one, ctypes.byref(pid))
found = filled("GT_GetPid", TPid, one, one)
assert (found.kaff, found.integralLimit, found.derivativeLimit, found.limit) == (5.0, 6, 7, 8)

home = guarded(THomePrm)
home.mode, home.moveDir, home.edge, home.velHigh, home.velLow, home.acc, home.dec = 20, -1, 1, 10, 1, 1, 1
home.homeOffset, home.searchHomeDistance, home.escapeStep = -7, 100, 9
home.indexDir, home.triggerIndex, home.smoothTime, home.searchIndexDistance = 1, 4, 0, 0
call("GT_AxisOn", short(4))
call("GT_GoHome", short(4), ctypes.byref(home))
found = filled("GT_GetHomePrm", THomePrm, short(4))
assert (found.mode, found.velLow, found.homeOffset, found.searchHomeDistance, found.escapeStep) == (20, 1.0, -7, 100, 9)
found = filled("GT_GetHomeStatus", THomeStatus, short(4))
assert (found.run, found.error) == (1, 0), (found.run, found.stage, found.error)

# Arrays that are read: not one value more than there is.
origin, scale = guarded(int32 * 4), guarded(double * 4)
for n in range(4):
    origin[n], scale[n] = -5 * n, 1
call("GT_SetAxisMode", short(7), one)
call("GT_SetHSIOOpt", ctypes.c_ushort(1), short(0))
call("GT_LaserPowerMode", short(0), double(100), double(0), short(0), short(0))
call("GT_SetLaserDisMode", one, short(0), ctypes.byref(origin), ctypes.byref(scale), short(0))
ratio, pos, limit = guarded(double * 8), guarded(int32 * 8), guarded(double * 4)
for n in range(8):
    ratio[n], pos[n], limit[n // 2] = n % 2, n % 2 * 1000, 100
call("GT_SetLaserDisTable1D", short(2), ctypes.byref(ratio), ctypes.byref(pos), double(0), double(100), ctypes.byref(limit),
     short(0))
values = filled("GT_GetDiEx", int32 * 1, short(4), after=(one,))
assert values[0] >= 0 or values[0] == -1
call("GT_Close")
print("all checks passed")
