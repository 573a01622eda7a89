"""What a robot file says, as plain numbers in SI units."""

import dataclasses
import math


@dataclasses.dataclass(frozen=True)
class SectionSpecification:
    """A cross-section: `kind` is "rectangle" (width, height) or "circle" (radius), sizes in m.

    `shear_factor` is the share of the area that carries shear, `None` for the usual one.
    """

    kind: str
    sizes: tuple[float, ...]
    shear_factor: float | None = None

    @property
    def area(self) -> float:
        """m²."""
        if self.kind == "circle":
            return math.pi * self.sizes[0] ** 2
        return self.sizes[0] * self.sizes[1]

    @property
    def second_moments(self) -> tuple[float, float]:
        """`I_2` and `I_3`, m⁴; a planar rod bends about axis 3."""
        if self.kind == "circle":
            second = math.pi * self.sizes[0] ** 4 / 4.0
            return second, second
        width, height = self.sizes
        return width * height**3 / 12.0, height * width**3 / 12.0


@dataclasses.dataclass(frozen=True)
class MaterialSpecification:
    """A material: `E` in Pa and `density` in kg/m³, `None` where the file does not say."""

    E: float | None
    nu: float
    density: float | None


@dataclasses.dataclass(frozen=True)
class RodSpecification:
    """A uniform rod, or a segment of one. Its stiffness is the first of these that is not `None`:

    - `bending_stiffness`: N·m², one in the plane, `(k_t, k_2, k_3)` in space.
    - `curvature_compliance`: their inverses, 1/(N·m²).
    - `section` and `material`.

    **Other attributes:**

    - `length`: m.
    - `precurvature`: 1/m, one in the plane, three in space.
    - `strain_compliance`: 1/N, (stretch, then shear), or `None`.
    - `extensible`: whether the strain compliance comes from section and material.
    - `force`, `moment`: distributed dead load in world axes, N/m and N, without the rod's weight.
    """

    length: float
    bending_stiffness: tuple[float, ...] | None
    curvature_compliance: tuple[float, ...] | None
    section: SectionSpecification | None
    material: MaterialSpecification | None
    precurvature: tuple[float, ...]
    extensible: bool
    strain_compliance: tuple[float, ...] | None
    force: tuple[float, ...] | None
    moment: tuple[float, ...] | None

    @property
    def stiffness(self) -> float | None:
        """Bending stiffness about the last local axis, N·m²; `None` without a material."""
        if self.bending_stiffness is not None:
            return self.bending_stiffness[-1]
        if self.curvature_compliance is not None:
            compliance = self.curvature_compliance[-1]
            return 1.0 / compliance if compliance else math.inf
        if self.section is None or self.material is None or self.material.E is None:
            return None
        return self.material.E * self.section.second_moments[-1]

    @property
    def mass_per_length(self) -> float | None:
        """kg/m, or `None` where the file does not say."""
        if self.section is None or self.material is None or self.material.density is None:
            return None
        return self.section.area * self.material.density


@dataclasses.dataclass(frozen=True)
class MotorSpecification:
    """A motor of a leg.

    **Attributes:**

    - `kind`: "revolute", "prismatic", "feed" (rod length), "telescopic" (the rigid segment a) or
        "none".
    - `axis`: a unit vector, or `None` for the last local axis of a revolute motor and the first
        one of a prismatic motor.
    - `ratio`: motion per unit of `q`.
    """

    kind: str
    axis: tuple[float, ...] | None = None
    ratio: float = 1.0

    @property
    def turns(self) -> bool:
        """Whether `q` is an angle."""
        return self.kind == "revolute"


@dataclasses.dataclass(frozen=True)
class BaseJointSpecification:
    """A passive joint between a motor and the rigid segment a.

    **Attributes:**

    - `joint`: as in `LegSpecification`.
    - `position`, `rotation`: where it is, in the axes of what the motor moves, m and rad.
    """

    joint: str | tuple[float, ...]
    position: tuple[float, ...]
    rotation: tuple[float, ...]


@dataclasses.dataclass(frozen=True)
class LegSpecification:
    """A leg.

    **Attributes** (m and rad):

    - `base`, `base_rotation`: of the motor in world axes.
    - `motor`: what moves it, or "none".
    - `base_joint`: or `None`.
    - `a`, `b`: rigid segments, in the axes of the rod's ends.
    - `rod`, `further`: the rod's first segment, which is all of a uniform rod, and the others.
    - `joint`: a name, see `CHOICES` of the tables, or the flags of its free directions.
    - `moment_row`: "pivot" or "printed", see `Joint.lever`.
    - `attachment`, `attachment_rotation`: joint frame on the platform, in its axes.
    """

    base: tuple[float, ...]
    base_rotation: tuple[float, ...]
    motor: MotorSpecification
    base_joint: BaseJointSpecification | None
    a: tuple[float, ...]
    rod: RodSpecification
    b: tuple[float, ...]
    joint: str | tuple[float, ...]
    moment_row: str
    attachment: tuple[float, ...]
    attachment_rotation: tuple[float, ...]
    further: tuple[RodSpecification, ...] = ()

    @property
    def segments(self) -> tuple[RodSpecification, ...]:
        """All segments of the rod, from the base to the tip."""
        return (self.rod, *self.further)


@dataclasses.dataclass(frozen=True)
class LoadSpecification:
    """A dead force, N, world axes, at a point of the platform, m, in its axes from `p_P`."""

    position: tuple[float, ...]
    force: tuple[float, ...]


@dataclasses.dataclass(frozen=True)
class PlatformSpecification:
    """The platform.

    **Attributes:**

    - `kind`: "point" or "body".
    - `force`, `moment`: dead load at `p_P` in world axes, N and N·m.
    - `mass`: kg, or `None`; `center_of_mass` in the platform's axes from `p_P`, m.
    - `loads`: at other points of a body.
    """

    kind: str
    force: tuple[float, ...]
    moment: tuple[float, ...]
    mass: float | None
    center_of_mass: tuple[float, ...]
    loads: tuple[LoadSpecification, ...]


@dataclasses.dataclass(frozen=True)
class HomeSpecification:
    """Where the robot's branch is known: motors, rad or m; platform position, m, rotation, rad."""

    motors: tuple[float, ...]
    position: tuple[float, ...]
    rotation: tuple[float, ...]


@dataclasses.dataclass(frozen=True)
class RobotSpecification:
    """A robot as its file describes it.

    **Attributes:**

    - `name`: for figures and files.
    - `geometry`: "plane" or "space".
    - `platform`: a point or a body, and what it carries.
    - `legs`: at least one.
    - `motors`: the legs that each motor moves, counted from 0.
    - `home`: or `None`.
    - `gravity`: m/s², or `None`.
    - `uncertainty`: half ranges of parameters by their label, in SI units.
    - `warnings`: what is allowed and yet looks like a mistake, one sentence each.
    """

    name: str
    geometry: str
    platform: PlatformSpecification
    legs: tuple[LegSpecification, ...]
    motors: tuple[tuple[int, ...], ...]
    home: HomeSpecification | None
    gravity: tuple[float, ...] | None
    uncertainty: dict[str, float]
    warnings: tuple[str, ...] = ()

    @property
    def turning(self) -> tuple[bool, ...]:
        """Whether each motor turns what it moves; its `q` is then an angle."""
        return tuple(self.legs[moved[0]].motor.turns for moved in self.motors)
