"""What a robot file says, as plain numbers in SI units."""

import dataclasses
import math


@dataclasses.dataclass(frozen=True)
class SectionSpecification:
    """A cross-section: `kind` is "rectangle" (width, height) or "circle" (radius), sizes in m."""

    kind: str
    sizes: tuple[float, ...]

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
    """A rod. Its stiffness is the first of these that is not `None`:

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
    def mass_per_length(self) -> float | None:
        """kg/m, or `None` where the file does not say."""
        if self.section is None or self.material is None or self.material.density is None:
            return None
        return self.section.area * self.material.density


@dataclasses.dataclass(frozen=True)
class LegSpecification:
    """A leg.

    **Attributes** (m and rad):

    - `base`, `base_rotation`: of the motor in world axes.
    - `motor`: "revolute" or "prismatic"; `motor_axis` is a unit vector, or `None` for the last
        local axis of a revolute motor and the first one of a prismatic motor.
    - `a`, `b`: rigid segments, in the axes of the rod's ends.
    - `joint`: "pivot", "spherical", "clamped", "slider", or the flags of its free directions.
    - `moment_row`: "pivot" or "printed", see `Joint.lever`.
    - `attachment`, `attachment_rotation`: joint frame on the platform, in its axes.
    """

    base: tuple[float, ...]
    base_rotation: tuple[float, ...]
    motor: str
    motor_axis: tuple[float, ...] | None
    a: tuple[float, ...]
    rod: RodSpecification
    b: tuple[float, ...]
    joint: str | tuple[float, ...]
    moment_row: str
    attachment: tuple[float, ...]
    attachment_rotation: tuple[float, ...]


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
    - `platform`: "point" or "body".
    - `force`, `moment`: dead load at `p_P` in world axes, N and N·m.
    - `legs`: at least one.
    - `home`: or `None`.
    - `gravity`: m/s², or `None`.
    - `uncertainty`: half ranges of parameters by their label, in SI units.
    - `warnings`: what is allowed and yet looks like a mistake, one sentence each.
    """

    name: str
    geometry: str
    platform: str
    force: tuple[float, ...]
    moment: tuple[float, ...]
    legs: tuple[LegSpecification, ...]
    home: HomeSpecification | None
    gravity: tuple[float, ...] | None
    uncertainty: dict[str, float]
    warnings: tuple[str, ...] = ()
