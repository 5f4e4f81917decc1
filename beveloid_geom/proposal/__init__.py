"""Pairs with contact without backlash, or with a given backlash, for given requirements."""
