"""For this session only: the module has moved to `beveloid_geom.reference.pitch_region`."""

from beveloid_geom.reference.pitch_region import *  # noqa: F403
