"""Triangles and hexahedra of teeth and gears, and contact found by meshes."""
