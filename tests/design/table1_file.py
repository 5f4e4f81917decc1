"""Design files of Table 1 with changes, and their faults."""

import tomllib

import pytest

from beveloid_geom.design.file import DesignError, builtin_text, parse_design
from tests.oracle.table1 import table1

DESIGN_1 = table1()
TABLE_1: dict[str, dict[str, object]] = tomllib.loads(builtin_text())
NUMBER = "write it without quotes, such as 1.5"


def toml(changes: dict[str, object]) -> str:
    """Return the file of Table 1 with changes: TOML values by 'table.key', None to omit the key."""
    tables: dict[str, dict[str, object]] = {name: dict(keys) for name, keys in TABLE_1.items()}
    for path, value in changes.items():
        table, _, key = path.partition(".")
        if value is None and not key:
            del tables[table]
        elif value is None:
            del tables[table][key]
        else:
            tables.setdefault(table, {})[key] = value
    return "\n".join(
        f"[{table}]\n" + "\n".join(f"{key} = {value}" for key, value in keys.items())
        for table, keys in tables.items()
    )


def faults_of(changes: dict[str, object]) -> tuple[str, ...]:
    """Return the messages for Table 1 with changes."""
    return faults_in(toml(changes))


def faults_in(text: str) -> tuple[str, ...]:
    """Return the messages for the text of a design file."""
    with pytest.raises(DesignError) as caught:
        parse_design(text)
    return caught.value.faults
