"""Measurements in a process of their own: its cores, its devices, its memory.

`python -m benchmarks.child MODULE FUNCTION ARGUMENTS` is how `measured_apart` starts one.
"""

import importlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from typing import Any

import jax

_ROOT = pathlib.Path(__file__).parents[1]


def measured_apart(
    module: str, function: str, arguments: dict[str, Any], *, cores: int, devices: int = 1
) -> Any:
    """What a function of a module of this package returns when it is called in a new process.

    **Arguments:**

    - `arguments`: of the function, as JSON knows them, as is what it returns.
    - `cores`: how many of the machine's cores it may use, by `os.sched_setaffinity`.
    - `devices`: of JAX.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.json"
        request = {"arguments": arguments, "cores": cores, "devices": devices, "out": str(out)}
        command = [sys.executable, "-m", "benchmarks.child", module, function, json.dumps(request)]
        path = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        subprocess.run(command, check=True, env={**os.environ, "PYTHONPATH": path})
        return json.loads(out.read_text())


def available_cores() -> list[int]:
    """Numbers of the cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def _main() -> None:
    module, function, request = sys.argv[1], sys.argv[2], json.loads(sys.argv[3])
    # The last ones: the first core is where the rest of a machine tends to be.
    cores = available_cores()[-request["cores"] :]
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, cores)
    jax.config.update("jax_enable_x64", True)
    jax.config.update("jax_num_cpu_devices", request["devices"])
    called = getattr(importlib.import_module(f"benchmarks.{module}"), function)
    pathlib.Path(request["out"]).write_text(json.dumps(called(**request["arguments"])))


if __name__ == "__main__":
    _main()
