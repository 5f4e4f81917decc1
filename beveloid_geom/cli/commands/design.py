"""The command `beveloid-geom design`."""

from __future__ import annotations

import click

from ..options import write_out


@click.command(short_help="Print the built-in design file, as a start for one's own.")
def design() -> None:
    """Print the built-in design file, as a start for one's own."""
    from ...design.file import builtin_text

    write_out(builtin_text())
