"""Amounts of modification for given properties of the contact."""
