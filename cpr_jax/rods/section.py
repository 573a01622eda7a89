"""Cross-sections and materials, and the compliances that they make."""

import dataclasses

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..checks import check_between, check_positive
from ..geometry import AbstractGeometry, floats, namespace


@dataclasses.dataclass(frozen=True)
class Material:
    """A linear elastic, isotropic material.

    **Attributes:**

    - `E`: Young's modulus, Pa.
    - `nu`: Poisson's ratio; `G = E / (2 (1 + nu))`.
    - `density`: kg/m³; needed for weight only.
    """

    E: float
    nu: float = 0.35
    density: float = 0.0

    def __post_init__(self) -> None:
        check_positive("material.E", self.E)
        check_positive("material.density", self.density, or_zero=True)
        check_between("material.nu", self.nu, -1.0, 0.5)

    @property
    def G(self) -> float:
        """Shear modulus, Pa."""
        return self.E / (2.0 * (1.0 + self.nu))


@dataclasses.dataclass(frozen=True)
class Section:
    """What a rod needs to know of its cross-section, whose local axes are 2 and 3.

    **Attributes:**

    - `area`: m².
    - `I_2`, `I_3`: second moments of area about the local axes 2 and 3, m⁴. A planar rod bends
        about axis 3.
    - `J`: torsion constant, m⁴.
    - `shear_factor`: share of the area that carries shear.
    """

    area: float
    I_2: float
    I_3: float
    J: float
    shear_factor: float

    def compliances(
        self, geometry: AbstractGeometry, material: Material
    ) -> tuple[Float[Array, " r"], Float[Array, " d"]]:
        """Curvature compliance, 1/(N·m²), and strain compliance, 1/N, in local axes."""
        shear = self.shear_factor * material.G * self.area
        stretch = [material.E * self.area] + [shear] * (geometry.d - 1)
        bending = [material.G * self.J, material.E * self.I_2, material.E * self.I_3]
        xp = namespace(bending, stretch)
        curvature, strain = 1.0 / xp.asarray(bending[-geometry.r :]), 1.0 / xp.asarray(stretch)
        return floats(curvature), floats(strain)


def rectangle(width: float, height: float) -> Section:
    """A rectangle, `width` along the local axis 2 (the plane of a planar rod), m.

    Bending in the plane is about axis 3: `I_3 = height width³ / 12`. The torsion constant is
    Saint-Venant's series cut after its first term, exact to 0.5 %.
    """
    check_positive("width", width)
    check_positive("height", height)
    xp = namespace(width, height)
    long, short = xp.maximum(width, height), xp.minimum(width, height)
    ratio = short / long
    torsion = long * short**3 * (1.0 / 3.0 - 0.21 * ratio * (1.0 - ratio**4 / 12.0))
    return Section(
        area=width * height,
        I_2=width * height**3 / 12.0,
        I_3=height * width**3 / 12.0,
        J=torsion,
        shear_factor=5.0 / 6.0,
    )


def circle(radius: float, shear_factor: float = 0.9) -> Section:
    """A full circle of the given radius, m."""
    check_positive("radius", radius)
    check_positive("shear_factor", shear_factor)
    area = jnp.pi * radius**2
    second = jnp.pi * radius**4 / 4.0
    return Section(area=area, I_2=second, I_3=second, J=2.0 * second, shear_factor=shear_factor)
