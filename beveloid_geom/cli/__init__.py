"""The command `beveloid-geom`."""
