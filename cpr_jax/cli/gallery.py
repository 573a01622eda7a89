"""`cpr-jax robots --figure`: the catalogue as a picture."""

import pathlib
import sys

import matplotlib
from tqdm import tqdm

from ..plotting.gallery import figure_of_robots
from ..plotting.style import journal_style, save_figure
from ..robots.names import CATALOGUE
from ..statics.solve import solve_forward
from ..statics.status import SolveError
from .session import NoSolution, load, print_json, start_jax


def draw_robots(file: str, as_json: bool) -> int:
    """Draws every robot of the catalogue at its home in one figure."""
    path = pathlib.Path(file)
    path.parent.mkdir(parents=True, exist_ok=True)
    start_jax()
    matplotlib.use("Agg")
    solved = []
    try:
        for entry in tqdm(CATALOGUE.values(), unit="robot", disable=not sys.stderr.isatty()):
            robot = load(entry)
            assert robot.home is not None
            solved.append((robot, solve_forward(robot, robot.home.q_a)))
    except SolveError as error:
        raise NoSolution(str(error)) from None
    with journal_style():
        save_figure(figure_of_robots(solved), path.with_suffix(""), [path.suffix[1:]])
    if as_json:
        print_json({"robots": list(CATALOGUE), "files": [file]})
    else:
        print(f"{len(solved)} robots are drawn in {file}")
    return 0
