"""Influence of errors and design parameters on the contact."""

TITLE = "Influence of errors and design parameters on the contact"
"""Heading of these commands in the help; `python -OO` removes docstrings."""
