"""Where the commands of the pictures start."""

from beveloid_geom.support.process import run


def figures() -> None:
    """Run `render-figures`."""
    run("viz.cli")


def animation() -> None:
    """Run `render-animation`."""
    run("viz.film.cli")


def report() -> None:
    """Run `render-report`."""
    run("viz.report.cli")
