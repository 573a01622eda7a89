"""The README and what is in it."""

import pathlib
import re

ROOT = pathlib.Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def block(name: str) -> str:
    """The code under a mark such as `<!-- python -->`."""
    return code_of(README, name)


def code_of(page: str, name: str) -> str:
    """The same of any page."""
    found = re.search(rf"<!-- {name} -->\n```\w+\n(.*?)```", page, re.DOTALL)
    assert found, name
    return found[1]


def printed_arrays(capsys) -> list[str]:
    """Printed arrays, each as one line."""
    return capsys.readouterr().out.replace("\n ", " ").splitlines()
