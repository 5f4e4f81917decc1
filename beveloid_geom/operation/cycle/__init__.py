"""Segments of a mesh cycle, their fit, and contacts between the sampled rolls."""
