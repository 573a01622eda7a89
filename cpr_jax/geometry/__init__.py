"""Floor 1: everything that differs between the plane and space, and nothing else."""

from .abstract import AbstractGeometry as AbstractGeometry, Components as Components
from .plane import PLANE as PLANE, Plane as Plane
from .space import SPACE as SPACE, Space as Space
