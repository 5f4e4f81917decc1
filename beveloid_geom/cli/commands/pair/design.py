"""The command `beveloid-geom design`."""

from __future__ import annotations

import click
from click.core import ParameterSource

from ...options import BUILTIN_DESIGN, Refusal, write_out


@click.command(short_help="Print a design file to start from.")
@click.argument("name", default=BUILTIN_DESIGN)
@click.option("--list", "listed", is_flag=True, help="List the built-in designs instead.")
def design(name: str, listed: bool) -> None:
    """Print a design file to start from.

    The default NAME is ni-2017, the pair of Table 1 of the paper.
    """
    from ....design.file import BUILTINS, DesignError, builtin_text

    if listed:
        if click.get_current_context().get_parameter_source("name") is ParameterSource.COMMANDLINE:
            raise Refusal([f"--list is for all designs and has no NAME, got {name!r}: omit one of them"])
        width = max(map(len, BUILTINS))
        write_out("".join(f"{key:{width}}  {description}\n" for key, description in BUILTINS.items()))
        return
    try:
        write_out(builtin_text(name))
    except DesignError as error:
        raise Refusal(error.faults) from None
