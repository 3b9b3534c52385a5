"""Tests of the Python package: `python3 -m unittest` in host/python, with BEAMTICK_LINK=virtual:max."""

import importlib.util
import json
import os
import pathlib
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

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

    def test_a_wrong_name_says_what_was_meant(self):
        for card, name, why in (
            (gts.Beamtick(), "GT_AxisOn", "there is no function GT_AxisOn; without its prefix there is: card.AxisOn"),
            (gts.Beamtick(gtn=True), "GTN_AxisOn", "there is no function GTN_AxisOn; without its prefix there is: card.AxisOn"),
            (gts.Beamtick(), "AxisOnn", "there is no function AxisOnn; the nearest is card.AxisOn; dir(card) lists them"),
            (gts.Beamtick(), "getsts", "there is no function getsts; the nearest is card.GetSts; dir(card) lists them"),
            (gts.Beamtick(), "zzzzzzzz", "there is no function zzzzzzzz; dir(card) lists them"),
            (gts.Beamtick(), "TTrapPrm", "TTrapPrm is not a function of the card; it is beamtick.TTrapPrm"),
            (gts.Beamtick(), "_nothing", "there is no _nothing"),
        ):
            with self.assertRaises(AttributeError) as caught:
                getattr(card, name)
            self.assertEqual(str(caught.exception), why)

    def test_a_trace_that_is_not_there_says_why(self):
        with gts.Beamtick("virtual:max", trace=False) as card:
            with self.assertRaisesRegex(AttributeError, r"no trace was kept: Beamtick\(…, trace=True\) keeps one"):
                card.trace
        card = gts.Beamtick("virtual:max", trace=True)
        # The second time it is a trace of its own.
        for axis in (1, 2):
            with card:
                card.SetPrfPos(axis, 5)
                card.sleep(1)
                with self.assertRaisesRegex(AttributeError, "the trace is read when the with has ended"):
                    card.trace
            self.assertEqual(card.trace.columns[:2], ["t_ms", f"axis{axis}_pos"])

    def test_without_with_the_reason_says_with(self):
        card = gts.Beamtick("virtual:max")
        for call in (lambda: card.AxisOn(1), lambda: gts.GT_AxisOn(1)):
            with self.assertRaises(gts.GtsError) as caught:
                call()
            self.assertEqual(caught.exception.code, -7)
            self.assertTrue(caught.exception.reason.endswith(", or open one by `with Beamtick(…) as card:`"))

    def test_what_cannot_be_opened_names_the_argument(self):
        with tempfile.TemporaryDirectory() as folder:
            missing = os.path.join(folder, "none")
            for given, reason in (
                ({"link": "bad"}, "link is `bad`; it is virtual[:SPEED|:max], qemu[:IMAGE], tcp:HOST:PORT"),
                ({"link": "tcp:x"}, "link: cannot open tcp:x: "),
                ({"profile": "zz"}, "profile is `zz`; it is gus, gtn-016"),
                ({"family": "zz"}, "family is `zz`; it is gus or lsr"),
                ({"inputs": missing}, f"inputs: {missing}: the inputs cannot be read"),
                ({"plot": "a.txt"}, "plot is `a.txt`; it is a name that ends in .png, .svg or .html"),
                ({"link": "tcp:a:1", "trace": True}, "trace, vcd and plot are for link=virtual"),
                *(
                    ({name: os.path.join(missing, "x.png")}, f"{name} is `{missing}/x.png`; there is no folder `{missing}`")
                    for name in ("trace", "vcd", "plot", "log")
                ),
                ({"log": folder}, f"log is `{folder}`; that is a folder; it must be a file"),
            ):
                with self.assertRaises(gts.GtsError) as caught:
                    with gts.Beamtick(**{"link": "virtual:max", **given}):
                        self.fail("it was opened")
                self.assertEqual((caught.exception.function, caught.exception.code), ("GT_Open", -6))
                self.assertTrue(caught.exception.reason.replace("\\", "/").startswith(reason.replace("\\", "/")), caught.exception)
            with self.assertRaisesRegex(gts.GtsError, "^GT_Open = -6: inputs: "):
                with gts.Controller(inputs=missing):
                    self.fail("it was opened")
            with unittest.mock.patch("os.access", return_value=False):
                with self.assertRaisesRegex(gts.GtsError, "plot is `.*x.png`; it must be a file that you may write"):
                    with gts.Beamtick("virtual:max", plot=os.path.join(folder, "x.png")):
                        self.fail("it was opened")

    def test_a_variable_of_the_environment_keeps_its_name_in_a_reason(self):
        with unittest.mock.patch.dict(os.environ, BEAMTICK_LINK="bad"):
            with self.assertRaisesRegex(gts.GtsError, "BEAMTICK_LINK is `bad`"):
                with gts.Beamtick(profile="gus"):
                    self.fail("it was opened")

    def test_arguments_of_the_wrong_type_are_named_where_they_are_given(self):
        for given, why in (
            ({"link": 5}, "link is 5; it must be a text"),
            ({"plot": True}, "plot is True; it must be a file's name"),
            ({"trace": 5}, "trace is 5; it must be True or a file's name"),
        ):
            with self.assertRaises(TypeError) as caught:
                gts.Beamtick(**given)
            self.assertEqual(str(caught.exception), why)

    def test_a_picture_ends_with_the_with(self):
        """What docs/start-python.md says of its first block."""
        for last, velocity in ((lambda card: None, 10.0), (lambda card: (card.Stop(1, 0), card.sleep(50)), 0.0)):
            with gts.Beamtick("virtual:max", trace=True) as card:
                card.AxisOn(1)
                card.PrfJog(1)
                card.SetJogPrm(1, {"acc": 1, "dec": 1})
                card.SetVel(1, 10)
                card.Update(1)
                card.sleep(100)
                last(card)
            self.assertEqual((card.trace["axis1_vel"][-1], max(card.trace["axis1_vel"])), (velocity, 10.0))

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

    def test_a_sleep_lasts_as_long_as_it_says(self):
        with gts.Beamtick("virtual:max") as card:
            begun = card.GetClock()[1]
            card.sleep(0)
            for _ in range(8):
                card.sleep(0.5)
            # 250 us each.
            self.assertGreaterEqual(card.GetClock()[1] - begun, 8 * 4)
            for wrong in (-1, -0.5, float("nan"), float("inf")):
                with self.assertRaisesRegex(ValueError, f"sleep: milliseconds is {wrong}; it must be finite, and 0 or more"):
                    card.sleep(wrong)
            with self.assertRaisesRegex(TypeError, "sleep: milliseconds is 'x'; it must be a number, 0 or more"):
                card.sleep("x")

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
                why = "must be a whole number" if number == 1.5 else "does not fit a short of 16 bits, -32768 to 32767"
                self.assertIn(f" is {number}; it {why}", caught.exception.reason)
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

    def test_a_wrong_argument_is_named_with_what_is_allowed(self):
        fields = "acc, dec, velStart, smoothTime"
        ratio = [0, 0, 0, 0]
        for call, why in (
            (lambda: gts.GT_AxisOn("x"), "AxisOn: axis is 'x'; it must be a whole number"),
            (lambda: gts.GT_AxisOn("1"), "AxisOn: axis is '1'; it must be a whole number"),
            (lambda: gts.GT_AxisOn(None), "AxisOn: axis is None; it must be a whole number"),
            (lambda: gts.GT_AxisOn(), "GT_AxisOn(axis): missing a required argument: 'axis'"),
            (lambda: gts.GT_GetSts(1, 1, 1), "GT_GetSts(axis, count=1): too many positional arguments"),
            (
                lambda: gts.GT_SetLaserDisRatio(),
                "GT_SetLaserDisRatio(ratio, minPower=NOT_GIVEN, maxPower=NOT_GIVEN, channel=0): missing a required argument: 'ratio'",
            ),
            (lambda: gts.GT_GetSts(1, count="a"), "GetSts: count is 'a'; it must be a whole number"),
            (lambda: gts.GT_SetVel(1, "fast"), "SetVel: vel is 'fast'; it must be a number"),
            (lambda: gts.GT_LoadConfig(5), "LoadConfig: file is 5; it must be a file's name"),
            (lambda: gts.GT_SetTrapPrm(1, {"accc": 1}), f"SetTrapPrm: prm: TTrapPrm has no accc; its fields are {fields}"),
            (lambda: gts.GT_SetTrapPrm(1, {3: 1}), f"SetTrapPrm: prm: TTrapPrm has no 3; its fields are {fields}"),
            (lambda: gts.GT_SetTrapPrm(1, {"acc": "x"}), "SetTrapPrm: prm: TTrapPrm: acc is 'x'; it must be a number"),
            *(
                (
                    lambda prm=prm: gts.GT_SetTrapPrm(1, prm),
                    f"SetTrapPrm: prm is {prm}; it must be a TTrapPrm, or a mapping of its fields: {fields}",
                )
                for prm in (5, None, gts.TJogPrm(acc=1))
            ),
            (lambda: gts.TTrapPrm(1, 2, 3, 4, 5), f"TTrapPrm has 5 values; its fields are {fields}"),
            (lambda: gts.TCrdPrm(profile=5), "TCrdPrm: profile is 5; it must be a sequence of numbers, 8 at most"),
            (lambda: gts.TCrdPrm(originPos=["a"]), "TCrdPrm: originPos[0] is 'a'; it must be a whole number"),
            (
                lambda: gts.TCrdPrm().profile.__setitem__(1, "x"),
                "TCrdPrm.profile: element 1 is 'x'; it must be a whole number",
            ),
            (lambda: gts.GT_PvtTable(1, 3, 5, [], []), "PvtTable: time is 5; it must be a sequence of numbers, 3 at least"),
            (lambda: gts.GT_PvtTable(1, 2, [0, "a"], [], []), "PvtTable: time[1] is 'a'; it must be a number"),
            (
                lambda: gts.GT_SetLaserDisTable2D([1, 2], 5, ratio, [0, 1], [0, 1], 0, 1),
                "SetLaserDisTable2D: count is 5; it must be a sequence of numbers, 2 at least",
            ),
        ):
            with self.assertRaises(TypeError) as caught:
                call()
            self.assertEqual(str(caught.exception), why)
        for call, why in (
            (lambda: gts.GT_AxisOn(99), "GT_AxisOn = 7: axis is 99; allowed are 1 to 8"),
            (lambda: gts.GT_AxisOn(1.5), "GT_AxisOn = 7: axis is 1.5; it must be a whole number"),
            (lambda: gts.GT_AxisOn(float("nan")), "GT_AxisOn = 7: axis is nan; it must be a whole number"),
            (lambda: gts.GT_AxisOn(float("inf")), "GT_AxisOn = 7: axis is inf; it must be a whole number"),
            (
                lambda: gts.GT_DelayHighPrecision(65536),
                "GT_DelayHighPrecision = 7: time is 65536; it does not fit an unsigned short of 16 bits, 0 to 65535",
            ),
            (
                lambda: gts.GT_SetVel(1, 10**400),
                "GT_SetVel = 7: vel is too great for a double, -1.7976931348623157e+308 to 1.7976931348623157e+308",
            ),
            (lambda: gts.TCrdPrm(profile=[0] * 9), "TCrdPrm = 7: profile has 9 values; it takes 8"),
            (
                lambda: gts.GT_SetLaserDisTable2D([1, 2], [3], ratio, [0, 1], [0, 1], 0, 1),
                "GT_SetLaserDisTable2D = 7: count has 1 values, 2 are needed",
            ),
            (
                lambda: gts.GT_SetLaserDisTable2D([1, 2], iter((2, 3)), ratio, [0, 1], [0, 1, 2], 0, 1),
                "GT_SetLaserDisTable2D = 7: ratio has 4 values, 6 are needed",
            ),
            # A file that is left out, where it may be.
            (lambda: gts.GT_OpenExtMdl(), "GT_OpenExtMdl = 1: there are no extension modules"),
        ):
            with self.assertRaises(gts.GtsError) as caught:
                call()
            self.assertEqual(str(caught.exception), why)

    def test_a_failure_passes_between_processes(self):
        error = pickle.loads(pickle.dumps(gts.GtsError("GT_AxisOn", 7, "AxisOn: axis is 99")))
        self.assertEqual((error.function, error.code, error.reason), ("GT_AxisOn", 7, "AxisOn: axis is 99"))

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

    def test_each_block_of_the_page_is_a_script_of_its_own(self):
        host = pathlib.Path(__file__).resolve().parents[1]
        page = (host.parents[1] / "docs" / "start-python.md").read_text(encoding="utf-8")
        blocks = re.findall(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
        blocks += [f"{line}\n" for line in re.findall(r'`env/bin/python -c "(.*?)"`', page)]
        said = []
        with tempfile.TemporaryDirectory() as folder:
            for block in blocks:
                script = pathlib.Path(folder) / "first.py"
                script.write_text(block, encoding="utf-8")
                done = subprocess.run(
                    [sys.executable, str(script)],
                    capture_output=True,
                    text=True,
                    timeout=120,
                    cwd=folder,
                    env={**os.environ, "PYTHONPATH": str(host)},
                )
                self.assertEqual(done.returncode, 0, done.stderr)
                said.append(done.stdout)
            self.assertTrue((pathlib.Path(folder) / "first.png").is_file())
        self.assertEqual([said[0], said[2]], ["", "7 AxisOn: axis is 99; allowed are 1 to 8\n"])
        self.assertIn("20000.0\n", said[1])
        self.assertIn("GT_PtData(profile, pos, time, type=0, fifo=0)", said[3])

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
