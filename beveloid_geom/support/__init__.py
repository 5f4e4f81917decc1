"""Numerical and file utilities that do not depend on gears."""
