"""The command `beveloid-geom`: the commands of the folder `commands`, each found by its module.

Exit status: 0 done (`check`: errors, warnings or not), 1 no contact on the flanks, none that could be
followed, or a pair that cannot be assembled, 2 bad input; `process` has those of a command that does
not come to its end.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

import click

from . import commands
from .options import version_option


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@version_option("beveloid-geom")
def main() -> None:
    """Tooth contact analysis of beveloid gears with parabolic profile modification.

    A DESIGN is a TOML file or the name of a built-in design, ni-2017 if none is given: see design --list.
    """


for _found in iter_modules(commands.__path__):
    _values = vars(import_module(f"{commands.__name__}.{_found.name}")).values()
    main.add_command(next(value for value in _values if isinstance(value, click.Command)))
