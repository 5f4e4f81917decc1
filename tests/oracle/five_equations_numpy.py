"""For this session only: the module has moved to `beveloid_geom.reference.five_equations_numpy`."""

from beveloid_geom.reference.five_equations_numpy import *  # noqa: F403
