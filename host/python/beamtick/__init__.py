"""The functions of libgts in Python, with the names that they have in C.

    import beamtick as gts

    gts.GT_Open()
    gts.GT_AxisOn(1)
    print(gts.GT_GetPrfPos(1), gts.GT_GetPrfPos(1, count=8))
    gts.GT_Close()

or, so that nothing stays lit or moving however it ends:

    with gts.Controller():
        gts.GT_AxisOn(1)

or with its outputs named here, and functions without their prefix:

    with gts.Beamtick("virtual:max", plot="t.png") as card:
        card.AxisOn(1)

What a function fills in C it returns here: one value as itself, several as a tuple, those of ``count`` axes (above 1) as a
list; the reader's clock is left out. Its other parameters stand in the order of C, with C++'s defaults, and may be named. Arrays are
sequences, structs are the classes of this module (``TJogPrm(acc=1, dec=1)``) or mappings. A call that fails raises
:class:`GtsError` with the return value and the reason. An argument of the wrong type raises ``TypeError``.

The library is looked for where ``BEAMTICK_LIBRARY`` says, beside this file, in the build folder ``target`` of the checkout,
and where the system looks. Which controller is opened the environment says (docs/c.md).
"""

import atexit
import csv
import ctypes
import ctypes.util
import difflib
import inspect
import math
import os
import pathlib
import re
import signal
import sys
import tempfile
import threading
import time

from . import table, values
from .values import GtsError

__version__ = "0.1.0"

__all__ = ["Beamtick", "Controller", "GtsError", "Trace", "sleep", "__version__", *table.STRUCTS, *table.FUNCTIONS, *table.CONSTANTS]


class _NotGiven(float):
    def __repr__(self):
        return "NOT_GIVEN"


#: Stands for a power or a bound that is left out.
NOT_GIVEN = _NotGiven(-sys.float_info.max)
# Return values: no answer, and a controller that cannot be opened.
_NO_ANSWER, _CANNOT_OPEN = -7, -6
#: Arguments of Beamtick that stand for a variable of the environment.
_ARGUMENTS = ("link", "profile", "family", "inputs", "trace", "vcd", "plot", "log")
#: Those that name a file that is written.
_OUTPUTS = ("trace", "vcd", "plot", "log")

#: Functions that wait; Ctrl-C ends them as it ends sleep.
_DELAYS = ("Delay", "DelayHighPrecision")
# A signal is heard between two waits of so long on the wall clock, s.
_HEARD = 0.03


def _library():
    names = {"win32": ["gts.dll"], "darwin": ["libgts.dylib"]}.get(sys.platform, ["libgts.so"])
    here = pathlib.Path(__file__).resolve().parent
    folders = [here]
    for folder in here.parents:
        folders += [folder / "target" / "release", folder / "target" / "debug"]
    candidates = [os.environ.get("BEAMTICK_LIBRARY"), *(str(f / n) for f in folders for n in names if (f / n).is_file())]
    candidates.append(ctypes.util.find_library("gts"))
    for path in filter(None, candidates):
        return ctypes.CDLL(path)
    raise OSError("libgts is not found: build it (cargo build --release -p beamtick-gts) or set BEAMTICK_LIBRARY")


_lib = _library()

for _name, _members in table.STRUCTS.items():
    globals()[_name] = values.struct_type(_name, _members)
globals().update(table.CONSTANTS)


def _reason():
    text = ctypes.create_string_buffer(1024)
    _lib.GT_GetLastReason(text, ctypes.c_short(len(text)))
    return text.value.decode("utf-8", "replace")


def _struct(function, name, of, value):
    made, where = globals()[of], values.where_of(function, name)
    if isinstance(value, made):
        return value
    if not hasattr(value, "keys"):
        known = ", ".join(member for member, _, _ in table.STRUCTS[of])
        raise TypeError(f"{where} is {value!r}; it must be a {of}, or a mapping of its fields: {known}")
    try:
        return made(**{str(member): value[member] for member in value.keys()})
    except GtsError as error:
        raise GtsError(function, error.code, f"{where}: {error.reason}") from None
    except TypeError as error:
        raise TypeError(f"{where}: {error}") from None


def _function(symbol, about, parameters):
    call = getattr(_lib, symbol)
    call.restype = ctypes.c_short
    inputs = [p for p in parameters if not p[1].startswith("out ") and p[1] not in ("clock", "working")]
    kinds = inspect.Parameter
    defaults = {"NULL": None, "NOT GIVEN": NOT_GIVEN}
    signature = inspect.Signature(
        [
            kinds(n, kinds.POSITIONAL_OR_KEYWORD, default=kinds.empty if d is None else defaults.get(d, d))
            for n, _, d in inputs
        ]
        if all(d is not None for _, _, d in inputs[next((i for i, p in enumerate(inputs) if p[2] is not None), len(inputs)):])
        else [kinds(n, kinds.POSITIONAL_OR_KEYWORD) for n, _, _ in inputs]
    )

    def wrapper(*args, **named):
        try:
            bound = signature.bind(*args, **named)
        except TypeError as error:
            raise TypeError(f"{symbol}{signature}: {error}") from None
        bound.apply_defaults()
        given = bound.arguments
        for name, kind, _ in inputs:
            if kind in values.NUMBERS:
                given[name] = values.number_of(symbol, name, kind, given[name])
            elif name == "count":
                given[name] = list(values.array_of(symbol, name, kind, given[name], given))
        passed, results = [], []
        for name, kind, default in parameters:
            if kind in ("clock", "working"):
                passed.append(None)
            elif kind == "out text" and default == "NULL" and given["size"] == 0:
                # Not wanted.
                passed.append(None)
            elif default == "NULL" and given.get(name, name) is None:
                passed.append(None)
            elif kind == "text":
                file = values.text_of(values.where_of(symbol, name), given[name], "a file's name")
                passed.append(ctypes.c_char_p(os.fsencode(file)))
            elif kind == "out text":
                text = ctypes.create_string_buffer(max(1, given["size"]))
                results.append(lambda text=text: text.value.decode("utf-8", "replace"))
                passed.append(text)
            elif kind == "out address":
                pointer = ctypes.c_char_p()
                results.append(lambda pointer=pointer: pointer.value.decode("utf-8", "replace"))
                passed.append(ctypes.byref(pointer))
            elif kind.startswith("out struct "):
                struct = globals()[kind[11:]]()
                results.append(lambda struct=struct: struct)
                passed.append(ctypes.byref(struct))
            elif kind.startswith("struct "):
                passed.append(ctypes.byref(_struct(symbol, name, kind[7:], given[name])))
            elif kind.startswith("out "):
                of, _, words = kind[4:].partition("[")
                if words:
                    room = max(1, values.length_of(words[:-1], given))
                    array = (values.NUMBERS[of] * room)()
                    single = words == "count]" and room == 1
                    results.append(lambda array=array, single=single: array[0] if single else list(array))
                    passed.append(array)
                else:
                    number = values.NUMBERS[of]()
                    results.append(lambda number=number: number.value)
                    passed.append(ctypes.byref(number))
            elif "[" in kind:
                passed.append(values.array_of(symbol, name, kind, given[name], given))
            else:
                passed.append(values.NUMBERS[kind](given[name]))
        if symbol.partition("_")[2] in _DELAYS:
            *before, time_ = passed
            code = _in_portions(time_.value, lambda portion: call(*before, type(time_)(portion)))
        else:
            code = call(*passed)
        if code != 0:
            reason = _reason()
            if code == _NO_ANSWER and reason.endswith("call GT_Open or GTN_Open first"):
                reason += ", or open one by `with Beamtick(…) as card:`"
            raise GtsError(symbol, code, reason)
        found = tuple(result() for result in results)
        return found[0] if len(found) == 1 else found or None

    wrapper.__name__ = wrapper.__qualname__ = symbol
    wrapper.__doc__ = about
    wrapper.__signature__ = signature
    return wrapper


for _name, (_about, _parameters) in table.FUNCTIONS.items():
    globals()[_name] = _function(_name, _about, _parameters)


def _in_portions(length, wait):
    """Waits for ``length`` in portions, between which a signal is heard. ``wait`` waits for one and returns a code; the first
    that is not 0 is returned."""
    portion = 1
    while True:
        portion = min(portion, length)
        begun = time.monotonic()
        code = wait(portion)
        length -= portion
        if code != 0 or length <= 0:
            return code
        # How long a ms of the controller lasts is not known here; one that is short takes more of them.
        took = time.monotonic() - begun
        if took < _HEARD / 2:
            portion *= 2
        elif took > _HEARD:
            portion = max(1, portion // 2)


def sleep(milliseconds):
    """Waits for so many ms, 0 or more, of the open controller's time (docs/c.md), of the wall
    clock's if none is open. A part of a ms counts as a whole one. Ctrl-C ends it at once."""

    def wait(portion):
        _lib.beamtick_sleep(ctypes.c_ulong(portion))
        return 0

    try:
        allowed = 0 <= milliseconds < math.inf
    except TypeError:
        raise TypeError(f"sleep: milliseconds is {milliseconds!r}; it must be a number, 0 or more") from None
    if not allowed:
        raise ValueError(f"sleep: milliseconds is {milliseconds}; it must be finite, and 0 or more")
    if milliseconds > 0:
        _in_portions(math.ceil(milliseconds), wait)


def _variables(**given):
    """The variables of the environment that stand for arguments."""
    allowed = {"trace": "True or a file's name", **dict.fromkeys(("link", "profile", "family"), "a text")}
    return {
        f"BEAMTICK_{name.upper()}": values.text_of(name, value, allowed.get(name, "a file's name"))
        for name, value in given.items()
        if value is not None
    }


def _obstacle(path):
    """Why a file cannot be written; None if it seems that it can."""
    folder = os.path.dirname(os.path.abspath(path))
    if os.path.isdir(path):
        return "that is a folder; it must be a file"
    if not os.path.isdir(folder):
        return f"there is no folder `{folder}`"
    if not os.access(path if os.path.exists(path) else folder, os.W_OK):
        return "it must be a file that you may write"
    return None


class Controller:
    """The controller for the length of a ``with``: opened by ``GT_Open``, or with ``gtn`` by ``GTN_Open``, whose arguments
    these are, and closed however the block ends, by TERM or HUP too. Closing aborts: every laser is shut off at once, all motion
    is brought to rest smoothly. ``inputs`` names a CSV of what the inputs do from then on (docs/jobs.md), for the virtual and the
    emulated board."""

    def __init__(self, *args, gtn=False, inputs=None, **named):
        self._open = lambda: globals()["GTN_Open" if gtn else "GT_Open"](*args, **named)
        self._variables = _variables(inputs=inputs)
        # What an error may call by the name of its argument.
        self._arguments = ("inputs",)
        self._handlers = {}

    def __enter__(self):
        self._enter()
        if threading.current_thread() is threading.main_thread():
            for name in ("SIGTERM", "SIGHUP"):
                number = getattr(signal, name, None)
                # Left alone where the program has a handler of its own, or is to ignore it.
                if number is not None and signal.getsignal(number) is signal.SIG_DFL:
                    self._handlers[number] = signal.signal(number, _leave)
        return self

    def _enter(self):
        before = {name: os.environ.get(name) for name in self._variables}
        os.environ.update(self._variables)
        try:
            self._open()
        except GtsError as error:
            raise GtsError(error.function, error.code, self._by_argument(error.reason)) from None
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value

    def _by_argument(self, reason):
        """A reason of Open with the names of arguments in the place of those variables that the
        environment does not set."""

        def called(found):
            variable, argument = found[0], found[1].lower()
            own = variable in self._variables or variable not in os.environ
            return argument if argument in self._arguments and own else variable

        link = self._variables.get("BEAMTICK_LINK")
        if link and reason.startswith(f"cannot open {link}:"):
            reason = f"link: {reason}"
        return re.sub(r"BEAMTICK_([A-Z]+)\b", called, reason)

    def __exit__(self, kind, error, trace):
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self._handlers.clear()
        try:
            globals()["GT_Close"]()
        except GtsError:
            # What ended the block is what is told.
            if kind is None:
                raise
        return False


def _leave(number, frame):
    raise SystemExit(128 + number)


def _close():
    try:
        globals()["GT_Close"]()
    except GtsError:
        pass


# A script that ends by Ctrl-C ends without the exit functions of C.
atexit.register(_close)


class Trace:
    """A trace of a controller (docs/c.md, ``BEAMTICK_TRACE``): its columns by name, as lists of numbers.

    ``trace["axis1_pos"]``, ``trace.columns``, ``len(trace)``, and with pandas ``trace.to_dataframe()``."""

    def __init__(self, path):
        with open(path, newline="", encoding="ascii") as file:
            rows = csv.reader(file)
            self.columns = next(rows, [])
            self._values = {name: [] for name in self.columns}
            lists = list(self._values.values())
            for row in rows:
                for values, value in zip(lists, row):
                    values.append(float(value))

    def __getitem__(self, column):
        return self._values[column]

    def __len__(self):
        return len(self._values[self.columns[0]]) if self.columns else 0

    def __repr__(self):
        return f"Trace of {len(self)} rows: {', '.join(self.columns)}"

    def to_dataframe(self):
        """A pandas DataFrame; the time in ms is its index."""
        try:
            import pandas
        except ImportError:
            raise ImportError("to_dataframe needs pandas: pip install pandas") from None
        return pandas.DataFrame(self._values).set_index("t_ms")


class Beamtick(Controller):
    """A controller with its link and its outputs, for the length of a ``with``. However that ends, it aborts: every laser is
    shut off at once, all motion is brought to rest smoothly.

    ``link``, ``profile``, ``family``, ``inputs``, ``vcd``, ``plot``, ``log`` and ``trace`` stand for the variables ``BEAMTICK_…``
    (docs/c.md); what is not given stays as the environment says. ``trace=True`` keeps a trace
    without a file. When the ``with`` has ended, ``card.trace`` is a :class:`Trace`. Functions are
    its methods, without their prefix: ``card.AxisOn(1)``, ``card.sleep(100)``."""

    def __init__(self, link=None, *, profile=None, family=None, inputs=None, trace=None, vcd=None, plot=None, log=None, gtn=False):
        super().__init__(gtn=gtn)
        self._prefix = "GTN_" if gtn else "GT_"
        self._arguments = _ARGUMENTS
        self._folder = None
        self._keeps_trace = trace is True
        trace = None if isinstance(trace, bool) else trace
        self._variables = _variables(
            link=link, profile=profile, family=family, inputs=inputs, trace=trace, vcd=vcd, plot=plot, log=log
        )

    def _enter(self):
        for name in _OUTPUTS:
            path = self._variables.get(f"BEAMTICK_{name.upper()}")
            why = _obstacle(path) if path else None
            if why:
                raise GtsError(f"{self._prefix}Open", _CANNOT_OPEN, f"{name} is `{path}`; {why}")
        self.__dict__.pop("trace", None)
        if self._keeps_trace:
            self._folder = tempfile.TemporaryDirectory(prefix="beamtick-")
            self._variables["BEAMTICK_TRACE"] = os.path.join(self._folder.name, "trace.csv")
        try:
            super()._enter()
        except BaseException:
            self._remove_folder()
            raise

    def _remove_folder(self):
        if self._folder:
            self._folder.cleanup()
            self._folder = None
            del self._variables["BEAMTICK_TRACE"]

    def __exit__(self, kind, error, trace):
        try:
            globals()["GT_Abort"]()
        except GtsError:
            # A link that is gone: Close tells it.
            pass
        try:
            super().__exit__(kind, error, trace)
            path = self._variables.get("BEAMTICK_TRACE")
            if path and os.path.isfile(path):
                self.trace = Trace(path)
        finally:
            self._remove_folder()
        return False

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(f"there is no {name}")
        if name == "trace":
            asked = self._keeps_trace or "BEAMTICK_TRACE" in self._variables
            why = "the trace is read when the with has ended" if asked else "no trace was kept: Beamtick(…, trace=True) keeps one"
            raise AttributeError(why)
        function = globals().get(self._prefix + name)
        if function is None:
            raise AttributeError(self._no_function(name))
        return function

    def _no_function(self, name):
        """Why there is no function of this name, and what was meant."""
        own = {n[len(self._prefix) :].lower(): n[len(self._prefix) :] for n in table.FUNCTIONS if n.startswith(self._prefix)}
        bare = values.bare(name).lower()
        if bare in own and bare != name.lower():
            return f"there is no function {name}; without its prefix there is: card.{own[bare]}"
        if name in __all__:
            return f"{name} is not a function of the card; it is beamtick.{name}"
        near = difflib.get_close_matches(bare, own, 1)
        nearest = f"the nearest is card.{own[near[0]]}; " if near else ""
        return f"there is no function {name}; {nearest}dir(card) lists them"

    def __dir__(self):
        return [*super().__dir__(), *(n[len(self._prefix) :] for n in table.FUNCTIONS if n.startswith(self._prefix))]

    @staticmethod
    def sleep(milliseconds):
        """See :func:`sleep`."""
        sleep(milliseconds)
