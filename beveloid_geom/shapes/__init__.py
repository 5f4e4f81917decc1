"""Triangles and hexahedra of teeth and gears, and contact found by meshes."""

TOLERANCES_PER_MODULE = 600.0
"""The default tolerance of surfaces is the normal module divided by this number."""
