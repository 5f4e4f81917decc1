"""The command `beveloid-geom`, which is `python -m beveloid_geom` too."""

from .support.process import run


def main() -> None:
    """Run it."""
    run("beveloid_geom.cli.main")


if __name__ == "__main__":
    main()
