"""The commands of `beveloid-geom`: each module holds the one of its name, and `main` finds it here."""
