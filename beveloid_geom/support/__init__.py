"""Tools without a word of gears."""
