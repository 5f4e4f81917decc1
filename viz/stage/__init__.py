"""Off-screen pictures and pages, without a word of gears."""
