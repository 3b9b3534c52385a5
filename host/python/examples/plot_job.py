"""A trapezoid in PT mode, run and plotted. Each `# %%` begins a cell, for editors that know notebooks of plain Python."""

# %% The controller: the virtual one, as fast as this machine can, unless the environment names another
import os
import pathlib
import sys

os.environ.setdefault("BEAMTICK_LINK", "virtual:max")
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import beamtick as gts

gts.GT_Open()
print(gts.GT_GetVersion())

# %% Three segments of 1024 ms: up to 2 pulse/ms, even, down to rest
AXIS = 1
gts.GT_AxisOn(AXIS)
gts.GT_PrfPt(AXIS)
gts.GT_PtClear(AXIS)
for position, time in ((1024, 1024), (3072, 2048), (4096, 3072)):
    gts.GT_PtData(AXIS, position, time)

# %% Run it, and read position and velocity every 16 ms
times, positions, velocities = [], [], []
gts.GT_PtStart(1 << (AXIS - 1))
begin, _ = gts.GT_GetClock()
while gts.GT_GetSts(AXIS) & 0x400:
    times.append(gts.GT_GetClock()[0] - begin)
    positions.append(gts.GT_GetPrfPos(AXIS))
    velocities.append(gts.GT_GetPrfVel(AXIS))
    gts.sleep(16)
print(f"{gts.GT_GetPrfPos(AXIS)} pulses after {times[-1]} ms, at most {max(velocities):.2f} pulse/ms")
gts.GT_AxisOff(AXIS)
gts.GT_Close()

# %% Plot it: in a window, or with `--save FILE` into a picture
saved = pathlib.Path(sys.argv[sys.argv.index("--save") + 1]) if "--save" in sys.argv else None
try:
    import matplotlib
except ImportError:
    print("matplotlib is not here: nothing is plotted")
else:
    if saved:
        matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (above, below) = plt.subplots(2, sharex=True)
    above.plot(times, positions)
    above.set_ylabel("position / pulse")
    below.plot(times, velocities)
    below.set_ylabel("velocity / (pulse/ms)")
    below.set_xlabel("time / ms")
    if saved:
        figure.savefig(saved, format="png")
    else:
        plt.show()
