"""Tables of modifications in design files: amounts, lengths, and files of measured points."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple, TypeAlias

from ..support.text_file import read_text
from .deviations import FlankDeviations, mean_deviations
from .field_limits import Fault, FieldLimit, number_fault
from .keys import checked_table
from .limits import outside
from .member import MODIFICATIONS, Member
from .modification import AMOUNT, PITCH, Modification, limits_of, missing_amounts, missing_lengths
from .written_numbers import refused

MODIFICATION_KEYS = limits_of(Modification)
"""Limits of the keys of [pinion.modification] and [gear.modification]."""
_DEVIATIONS = "deviations"
"""Key of these tables that names a file of measured points."""
FILE_KEYS = (_DEVIATIONS, PITCH)
"""Keys of these tables that only a design file may have."""


class DeviationFile(NamedTuple):
    """File of measured points, with the grid of the points: numbers of rows and columns, and border."""

    file: str
    rows: int = 5
    columns: int = 9
    border: str = "10%"


ReadDeviations: TypeAlias = Callable[[Member, DeviationFile], FlankDeviations]
"""`workshop.design_file.read_flank_deviations`, which needs the flanks of the member. It raises ValueError,
with a message that begins with a verb, and OSError."""


def modification_tables_of(table: str, given: object, faults: list[Fault]) -> dict[str, tuple[str, object]]:
    """Return the name and the content of the table that applies to each flank of a member."""
    both, flanks = given, {}
    if isinstance(given, dict):
        flanks = {name: value for name, value in given.items() if name in MODIFICATIONS}
        known_tables = (*flanks, _DEVIATIONS)
        unknown = [
            name for name, value in given.items() if isinstance(value, dict) and name not in known_tables
        ]
        known = " and ".join(MODIFICATIONS)
        faults += (Fault(table, name, f"is unknown: tables for one flank are {known}") for name in unknown)
        both = {name: value for name, value in given.items() if name not in (*flanks, *unknown)}
    if len(flanks) == len(MODIFICATIONS):  # replaced, but its faults are reported
        read_modification(table, both, faults)
    # A table for one flank replaces the table for both.
    return {
        flank: (f"{table}.{flank}", flanks[flank]) if flank in flanks else (table, both)
        for flank in MODIFICATIONS
    }


def read_modifications(
    tables: Mapping[str, tuple[str, object]], faults: list[Fault], others: tuple[str, ...] = FILE_KEYS
) -> dict[str, Modification | None]:
    """Read the tables of `modification_tables_of`, without measured deviations, by field of `Member`.

    `others` are the keys that are suggested for an unknown key in addition to amounts and lengths."""
    return {
        MODIFICATIONS[flank]: read_modification(table, values, faults, others)
        for flank, (table, values) in tables.items()
    }


def file_key_faults(tables: Mapping[str, tuple[str, object]]) -> Iterator[Fault]:
    """Yield the faults of keys that only a design file may have."""
    for table, values in tables.values():
        for key in FILE_KEYS:
            if isinstance(values, dict) and key in values:
                yield Fault(table, key, f"can only be given in a design file: write it in [{table}]")


def read_modification(
    table: str, given: object, faults: list[Fault], others: tuple[str, ...] = FILE_KEYS
) -> Modification | None:
    """Read one table of amounts and lengths, without measured deviations; None for an empty one."""
    if not isinstance(given, dict):
        faults.append(outside(table, "", "be a table", given, f"write the line [{table}] above its keys"))
        return None
    if _DEVIATIONS in given:
        _deviation_files(table, given[_DEVIATIONS], faults)
    given = {key: value for key, value in given.items() if key not in FILE_KEYS}
    values = checked_table(MODIFICATION_KEYS, table, given, faults, others=others)
    incomplete = [*missing_lengths(Modification, given), *missing_amounts(Modification, given)]
    faults += (fault._replace(table=table) for fault in incomplete)
    return Modification(**values) if values and not incomplete else None


def _deviation_files(table: str, given: object, faults: list[Fault]) -> list[DeviationFile]:
    """Read the value of the key `deviations`: a file or a list of those of single teeth, or a table with
    their grid."""
    keys = given if isinstance(given, dict) else {"file": given}
    new = [
        Fault(table, f"{_DEVIATIONS}.{key}", f"is unknown: known are {', '.join(DeviationFile._fields)}")
        for key in keys
        if key not in DeviationFile._fields
    ]
    grid_size = FieldLimit(2, 999, "", "give the number in the measuring grid", integer=True)
    for key, value in keys.items():
        if key in ("rows", "columns") and (text := number_fault(value, grid_size)):
            new.append(Fault(table, f"{_DEVIATIONS}.{key}", text))
    files = keys.get("file")
    files = files if isinstance(files, list) else [files]
    if not files or not all(isinstance(file, str) and file for file in files):
        cure = 'write "points.csv" or {file = "points.csv", rows = 5, columns = 9, border = "10%"}'
        new.append(outside(table, _DEVIATIONS, "name a file of measured points", given, cure))
    elif not isinstance(keys.get("border", ""), str):
        cure = 'write a percentage such as "10%" or a length such as "2mm"'
        new.append(outside(table, f"{_DEVIATIONS}.border", "be a text", keys["border"], cure))
    faults += new
    return [] if new else [DeviationFile(**{**keys, "file": file}) for file in files]


def _pitch_deviations(member: Member, folder: str, given: object) -> tuple[float, ...]:
    """Read the value of the key of pitch deviations: a list, or a file with one number in each line.

    Raises ValueError, with a message for values that are not one finite number for each tooth, and OSError.
    """
    # Largest size of a file of pitch deviations.
    max_pitch_file_bytes = 100_000
    values: object = given
    if isinstance(given, str):
        text = read_text(os.path.join(folder, given), max_pitch_file_bytes, fallback="cp1252")
        rows = [row.partition("#")[0].strip() for row in text.splitlines()]
        numbers: list[float] = []
        values = numbers
        for number, row in enumerate(rows, 1):
            if not row:
                continue
            try:
                numbers.append(float(row))
            except ValueError:
                cure = "write one number in um in each line, tooth 0 first"
                raise ValueError(f"line {number} is not a number: {cure}") from None
    if not isinstance(values, list):
        cure = "write [2.1, -0.4, ...] or the name of a file with one number in each line"
        raise ValueError(refused("be a list of numbers in um", given, cure))
    for number, value in enumerate(values):
        if reason := number_fault(value, AMOUNT):
            raise ValueError(f"{reason}, for tooth {number}")
    if fault := member.pitch_fault(values):
        raise ValueError(fault)
    return tuple(map(float, values))


def measured_member(
    member: Member,
    tables: Mapping[str, tuple[str, object]],
    faults: list[Fault],
    folder: str,
    read_deviations: ReadDeviations | None,
) -> Member:
    """Return a member with the measured deviations of its flanks from the flanks of the given member, and
    with pitch deviations. Files are in the folder of the design file."""
    result = member
    for flank, (table, values) in tables.items():
        if not isinstance(values, dict):
            continue
        measured: dict[str, Any] = {}
        if _DEVIATIONS in values and (sources := _deviation_files(table, values[_DEVIATIONS], [])):
            if read_deviations is None:
                raise TypeError("parse_design needs read_deviations for files of measured points")
            measured[_DEVIATIONS] = _measured(table, member, sources, faults, folder, read_deviations)
        if PITCH in values:
            read = partial(_pitch_deviations, member, folder, values[PITCH])
            file = repr(values[PITCH]) if isinstance(values[PITCH], str) else ""
            measured[PITCH] = _read(table, PITCH, read, faults, file)
        if measured:
            given = getattr(member, MODIFICATIONS[flank]) or Modification()
            result = result.modified(replace(given, **measured), flank)
    return result


def _measured(
    table: str,
    member: Member,
    sources: list[DeviationFile],
    faults: list[Fault],
    folder: str,
    read_deviations: ReadDeviations,
) -> FlankDeviations | None:
    """Return the deviations in a file, or the mean of those of single teeth; None after adding faults."""
    if len(sources) > member.teeth:
        text = f"must name at most {member.teeth} files, one for each tooth, got {len(sources)}"
        faults.append(Fault(table, _DEVIATIONS, f"{text}: remove the others"))
        return None
    placed = [source._replace(file=os.path.join(folder, source.file)) for source in sources]
    deviations = [
        _read(table, _DEVIATIONS, partial(read_deviations, member, place), faults, repr(source.file))
        for place, source in zip(placed, sources, strict=True)
    ]
    if None in deviations:
        return None
    one: FlankDeviations = deviations[0]
    return one if len(deviations) == 1 else mean_deviations(deviations)


def _read(table: str, key: str, read: Callable[[], Any], faults: list[Fault], file: str = "") -> Any:
    """Return the result of `read`, or None after adding its error to `faults`."""
    try:
        return read()
    except OSError as error:
        reason = f"names {file}, which cannot be read ({error.strerror or error})"
        faults.append(Fault(table, key, f"{reason}: paths are relative to the design file"))
    except ValueError as error:
        faults.append(Fault(table, key, f"{file} {error}".strip()))
    return None
