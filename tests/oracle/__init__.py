"""Independent oracles of the contact solve: the paper's five equations, three times over."""
