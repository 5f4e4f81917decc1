"""The tables of README's section on the paper's statements, made from the built-in design.

`python -m tests.validation.statements_page` prints them.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from beveloid_geom import builtin_design
from beveloid_geom.studies.claims import SMALL
from beveloid_geom.studies.statement_readings import statements_by_reading
from beveloid_geom.studies.statement_verdicts import Statement, Verdict

FLANKS = ("right", "left")
AS_GIVEN = "as given"
SHARES = (0.25, 0.5, 1.0)
"""Of the greatest coefficient of R1 and R2, where their ratios are shown."""
Found = dict[str, dict[str, dict[str, Statement]]]


@lru_cache(maxsize=1)
def found() -> Found:
    """Statements by flank, reading and id; once."""
    return {flank: statements_by_reading(builtin_design(), flank) for flank in FLANKS}


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table of Markdown."""
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ("---",) * len(head), *rows))


def cell(one: Statement) -> str:
    """Verdict, the claims that do not simply hold, and the numbers."""
    open_ = []
    for claim in one.claims:
        yes, known = claim.count
        if claim.verdict is Verdict.DEPENDS:
            open_.append(f"{claim.text} by {yes} of {known} measures")
        elif claim.verdict is not Verdict.HOLDS and len(one.claims) > 1:
            word = "not" if claim.verdict is Verdict.DOES_NOT_HOLD else "not known whether"
            open_.append(f"{word}: {claim.text}")
    numbers = one.detail.removeprefix("pinion in the side view: ")
    return "; ".join([f"**{one.verdict.value}**", *open_, numbers])


def verdicts() -> str:
    """The statements, and what becomes of each on both flanks."""
    both = [found()[flank][AS_GIVEN] for flank in FLANKS]
    rows = [
        (id_, f"{one.source}: {one.statement.rstrip('.')}", *(cell(side[id_]) for side in both))
        for id_, one in both[0].items()
    ]
    return table(("", "the paper says", "right flanks", "left flanks"), rows)


def changes(flank: str, reading: str) -> str:
    """What a reading makes of the verdicts it changes."""
    before, after = found()[flank][AS_GIVEN], found()[flank][reading]
    words = []
    for verdict in Verdict:
        ids = [
            id_ for id_, one in after.items() if one.verdict is verdict and before[id_].verdict is not verdict
        ]
        words += [f"{', '.join(ids)}: {verdict.value}"] if ids else []
    return "; ".join(words) or "nothing"


def readings() -> str:
    """What each reading changes."""
    rows = [
        (name, *(changes(flank, name) for flank in FLANKS)) for name in found()["right"] if name != AS_GIVEN
    ]
    return table(("reading", "right flanks", "left flanks"), rows)


def ratios() -> str:
    """Contact ratios of the right flanks under equal coefficients of both members, by reading."""
    head = [*(f"-{share * SMALL:.5f}" for share in reversed(SHARES)), "0"]
    head += [f"{share * SMALL:.5f}" for share in SHARES]
    rows = []
    for name, by_id in found()["right"].items():
        negative, positive = (by_id[id_].claims[0].numbers["Eq. 16"] for id_ in ("R2", "R1"))
        at = [round(share * (positive.size - 1)) for share in SHARES]
        values = [*negative[at[::-1]], positive[0], *positive[at]]
        rows.append((name, *("none" if np.isnan(value) else f"{value:.3f}" for value in values)))
    return table(("reading", *(text.rstrip("0") if text != "0" else text for text in head)), rows)


def markdown() -> str:
    """All tables, as they stand in the README."""
    return "\n\n".join((verdicts(), readings(), ratios()))


if __name__ == "__main__":
    print(markdown())
