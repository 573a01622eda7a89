"""Workspace maps: time, cost per cell and memory over the number of cells.

python -m benchmarks.maps [--cells 1000 10000 100000]
"""

import argparse
import json
import os
import resource
import time

import jax
import numpy as np


def main() -> None:
    """Maps half the workspace of the paper's robot at several resolutions."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--cells", nargs="+", type=float, default=[1e3, 1e4, 1e5])
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    import cpr_jax as cpr

    print(f"Load average {os.getloadavg()[0]:.2f}; {len(os.sched_getaffinity(0))} cores.")
    robot = cpr.rfrfr()
    begin = time.perf_counter()
    cpr.workspace_map(robot, spacing=0.02)
    print(f"First map, everything compiled on the way: {time.perf_counter() - begin:.1f} s")
    print(f"{'cells':>9} {'solved':>9} {'time':>9} {'per cell':>10} {'peak memory':>12}")
    rows = []
    # Half of the workspace is about 0.108 m² within reach.
    for wanted in sorted(arguments.cells):
        spacing = float(np.sqrt(0.108 / wanted))
        begin = time.perf_counter()
        dataset = cpr.workspace_map(robot, spacing=spacing)
        seconds = time.perf_counter() - begin
        cells = int(np.sum(dataset["status"].values != cpr.Status.OUT_OF_REACH))
        solved = int(np.sum(dataset["index"].values >= 0))
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
        rows.append({"cells": cells, "solved": solved, "seconds": seconds, "peak_MB": peak})
        print(
            f"{cells:9} {solved:9} {seconds:7.2f} s {1e6 * seconds / cells:7.1f} µs {peak:9.0f} MB"
        )
    if arguments.json:
        with open(arguments.json, "w") as file:
            json.dump(rows, file, indent=2)


if __name__ == "__main__":
    main()
