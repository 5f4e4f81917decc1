"""The positions of the built-in design at which methods are compared, at 60 digits.

`python -m tests.studies.kept_positions > beveloid_geom/studies/positions_of_table1.json` makes them anew.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from beveloid_geom import builtin_design, path_of_contact
from beveloid_geom.studies.comparison_methods import COUNT, solved_positions


def cases() -> list[dict[str, Any]]:
    """What is kept: pinion and gear roll (rad), l1 and the point in S_f (mm) of each position."""
    found = []
    for parabola in ((0.0, 0.0), (0.001, -0.001)):
        for flank in ("right", "left"):
            design = builtin_design().with_parabola(*parabola)
            path = path_of_contact(design, flank, 2 * COUNT + 1)
            columns = (path.l1, path.u1, path.l2, path.u2, path.pinion_roll, path.gear_roll)
            numbers = solved_positions(design, flank, np.stack(columns, axis=-1)[1::2])
            found.append({"flank": flank, "parabola": parabola, "positions": numbers.tolist()})
    return found


if __name__ == "__main__":
    print("[" + ",\n".join(json.dumps(case) for case in cases()) + "]")
