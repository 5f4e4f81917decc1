"""For this session only: the module has moved to `beveloid_geom.reference.five_equations_mp`."""

from beveloid_geom.reference.five_equations_mp import *  # noqa: F403
