"""Tests of the Python package: `python3 -m unittest` in host/python, with BEAMTICK_LINK=virtual:max."""

import importlib.util
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

os.environ["BEAMTICK_LINK"] = "virtual:max"
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import beamtick as gts  # noqa: E402


class Context(unittest.TestCase):
    def test_a_with_closes_however_it_ends(self):
        with self.assertRaises(ZeroDivisionError):
            with gts.Controller():
                gts.GT_SetPrfPos(1, 5)
                1 / 0
        with gts.Controller(1, 2, gtn=True):
            self.assertIn("gsn-024", gts.GT_GetVersion())
            gts.GT_Abort()
            self.assertEqual(gts.GT_GetLinkLoss(), (500.0, 0))
        with self.assertRaises(gts.GtsError) as caught:
            gts.GT_GetClock()
        self.assertEqual(caught.exception.code, -7)

    def test_a_file_of_inputs_counts_from_open(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "in.csv"
            path.write_text("t_ms,input,level\n20,gpi3,1\n40,adc1,3.125\n", encoding="utf-8")
            with gts.Controller(inputs=path):
                self.assertEqual(gts.GT_GetDi(gts.MC_GPI), 0)
                gts.sleep(30)
                self.assertEqual((gts.GT_GetDi(gts.MC_GPI), gts.GT_GetAdc(1)), (4, 0.0))
                gts.sleep(20)
                self.assertEqual(gts.GT_GetAdc(1), 3.125)
            self.assertNotIn("BEAMTICK_INPUTS", os.environ)
            for text, reason in (
                ("t_ms,input,level\n0,home9,1\n", "in.csv:2: input: the number is 9; allowed are 1 to 8"),
                ("t_ms,input,level\n0,home1,7\n", "in.csv:2: level: 7; it is 0 (low) or 1 (high)"),
            ):
                path.write_text(text, encoding="utf-8")
                with self.assertRaises(gts.GtsError) as caught:
                    with gts.Controller(inputs=path):
                        self.fail("it was opened")
                self.assertEqual(caught.exception.code, -6)
                self.assertIn(reason, caught.exception.reason)

    def test_what_ended_a_with_is_told_not_that_it_was_closed_already(self):
        with self.assertRaises(KeyError):
            with gts.Controller():
                raise KeyError


class Card(unittest.TestCase):
    def test_outputs_are_named_where_the_card_is_opened(self):
        with tempfile.TemporaryDirectory() as folder:
            plot, log = pathlib.Path(folder) / "t.svg", pathlib.Path(folder) / "calls.txt"
            with gts.Beamtick("virtual:max", trace=True, plot=plot, log=log) as card:
                card.AxisOn(1)
                card.PrfTrap(1)
                card.SetTrapPrm(1, {"acc": 1, "dec": 1})
                card.SetPos(1, 500)
                card.SetVel(1, 10)
                card.Update(1)
                card.sleep(200)
                with self.assertRaises(gts.GtsError):
                    card.AxisOn(99)
                self.assertIn("GetPrfPos", dir(card))
                with self.assertRaises(AttributeError):
                    card.Nothing
            self.assertNotIn("BEAMTICK_PLOT", os.environ)
            self.assertEqual(card.trace["axis1_pos"][-1], 500.0)
            self.assertGreater(max(card.trace["axis1_vel"]), 9)
            self.assertEqual(len(card.trace), len(card.trace["t_ms"]))
            self.assertIn("axis 1 position", plot.read_text(encoding="utf-8"))
            self.assertNotIn("axis 2 position", plot.read_text(encoding="utf-8"))
            lines = log.read_text(encoding="utf-8").splitlines()
            self.assertIn("GT_Open(0, 1) = 0", lines[0])
            self.assertTrue(any("GT_AxisOn(99) = 7  AxisOn: axis is 99" in line for line in lines), lines)
            self.assertEqual(sorted(f.name for f in pathlib.Path(folder).iterdir()), ["calls.txt", "t.svg"])
            try:
                import pandas
            except ImportError:
                with self.assertRaisesRegex(ImportError, "pip install pandas"):
                    card.trace.to_dataframe()
            else:
                frame = card.trace.to_dataframe()
                self.assertEqual((frame.index.name, frame["axis1_pos"].iloc[-1]), ("t_ms", 500.0))

    def test_it_aborts_on_the_way_out(self):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "calls.txt"
            with self.assertRaises(KeyboardInterrupt):
                with gts.Beamtick("virtual:max", log=log) as card:
                    card.AxisOn(1)
                    card.PrfJog(1)
                    card.SetJogPrm(1, gts.TJogPrm(acc=1, dec=1))
                    card.SetVel(1, 50)
                    card.Update(1)
                    card.sleep(300)
                    raise KeyboardInterrupt
            calls = [line.partition(" ")[2] for line in log.read_text(encoding="utf-8").splitlines()]
            self.assertEqual(calls[-3:], ["GT_Update(1) = 0", "GT_Abort() = 0", "GT_Close() = 0"])

    def test_structs_can_be_read_and_compared(self):
        jog = gts.TJogPrm(acc=1, dec=0.5)
        self.assertEqual(repr(jog), "TJogPrm(acc=1.0, dec=0.5, smooth=0.0)")
        self.assertEqual(jog, gts.TJogPrm(acc=1, dec=0.5, smooth=0))
        self.assertNotEqual(jog, gts.TJogPrm(acc=2, dec=0.5))
        self.assertIn("profile=[1, 2, 0, 0, 0, 0, 0, 0]", repr(gts.TCrdPrm(profile=[1, 2])))

    def test_the_version_and_the_types_are_those_of_the_tables(self):
        host = pathlib.Path(__file__).resolve().parents[1]
        cargo = (host.parents[1] / "Cargo.toml").read_text(encoding="utf-8")
        self.assertIn(f'version = "{gts.__version__}"', cargo)
        self.assertIn(f'version = "{gts.__version__}"', (host / "pyproject.toml").read_text(encoding="utf-8"))
        self.assertTrue((host / "beamtick" / "py.typed").is_file())
        subprocess.run([sys.executable, str(host / "stubs.py"), "--check"], check=True)

    def test_ctrl_c_ends_a_sleep_at_once(self):
        if not hasattr(signal, "setitimer"):
            self.skipTest("there is no timer of signals")
        for wait in (gts.sleep, gts.GT_Delay, gts.GT_DelayHighPrecision, lambda time_: gts.GTN_Delay(1, time_)):
            with gts.Beamtick("virtual:1"):
                handler = signal.signal(signal.SIGALRM, signal.default_int_handler)
                signal.setitimer(signal.ITIMER_REAL, 0.3)
                begun = time.monotonic()
                try:
                    with self.assertRaises(KeyboardInterrupt):
                        wait(20_000)
                finally:
                    signal.signal(signal.SIGALRM, handler)
                self.assertLess(time.monotonic() - begun, 2)

    def test_a_delay_lasts_as_long_as_it_says(self):
        with gts.Beamtick("virtual:max", trace=True) as card:
            begun = card.GetClock()[0]
            for time_ in (0, 1, 1000):
                card.Delay(time_)
            card.DelayHighPrecision(4)
            self.assertLess(abs(card.GetClock()[0] - begun - 1002), 4)
            for wrong in (-1, 65536):
                with self.assertRaises(gts.GtsError):
                    card.Delay(wrong)
        with self.assertRaises(gts.GtsError):
            gts.GT_Delay(1)


class Controller(unittest.TestCase):
    def setUp(self):
        gts.GT_Open()
        self.addCleanup(gts.GT_Close)

    def test_why_motion_has_stopped(self):
        self.assertEqual(gts.GT_GetStopReason(1), 0)
        gts.GT_AxisOn(1)
        gts.GT_PrfPt(1, gts.PT_MODE_DYNAMIC)
        gts.GT_PtData(1, 10, 10)
        gts.GT_PtStart(1)
        gts.sleep(20)
        self.assertEqual(gts.GT_GetStopReason(1, size=80), (10, "an underrun"))
        self.assertEqual(gts.GTN_GetStopReason(1, 1), 10)
        gts.GT_SetCrdPrm(1, {"dimension": 1, "profile": [0, 1], "synVelMax": 10, "synAccMax": 1})
        self.assertEqual(gts.GT_GetCrdStopReason(1, size=4), (0, "it "))

    def test_a_read_past_the_last_axis_gives_zeros(self):
        gts.GT_SetPrfPos(8, 5)
        self.assertEqual(gts.GT_GetPrfPos(8, count=3), [5.0, 0.0, 0.0])
        for count in (1000, 5000, 32767):
            self.assertEqual(gts.GT_GetPrfPos(8, count=count), [5.0] + [0.0] * (count - 1))

    def test_values_come_back(self):
        gts.GT_SetPrfPos(2, 500)
        self.assertEqual(gts.GT_GetPrfPos(2), 500.0)
        self.assertEqual(gts.GT_GetPrfPos(1, count=3), [0.0, 500.0, 0.0])
        self.assertEqual(gts.GTN_GetPrfPos(1, 2), 500.0)
        gts.GT_SetStopDec(1, 2, 300)
        self.assertEqual(gts.GT_GetStopDec(1), (2.0, 300.0))
        self.assertIn("profile gus", gts.GT_GetVersion())
        clock, ticks = gts.GT_GetClock()
        self.assertEqual(ticks // 4, clock)

    def test_inputs_are_set_and_read(self):
        kinds = (gts.MC_LIMIT_POSITIVE, gts.MC_LIMIT_NEGATIVE, gts.MC_ALARM, gts.MC_HOME, gts.MC_GPI, gts.MC_ARRIVE)
        for kind in kinds:
            gts.GT_SimInput(kind, 3, 1)
            self.assertEqual(gts.GT_GetDi(kind), 4)
            gts.GTN_SimInput(1, kind, index=3, level=0)
            self.assertEqual(gts.GT_GetDi(kind), 0)
        gts.GT_SimAdc(2, 6.25)
        self.assertEqual(gts.GT_GetAdc(1, count=3), [0.0, 6.25, 0.0])
        gts.GT_SetAxisMode(7, 1)
        gts.GT_SimInput(gts.MC_INTERLOCK, 1, 1)
        gts.sleep(1)
        self.assertEqual(gts.GT_GetLaserFault(0), 1)
        for arguments, reason in (
            ((6, 1, 1), "di_type is 6; allowed are 0 to 5, and 90, the interlock"),
            ((gts.MC_HOME, 9, 1), "index is 9; allowed are 1 to 8"),
            ((gts.MC_GPI, 1, -1), "level is -1; allowed are 0 to 1"),
        ):
            with self.assertRaises(gts.GtsError) as caught:
                gts.GT_SimInput(*arguments)
            self.assertEqual(caught.exception.code, 7)
            self.assertIn(reason, caught.exception.reason)
        with self.assertRaises(gts.GtsError) as caught:
            gts.GT_SimAdc(1, 12.6)
        self.assertIn("volts is 12.6; it must be from -12.5 to 12.5", caught.exception.reason)

    def test_structs(self):
        gts.GT_PrfJog(1)
        gts.GT_SetJogPrm(1, gts.TJogPrm(acc=2, dec=1, smooth=0.5))
        self.assertEqual(gts.GT_GetJogPrm(1).smooth, 0.5)
        gts.GT_PrfTrap(2)
        gts.GT_SetTrapPrm(2, {"acc": 1, "dec": 2, "velStart": 0, "smoothTime": 5})
        found = gts.GT_GetTrapPrm(2)
        self.assertEqual((found.acc, found.dec, found.smoothTime), (1.0, 2.0, 5))
        gts.GT_SetCrdPrm(1, {"dimension": 2, "profile": [1, 2], "synVelMax": 100, "synAccMax": 1})
        self.assertEqual(list(gts.GT_GetCrdPrm(1).profile)[:3], [1, 2, 0])
        self.assertEqual(gts.GT_GetCrdPos(1)[:2], [0.0, 0.0])
        with self.assertRaises(TypeError):
            gts.GT_SetJogPrm(1, {"speed": 1})

    def test_struct_members_are_not_cut(self):
        gts.GT_PrfTrap(2)
        trap = gts.TTrapPrm(acc=1, dec=2, smoothTime=5)
        crd = gts.TCrdPrm(dimension=2)
        for number in (65541, -32769, 1.5):
            for call in (
                lambda number=number: gts.GT_SetTrapPrm(2, {"acc": 1, "dec": 2, "smoothTime": number}),
                lambda number=number: gts.TTrapPrm(smoothTime=number),
                lambda number=number: setattr(trap, "smoothTime", number),
                lambda number=number: gts.TCrdPrm(profile=[1, number]),
                lambda number=number: crd.profile.__setitem__(1, number),
                lambda number=number: crd.profile.__setitem__(slice(0, 2), [1, number]),
            ):
                with self.assertRaises(gts.GtsError) as caught:
                    call()
                self.assertEqual(caught.exception.code, 7)
                self.assertIn(f" is {number}; it does not fit a short", caught.exception.reason)
        self.assertEqual((trap.smoothTime, list(crd.profile)), (5, [0] * 8))
        with self.assertRaises(gts.GtsError):
            crd.profile = [1] * 9
        with self.assertRaises(TypeError):
            trap.speed = 1
        crd.profile[0] = 3
        crd.originPos = (1, 2)
        self.assertEqual((crd.profile[0], list(crd.originPos)[:3]), (3, [1, 2, 0]))

    def test_ratios_without_bounds(self):
        gts.GT_SetLaserDisMode(1, 0, [0, 0, 0, 0], [1000, 1000, 1000, 1000])
        ratio = [0.1, 0, 0, 0]
        for call in (
            lambda: gts.GT_SetLaserDisRatio(ratio),
            lambda: gts.GT_SetLaserDisRatio(ratio, channel=0),
            lambda: gts.GT_SetLaserDisRatio(ratio, 0, 100),
            lambda: gts.GTN_SetLaserDisRatio(1, ratio),
        ):
            self.assertIsNone(call())
        with self.assertRaises(gts.GtsError) as caught:
            gts.GT_SetLaserDisRatio(ratio, channel=9)
        self.assertIn("channel is 9", caught.exception.reason)

    def test_a_failure_has_code_and_reason(self):
        with self.assertRaises(gts.GtsError) as caught:
            gts.GT_AxisOn(99)
        self.assertEqual(caught.exception.code, 7)
        self.assertIn("axis is 99", caught.exception.reason)
        for call in (
            lambda: gts.GT_SetPos(1, 1 << 40),
            lambda: gts.GT_AxisOn(1 << 20),
            lambda: gts.GT_AxisOn(1.5),
            lambda: gts.GT_PvtTable(1, 3, [0, 1], [0, 1, 2], [0, 0, 0]),
            lambda: gts.GT_GetSts(1, count=0),
            lambda: gts.GT_GetSts(1, count=40000),
        ):
            with self.assertRaises(gts.GtsError) as caught:
                call()
            self.assertEqual(caught.exception.code, 7)

    def test_a_motion(self):
        gts.GT_AxisOn(1)
        gts.GT_PrfPt(1)
        gts.GT_PtClear(1)
        for n in range(1, 11):
            gts.GT_PtData(1, 100 * n, 10 * n, type=gts.PT_SEGMENT_EVEN)
        self.assertEqual(gts.GT_PtSpace(1), 22)
        gts.GT_PtStart(1)
        gts.sleep(50)
        self.assertAlmostEqual(gts.GT_GetPrfPos(1), 500, delta=20)
        while gts.GT_GetSts(1) & 0x400:
            pass
        self.assertEqual(gts.GT_GetPrfPos(1), 1000.0)

    def test_calculated_arrays(self):
        vel = gts.GT_PvtPercentCalculate(3, [0, 1000, 2000], [0, 5000, 15000], [60, 0, 60], 0)
        self.assertEqual(vel, [0.0, 10.0, 10.0])


class Package(unittest.TestCase):
    def test_closed(self):
        with self.assertRaises(gts.GtsError) as caught:
            gts.GT_GetPrfPos(1)
        self.assertEqual(caught.exception.code, -7)

    def test_every_function_has_a_doc_string(self):
        for name in gts.table.FUNCTIONS:
            self.assertTrue(getattr(gts, name).__doc__, name)
        self.assertEqual(gts.FOLLOW_MASTER_PROFILE, 2)

    def test_the_example(self):
        example = pathlib.Path(__file__).resolve().parents[1] / "examples" / "plot_job.py"
        with tempfile.TemporaryDirectory() as folder:
            picture = pathlib.Path(folder) / "job.png"
            done = subprocess.run(
                [sys.executable, str(example), "--save", str(picture)], capture_output=True, text=True, timeout=120
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("4096.0 pulses", done.stdout)
            if importlib.util.find_spec("matplotlib") is None:
                self.assertIn("matplotlib is not here", done.stdout)
                self.assertFalse(picture.exists())
                self.skipTest("there is no matplotlib: no plot is drawn")
            self.assertNotIn("matplotlib is not here", done.stdout)
            self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            self.assertGreater(picture.stat().st_size, 5000)

    def test_the_notebook(self):
        """Every cell, from top to bottom, as a fresh kernel runs them."""
        path = pathlib.Path(__file__).resolve().parents[1] / "examples" / "first_plot.ipynb"
        notebook = json.loads(path.read_text(encoding="utf-8"))
        self.assertEqual(notebook["nbformat"], 4)
        os.environ.setdefault("MPLBACKEND", "Agg")
        names = {}
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                self.assertEqual((cell["outputs"], cell["execution_count"]), ([], None))
                exec(compile("".join(cell["source"]), f"{path.name} {cell['id']}", "exec"), names)
        positions = names["trace"]["axis1_pos"]
        self.assertEqual((max(positions), positions[-1]), (20000.0, 0.0))
        has_pandas = importlib.util.find_spec("pandas") is not None
        self.assertEqual(isinstance(names["summary"], str), not has_pandas)
        self.assertEqual(names["figure"] is None, importlib.util.find_spec("matplotlib") is None)


if __name__ == "__main__":
    unittest.main()
