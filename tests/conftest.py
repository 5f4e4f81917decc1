"""Options shared by all tests."""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--reset-snapshots",
        action="store_true",
        help="write the reference pictures anew; look at each before committing it",
    )
