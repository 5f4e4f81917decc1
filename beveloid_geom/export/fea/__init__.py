"""Hexahedra as files for finite elements: teeth under a load, the pair in contact."""
