"""Good robot files, from which mistakes are made."""

import copy
import tomllib
from typing import Any

DOCUMENTS = {
    "point": """
        format = 1
        geometry = "plane"
        [platform]
        kind = "point"
        [home]
        motors = [2.7, 0.44]
        position = [0, 0.2]
        [[legs]]
        base = [-0.1, 0]
        rod = { length = "250 mm", bending_stiffness = "1.83e-2 N*m^2" }
        [[legs]]
        base = [0.1, 0]
        rod = { length = "250 mm", bending_stiffness = "1.83e-2 N*m^2" }
        [uncertainty]
        k_b1 = "4.73e-3 N*m^2"
        """,
    "body": """
        format = 1
        name = "body"
        geometry = "plane"
        [platform]
        kind = "body"
        force = ["0 N", "1 N"]
        moment = "0 N*m"
        [home]
        motors = ["154 deg", "20 mm"]
        position = ["0 mm", "200 mm"]
        rotation = "0 deg"
        [environment]
        gravity = ["0 m/s^2", "-9.81 m/s^2"]
        [defaults.leg]
        a = "45 mm"
        [defaults.leg.rod]
        length = "250 mm"
        section = { kind = "rectangle", width = "2 mm", height = "10 mm" }
        material = { E = "2.7 GPa", nu = 0.35, density = "1200 kg/m^3" }
        [[legs]]
        base = ["-100 mm", "0 mm"]
        attachment = ["-1 mm", "0 mm"]
        [[legs]]
        base = ["100 mm", "0 mm"]
        base_rotation = "10 deg"
        motor = { kind = "prismatic", axis = [0, 1] }
        joint = { free = [0, 1, 0] }
        attachment_rotation = "10 deg"
        [legs.rod]
        precurvature_radius = "-1 m"
        force = ["0 N/m", "-0.1 N/m"]
        moment = "0 N"
        """,
    "space": """
        format = 1
        geometry = "space"
        [platform]
        kind = "body"
        moment = ["0 N*m", "0 N*m", "0 N*m"]
        [[legs]]
        base = [0, 0, 0]
        base_rotation = ["0 deg", "0 deg", "90 deg"]
        motor = { kind = "revolute", axis = [0, 0, 1] }
        joint = "spherical"
        [legs.rod]
        length = 0.5
        bending_stiffness = [1, 2, 2]
        strain_compliance = [1e-5, 0, 0]
        precurvature = [0, 0, "1/m"]
        """,
    "motors": """
        format = 1
        geometry = "space"
        motors = [[1, 2], [3, 5]]
        [platform]
        kind = "body"
        mass = "100 g"
        center_of_mass = ["0 mm", "0 mm", "10 mm"]
        [[platform.loads]]
        position = ["10 mm", "0 mm", "0 mm"]
        force = ["0 N", "0 N", "-1 N"]
        [environment]
        gravity = ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"]
        [home]
        motors = ["10 deg", "20 mm"]
        position = ["0 mm", "0 mm", "200 mm"]
        rotation = { axis = [0, 0, 1], angle = "30 deg" }
        [defaults.leg]
        joint = "spherical"
        [defaults.leg.rod]
        length = "250 mm"
        section = { kind = "circle", radius = "1 mm", shear_factor = 1 }
        material = { E = "200 GPa", density = "7850 kg/m^3" }
        [[legs]]
        base = ["100 mm", "0 mm", "0 mm"]
        base_rotation = { tangent = [0, 0, 1], third = [1, 0, 0] }
        motor = { kind = "revolute", ratio = -0.5 }
        [legs.base_joint]
        joint = "universal"
        position = ["50 mm", "0 mm", "0 mm"]
        rotation = { tangent = [0, 1, 0] }
        [[legs]]
        base = ["0 mm", "100 mm", "0 mm"]
        base_joint = { free = [0, 0, 0, 0, 1, 1] }
        [[legs]]
        base = ["0 mm", "0 mm", "0 mm"]
        motor = "feed"
        joint = "swivel"
        attachment_rotation = { tangent = [0, 0, 1] }
        [[legs]]
        base = ["-100 mm", "0 mm", "0 mm"]
        motor = "none"
        joint = "universal"
        base_joint = "slider"
        [[legs]]
        base = ["0 mm", "-100 mm", "0 mm"]
        motor = { kind = "telescopic", ratio = 2 }
        """,
    "segments": """
        format = 1
        geometry = "plane"
        [platform]
        kind = "point"
        [environment]
        gravity = [0, -9.81]
        [defaults.leg.rod]
        length = "250 mm"
        section = { kind = "rectangle", width = "2 mm", height = "10 mm" }
        material = { E = "2.7 GPa", nu = 0.35, density = "1200 kg/m^3" }
        [[legs]]
        base = [-0.1, 0]
        rod.precurvature = 1
        [[legs.rod.segments]]
        length = "100 mm"
        [[legs.rod.segments]]
        length = "150 mm"
        section = { kind = "rectangle", width = "1 mm", height = "10 mm" }
        precurvature_radius = "-0.5 m"
        force = [0.1, 0]
        [[legs]]
        base = [0.1, 0]
        [uncertainty]
        l1_2 = "1 mm"
        k_b2 = 1e-3
        """,
}

MISSING = object()
"""Put in the place of a value to take it out."""


def edited(document: str, path: str, value: Any) -> dict[str, Any]:
    """A document with one value put in, or taken out where the value is `MISSING`."""
    root = tomllib.loads(DOCUMENTS[document])
    *parents, last = [int(key) if key.isdigit() else key for key in path.split(".")]
    place: Any = root
    for key in parents:
        place = place[key]
    if value is MISSING:
        del place[last]
    else:
        place[last] = copy.deepcopy(value)
    return root
