"""The command that repeats the paper's case study."""

import pathlib
import sys

from ..aside import Aside


def paper(out: str, samples: int, seed: int, as_json: bool) -> int:
    """Makes the figures, the samples and the report of the paper."""
    # At once, so that a folder that cannot be is refused before anything is computed.
    pathlib.Path(out).mkdir(parents=True, exist_ok=True)
    with Aside("cpr_jax.plotting.paper") as aside:
        # Imported on one core while the other process imports its own on another.
        from ..plotting.paper_folder import make_paper
        from .session import print_json, start_jax

        start_jax()
        aside.call("cpr_jax.cli.session:start_jax")
        report = make_paper(out, samples, seed, progress=sys.stderr.isatty(), aside=aside)
    if as_json:
        print_json(report)
        return 0
    for claim in report["claims"]:
        mark = "agrees" if claim["agrees"] else "DIFFERS"
        print(f"{mark:8} {claim['claim']}\n         computed: {claim['computed']}")
    print(f"Figures, samples and report are in {out}")
    return 0
