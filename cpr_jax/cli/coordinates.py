"""What a robot's coordinates are called and what they measure; without JAX."""

import dataclasses
from collections.abc import Sequence

from ..errors import InputError, shown
from ..robots.labels import AXES, ROTATION_AXES
from ..robots.names import CatalogueEntry
from ..robots.specification import RobotSpecification
from ..robots.units import ANGLE, LENGTH, Dimension


@dataclasses.dataclass(frozen=True)
class Coordinates:
    """The coordinates of a robot by their names.

    **Attributes:**

    - `geometry`: "plane" or "space".
    - `segments`: how many the rod of each leg has.
    - `platform`: positions, called by their axes, then the rotation vector of a body.
    - `motors`: `q1` and so on.
    """

    geometry: str
    segments: tuple[int, ...]
    platform: dict[str, Dimension]
    motors: dict[str, Dimension]

    @property
    def square(self) -> bool:
        """Whether there are as many motors as platform coordinates."""
        return len(self.platform) == len(self.motors)

    def imposed(self, text: str | None) -> tuple[str, ...] | None:
        """The names of `--imposed`; `None` where all of the platform's are imposed.

        **Raises:** `InputError` where they do not fit, with what to name.
        """
        count, choice = len(self.motors), f"({', '.join(self.platform)})"
        if text is None and self.square:
            return None
        if text is None and count < len(self.platform):
            raise InputError(
                f"Argument `--imposed` must name {count} of the {len(self.platform)} platform "
                f"coordinates {choice}, one for each motor, but it is not given."
            )
        if text is None:
            raise InputError(
                f"Argument `--imposed` must name the platform coordinates {choice} and "
                f"{count - len(self.platform)} of the {count} motors ({', '.join(self.motors)}), "
                "but it is not given."
            )
        names = self.named("--imposed", text, self.platform | self.motors)
        if len(names) != count:
            raise InputError(
                f"Argument `--imposed` must name {count} coordinates {choice}, one for each "
                f"motor, but it names {len(names)}."
            )
        return names

    def named(self, field: str, text: str, choice: dict[str, Dimension]) -> tuple[str, ...]:
        """Different names, separated by commas, of coordinates; `p_P_x` is `x`."""
        names = tuple(name.strip().removeprefix("p_P_") for name in text.split(","))
        for name in names:
            if name not in choice:
                raise InputError(
                    f"Argument `{field}` must name coordinates of the robot "
                    f"({', '.join(choice)}), but it names {shown(name)}."
                )
        if len(set(names)) != len(names):
            raise InputError(
                f"Argument `{field}` must name different coordinates, but it is {shown(text)}."
            )
        return names

    def dimensions(self, names: Sequence[str]) -> list[Dimension]:
        """What coordinates of these names measure."""
        every = self.platform | self.motors
        return [every[name] for name in names]


def coordinates_of(robot: CatalogueEntry | RobotSpecification) -> Coordinates:
    """The coordinates of a robot of the catalogue or of a robot file."""
    if isinstance(robot, CatalogueEntry):
        kind, segments = robot.platform, (1,) * len(robot.motors)
    else:
        kind = robot.platform.kind
        segments = tuple(len(leg.segments) for leg in robot.legs)
    platform = {axis: LENGTH for axis in AXES[robot.geometry]}
    if kind == "body":
        platform |= {f"phi_P_{axis}": ANGLE for axis in ROTATION_AXES[robot.geometry]}
    motors = {f"q{i}": ANGLE if turns else LENGTH for i, turns in enumerate(robot.turning, 1)}
    return Coordinates(robot.geometry, segments, platform, motors)
