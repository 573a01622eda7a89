"""The JSON Schema of robot files, with which editors complete and check them."""

import importlib.resources

FILE = "robot-file.schema.json"
"""Its name, beside this module."""


def schema_text() -> str:
    """The schema, JSON Schema draft 2020-12.

    It knows keys, words and how many numbers there are; units and what depends on several places
    of a file are left to `read_specification`.
    """
    return importlib.resources.files(__package__).joinpath(FILE).read_text(encoding="utf-8")
