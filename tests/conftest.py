"""Options shared by all tests; property tests draw the same examples in every run."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


SILENT = 15.0
"""s after which a test that is still running is named."""


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    done = threading.Event()
    reporter: Any = item.config.pluginmanager.get_plugin("terminalreporter")

    def watch() -> None:
        while not done.wait(SILENT):
            reporter.write(f"[{item.name} goes on]", flush=True)

    watcher = threading.Thread(target=watch, daemon=True)
    if reporter is not None:
        watcher.start()
    try:
        return (yield)
    finally:
        done.set()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--reset-snapshots",
        action="store_true",
        help="write the reference pictures anew; look at each before committing it",
    )
