"""The folder that holds the paper's figures, their samples, the map and a report."""

import json
import pathlib

from ..aside import Aside
from ..atomic import write_atomically
from ..plain import plain
from ..studies.paper import Observer, case_study
from ..studies.paper_samples import POINTS
from ..studies.report import markdown_report
from ..studies.results import samples_dataset, save_dataset
from ..studies.versions import versions

FIGURES = "cpr_jax.plotting.paper"
"""The module that an `Aside` draws with."""


class _Folder(Observer):
    """Draws and saves what there is of a study."""

    def __init__(self, folder: pathlib.Path, aside: Aside, seed: int):
        self._folder, self._aside, self._seed = folder, aside, seed

    def _draw(self, number: int, *what: object) -> None:
        self._aside.call(f"{FIGURES}:save_figure_{number}", self._folder, *what)

    def robot(self, robot) -> None:
        self._aside.call(f"{FIGURES}:prepare", robot)

    def equilibria(self, robot, found) -> None:
        self._draw(1, robot, found["A"])

    def studies(self, robot, equilibria, found) -> None:
        self._draw(2, robot, equilibria["A"], found)
        about = {"robot": robot.name, "seed": self._seed, "distribution": "gaussian"}
        dataset = samples_dataset(found, about)
        save_dataset(dataset, self._folder / "samples.nc")

    def workspace(self, robot, found) -> None:
        self._draw(3, robot, found)
        save_dataset(found, self._folder / "map.nc")


def make_paper(
    out: str | pathlib.Path,
    samples: int = 2000,
    seed: int = 0,
    progress: bool = False,
    aside: Aside | None = None,
) -> dict:
    """Writes Figures 1 to 3, their samples, the map and a report; returns the report.

    **Arguments:**

    - `aside`: draws the figures, which are there when its block ends; by default one of its own.
    """
    if aside is None:
        with Aside(FIGURES) as own:
            return make_paper(out, samples, seed, progress, own)
    folder = pathlib.Path(out).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    study = case_study(samples, seed, progress, _Folder(folder, aside, seed))
    report = {
        "samples": samples,
        "seed": seed,
        "points": POINTS,
        "q_a": {name: plain(e.q_a) for name, e in study.equilibria.items()},
        "semi_axes": {name: plain(s.ellipsoid.semi_axes) for name, s in study.studies.items()},
        "coverage": {name: s.coverage for name, s in study.studies.items()},
        "coverage_interval": {name: s.coverage_interval for name, s in study.studies.items()},
        "lost": {name: s.lost for name, s in study.studies.items()},
        "failed": {name: s.failed for name, s in study.studies.items()},
        "claims": study.claims,
        "versions": versions(),
    }
    text = json.dumps(plain(report), indent=2)
    write_atomically(folder / "report.json", lambda file: file.write_text(text + "\n"))
    write_atomically(folder / "report.md", lambda file: file.write_text(markdown_report(report)))
    return report
