"""Drawings, measurement, assembly, files for other programs."""
