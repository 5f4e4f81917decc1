"""Results derived from the contact: sliding, pressure, sensitivity, tolerances, maps, optimisation."""
