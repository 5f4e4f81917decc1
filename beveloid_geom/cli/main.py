"""The command `beveloid-geom`: commands on the shelves of the folder `commands`, found by module.

Exit status: 0 done (`check`: errors, warnings or not), 1 no contact on the flanks, none that could be
followed, or a pair that cannot be assembled, 2 bad input; `process` has those of a command that does
not come to its end.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

import click

from .commands import contact, errors, pair, workshop
from .options import version_option

SHELVES = (pair, contact, errors, workshop)
"""Folders of commands, in the order of the help."""


def _found(shelf: ModuleType) -> Iterator[click.Command]:
    """Give the command of each module of a folder, by name."""
    for module in iter_modules(shelf.__path__):
        values = vars(import_module(f"{shelf.__name__}.{module.name}")).values()
        yield next(value for value in values if isinstance(value, click.Command))


COMMANDS = {str(shelf.__doc__).rstrip("."): {str(c.name): c for c in _found(shelf)} for shelf in SHELVES}
"""Commands by name, by what their shelf's docstring says of it."""


class ShelvedGroup(click.Group):
    """A group whose help lists the commands by shelf."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write a section for each shelf, all in the same columns."""
        width = max(map(len, self.commands))
        for title, of_shelf in COMMANDS.items():
            rows = [(name.ljust(width), of_shelf[name].get_short_help_str()) for name in of_shelf]
            with formatter.section(title):
                formatter.write_dl(rows)


@click.group(
    cls=ShelvedGroup,
    commands={name: command for of_shelf in COMMANDS.values() for name, command in of_shelf.items()},
    context_settings={"help_option_names": ["-h", "--help"]},
)
@version_option("beveloid-geom")
def main() -> None:
    """Tooth contact analysis of beveloid gears with parabolic profile modification.

    A DESIGN is a TOML file or the name of a built-in design, ni-2017 if none is given: see design --list.
    """
