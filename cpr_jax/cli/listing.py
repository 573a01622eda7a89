"""`cpr-jax robots`."""

import dataclasses
import json

from ..robots.names import CATALOGUE


def robots(as_json: bool) -> int:
    """Prints the catalogue."""
    if as_json:
        print(json.dumps({name: dataclasses.asdict(entry) for name, entry in CATALOGUE.items()}))
        return 0
    width = max(map(len, CATALOGUE))
    for entry in CATALOGUE.values():
        print(f"{entry.name:{width}}  {entry.title}")
        print(f"{'':{width}}  {entry.motors} motors, {entry.platform} platform; {entry.source}")
    return 0
