"""Contact of a pair with given errors."""

TITLE = "Contact of a pair with given errors"
"""Heading of these commands in the help; `python -OO` removes docstrings."""
