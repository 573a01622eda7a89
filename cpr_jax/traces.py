"""What a traced program consists of, with its loops and calls."""

from collections.abc import Iterator

from .lazy import is_lazy, traced

VIEWS = frozenset({"broadcast_in_dim", "convert_element_type", "reshape", "slice", "squeeze"})
"""What moves values without calculating: rather done again than stored."""

_MOVES = VIEWS | {"concatenate", "dynamic_slice", "dynamic_update_slice", "pad", "transpose"}

CALLS = {
    "jit": "jaxpr",
    "pjit": "jaxpr",
    "closed_call": "call_jaxpr",
    "custom_jvp_call": "call_jaxpr",
    "custom_vjp_call": "call_jaxpr",
    "custom_vmap_call": "call",
}
"""Where the operations called so have the program that they call."""

LOOPS = {"scan": "jaxpr", "while": "body_jaxpr"}
"""Where loops have their body."""


def name_of(equation) -> str:
    """What an operation is called."""
    return equation.primitive.name


def inner(equation) -> list:
    """The program of a call, or of a loop's body, if an operation is one."""
    if is_lazy(equation):
        return [traced(equation)]
    places = CALLS | LOOPS
    name = name_of(equation)
    return [equation.params[places[name]]] if name in places else []


def operations(jaxpr) -> int:
    """Number of operations."""
    return sum(1 + sum(operations(body.jaxpr) for body in inner(e)) for e in jaxpr.eqns)


def largest(jaxpr) -> int:
    """Elements of the largest array that is calculated or moved."""
    within = [largest(body.jaxpr) for equation in jaxpr.eqns for body in inner(equation)]
    outputs = [variable.aval.size for equation in jaxpr.eqns for variable in equation.outvars]
    return max(within + outputs, default=0)


def loops_over_elements(jaxpr) -> Iterator[tuple[int, int]]:
    """Operations of each loop over the elements of an array, and bytes that it reads and writes.

    A call without loops and calls of its own is one such loop, as are operations by themselves.
    """
    for equation in jaxpr.eqns:
        steps = [step for body in inner(equation) for step in body.jaxpr.eqns]
        if name_of(equation) in LOOPS or any(inner(step) for step in steps):
            for body in inner(equation):
                yield from loops_over_elements(body.jaxpr)
            continue
        arrays = [variable.aval for variable in (*equation.invars, *equation.outvars)]
        calculated = [step for step in steps or [equation] if name_of(step) not in _MOVES]
        yield (
            sum(variable.aval.size for step in calculated for variable in step.outvars),
            sum(array.size * array.dtype.itemsize for array in arrays),
        )
