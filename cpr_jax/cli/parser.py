"""Arguments of the command line; no module of numbers is imported here."""

import argparse
import importlib.metadata

_EPILOG = """\
ROBOT is a name of the catalogue (see `cpr-jax robots`) or the path of a robot file (TOML, see
docs/robot-files.md). Numbers are in SI units; quantities such as 200mm or 45deg work too.
Exit codes: 0 done, 2 a mistake in the input, 3 a solve that has no solution.
"""


def build_parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    parser = argparse.ArgumentParser(
        prog="cpr-jax",
        description="Continuum parallel robots: statics, sensitivity, uncertainty ellipsoids.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    version = importlib.metadata.version("cpr_jax")
    parser.add_argument("--version", action="version", version=f"cpr-jax {version}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def add(name: str, text: str) -> argparse.ArgumentParser:
        return commands.add_parser(
            name,
            help=text,
            description=text[0].upper() + text[1:] + ".",
            epilog=_EPILOG,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )

    paper = add("paper", "make the paper's Figures 1 to 3, their samples, the map and a report")
    paper.add_argument("--out", default="paper", metavar="DIR", help="folder (default: paper)")
    paper.add_argument(
        "--samples", default="2000", metavar="N", help="samples a point (default: 2000)"
    )
    paper.add_argument("--seed", default="0", metavar="S", help="random seed (default: 0)")
    paper.add_argument("--json", action="store_true", help="print the report as JSON")

    _add_robot(add("solve", "solve the inverse (--point) or the forward (--motors) problem"))
    analysis = add("sensitivity", "sensitivity matrix and uncertainty ellipsoid at an equilibrium")
    _add_robot(analysis)
    _add_parameters(analysis)
    analysis.add_argument(
        "--hold",
        choices=("motors", "platform"),
        default="motors",
        help="what stays while the parameters vary (default: motors)",
    )
    sampling = add("monte-carlo", "random parameters: coverage of the uncertainty ellipsoid")
    _add_robot(sampling)
    _add_parameters(sampling)
    sampling.add_argument("--samples", default="2000", metavar="N", help="default: 2000")
    sampling.add_argument("--seed", default="0", metavar="S", help="default: 0")
    sampling.add_argument(
        "--distribution",
        choices=("gaussian", "ellipsoid", "box"),
        default="gaussian",
        help="Gaussian with σ = δ/3 (default), or uniform in the ellipsoid or the box",
    )
    sampling.add_argument(
        "--prediction",
        choices=("tangent", "second-order"),
        default="second-order",
        help="where the iteration starts (default: second-order)",
    )
    sampling.add_argument("--out", metavar="FILE.nc", help="write the samples as NetCDF")
    sampling.add_argument(
        "--keep",
        default="100000",
        metavar="N",
        help="samples that are written; all are counted (default: 100000)",
    )
    sampling.add_argument(
        "--resume", action="store_true", help="go on with an interrupted run to FILE.nc"
    )

    mapping = add("workspace", "map of a branch: sensitivity, singularities, stability")
    mapping.add_argument("robot", metavar="ROBOT", help="catalogue name or robot file")
    where = mapping.add_mutually_exclusive_group()
    where.add_argument(
        "--point", nargs="+", metavar="Q", help="start at these platform coordinates"
    )
    where.add_argument("--motors", nargs="+", metavar="Q", help="start at these motor positions")
    _add_imposed(mapping)
    _add_steps(mapping)
    _add_parameters(mapping)
    mapping.add_argument("--out", default="workspace", metavar="DIR", help="default: workspace")
    mapping.add_argument(
        "--axes",
        metavar="NAME,NAME",
        help="platform coordinates that vary, such as x,y or z,phi_P_x (default: y,z)",
    )
    mapping.add_argument(
        "--spacing",
        nargs="+",
        metavar="H",
        help="of the grid, along both axes or along each (default: a hundredth of the rods' "
        "length, or of a radian)",
    )
    mapping.add_argument(
        "--refine",
        default="0",
        metavar="N",
        help="halve the spacing N times where the sensitivity changes fast (default: 0)",
    )
    mapping.add_argument(
        "--box",
        nargs=4,
        metavar=("LOW", "LOW", "HIGH", "HIGH"),
        help="lower and upper corner (default: all within reach, half of it if symmetric; where a "
        "motor slides or feeds, a rod length around the beginning)",
    )
    _add_limits(mapping)
    mapping.add_argument(
        "--resume", action="store_true", help="go on with an interrupted run in DIR"
    )
    mapping.add_argument("--json", action="store_true", help="print one JSON object")

    path = add("trajectory", "a path: motors, torques, sensitivity, stability, where it ends")
    path.add_argument("robot", metavar="ROBOT", help="catalogue name or robot file")
    through = path.add_mutually_exclusive_group(required=True)
    through.add_argument(
        "--via",
        action="append",
        nargs="+",
        metavar="Q",
        help="a waypoint: platform coordinates, or those of --imposed; at least twice",
    )
    through.add_argument("--file", metavar="FILE", help="waypoints, one a line (CSV)")
    path.add_argument(
        "--plan",
        metavar="DIR",
        help="plan the way between waypoints on the map that `cpr-jax workspace` has written: "
        "least exposed to uncertainty, stable, within its limits (default: straight lines)",
    )
    _add_imposed(path)
    _add_steps(path)
    _add_parameters(path)
    path.add_argument("--out", default="trajectory", metavar="DIR", help="default: trajectory")
    path.add_argument(
        "--spacing",
        metavar="H",
        help="largest distance of two stops (default: a hundredth of the rods' length, or of a "
        "radian)",
    )
    _add_limits(path)
    path.add_argument("--json", action="store_true", help="print one JSON object")

    check = add("validate", "check robot files")
    what = check.add_mutually_exclusive_group(required=True)
    what.add_argument("files", nargs="*", default=[], metavar="FILE", help="robot files")
    what.add_argument("--schema", action="store_true", help="print the JSON Schema of robot files")
    check.add_argument("--json", action="store_true", help="print a list of JSON objects")

    robots = add("robots", "list the catalogue, or draw it")
    robots.add_argument(
        "--figure", metavar="FILE", help="draw every robot at its home: FILE.png or FILE.pdf"
    )
    robots.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def _add_robot(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="catalogue name or robot file")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument(
        "--point",
        nargs="+",
        metavar="Q",
        help="platform coordinates: position, then the rotation vector of a body; or those of "
        "--imposed",
    )
    where.add_argument("--motors", nargs="+", metavar="Q", help="motor positions")
    _add_imposed(parser)
    _add_steps(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _add_imposed(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--imposed",
        metavar="NAME,...",
        help="coordinates that the motors impose, as many as motors, such as x,y,z or y,phi_P_x,q3 "
        "(default: those of the platform)",
    )


def _add_steps(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--steps",
        metavar="N",
        help="integration steps along each rod or segment (default: as many as a solve needs, 10 "
        "in maps and on paths)",
    )


def _add_limits(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--max-torque", metavar="T", help="mark where a motor needs more (N m or N)"
    )
    parser.add_argument("--max-moment", metavar="M", help="mark where a rod carries more (N m)")


def _add_parameters(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--parameters",
        nargs="+",
        metavar="LABEL",
        help="uncertain parameters, such as k_b1 r_c1 l1 (default: those of the robot)",
    )
    parser.add_argument(
        "--delta",
        nargs="+",
        metavar="LABEL=VALUE",
        help="half ranges, such as l1=2mm, where they differ from those of the robot",
    )
