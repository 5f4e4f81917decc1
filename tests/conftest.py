"""Options shared by all tests; property tests draw the same examples in every run."""

from __future__ import annotations

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--reset-snapshots",
        action="store_true",
        help="write the reference pictures anew; look at each before committing it",
    )
