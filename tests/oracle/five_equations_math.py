"""For this session only: the module has moved to `beveloid_geom.reference.five_equations_math`."""

from beveloid_geom.reference.five_equations_math import *  # noqa: F403
