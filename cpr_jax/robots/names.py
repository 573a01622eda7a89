"""The catalogue's table of contents, readable without JAX."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class CatalogueEntry:
    """One robot of the catalogue.

    **Attributes:**

    - `name`: for the command line; `function` is its name in `robots.catalogue`.
    - `title`, `source`: what it is and where it comes from.
    - `platform`: `"point"` or `"body"`; `motors`: how many, all of them turning.
    """

    name: str
    function: str
    title: str
    source: str
    platform: str
    motors: int


CATALOGUE = {
    entry.name: entry
    for entry in (
        CatalogueEntry(
            "rfrfr",
            "rfrfr",
            "planar RFRFR with precurved rods and rigid segments",
            "Sensitivity Analysis of a RFRFR Continuum Parallel Robot, Table 1",
            "point",
            2,
        ),
        CatalogueEntry(
            "rfrfr-straight",
            "rfrfr_straight",
            "planar RFRFR with straight rods of 1 m",
            "Zaccaria, A Gazebo Simulator for Continuum Parallel Robots",
            "point",
            2,
        ),
        CatalogueEntry(
            "three-rfr",
            "three_rfr",
            "planar 3-RFR with a triangular platform that has an orientation",
            "cpr_jax",
            "body",
            3,
        ),
    )
}
