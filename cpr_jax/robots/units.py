"""Quantities with units, as people write them: '250 mm', '1.83e-2 N*m^2', '45 deg'."""

import dataclasses
import enum
import functools
import math
import re
from fractions import Fraction
from typing import NamedTuple, NoReturn

from ..errors import InputError, shown


class Sign(enum.Enum):
    """What is asked of a quantity's sign."""

    ANY = ""
    POSITIVE = "positive"
    NOT_NEGATIVE = "non-negative"
    NOT_ZERO = "nonzero"

    def allows(self, number: float) -> bool:
        """Whether a number has this sign."""
        return {
            Sign.ANY: True,
            Sign.POSITIVE: number > 0.0,
            Sign.NOT_NEGATIVE: number >= 0.0,
            Sign.NOT_ZERO: number != 0.0,
        }[self]


@dataclasses.dataclass(frozen=True)
class Dimension:
    """What a quantity measures.

    **Attributes:**

    - `noun`: its name in messages.
    - `units`: its SI unit, then others whose dimension is accepted too (1/m for rad/m).
    - `example`: how a user may write it.
    """

    noun: str
    units: tuple[str, ...]
    example: str

    @property
    def unit(self) -> str:
        """The SI unit, in which bare numbers are read."""
        return self.units[0]

    def expected(self, sign: Sign = Sign.ANY) -> str:
        """What a message asks for: 'a positive length such as 0.25 or '250mm''."""
        words = f"{sign.value} {self.noun}".strip()
        return f"{'an' if words[0] in 'aeiou' else 'a'} {words} such as {self.example}"

    def admits(self, exponents: tuple[int, ...]) -> bool:
        """Whether a unit with these exponents of (kg, m, s, rad) measures this."""
        return exponents in [_parse_unit(unit).exponents for unit in self.units]


LENGTH = Dimension("length", ("m",), "0.25 or '250mm'")
ANGLE = Dimension("angle", ("rad",), "0.785 or '45deg'")
MASS = Dimension("mass", ("kg",), "0.1 or '100 g'")
FORCE = Dimension("force", ("N",), "0.5 or '500mN'")
MOMENT = Dimension("moment", ("N*m",), "0.01 or '10 N*mm'")
BENDING_STIFFNESS = Dimension("stiffness", ("N*m^2",), "0.0183 or '1.83e-2 N*m^2'")
CURVATURE_COMPLIANCE = Dimension("compliance", ("1/(N*m^2)",), "54.6 or '54.6 1/(N*m^2)'")
STRAIN_COMPLIANCE = Dimension("compliance", ("1/N",), "1.8e-5 or '1.8e-5 1/N'")
CURVATURE = Dimension("curvature", ("rad/m", "1/m"), "-1 or '-1 rad/m'")
FORCE_PER_LENGTH = Dimension("force per length", ("N/m",), "-0.1 or '-0.1 N/m'")
MOMENT_PER_LENGTH = Dimension("moment per length", ("N*m/m",), "0.1 or '0.1 N'")
MODULUS = Dimension("modulus", ("Pa",), "2.7e9 or '2.7 GPa'")
DENSITY = Dimension("density", ("kg/m^3",), "1200 or '1.2 g/cm^3'")
ACCELERATION = Dimension("acceleration", ("m/s^2",), "-9.81 or '-9.81 m/s^2'")
RATIO = Dimension("pure number", ("1",), "0.35")

# Far beyond any robot, and such that no power of it that a formula takes leaves the floats.
_LARGEST = 1e30


def parse_quantity(value: object, dimension: Dimension, field: str, sign: Sign = Sign.ANY) -> float:
    """The SI value of a quantity that a user gave.

    **Arguments:**

    - `value`: a number, which is in SI units already, or a string with a number and a unit.
        Units have SI prefixes; products are written with `*`, `·`, `.` or a space, quotients
        with `/` from left to right, powers as `^2`, `**2`, `2` or `²`.
    - `dimension`: what it must measure. Angles count, so that `deg` is not taken for a ratio.
    - `field`: where it stands, for the message.
    - `sign`: which sign it must have.

    **Raises:**

    - `InputError`: if it is not a finite quantity of that dimension and sign.
    """

    def refuse(reason: str = "") -> NoReturn:
        raise InputError(
            f"Argument `{field}` must be {dimension.expected(sign)}, "
            f"but it is {shown(value)}{reason and ', '}{reason}."
        )

    number = math.nan
    try:
        if isinstance(value, str):
            number = _parse_text(value, dimension)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            number = float(value)
    except _UnitError as error:
        refuse(str(error))
    except OverflowError:
        refuse("too large a number")
    if not math.isfinite(number) or not sign.allows(number):
        refuse()
    if abs(number) > _LARGEST:
        refuse("too large a number")
    if sign in (Sign.POSITIVE, Sign.NOT_ZERO) and abs(number) < 1.0 / _LARGEST:
        refuse("too small a number")
    return number


class _UnitError(Exception):
    """Why a text is no quantity, in words that follow 'but it is ...,', if it needs any."""


class _Unit(NamedTuple):
    """A unit in SI: its scale, and its exponents of (kg, m, s, rad)."""

    # Exact, so that '1.1 mm' is the float next to 0.0011 and not one beside it.
    scale: Fraction
    exponents: tuple[int, ...]

    def times(self, other: "_Unit", power: int = 1) -> "_Unit":
        exponents = zip(self.exponents, other.exponents, strict=True)
        return _Unit(self.scale * other.scale**power, tuple(a + power * b for a, b in exponents))


_ONE = _Unit(Fraction(1), (0, 0, 0, 0))
_SYMBOLS = {
    "m": _Unit(Fraction(1), (0, 1, 0, 0)),
    "g": _Unit(Fraction(1, 1000), (1, 0, 0, 0)),
    "s": _Unit(Fraction(1), (0, 0, 1, 0)),
    "N": _Unit(Fraction(1), (1, 1, -2, 0)),
    "Pa": _Unit(Fraction(1), (1, -1, -2, 0)),
    "J": _Unit(Fraction(1), (1, 2, -2, 0)),
    "rad": _Unit(Fraction(1), (0, 0, 0, 1)),
}
_DEGREE = _Unit(Fraction(math.pi) / 180, (0, 0, 0, 1))
_PREFIXES = {
    "G": 9, "M": 6, "k": 3, "h": 2, "da": 1, "": 0, "d": -1, "c": -2, "m": -3, "u": -6, "n": -9,
}  # fmt: skip

_SPELLINGS = str.maketrans({"−": "-", "·": "*", "⋅": "*", "×": "*", "µ": "u", "μ": "u", "°": "deg"})
_SUPERSCRIPTS = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")
_SUPERSCRIPT = re.compile("[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
# The lengths of the text and of its exponents are bounded: exact arithmetic has no overflow.
_LONGEST = 100
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3}(?![0-9]))?")
_TOKEN = re.compile(
    r"(?:(?P<symbol>[A-Za-z]+)(?:\s*\^\s*(?P<power>[+-]?[0-9])|(?P<digit>[0-9]))?(?![0-9])"
    r"|(?P<mark>[*/()]|1(?![0-9])))\s*"
)


def _parse_text(text: str, dimension: Dimension) -> float:
    text = text.translate(_SPELLINGS).strip()
    number = _NUMBER.match(text)
    if number is None or len(text) > _LONGEST:
        raise _UnitError("not a number with a unit")
    unit_text = text[number.end() :].strip()
    scale = Fraction(1)
    if unit_text:
        unit = _parse_unit(unit_text)
        if not dimension.admits(unit.exponents):
            raise _UnitError()
        scale = unit.scale
    return float(Fraction(number[0]) * scale)


@functools.cache
def _parse_unit(text: str) -> _Unit:
    text = _SUPERSCRIPT.sub(lambda match: "^" + match[0].translate(_SUPERSCRIPTS), text)
    text = text.replace("**", "^").replace(".", "*")
    tokens: list[re.Match[str]] = []
    position = 0
    while position < len(text):
        token = _TOKEN.match(text, position)
        if token is None:
            raise _UnitError(f"whose unit cannot be read at {shown(text[position:])}")
        tokens.append(token)
        position = token.end()
    tokens.reverse()
    unit = _product(tokens)
    if tokens:
        raise _UnitError("whose unit has an unmatched ')'")
    return unit


def _product(tokens: list[re.Match[str]]) -> _Unit:
    """Consumes factors from the end of `tokens` up to a closing parenthesis."""
    unit = _ONE if tokens and tokens[-1]["mark"] == "/" else _factor(tokens)
    while tokens and tokens[-1]["mark"] != ")":
        divides = tokens[-1]["mark"] == "/"
        if tokens[-1]["mark"] in ("*", "/"):
            tokens.pop()
        unit = unit.times(_factor(tokens), -1 if divides else 1)
    return unit


def _factor(tokens: list[re.Match[str]]) -> _Unit:
    token = tokens.pop() if tokens else None
    if token is None or token["mark"] in ("*", "/", ")"):
        raise _UnitError("whose unit lacks a factor")
    if token["mark"] == "1":
        return _ONE
    if token["mark"] == "(":
        unit = _product(tokens)
        if not tokens:
            raise _UnitError("whose unit has an unmatched '('")
        tokens.pop()
        return unit
    power = int(token["power"] or token["digit"] or 1)
    # 'Nm' is so common that it is read as N*m; only newtons start such a word.
    head, newton, tail = token["symbol"].partition("N")
    if newton and tail:
        return _symbol(head + newton).times(_symbol(tail), power)
    return _ONE.times(_symbol(token["symbol"]), power)


def _symbol(name: str) -> _Unit:
    if name == "deg":
        return _DEGREE
    for prefix, exponent in _PREFIXES.items():
        base = _SYMBOLS.get(name.removeprefix(prefix)) if name.startswith(prefix) else None
        if base is not None:
            return base._replace(scale=base.scale * Fraction(10) ** exponent)
    raise _UnitError(f"whose unit {shown(name)} is unknown")
