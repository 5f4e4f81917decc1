"""Options shared by all tests; property tests draw the same examples in every run."""

from __future__ import annotations

import os
import threading

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


SILENT = 15.0
"""s without output after which the running tests are named."""


class Heartbeat:
    """Names the tests that are running when none has ended for a while, in this process or in its workers."""

    def __init__(self) -> None:
        self.terminal = open(os.dup(1), "w")  # noqa: SIM115 - what a test writes to 1 is captured
        self.running: dict[str, None] = {}
        self.news, self.done = threading.Event(), False
        self.watcher = threading.Thread(target=self._watch, daemon=True)
        self.watcher.start()

    def _watch(self) -> None:
        while not self.done:
            self.news.clear()
            if not self.news.wait(SILENT) and self.running:
                names = (node.rsplit("/", 1)[-1] for node in tuple(self.running))
                print(f"[{', '.join(names)} goes on]", end="", file=self.terminal, flush=True)

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.running[nodeid] = None

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self.running.pop(nodeid, None)
        self.news.set()

    def pytest_sessionfinish(self) -> None:
        self.done = True
        self.news.set()
        self.watcher.join()
        self.terminal.close()


@pytest.fixture(params=["right", "left"])
def flank(request: pytest.FixtureRequest) -> str:
    """Both flanks, one after the other, of every test that asks for one and names none."""
    return str(request.param)


def pytest_configure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Heartbeat())


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--reset-snapshots",
        action="store_true",
        help="write the reference pictures anew; look at each before committing it",
    )
