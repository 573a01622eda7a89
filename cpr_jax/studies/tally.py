"""Counts and moments of samples, window by window."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..statics.status import Status
from .samples import Samples


class Tally(NamedTuple):
    """What is counted of all samples, also of those that are not kept.

    **Attributes:**

    - `solved`, `lost`, `inside`, `followed`: how many.
    - `mean`: of the solved positions; `scatter`: sum of the outer products of their deviations.
    """

    solved: int
    lost: int
    inside: int
    followed: int
    mean: Float[np.ndarray, " d"]
    scatter: Float[np.ndarray, "d d"]

    @property
    def covariance(self) -> Float[np.ndarray, "d d"]:
        """Of the solved positions; NaN where there are fewer than two."""
        return self.scatter / (self.solved - 1 if self.solved > 1 else np.nan)

    def row(self) -> Float[np.ndarray, " numbers"]:
        """All numbers in one array; counts below 2⁵³ keep every digit."""
        counts = [self.solved, self.lost, self.inside, self.followed]
        return np.concatenate([counts, self.mean, self.scatter.ravel()])


def from_row(row: Float[np.ndarray, " numbers"], d: int) -> Tally:
    """Inverse of `Tally.row`."""
    solved, lost, inside, followed = (int(count) for count in row[:4])
    mean, scatter = row[4 : 4 + d], row[4 + d :].reshape(d, d)
    return Tally(solved, lost, inside, followed, mean, scatter)


def tally(window: Samples, d: int) -> Tally:
    """The tally of one window; `d` is the number of coordinates of a position."""
    points = window.q_p[window.status == Status.SOLVED][:, :d]
    mean = points.mean(axis=0) if len(points) else np.zeros(d)
    return Tally(
        solved=len(points),
        lost=int(np.sum(window.status == Status.LOST)),
        inside=int(np.sum(window.inside)),
        followed=int(np.sum(window.followed)),
        mean=mean,
        scatter=(points - mean).T @ (points - mean),
    )


def merged(tallies: Iterable[Tally], d: int) -> Tally:
    """The tally of all windows, by Chan's update of mean and covariance, in order."""
    total = Tally(0, 0, 0, 0, np.zeros(d), np.zeros((d, d)))
    for part in tallies:
        solved = total.solved + part.solved
        share = part.solved / max(solved, 1)
        shift = part.mean - total.mean
        total = Tally(
            solved=solved,
            lost=total.lost + part.lost,
            inside=total.inside + part.inside,
            followed=total.followed + part.followed,
            mean=total.mean + share * shift,
            scatter=total.scatter + part.scatter + total.solved * share * np.outer(shift, shift),
        )
    return total
