"""Origin of the numbers of a page."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from beveloid_geom.cli.options import option_name
from beveloid_geom.cli.tolerance_options import TOLERANCES, tolerance_names


@dataclass(frozen=True)
class Origin:
    """Origin of the numbers of a page.

    Attributes
    ----------
    name : str
        Name of the design as given.
    written : datetime or None
        Time of the design file; None for a built-in design.
    made : datetime
        Time of the page.
    changes : list of str
        Options that change the design, as on a command line.
    tolerances : str
        Options of the tolerance study.
    """

    name: str
    written: datetime | None
    made: datetime
    changes: list[str]
    tolerances: str

    @property
    def argument(self) -> str:
        """Name of the design as an argument of a command line."""
        return shlex.quote(self.name)

    @property
    def tooth_changes(self) -> list[str]:
        """Those of `changes` that are no errors, for commands that have their own errors."""
        return [change for change in self.changes if "-error" not in change.split()[0]]


def design_options(values: Mapping[str, Any]) -> list[str]:
    """Return options that change a design, with their values (None if not given), as on a command line."""
    from beveloid_geom.design.amounts import amounts_text  # imports NumPy, which --help does not need

    texts = {
        name: shlex.quote(amounts_text(value)) if isinstance(value, dict) else repr(value)
        for name, value in values.items()
        if value is not None
    }
    return [f"{option_name(name)} {text}" for name, text in texts.items()]


def tolerances_of(sizes: Mapping[str, float], cases: int, seed: int) -> str:
    """Return the options of a tolerance study as on a command line, with sizes by argument."""
    given = [f"{option} {sizes[name]!r}" for name, option, *_ in TOLERANCES if sizes.get(name)]
    return " ".join([*given, f"--cases {cases}", f"--seed {seed}"])


def with_options(text: str) -> str:
    """Return a message on a tolerance with the name of its option."""
    for argument, name in tolerance_names("tolerance of").items():
        text = text.replace(f"{argument} ", f"{name} ")
    return text
