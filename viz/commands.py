"""Where the commands of the pictures start."""

from beveloid_geom.support.process import run


def figures() -> None:
    """Run `render-figures`."""
    run("beveloid_viz.cli")


def animation() -> None:
    """Run `render-animation`."""
    run("beveloid_viz.film.cli")


def report() -> None:
    """Run `render-report`."""
    run("beveloid_viz.report.cli")
