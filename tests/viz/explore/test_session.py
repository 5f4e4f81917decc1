"""One window: newest values, stages, refusals, independent windows. No web server is needed."""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Design, builtin_design
from beveloid_viz.explore.session import Session
from beveloid_viz.explore.values import Start

STATM = Path("/proc/self/statm")


class Window:
    """Page of a session: sends messages and collects the answers."""

    def __init__(self, start: Start) -> None:
        self.answers: list[dict[str, Any]] = []
        self._arrived = threading.Condition()
        self.session = Session(start, self._take)

    def _take(self, text: str) -> None:
        with self._arrived:
            self.answers.append(json.loads(text))
            self._arrived.notify()

    def send(self, number: int, **values: Any) -> None:
        assert self.session.receive(json.dumps({"kind": "values", "id": number, "values": values})) is None

    def ask(self, kind: str, **values: Any) -> Any:
        answer = self.session.receive(json.dumps({"kind": kind, "values": values}))
        assert answer is not None
        return json.loads(answer)

    def wait(self, number: int) -> list[dict[str, Any]]:
        """Return all answers to a message, after the last of them has arrived."""

        def ended() -> bool:
            return any(answer["id"] == number and answer["last"] for answer in self.answers)

        with self._arrived:
            assert self._arrived.wait_for(ended, timeout=20.0)
        return [answer for answer in self.answers if answer["id"] == number]


@pytest.fixture
def opened() -> Iterator[Callable[[Design], Window]]:
    windows: list[Window] = []

    def open_window(design: Design) -> Window:
        windows.append(Window(Start(design)))
        return windows[-1]

    yield open_window
    for window in windows:
        window.session.close()
        window.session._worker.join(20.0)


class Held:
    """The first stage of the calculation, held until `go` is set; `offsets` are those computed."""

    def __init__(self, status: str) -> None:
        self.entered, self.go = threading.Event(), threading.Event()
        self.status, self.offsets = status, list[float]()

    def motion(self, calculation: Any) -> dict[str, Any]:
        self.offsets.append(calculation.design.errors.offset)
        self.entered.set()
        assert self.go.wait(20.0)
        return {"status": self.status, "reason": "of the test"}


MOTION = "beveloid_viz.explore.calculation.Calculation.motion"


def test_stages_come_in_order_and_refusals_do_not_end_the_window(
    opened: Callable[[Design], Window], modified: Design
) -> None:
    window = opened(modified)
    window.send(1, offset_error=1e5)
    (refusal,) = window.wait(1)
    assert (refusal["status"], refusal["faults"][0]["name"]) == ("refused", "offset_error")
    window.send(2, offset_error=0.01)
    assert [answer["stage"] for answer in window.wait(2)] == ["motion", "pattern", "remarks"]


@pytest.mark.parametrize(
    "text",
    [
        *("", "[]", "{}", '{"kind": "values"}', '{"kind": "x", "values": {}}', "[" * 9999),
        *(f'{{"kind": "values", "id": {one}, "values": {{}}}}' for one in ("NaN", "1e999", "null", "[]")),
    ],
)
def test_unreadable_messages_are_answered(opened: Callable[[Design], Window], text: str) -> None:
    """Unreadable messages get an answer and do not end the window."""
    window = opened(builtin_design())
    answer = window.session.receive(text)
    assert answer is not None
    assert json.loads(answer)["kind"] == "failed"
    window.send(1, offset_error=1e5)
    assert window.wait(1)[-1]["status"] == "refused"


def test_an_error_of_the_calculation_is_shown_and_the_next_values_are_computed(
    opened: Callable[[Design], Window],
    modified: Design,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    window = opened(modified)
    with monkeypatch.context() as broken:
        broken.setattr(MOTION, lambda _: 1 / 0)
        window.send(1)
        (answer,) = window.wait(1)
    assert (answer["status"], "ZeroDivisionError" in answer["reason"]) == ("not computed", True)
    assert "ZeroDivisionError" in capsys.readouterr().err
    window.send(2, film=0.0)
    assert window.wait(2)[-1]["status"] == "solved"


def test_only_the_newest_values_are_computed(
    opened: Callable[[Design], Window], modified: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    held, window = Held("no contact"), opened(modified)
    monkeypatch.setattr(MOTION, lambda own: held.motion(own))
    window.send(1, offset_error=0.001)
    assert held.entered.wait(20.0)
    for number in range(2, 50):
        window.send(number, offset_error=0.001 * number)
    held.go.set()
    window.wait(49)
    assert held.offsets == [0.001, 0.049]


def test_pattern_and_remarks_of_outdated_values_are_skipped(
    opened: Callable[[Design], Window], modified: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("beveloid_viz.explore.session.PATIENCE_S", 1e6)
    window = opened(modified)
    window.send(1, film=0.0)
    window.wait(1)
    held = Held("solved")
    monkeypatch.setattr(MOTION, lambda own: held.motion(own))
    window.send(2, film=0.0)
    assert held.entered.wait(20.0)
    window.send(3, film=0.0)
    held.go.set()
    assert len(window.wait(3)) == 3
    assert [answer["stage"] for answer in window.answers if answer["id"] == 2] == ["motion"]


def test_windows_do_not_influence_each_other(opened: Callable[[Design], Window], modified: Design) -> None:
    one, other = opened(modified), opened(modified)
    one.send(1, offset_error=0.05, film=0.0)
    other.send(1, film=0.0)
    first, second = one.wait(1), other.wait(1)
    assert first[0]["figures"] != second[0]["figures"]
    assert one.ask("save", offset_error=0.05)["text"] != other.ask("save")["text"]
    assert "offset = 0.05" in one.ask("save", offset_error=0.05)["text"]


def test_the_start_waits_for_the_values(opened: Callable[[Design], Window], modified: Design) -> None:
    window = opened(modified)
    window.session.receive(json.dumps({"kind": "start", "id": 0, "values": {"film": 0.0}}))
    assert [answer["kind"] for answer in window.wait(0)] == ["start"] * 3


def test_values_that_are_no_numbers_are_not_saved(opened: Callable[[Design], Window]) -> None:
    answer = opened(builtin_design()).ask("save", offset_error="x")
    assert answer["kind"] == "failed"
    assert "offset_error must be a finite number" in answer["reason"]


@pytest.mark.slow
@pytest.mark.skipif(not STATM.exists(), reason="needs the memory statistics of Linux")
def test_a_thousand_random_values_leave_the_memory_constant(
    opened: Callable[[Design], Window], modified: Design
) -> None:
    window, random, sizes = opened(modified), np.random.default_rng(0), []
    names = "offset_error", "shaft_angle_error_deg", "pinion_axial_error", "gear_axial_error"
    for number in range(1, 1_401):
        errors = dict(zip(names, random.uniform(-0.03, 0.03, 4).tolist(), strict=True))
        window.send(number, **Start(modified).values | errors)
        time.sleep(0.01)
        if number in (400, 1_400):  # the first values fill the caches
            window.wait(number)
            sizes.append(int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE"))
            window.answers.clear()
    assert sizes[1] - sizes[0] < 20e6
