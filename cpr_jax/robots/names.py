"""The catalogue's table of contents, readable without JAX."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class CatalogueEntry:
    """One robot of the catalogue; each of its legs has a motor of its own.

    **Attributes:**

    - `name`: for the command line.
    - `module`, `function`: where `robots` has the function that makes it.
    - `title`, `source`: what it is and where it comes from.
    - `geometry`: `"plane"` or `"space"`.
    - `platform`: `"point"` or `"body"`.
    - `motors`: the kind of each, as in robot files: `"revolute"`, whose position is an angle;
        `"prismatic"` or `"feed"`, whose position is a length.
    """

    name: str
    module: str
    function: str
    title: str
    source: str
    geometry: str
    platform: str
    motors: tuple[str, ...]

    @property
    def turning(self) -> tuple[bool, ...]:
        """Whether each motor turns what it moves; its `q` is then an angle."""
        return tuple(kind == "revolute" for kind in self.motors)


CATALOGUE = {
    entry.name: entry
    for entry in (
        CatalogueEntry(
            "rfrfr",
            "catalogue",
            "rfrfr",
            "RFRFR with precurved rods and rigid segments",
            "Sensitivity Analysis of a RFRFR Continuum Parallel Robot, Table 1",
            "plane",
            "point",
            ("revolute",) * 2,
        ),
        CatalogueEntry(
            "rfrfr-straight",
            "catalogue",
            "rfrfr_straight",
            "RFRFR with straight rods of 1 m",
            "Zaccaria, A Gazebo Simulator for Continuum Parallel Robots",
            "plane",
            "point",
            ("revolute",) * 2,
        ),
        CatalogueEntry(
            "three-rfr",
            "catalogue",
            "three_rfr",
            "3-RFR: three motors turn precurved rods of a triangular platform",
            "cpr_jax",
            "plane",
            "body",
            ("revolute",) * 3,
        ),
        CatalogueEntry(
            "three-pfr",
            "catalogue",
            "three_pfr",
            "3-PFR: three sliders push precurved rods of a triangular platform",
            "cpr_jax",
            "plane",
            "body",
            ("prismatic",) * 3,
        ),
        CatalogueEntry(
            "stewart-gough",
            "catalogue_space",
            "stewart_gough",
            "continuum Stewart–Gough: six rods of fed length, clamped but for a free twist",
            "Till, ContinuumRobotExamples, 02_CSG_Inverse_Kinematics",
            "space",
            "body",
            ("feed",) * 6,
        ),
        CatalogueEntry(
            "stewart-gough-clamped",
            "catalogue_space",
            "stewart_gough_clamped",
            "Stewart–Gough of six fed rods that spin in their base, clamped to the platform",
            "Kuntz Lab, bendier, parallel robot scripts",
            "space",
            "body",
            ("feed",) * 6,
        ),
        CatalogueEntry(
            "stewart-gough-sliding",
            "catalogue_space",
            "stewart_gough_sliding",
            "6-PFS: six upright sliders push rods to spherical joints",
            "cpr_jax",
            "space",
            "body",
            ("prismatic",) * 6,
        ),
        CatalogueEntry(
            "six-rus",
            "catalogue_space",
            "six_rus",
            "6-RUS: six cranks move precurved rods between universal and spherical joints",
            "cpr_jax",
            "space",
            "body",
            ("revolute",) * 6,
        ),
        CatalogueEntry(
            "three-rfs",
            "catalogue_space",
            "three_rfs",
            "3-RFS: three motors bend rods that carry a platform with six freedoms",
            "cpr_jax",
            "space",
            "body",
            ("revolute",) * 3,
        ),
    )
}
