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
:class:`GtsError` with the return value and the reason.

The library is looked for where ``BEAMTICK_LIBRARY`` says, beside this file, in the build folder ``target`` of the checkout,
and where the system looks. Which controller is opened the environment says (docs/c.md).
"""

import atexit
import csv
import ctypes
import ctypes.util
import inspect
import os
import pathlib
import signal
import sys
import tempfile
import threading
import time

from . import table

__version__ = "0.1.0"

__all__ = ["Beamtick", "Controller", "GtsError", "Trace", "sleep", "__version__", *table.STRUCTS, *table.FUNCTIONS, *table.CONSTANTS]

_NUMBERS = {
    "short": ctypes.c_short,
    "unsigned short": ctypes.c_ushort,
    "long": ctypes.c_long,
    "unsigned long": ctypes.c_ulong,
    "double": ctypes.c_double,
}
#: Stands for a power or a bound that is left out.
NOT_GIVEN = -sys.float_info.max


#: Functions that wait; Ctrl-C ends them as it ends sleep.
_DELAYS = ("Delay", "DelayHighPrecision")
# A signal is heard between two waits of so long on the wall clock, s.
_HEARD = 0.03


class GtsError(Exception):
    """A call that failed: ``function``, ``code`` (a return value of the manuals) and ``reason``."""

    def __init__(self, function, code, reason):
        super().__init__(f"{function} = {code}: {reason}")
        self.function, self.code, self.reason = function, code, reason


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


def _array_type(kind, count):
    """An array of a struct, whose elements are checked as arguments are."""

    def set_element(self, place, value):
        if kind != "double":
            numbers = value if isinstance(place, slice) else [value]
            checked = [_whole(None, f"element {place}", kind, number) for number in numbers]
            value = checked if isinstance(place, slice) else checked[0]
        ctypes.Array.__setitem__(self, place, value)

    return type("Array", (ctypes.Array,), {"_type_": _NUMBERS[kind], "_length_": count, "__setitem__": set_element})


def _struct_type(name, members):
    """A struct of gts.h. A member that is set is checked as an argument is; one that is an array takes a sequence."""
    kinds = {member: (kind, count) for member, kind, count in members}

    def set_member(self, member, value):
        kind, count = kinds.get(member, (None, 0))
        if kind is None:
            raise TypeError(f"{name} has no {member}")
        if count > 1 and isinstance(value, (list, tuple)):
            if len(value) > count:
                raise GtsError(name, 7, f"{name}: {member} has {len(value)} values; it takes {count}")
            if kind != "double":
                value = [_whole(name, member, kind, element) for element in value]
            value = (type(getattr(self, member)))(*value)
        elif count == 1 and kind != "double":
            value = _whole(name, member, kind, value)
        ctypes.Structure.__setattr__(self, member, value)

    def values(self):
        return [(m, list(v) if isinstance(v, ctypes.Array) else v) for m, v in ((m, getattr(self, m)) for m, _, _ in members)]

    def show(self):
        return f"{name}({', '.join(f'{member}={value!r}' for member, value in values(self))})"

    def equal(self, other):
        return values(self) == values(other) if isinstance(other, type(self)) else NotImplemented

    fields = [(member, _array_type(kind, count) if count > 1 else _NUMBERS[kind]) for member, kind, count in members]
    return type(
        name,
        (ctypes.Structure,),
        {
            "_fields_": fields,
            "__doc__": f"{name} of gts.h.",
            "__setattr__": set_member,
            "__repr__": show,
            "__eq__": equal,
            "__hash__": None,
        },
    )


for _name, _members in table.STRUCTS.items():
    globals()[_name] = _struct_type(_name, _members)
globals().update(table.CONSTANTS)


def _reason():
    text = ctypes.create_string_buffer(1024)
    _lib.GT_GetLastReason(text, ctypes.c_short(len(text)))
    return text.value.decode("utf-8", "replace")


def _whole(function, name, kind, value):
    """An integer that the C type holds; ctypes would cut it in silence."""
    number = int(value)
    if number != value or _NUMBERS[kind](number).value != number:
        bits = 8 * ctypes.sizeof(_NUMBERS[kind])
        where = f"{function}: {name}" if function else name
        raise GtsError(function, 7, f"{where} is {value}; it does not fit a {kind} of {bits} bits")
    return number


def _length(words, given):
    """Elements that an array must have."""
    count = given.get("count", 1)
    first, second = (count[0], count[1]) if isinstance(count, (list, tuple)) else (count, count)
    lengths = {"count": first, "columns": first, "rows": second, "grid": first * second}
    if words in lengths:
        return lengths[words]
    times, _, of = words.partition(" ")
    return int(times) * (first if of else 1)


def _array(function, name, kind, values, given):
    of, _, words = kind[:-1].partition("[")
    values = list(values)
    if len(values) < _length(words, given):
        raise GtsError(function, 7, f"{function}: {name} has {len(values)} values, {_length(words, given)} are needed")
    if of != "double":
        values = [_whole(function, name, of, value) for value in values]
    return (_NUMBERS[of] * len(values))(*values)


def _struct(function, of, value):
    made = globals()[of]
    if isinstance(value, made):
        return value
    try:
        return made(**value)
    except GtsError as error:
        raise GtsError(function, error.code, f"{function}: {error.reason}") from None


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
        bound = signature.bind(*args, **named)
        bound.apply_defaults()
        given = bound.arguments
        passed, results = [], []
        for name, kind, default in parameters:
            if kind in ("clock", "working"):
                passed.append(None)
            elif kind == "out text" and default == "NULL" and given["size"] == 0:
                # Not wanted.
                passed.append(None)
            elif kind == "text":
                passed.append(ctypes.c_char_p(os.fsencode(given[name])))
            elif kind == "out text":
                text = ctypes.create_string_buffer(max(1, min(int(given["size"]), 32767)))
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
                value = given[name]
                passed.append(None if value is None else ctypes.byref(_struct(symbol, kind[7:], value)))
            elif kind.startswith("out "):
                of, _, words = kind[4:].partition("[")
                if words:
                    # A count of a read is a short, and the library fills as many; a greater one is refused before it is looked at.
                    room = max(1, min(_length(words[:-1], given), 32767))
                    array = (_NUMBERS[of] * room)()
                    single = words == "count]" and room == 1
                    results.append(lambda array=array, single=single: array[0] if single else list(array))
                    passed.append(array)
                else:
                    number = _NUMBERS[of]()
                    results.append(lambda number=number: number.value)
                    passed.append(ctypes.byref(number))
            elif "[" in kind:
                value = given[name]
                passed.append(None if value is None else _array(symbol, name, kind, value, given))
            elif kind == "double":
                passed.append(ctypes.c_double(given[name]))
            else:
                passed.append(_NUMBERS[kind](_whole(symbol, name, kind, given[name])))
        if symbol.partition("_")[2] in _DELAYS:
            *before, time_ = passed
            code = _in_portions(time_.value, lambda portion: call(*before, type(time_)(portion)))
        else:
            code = call(*passed)
        if code != 0:
            raise GtsError(symbol, code, _reason())
        values = tuple(result() for result in results)
        return values[0] if len(values) == 1 else values or None

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
    """Waits for so many ms of the open controller's time (docs/c.md), of the wall clock's if none is open. Ctrl-C ends it at
    once."""

    def wait(portion):
        _lib.beamtick_sleep(ctypes.c_ulong(portion))
        return 0

    if int(milliseconds) > 0:
        _in_portions(int(milliseconds), wait)


class Controller:
    """The controller for the length of a ``with``: opened by ``GT_Open``, or with ``gtn`` by ``GTN_Open``, whose arguments
    these are, and closed however the block ends, by TERM or HUP too. Closing aborts: every laser is shut off at once, all motion
    is brought to rest smoothly. ``inputs`` names a CSV of what the inputs do from then on (docs/jobs.md), for the virtual and the
    emulated board."""

    def __init__(self, *args, gtn=False, inputs=None, **named):
        self._open = lambda: globals()["GTN_Open" if gtn else "GT_Open"](*args, **named)
        self._inputs = inputs
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
        if self._inputs is None:
            self._open()
            return
        before = os.environ.get("BEAMTICK_INPUTS")
        os.environ["BEAMTICK_INPUTS"] = os.fspath(self._inputs)
        try:
            self._open()
        finally:
            if before is None:
                del os.environ["BEAMTICK_INPUTS"]
            else:
                os.environ["BEAMTICK_INPUTS"] = before

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
    (docs/c.md); what is not given stays as the environment says. ``trace=True`` keeps a trace without a file: afterwards
    ``card.trace`` is a :class:`Trace`. Functions are its methods, without their prefix: ``card.AxisOn(1)``,
    ``card.sleep(100)``."""

    def __init__(self, link=None, *, profile=None, family=None, inputs=None, trace=None, vcd=None, plot=None, log=None, gtn=False):
        super().__init__(gtn=gtn)
        self.trace = None
        self._folder = tempfile.TemporaryDirectory(prefix="beamtick-") if trace is True else None
        self._trace = os.path.join(self._folder.name, "trace.csv") if self._folder else trace
        given = {"link": link, "profile": profile, "family": family, "inputs": inputs, "vcd": vcd, "plot": plot, "log": log}
        given["trace"] = self._trace
        self._variables = {f"BEAMTICK_{name.upper()}": os.fspath(value) for name, value in given.items() if value is not None}
        self._prefix = "GTN_" if gtn else "GT_"

    def _enter(self):
        before = {name: os.environ.get(name) for name in self._variables}
        os.environ.update(self._variables)
        try:
            self._open()
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value

    def __exit__(self, kind, error, trace):
        try:
            globals()["GT_Abort"]()
        except GtsError:
            # A link that is gone: Close tells it.
            pass
        try:
            super().__exit__(kind, error, trace)
            if self._trace is not None and os.path.isfile(self._trace):
                self.trace = Trace(self._trace)
        finally:
            if self._folder:
                self._folder.cleanup()
        return False

    def __getattr__(self, name):
        function = globals().get(self.__dict__.get("_prefix", "GT_") + name)
        if function is None or name.startswith("_"):
            raise AttributeError(f"there is no function {name}; dir(beamtick) lists them")
        return function

    def __dir__(self):
        return [*super().__dir__(), *(n[len(self._prefix) :] for n in table.FUNCTIONS if n.startswith(self._prefix))]

    @staticmethod
    def sleep(milliseconds):
        """See :func:`sleep`."""
        sleep(milliseconds)
