"""How a solve ended."""

import enum


class Status(enum.IntEnum):
    """Outcome of one solve; the same codes in single solves, batches and result files."""

    SOLVED = 0
    NOT_CONVERGED = 1
    OUT_OF_REACH = 2
    NOT_FINITE = 3
    LOST = 4
    NOT_FOUND = 5
    BEYOND_FOLD = 6
    BEYOND_LIMITS = 7
    INACCURATE = 8
    NOT_ASSEMBLED = 9

    @property
    def message(self) -> str:
        """What happened, for a person."""
        return _MESSAGES[self]


_MESSAGES = {
    Status.SOLVED: "solved",
    Status.NOT_CONVERGED: "the iteration did not converge",
    Status.OUT_OF_REACH: "a leg is too short to reach it",
    Status.NOT_FINITE: "the input or the residual is not finite",
    Status.LOST: (
        "the branch has no equilibrium there: following it met a singularity "
        "(a point out of reach, or beyond a fold)"
    ),
    Status.NOT_FOUND: "no equilibrium was found in a systematic search",
    Status.BEYOND_FOLD: "the branch folds back before it (a Type 1 singularity)",
    Status.BEYOND_LIMITS: "there is an equilibrium, beyond a limit",
    Status.INACCURATE: "its rods take more integration steps, see `steps`",
    Status.NOT_ASSEMBLED: (
        "it could not be assembled at its home: motors and platform must be close to where it is "
        "at rest there, or the home be left out for a search"
    ),
}


class SolveError(RuntimeError):
    """A solve that has no solution to return.

    **Attributes:**

    - `status`: why.
    - `hint`: what may be wrong with the numbers of the call, a sentence, or nothing.
    - `equilibrium`: what the call would have returned, if it is known.
    """

    def __init__(
        self, status: Status, message: str, hint: str = "", equilibrium: object = None
    ) -> None:
        super().__init__(f"{message} {hint}" if hint else message)
        self.status, self.hint, self.equilibrium = status, hint, equilibrium
