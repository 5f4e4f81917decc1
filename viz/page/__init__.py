"""One self-contained page on a design: tables, charts, and the pair in mesh as a view in 3D."""
