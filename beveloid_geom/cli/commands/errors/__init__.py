"""Influence of errors and design parameters on the contact."""
