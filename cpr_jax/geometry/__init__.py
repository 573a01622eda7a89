"""Floor 1: everything that differs between the plane and space, and nothing else."""

from .abstract import AbstractGeometry as AbstractGeometry
from .abstract import Components as Components
from .abstract import Numbers as Numbers
from .abstract import as_array as as_array
from .abstract import floats as floats
from .abstract import namespace as namespace
from .abstract import unchanged as unchanged
from .plane import PLANE as PLANE
from .plane import Plane as Plane
from .space import SPACE as SPACE
from .space import Space as Space
