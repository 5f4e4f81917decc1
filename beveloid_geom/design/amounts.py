"""Modification of a member in one line of text, as in the options of the commands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .modification import PITCH, limits_of


def read_amounts(text: str) -> dict[str, Any]:
    """Return the table of a design file for a line such as "helix_crowning=10".

    Names with `right.` or `left.` in front are those of a table for one flank. Values that are not numbers
    are kept, so that they are reported with their key.

    Parameters
    ----------
    text : str
        Amounts in um and lengths in mm, separated by commas.

    Returns
    -------
    dict
        Values by key of a design file.

    Raises
    ------
    ValueError
        For another form of the text, and for a name that is given twice.
    """
    names = (*limits_of(), PITCH)  # the latter has a message that it needs a design file
    keys = {key.removesuffix(unit): key for key in names for unit in ("_um", "_mm")}
    table: dict[str, Any] = {}
    # Amounts in um and lengths in mm; their names may end in the unit, as in a design file.
    example = "helix_crowning=10, tip_relief=15, tip_relief_length=2.5"
    if ";" in text:
        raise ValueError(f'must have commas between the amounts, not ";": write them such as "{example}"')
    for entry in [] if text.strip().lower() == "none" else text.split(","):
        words, _, amount = (part.strip() for part in entry.partition("="))
        flank, dot, name = words.rpartition(".")
        if not name or not amount:
            cure = f'write amounts such as "{example}", with decimal points, or none'
            raise ValueError(f"cannot be read at {entry.strip()!r}: {cure}")
        # Lead is another word for helix.
        key = keys.get(name.replace("lead_", "helix_"), name)
        values = table.setdefault(flank, {}) if dot else table
        if key in values:
            raise ValueError(f"has {words} twice: remove one of them")
        try:
            values[key] = float(amount)
        except ValueError:
            values[key] = amount
    return table


def amounts_text(table: Mapping[str, Any]) -> str:
    """Return the line that `read_amounts` reads as this table."""
    entries = []
    for name, value in table.items():
        within = value if isinstance(value, Mapping) else {name: value}
        flank = f"{name}." if within is value else ""
        entries += [
            f"{flank}{key.removesuffix('_um').removesuffix('_mm')}={amount}" for key, amount in within.items()
        ]
    return ", ".join(entries) or "none"
