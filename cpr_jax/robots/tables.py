"""The tables of a robot file: which keys they have, and access that knows where a value stands."""

import dataclasses
import difflib
import math
import re
from collections.abc import Mapping, Sequence

from ..errors import InputError, shown
from .units import Dimension, Sign, parse_quantity

KEYS = {
    "file": ("format", "name", "geometry", "motors", "platform", "home", "defaults", "legs",
             "environment", "uncertainty"),
    "platform": ("kind", "force", "moment", "mass", "center_of_mass", "loads"),
    "platform.loads": ("position", "force"),
    "home": ("motors", "position", "rotation"),
    "defaults": ("leg",),
    "legs": ("base", "base_rotation", "motor", "base_joint", "a", "b", "joint", "moment_row",
             "attachment", "attachment_rotation", "rod"),
    "motor": ("kind", "axis", "ratio"),
    "joint": ("free",),
    "base_joint": ("joint", "free", "position", "rotation"),
    "rotation": ("tangent", "third", "axis", "angle"),
    "legs.rod": ("length", "bending_stiffness", "curvature_compliance", "section", "material",
                 "precurvature", "precurvature_radius", "extensible", "strain_compliance",
                 "force", "moment", "segments"),
    "legs.rod.segments": ("length", "bending_stiffness", "curvature_compliance", "section",
                          "material", "precurvature", "precurvature_radius", "extensible",
                          "strain_compliance", "force", "moment"),
    "rectangle": ("kind", "width", "height", "shear_factor"),
    "circle": ("kind", "radius", "shear_factor"),
    "material": ("E", "nu", "density"),
    "environment": ("gravity",),
}  # fmt: skip
"""The keys of each kind of table."""

CHOICES = {
    "geometry": ("plane", "space"),
    "platform": ("point", "body"),
    "motor": ("revolute", "prismatic", "feed", "telescopic", "none"),
    "joint": ("pivot", "universal", "spherical", "clamped", "swivel", "slider"),
    "moment_row": ("pivot", "printed"),
    "section": ("rectangle", "circle"),
}
"""The words between which a file chooses."""

_REQUIRED = object()


@dataclasses.dataclass(frozen=True)
class Entry:
    """A value of a robot file and where it stands; each method checks it and converts it."""

    value: object
    field: str

    def error(self, expected: str) -> InputError:
        """The mistake that this value is not `expected`."""
        return InputError(
            f"Argument `{self.field}` must be {expected}, but it is {shown(self.value)}."
        )

    @property
    def is_list(self) -> bool:
        """Whether the value is a list of values."""
        return isinstance(self.value, list | tuple)

    @property
    def is_table(self) -> bool:
        """Whether the value is a table."""
        return isinstance(self.value, Mapping)

    def quantity(self, dimension: Dimension, sign: Sign = Sign.ANY) -> float:
        """A number in SI units."""
        return parse_quantity(self.value, dimension, self.field, sign)

    def vector(
        self, dimension: Dimension, parts: Sequence[str], sign: Sign = Sign.ANY
    ) -> tuple[float, ...]:
        """As many numbers in SI units as there are `parts`, which the message names."""
        names = ", ".join(parts)
        if not isinstance(self.value, list | tuple) or len(self.value) != len(parts):
            raise self.error(f"a list of {len(parts)} entries ({names})")
        return tuple(entry.quantity(dimension, sign) for entry in self.items())

    def items(self) -> list["Entry"]:
        """The entries of a list that is not empty."""
        if not isinstance(self.value, list | tuple) or not self.value:
            raise self.error("a list with at least one entry")
        return [Entry(value, f"{self.field}[{i}]") for i, value in enumerate(self.value)]

    def choice(self, *options: str) -> str:
        """One of some words."""
        word = self.value if isinstance(self.value, str) else ""
        if word in options:
            return word
        words = " or ".join(f"'{option}'" for option in options)
        close = difflib.get_close_matches(word, options, n=1)
        hint = f" (did you mean '{close[0]}'?)" if close else ""
        raise self.error(f"{words}{hint}")

    def truth(self) -> bool:
        """True or false."""
        if not isinstance(self.value, bool):
            raise self.error("true or false")
        return self.value

    def line(self) -> str:
        """A text of one line."""
        text = self.value
        if not isinstance(text, str) or not text.strip() or not text.isprintable():
            raise self.error("a text of one line that is not empty")
        return text

    def table(self, kind: str | None) -> "Table":
        """A table with the keys of a kind, or with any keys."""
        return Table(self.value, self.field, kind)


class Table:
    """A table of a robot file, and the defaults for what it leaves out."""

    def __init__(self, value: object, place: str, kind: str | None, behind: "Table | None" = None):
        """
        **Arguments:**

        - `value`: the table, to be checked.
        - `place`: where it stands; empty for the whole file.
        - `kind`: which keys it may have, see `KEYS`; `None` for any.
        - `behind`: the defaults.
        """
        if not isinstance(value, Mapping):
            raise Entry(value, place or "file").error("a table of keys and values")
        self._entries = value
        self._place = place
        self._behind = behind
        if kind is not None:
            self._check_keys(kind)

    def _check_keys(self, kind: str) -> None:
        for key in self._entries:
            if key in KEYS[kind]:
                continue
            # A key under the wrong heading, a trap of TOML, unless it looks like a typing error.
            elsewhere = [f"`{other}`" for other in KEYS if key in KEYS[other]]
            cutoff = 0.8 if elsewhere else 0.6
            close = difflib.get_close_matches(str(key), KEYS[kind], n=1, cutoff=cutoff)
            hint = "."
            if close:
                hint = f"; did you mean `{close[0]}`?"
            elif elsewhere:
                hint = f"; it belongs to {' or '.join(elsewhere)}."
            raise InputError(
                f"Argument `{self.field(key)}` must be one of the keys {', '.join(KEYS[kind])}, "
                f"but it is not{hint}"
            )

    def field(self, key: object) -> str:
        """Where a key of this table stands in the file."""
        plain = isinstance(key, str) and re.fullmatch(r"[A-Za-z0-9_-]+", key)
        name = str(key) if plain else shown(key)
        return f"{self._place}.{name}" if self._place else name

    def keys(self) -> list[str]:
        """The keys of the table itself, without its defaults."""
        return list(self._entries)

    def has(self, key: str) -> bool:
        """Whether the table or its defaults have a key."""
        return key in self._entries or (self._behind is not None and self._behind.has(key))

    def entry(self, key: str, default: object = _REQUIRED) -> Entry:
        """The value of a key, from the defaults where the table leaves it out."""
        if key in self._entries:
            return Entry(self._entries[key], self.field(key))
        if self._behind is not None and self._behind.has(key):
            return self._behind.entry(key)
        if default is _REQUIRED:
            raise InputError(f"Argument `{self.field(key)}` must be given, but it is missing.")
        return Entry(default, self.field(key))

    def table(self, key: str, kind: str) -> "Table":
        """A table inside this one whose keys stand before those of the defaults' table."""
        behind = None
        if self._behind is not None and self._behind.has(key):
            behind = self._behind.table(key, kind)
        own = {} if behind is not None and key not in self._entries else self.entry(key).value
        return Table(own, self.field(key), kind, behind)

    def first(self, *alternatives: str) -> str | None:
        """Which of some keys that exclude each other is given; a leg's choice hides a default."""
        given = [key for key in alternatives if key in self._entries]
        if len(given) > 1:
            raise InputError(
                f"Argument `{self.field(given[0])}` must be given alone, "
                f"but `{self.field(given[1])}` is given too."
            )
        if given or self._behind is None:
            return given[0] if given else None
        return self._behind.first(*alternatives)

    def refuse(self, key: str, reason: str) -> None:
        """Raises if a key is given, although `reason`."""
        if self.has(key):
            entry = self.entry(key)
            raise InputError(
                f"Argument `{entry.field}` must be left out, since {reason}, "
                f"but it is {shown(entry.value)}."
            )


def unit_vector(vector: tuple[float, ...], entry: Entry) -> tuple[float, ...]:
    """The direction of a vector; one of length 1 to rounding stays as it is."""
    length = math.hypot(*vector)
    if not 0.0 < length < math.inf:
        raise entry.error("a direction of nonzero, finite length")
    if abs(length - 1.0) < 1e-12:
        return vector
    return tuple(c / length for c in vector)
