"""Matrix products in blocks, which start no further threads."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from beveloid_geom.support.products import product


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ((3, 4), (4, 5)),
        ((700_001, 3), (3, 5)),
        ((25, 3000, 17), (17, 41)),
        ((17, 13), (13, 30_001)),
        ((3, 24, 17), (3, 17, 20_000)),
        ((2, 3, 24, 17), (17, 9000)),
        ((2, 300, 300), (2, 300, 300)),
        ((0, 17), (17, 9)),
        ((17,), (17, 9)),
        ((200,), (200, 300)),
        ((400, 300), (300, 1)),
    ],
)
def test_blocks_give_the_product(left: tuple[int, ...], right: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    first, second = rng.normal(size=left), rng.normal(size=right)
    np.testing.assert_allclose(product(first, second), np.matmul(first, second), rtol=0.0, atol=1e-11)


THREADS = """
import time
import numpy as np
from beveloid_geom import Errors, builtin_design, contact_ratio, mesh_cycle, path_of_contact
from beveloid_geom.analysis.tolerance import USUAL, tolerance_study

table = builtin_design("ni-2017").with_parabola(0.001, -0.001)
offsets = np.linspace(-0.05, 0.05, 3000)
many = table.with_errors(Errors(offset=offsets))
works = {
    "path": lambda: path_of_contact(table, "right", 30_000),
    "given": lambda: path_of_contact(table, "right", l1=np.linspace(-5.0, 5.0, 30_000)),
    "pairs": lambda: path_of_contact(many, "right", 101),
    "ratios": lambda: contact_ratio(many),
    "study": lambda: tolerance_study(table, USUAL, "right", 2000),
    "cycle": lambda: mesh_cycle(table.with_errors(Errors(offset=offsets[:60]))),
}
for name, work in works.items():
    work()
    time.sleep(0.2)  # started threads wait actively for some time
    start = time.process_time(), time.thread_time()
    work()
    print(name, time.process_time() - start[0], time.thread_time() - start[1])
"""


def test_calculations_use_one_thread() -> None:
    """Calculations use a single thread with NumPy's default settings: the processor time of the process is
    that of the calling thread."""
    default = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    run = subprocess.run([sys.executable, "-c", THREADS], env=default, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    for name, process, thread in (line.split() for line in run.stdout.splitlines()):
        assert float(process) - float(thread) < 0.002 + 0.02 * float(thread), name
