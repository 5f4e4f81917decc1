"""Drawings, measurement, assembly, files for other programs."""

TITLE = "Drawings, measurement, assembly, files for other programs"
"""Heading of these commands in the help; `python -OO` removes docstrings."""
