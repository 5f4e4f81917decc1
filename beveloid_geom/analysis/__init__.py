"""What follows from contact: sliding, sensitivity, tolerances, maps, an optimum."""
