"""The paper's case study, carried out: four points, their ellipses, the map."""

from concurrent.futures import ThreadPoolExecutor

import xarray as xr

from ..analysis.parameters import ranges, select
from ..robots.catalogue import rfrfr
from ..robots.robot import Robot
from ..statics.equilibrium import Equilibrium
from ..statics.solve import solve_inverse
from ..surroundings import inherited
from .ahead import compile_study
from .draws import Distribution
from .monte_carlo import monte_carlo
from .outcome import MonteCarlo
from .paper_map import map_claims
from .paper_samples import POINTS, CaseStudy, sample_claims
from .samples import Options, Prediction
from .workspace import workspace_map

LINEAR_SAMPLES = 20_000

MAP_SPACING = 0.003
"""Of the grid over the workspace, m."""


class Observer:
    """Is told of the parts of a case study, each as soon as it is there."""

    def robot(self, robot: Robot) -> None:
        """The first of them."""

    def equilibria(self, robot: Robot, found: dict[str, Equilibrium]) -> None:
        """At all points."""

    def studies(
        self, robot: Robot, equilibria: dict[str, Equilibrium], found: dict[str, MonteCarlo]
    ) -> None:
        """At all points."""

    def workspace(self, robot: Robot, found: xr.Dataset) -> None:
        """The map."""


def case_study(
    samples: int = 2000,
    seed: int = 0,
    progress: bool = False,
    observer: Observer | None = None,
) -> CaseStudy:
    """Runs the case study of Section 3 with `samples` samples at each point."""
    robot, observer = rfrfr(), observer or Observer()
    observer.robot(robot)

    def mapped() -> xr.Dataset:
        workspace = workspace_map(robot, spacing=MAP_SPACING)
        observer.workspace(robot, workspace)
        return workspace

    selection = select(robot)
    options = Options(selection, Distribution.GAUSSIAN, Prediction.SECOND_ORDER)
    # At D, samples are lost beyond the T2 line.
    ahead = compile_study(robot, options, ranges(robot, selection), followed=True)
    # Side by side: the map is traced by Python while the samples are solved by XLA.
    with ThreadPoolExecutor(1) as pool, ahead:
        mapping = pool.submit(inherited(mapped))
        equilibria = {name: solve_inverse(robot, point) for name, point in POINTS.items()}
        observer.equilibria(robot, equilibria)
        studies = {
            name: monte_carlo(robot, equilibrium, samples, seed, progress=progress)
            for name, equilibrium in equilibria.items()
        }
        observer.studies(robot, equilibria, studies)
        small = {label: float(value) / 100.0 for label, value in robot.uncertainty.items()}
        linear = monte_carlo(
            robot,
            equilibria["A"],
            LINEAR_SAMPLES,
            seed,
            delta=small,
            progress=progress,
        )
        study = CaseStudy(robot, equilibria, studies, linear, xr.Dataset(), [])
        claims = sample_claims(study)
        workspace = mapping.result()
    return study._replace(workspace=workspace, claims=claims + map_claims(workspace))
