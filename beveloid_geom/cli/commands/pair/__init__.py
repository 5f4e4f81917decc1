"""Design files, proposals, checks."""

TITLE = "Design files, proposals, checks"
"""Heading of these commands in the help; `python -OO` removes docstrings."""
