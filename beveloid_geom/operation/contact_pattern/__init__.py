"""Contact pattern: region in which flanks come closer than the thickness of marking compound."""
