"""The command `beveloid-geom`: the commands of the packages in `commands`, one module for each.

Exit status: 0 success, with or without warnings; 1 no contact on the flanks, a pair that cannot be assembled,
axial positions out of reach of `shim`, no result of `gear-data`, or errors found by `check`; 2 bad input, or
no solution of `propose`, `optimise` or `modify`; 4 a failed calculation, or no axial positions found by
`shim`. `support.process` has the statuses of interrupted commands.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

import click

from .commands import contact, errors, pair, workshop
from .options import OneLineCommand, version_option


def _commands_of(package: ModuleType) -> Iterator[click.Command]:
    """Yield the command of each module of a package, sorted by name."""
    for module in iter_modules(package.__path__):
        values = vars(import_module(f"{package.__name__}.{module.name}")).values()
        yield next(value for value in values if isinstance(value, click.Command))


COMMANDS = {
    title: {str(command.name): command for command in _commands_of(package)}
    for title, package in {
        "Design files, proposals, checks": pair,
        "Contact of a pair with given errors": contact,
        "Influence of errors and design parameters on the contact": errors,
        "Drawings, measurement, assembly, files for other programs": workshop,
    }.items()
}
"""Commands by the title of their section in the help and by name, in the order of the help."""


class SectionedGroup(OneLineCommand, click.Group):
    """Group whose help lists the commands by section."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the sections with aligned columns."""
        width = max(map(len, self.commands))
        for title, by_name in COMMANDS.items():
            rows = [(name.ljust(width), by_name[name].get_short_help_str()) for name in by_name]
            with formatter.section(title):
                formatter.write_dl(rows)


@click.group(
    cls=SectionedGroup,
    commands={name: command for by_name in COMMANDS.values() for name, command in by_name.items()},
    context_settings={"help_option_names": ["-h", "--help"]},
)
@version_option("beveloid-geom")
def main() -> None:
    """Tooth contact analysis of beveloid gears with generated, modified or measured flanks.

    DESIGN is a design file (TOML) or the name of a built-in design; `design --list` shows the names. The
    default is ni-2017.
    """
