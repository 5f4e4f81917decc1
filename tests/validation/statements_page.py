"""The table of the paper's statements on the page of the package, computed from the built-in design.

`python -m tests.validation.statements_page` prints the table.
"""

from __future__ import annotations

from functools import lru_cache

from beveloid_geom import builtin_design
from beveloid_geom.validation.statement_verdicts import Statement, StatementVerdict
from beveloid_geom.validation.statements import paper_statements

FLANKS = ("right", "left")


@lru_cache(maxsize=1)
def statements_by_flank() -> dict[str, tuple[Statement, ...]]:
    """Return the statements of each flank, computed once."""
    return {flank: paper_statements(builtin_design(), flank) for flank in FLANKS}


def cell(one: Statement) -> str:
    """Return the verdict, the claims that do not hold in every measure, and the numbers."""
    open_claims = []
    for claim in one.claims:
        yes, known = claim.count
        if claim.verdict is StatementVerdict.DEPENDS:
            open_claims.append(f"{claim.text} by {yes} of {known} measures")
        elif claim.verdict is not StatementVerdict.HOLDS and len(one.claims) > 1:
            word = "not true" if claim.verdict is StatementVerdict.DOES_NOT_HOLD else "not known whether"
            open_claims.append(f"{word}: {claim.text}")
    numbers = one.detail.removeprefix("pinion in the side view: ")
    return "; ".join([f"**{one.verdict.value}**", *open_claims, numbers])


def markdown() -> str:
    """Return the statements with the results of both flanks as a table of Markdown."""
    head = ("", "the paper says", "right flanks", "left flanks, for comparison")
    rows = [
        (one.id, f"{one.source}: {one.statement.rstrip('.')}", cell(one), cell(left))
        for one, left in zip(*statements_by_flank().values(), strict=True)
    ]
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ("---",) * len(head), *rows))


if __name__ == "__main__":
    print(markdown())
