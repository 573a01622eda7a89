"""The public names, and what importing does not do."""

import ast
import pathlib
import subprocess
import sys

import cpr_jax

ROOT = pathlib.Path(cpr_jax.__file__).parent


def test_every_public_name_loads():
    tree = ast.parse((ROOT / "__init__.pyi").read_text())
    names = [alias.name for node in tree.body for alias in node.names]
    assert len(names) == len(set(names)) > 40
    for name in names:
        assert getattr(cpr_jax, name) is not None
    assert set(names) <= set(dir(cpr_jax))


def test_importing_changes_no_setting_and_loads_no_jax():
    code = (
        "import sys, cpr_jax, cpr_jax.cli, cpr_jax.robots.reading;"
        "assert 'jax' not in sys.modules and 'numpy' not in sys.modules;"
        "import jax; before = jax.config.values.copy(); cpr_jax.rfrfr;"
        "assert jax.config.values == before"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_floors_import_only_from_below():
    floors = ["geometry", "rods", "robots", "statics", "analysis", "studies", "plotting", "cli"]
    for floor, name in enumerate(floors):
        for path in (ROOT / name).glob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.ImportFrom) and node.level == 2 and node.module:
                    target = node.module.split(".")[0]
                    if target in floors:
                        assert floors.index(target) <= floor, f"{path} imports {node.module}"
