"""Figs. 1 to 15 of Ni et al. 2017."""
