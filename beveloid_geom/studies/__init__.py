"""Claims, measured: the paper's statements, one method against another."""
