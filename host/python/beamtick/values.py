"""Arguments for the library, and its structs: each value is checked against its C type.

Fails: a wrong type raises ``TypeError``, a wrong value :class:`GtsError`. Both name the parameter
and what is allowed."""

import ctypes
import math
import os
import re
import sys

NUMBERS = {
    "short": ctypes.c_short,
    "unsigned short": ctypes.c_ushort,
    "long": ctypes.c_long,
    "unsigned long": ctypes.c_ulong,
    "double": ctypes.c_double,
}

# The return value for a wrong parameter.
WRONG = 7


class GtsError(Exception):
    """A call that failed: ``function``, ``code`` (a return value of the manuals) and ``reason``."""

    __module__ = "beamtick"

    def __init__(self, function, code, reason):
        super().__init__(function, code, reason)
        self.function, self.code, self.reason = function, code, reason

    def __str__(self):
        # The reason begins with the function, without its prefix.
        reason = self.reason.removeprefix(bare(self.function) + ": ")
        return f"{self.function} = {self.code}: {reason}"


def bare(function):
    """The name of a function without its prefix, as reasons have it; another name as it is."""
    return re.sub("^GTN?_", "", function)


def where_of(function, name):
    """A parameter of a function, as reasons begin."""
    return f"{bare(function)}: {name}"


def number_of(function, name, kind, value):
    """A number that the C type holds; ctypes would cut an integer in silence."""
    where, of = where_of(function, name), NUMBERS[kind]
    if kind == "double":
        try:
            return of(value).value
        except TypeError:
            raise TypeError(f"{where} is {value!r}; it must be a number") from None
        except OverflowError:
            limit = sys.float_info.max
            raise GtsError(function, WRONG, f"{where} is too great for a double, {-limit} to {limit}") from None
    bits = 8 * ctypes.sizeof(of)
    low, high = (0, 2**bits - 1) if kind.startswith("unsigned") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    try:
        number = None if isinstance(value, (str, bytes, bytearray)) else int(value)
    except TypeError:
        number = None
    except (ValueError, OverflowError):
        # Not a number, or infinite.
        number = math.nan
    if number is None:
        raise TypeError(f"{where} is {value!r}; it must be a whole number")
    if number != value:
        raise GtsError(function, WRONG, f"{where} is {value}; it must be a whole number")
    if not low <= number <= high:
        article = "an" if kind.startswith("unsigned") else "a"
        raise GtsError(function, WRONG, f"{where} is {value}; it does not fit {article} {kind} of {bits} bits, {low} to {high}")
    return number


def numbers_of(function, name, kind, values, length):
    """The numbers of a sequence; ``length`` says in words how many are allowed."""
    try:
        values = list(values)
    except TypeError:
        raise TypeError(f"{where_of(function, name)} is {values!r}; it must be a sequence of numbers, {length}") from None
    return [number_of(function, f"{name}[{index}]", kind, value) for index, value in enumerate(values)]


def text_of(where, value, allowed):
    """A text or a path as a text."""
    try:
        return os.fsdecode(value)
    except TypeError:
        raise TypeError(f"{where} is {value!r}; it must be {allowed}") from None


def length_of(words, given):
    """Elements that an array must have."""
    times, _, of = words.partition(" ")
    if times.isdigit() and not of:
        return int(times)
    count = given.get("count", 1)
    first, second = count[:2] if isinstance(count, list) else (count, count)
    lengths = {"count": first, "columns": first, "rows": second, "grid": first * second}
    return int(times) * first if of else lengths[words]


def array_of(function, name, kind, values, given):
    """An array for the library, of as many numbers as it reads, or more."""
    of, _, words = kind[:-1].partition("[")
    length = length_of(words, given)
    numbers = numbers_of(function, name, of, values, f"{length} at least")
    if len(numbers) < length:
        raise GtsError(function, WRONG, f"{where_of(function, name)} has {len(numbers)} values, {length} are needed")
    return (NUMBERS[of] * len(numbers))(*numbers)


def array_type(owner, kind, count):
    """An array of a struct, whose elements are checked as arguments are."""

    def set_element(self, place, value):
        numbers = value if isinstance(place, slice) else [value]
        checked = [number_of(owner, f"element {place}", kind, number) for number in numbers]
        ctypes.Array.__setitem__(self, place, checked if isinstance(place, slice) else checked[0])

    return type("Array", (ctypes.Array,), {"_type_": NUMBERS[kind], "_length_": count, "__setitem__": set_element})


def struct_type(name, members):
    """A struct of gts.h. A member that is set is checked as an argument is; one that is an array
    takes a sequence."""
    kinds = {member: (kind, count) for member, kind, count in members}
    known = ", ".join(kinds)

    def init(self, *positional, **named):
        if len(positional) > len(members):
            raise TypeError(f"{name} has {len(positional)} values; its fields are {known}")
        ctypes.Structure.__init__(self, *positional, **named)

    def set_member(self, member, value):
        kind, count = kinds.get(member, (None, 0))
        if kind is None:
            raise TypeError(f"{name} has no {member}; its fields are {known}")
        if count > 1:
            numbers = numbers_of(name, member, kind, value, f"{count} at most")
            if len(numbers) > count:
                raise GtsError(name, WRONG, f"{name}: {member} has {len(numbers)} values; it takes {count}")
            value = type(getattr(self, member))(*numbers)
        else:
            value = number_of(name, member, kind, value)
        ctypes.Structure.__setattr__(self, member, value)

    def values(self):
        return [(m, list(v) if isinstance(v, ctypes.Array) else v) for m, v in ((m, getattr(self, m)) for m, _, _ in members)]

    def show(self):
        return f"{name}({', '.join(f'{member}={value!r}' for member, value in values(self))})"

    def equal(self, other):
        return values(self) == values(other) if isinstance(other, type(self)) else NotImplemented

    fields = [(member, array_type(f"{name}.{member}", kind, count) if count > 1 else NUMBERS[kind]) for member, kind, count in members]
    return type(
        name,
        (ctypes.Structure,),
        {
            "_fields_": fields,
            "__module__": "beamtick",
            "__doc__": f"{name} of gts.h: {known}.",
            "__init__": init,
            "__setattr__": set_member,
            "__repr__": show,
            "__eq__": equal,
            "__hash__": None,
        },
    )
