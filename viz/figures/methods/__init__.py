"""Figures that compare the methods."""
