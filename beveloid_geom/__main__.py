"""The command `beveloid-geom`, which is `python -m beveloid_geom` too."""

from .process import run


def main() -> None:
    """Run it."""
    run("beveloid_geom.cli")


if __name__ == "__main__":
    main()
