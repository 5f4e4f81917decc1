"""Triangles and hexahedra of teeth and gears, and contact found by meshes."""

MODULE_PER_TOLERANCE = 600.0
"""Normal module divided by the default tolerance of surfaces."""
