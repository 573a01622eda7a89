"""How a solve ended."""

import enum


class Status(enum.IntEnum):
    """Outcome of one solve; the same codes in single solves, batches and result files."""

    SOLVED = 0
    NOT_CONVERGED = 1
    SINGULAR = 2
    NOT_FINITE = 3
    LOST = 4
    NOT_FOUND = 5

    @property
    def message(self) -> str:
        """What happened, for a person."""
        return _MESSAGES[self]


_MESSAGES = {
    Status.SOLVED: "solved",
    Status.NOT_CONVERGED: "the iteration did not converge",
    Status.SINGULAR: "the Jacobian of the residual is singular",
    Status.NOT_FINITE: "the input or the residual is not finite",
    Status.LOST: (
        "the branch has no equilibrium there: following it met a singularity "
        "(a point out of reach, or beyond a fold)"
    ),
    Status.NOT_FOUND: "no equilibrium was found in a systematic search",
}


class SolveError(RuntimeError):
    """A solve that has no solution to return; `status` says why."""

    def __init__(self, status: Status, message: str) -> None:
        super().__init__(message)
        self.status = status
