"""A system of equations: R₀(y, ρ) with the imposed coordinates, dimensionless."""

from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..errors import InputError, shown
from ..geometry import floats
from ..robots.robot import Robot
from ..rods.integration import DEFAULT_STEPS
from ..rods.solver import Steps
from .residual import residual
from .unknowns import unknown_labels, unknown_scales, unravel


class Problem(eqx.Module):
    """Which coordinates of a robot are imposed, and to what.

    One form serves the forward problem (`q_a` imposed), the inverse problem (`q_p` imposed) and
    mixtures; since the choice is an array, all share their compiled code.

    **Attributes:**

    - `robot`: the robot.
    - `imposed`: one row per motor that picks a coordinate of `(q_a, q_p)`, `(n_a, n_a + n_p)`.
    - `target`: desired `(q_a, q_p)`; entries that are not imposed do not matter.
    - `offset`: subtracted from `R₀`; zero but on the way to assembling a robot.
    """

    robot: Robot
    imposed: Float[Array, "n_a n_q"]
    target: Float[Array, " n_q"]
    offset: Float[Array, " n_r"] | None = None


def forward_rows(robot: Robot) -> Float[Array, "n_a n_q"]:
    """Rows that impose the motor positions."""
    return floats(np.eye(robot.n_a, robot.n_a + robot.n_p))


def imposed_rows(robot: Robot, places: Sequence[int]) -> Float[Array, "n_a n_q"]:
    """Rows that impose these entries of `(q_a, q_p)`, as many as the robot has motors."""
    return floats(np.eye(robot.n_a + robot.n_p)[list(places)])


def imposed_coordinates(robot: Robot, names: Sequence[str] | None = None) -> tuple[int, ...]:
    """Places in `(q_a, q_p)` of the coordinates that an inverse problem imposes.

    **Arguments:**

    - `names`: labels such as `p_P_x`, or `x`, `phi_P_z` and `q1`, as many as the robot has
        motors; by default all platform coordinates.

    **Raises:** `InputError` where the numbers do not fit, with what to do about it.
    """
    n_a, n_p = robot.n_a, robot.n_p
    choice = f"({', '.join(_short(robot)[n_a:])})"
    if names is None:
        if n_a == n_p:
            return tuple(range(n_a, n_a + n_p))
        advice = (
            f"name {n_a} of them {choice}"
            if n_a < n_p
            else f"name {n_a - n_p} of the motors with them, or use `resolve_redundancy`"
        )
        raise InputError(
            f"Argument `imposed` must be given for {robot.name}, since its {n_a} motors cannot "
            f"impose {n_p} platform coordinates: {advice}."
        )
    if isinstance(names, str):
        raise InputError(f"Argument `imposed` must be a list of names, but it is {names!r}.")
    if len(names) != n_a or len(set(names)) != n_a:
        raise InputError(
            f"Argument `imposed` must name {n_a} different coordinates of {robot.name} {choice}, "
            f"one for each motor, but it names {', '.join(map(str, names)) or 'none'}."
        )
    places = coordinate_places(robot, names)
    if len(set(places)) != n_a:
        raise InputError(
            f"Argument `imposed` must name {n_a} different coordinates of {robot.name}, but two of "
            f"{', '.join(map(str, names))} are the same."
        )
    return places


def coordinate_places(
    robot: Robot, names: Sequence[str], field: str = "imposed"
) -> tuple[int, ...]:
    """Places in `(q_a, q_p)` of coordinates by name; `field` is the argument that errors name."""
    short = _short(robot)
    labels = unknown_labels(robot)[: len(short)]
    places = []
    for name in names:
        if name not in short and name not in labels:
            raise InputError(
                f"Argument `{field}` must name coordinates of {robot.name} "
                f"({', '.join(short)}), but it names {shown(name)}."
            )
        places.append(short.index(name) if name in short else labels.index(name))
    return tuple(places)


def _short(robot: Robot) -> list[str]:
    """Names of `(q_a, q_p)`: positions are called by their axes."""
    labels = unknown_labels(robot)[: robot.n_a + robot.n_p]
    return [label.removeprefix("p_P_") for label in labels]


def inverse_rows(robot: Robot) -> Float[Array, "n_a n_q"]:
    """Rows that impose the platform coordinates, all of them."""
    return imposed_rows(robot, imposed_coordinates(robot))


def full_residual(
    scaled: Float[Array, " n_y"], problem: Problem, steps: Steps = DEFAULT_STEPS
) -> Float[Array, " n_y"]:
    """`R(y, ρ)` (5), (15) at the dimensionless unknowns `y / unknown_scales`."""
    robot = problem.robot
    units = unknown_scales(robot)
    y = scaled * units
    rows = residual(robot, unravel(robot, y), steps)
    if problem.offset is not None:
        rows = rows - problem.offset
    n_q = robot.n_a + robot.n_p
    imposed = problem.imposed @ ((y[:n_q] - problem.target) / units[:n_q])
    return jnp.concatenate([rows, imposed])
