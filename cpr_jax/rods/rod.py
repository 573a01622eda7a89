"""The description of one rod."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..checks import check_finite, check_kind, check_positive, check_shape, check_vector
from ..geometry import AbstractGeometry, Numbers, floats, namespace
from .section import Material, Section


class Segments(eqx.Module):
    """What follows the first segment of a rod: `k` further segments, each uniform.

    The segments of a rod are joined end to end, rigidly and with one tangent: position, rotation,
    force and moment are continuous, curvature and strain jump.

    **Attributes** (from the base to the tip along an axis of length `k`, otherwise as in `Rod`):

    - `length`: m, shape `(k,)`. A length of zero stands for a segment that is not there.
    - `curvature_compliance`, `precurvature`: shape `(k, r)`.
    - `strain_compliance`, `force`: shape `(k, d)`, or `None` as in the `Rod`.
    - `moment`: shape `(k, r)`, or `None` as in the `Rod`.
    """

    length: Float[Array, "*batch k"]
    curvature_compliance: Float[Array, "*batch k r"]
    precurvature: Float[Array, "*batch k r"]
    strain_compliance: Float[Array, "*batch k d"] | None = None
    force: Float[Array, "*batch k d"] | None = None
    moment: Float[Array, "*batch k r"] | None = None


class Rod(eqx.Module):
    """A rod in compliance form, uniform or of several segments that are.

    Compliances instead of stiffnesses make the Kirchhoff rod the case of a strain compliance
    of zero. `None` stands for a physical effect that is left out, and costs nothing.

    **Attributes** (local axes: the first is the tangent; `d` = 2, `r` = 1 in the plane,
    `d` = `r` = 3 in space):

    - `length`: of the whole rod, m.
    - `curvature_compliance`: `1 / k_b`, shape `(r,)`, 1/(N·m²); in space
        (torsion, bending about 2, bending about 3).
    - `precurvature`: curvature at rest `1 / r_c`, shape `(r,)`, 1/m.
    - `strain_compliance`: shape `(d,)`, 1/N (stretch, then shear), or `None` for an inextensible
        and unshearable rod.
    - `force`: distributed dead force in world axes, shape `(d,)`, N/m, or `None`.
    - `moment`: distributed dead moment in world axes, shape `(r,)`, N, or `None`.
    - `further`: the segments beyond the first one, or `None` for a uniform rod. The first one, at
        the base, has all of the above, and of the length what the further ones leave:
        `length - Σ further.length`. So a rod that is fed through its base grows there.
    """

    length: Float[Array, "*batch"]
    curvature_compliance: Float[Array, "*batch r"]
    precurvature: Float[Array, "*batch r"]
    strain_compliance: Float[Array, "*batch d"] | None = None
    force: Float[Array, "*batch d"] | None = None
    moment: Float[Array, "*batch r"] | None = None
    further: Segments | None = None


def kirchhoff_rod(
    geometry: AbstractGeometry,
    length: Numbers,
    k_b: Numbers,
    precurvature: Numbers = 0.0,
    force: Numbers | None = None,
    moment: Numbers | None = None,
) -> Rod:
    """An inextensible, unshearable rod from its stiffnesses.

    **Arguments:**

    - `length`: m.
    - `k_b`: bending stiffness, N·m²; in space `(k_t, k_2, k_3)`, or one number for all three.
    - `precurvature`: `1 / r_c`, 1/m; in space a vector, or one number for the axis 3. Where that is
        positive, the tangent turns towards axis 2: in the plane to the left.
    - `force`, `moment`: distributed dead load in world axes, N/m and N.

    **Raises:** `InputError` for shapes that do not fit, and lengths and stiffnesses that are not
    positive.
    """
    check_kind("geometry", geometry, AbstractGeometry, "PLANE or SPACE")
    r = geometry.r
    for name, value in (("length", length), ("k_b", k_b)):
        check_positive(name, value)
    check_shape("length", length, ())
    check_shape("k_b", k_b, (), (r,))
    check_shape("precurvature", precurvature, (), (r,))
    if force is not None:
        check_shape("force", force, (geometry.d,))
    if moment is not None:
        check_vector("moment", moment, r)
    xp = namespace(k_b, precurvature)
    rest = xp.asarray(precurvature, float)
    if rest.ndim == 0:
        rest = xp.append(np.zeros(geometry.r - 1), rest)
    stiffness = xp.broadcast_to(xp.asarray(k_b, float), (geometry.r,))
    return Rod(
        length=floats(length),
        curvature_compliance=floats(1.0 / stiffness),
        precurvature=floats(rest),
        force=None if force is None else floats(force),
        moment=None if moment is None else jnp.atleast_1d(floats(moment)),
    )


def section_rod(
    geometry: AbstractGeometry,
    length: Numbers,
    section: Section,
    material: Material,
    precurvature: Numbers = 0.0,
    extensible: bool = False,
    gravity: Numbers | None = None,
) -> Rod:
    """A rod made from a section and a material.

    **Arguments:**

    - `extensible`: also stretch and shear (Cosserat); otherwise Kirchhoff.
    - `gravity`: acceleration in world axes, m/s², shape `(d,)`; the rod then carries its weight
        `density area gravity`, for which the material must have a density.
    """
    check_kind("section", section, Section, "a Section, such as `circle(radius)`")
    check_kind("material", material, Material, "a Material")
    check_positive("material.E", material.E)
    check_positive("section.area", section.area)
    curvature, strain = section.compliances(geometry, material)
    weight = None
    if gravity is not None:
        check_shape("gravity", gravity, (geometry.d,))
        check_finite("gravity", gravity)
        check_positive("material.density", material.density)
        weight = material.density * section.area * namespace(gravity).asarray(gravity, float)
    rod = kirchhoff_rod(
        geometry,
        length,
        1.0 / namespace(curvature).asarray(curvature),
        precurvature,
        force=weight,
    )
    if not extensible:
        return rod
    return eqx.tree_at(
        lambda rod: rod.strain_compliance, rod, strain, is_leaf=lambda leaf: leaf is None
    )
