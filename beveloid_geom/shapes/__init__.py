"""Triangles and hexahedra of teeth and gears, and contact found by meshes."""

SURFACE_STEPS = 600.0
"""Normal module over the default tolerance of surfaces."""
