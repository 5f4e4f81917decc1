"""Calculations of one window: off the event loop, newest values first.

Each window has one worker thread and its own values, so that windows do not influence each other. Values that
come while a calculation runs replace each other; only the newest are computed. Path and motion are always
finished. Pattern and remarks of outdated values are skipped, but not for longer than `PATIENCE_S`, so that
the pattern moves during a long drag.
"""

from __future__ import annotations

import json
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from typing import Any

from beveloid_geom.design.field_limits import DesignError
from beveloid_geom.design.text import design_text

from .calculation import Calculation
from .values import Start

PATIENCE_S = 0.35
"""Largest time between two complete pictures while values keep coming."""
QUEUED = ("values", "start")
"""Kinds of messages that need a calculation: values of the controls come before those of the start, which the
page compares with them."""
Send = Callable[[str], None]


class Session:
    """One window: receives messages of the page and sends results until it is closed."""

    def __init__(self, start: Start, send: Send) -> None:
        """Start the worker thread.

        Parameters
        ----------
        start : Start
            Start of the exploration, shared by all windows and never changed.
        send : callable
            Called from the worker thread with each answer as JSON.
        """
        self._start, self._send = start, send
        self._changed = threading.Condition()
        self._waiting: dict[str, Mapping[str, Any]] = {}  # the newest message by kind
        self._closed = False
        self._complete_at = 0.0
        self._worker = threading.Thread(target=self._work, daemon=True, name="explore-pair")
        self._worker.start()

    def receive(self, text: str) -> str | None:
        """Take a message of the page, JSON with `kind`; return an answer that needs no calculation.

        Values are queued. Requests for a design file, a command line or errors at the other place are
        answered at once.
        """
        try:
            message = json.loads(text)
            kind, values = str(message["kind"]), dict(message["values"])
            number = int(message.get("id", 0))  # ValueError and OverflowError for NaN and infinity
        except (ValueError, ArithmeticError, LookupError, TypeError, RecursionError):
            reason = "the message of the page cannot be read: reload the page"
            return json.dumps({"kind": "failed", "reason": reason})
        if kind in QUEUED:
            with self._changed:
                self._waiting[kind] = {"kind": kind, "id": number, "values": values}
                self._changed.notify()
            return None
        try:
            return json.dumps({"kind": kind, **self._answer(kind, values)}, allow_nan=False)
        except (ValueError, ArithmeticError) as error:  # DesignError is a ValueError
            return json.dumps({"kind": "failed", "reason": _lines(error)})

    def close(self) -> None:
        """End the worker thread after its present stage."""
        with self._changed:
            self._closed = True
            self._changed.notify()

    def _answer(self, kind: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the answer to a request. Raises ValueError."""
        if kind == "save":
            remark = f"Saved by explore-pair; start: {self._start.name}."
            return {"text": design_text(self._start.read(values)[0], remark)}
        if kind == "command":
            line, reason = self._start.command(values)
            return {"line": line, "reason": reason}
        if kind in ("perpendicular", "mesh"):
            return {"values": self._start.at(values, "mesh" if kind == "mesh" else "perpendicular")}
        raise ValueError("the request of the page is unknown: reload the page")

    def _work(self) -> None:
        """Compute the newest values until the window is closed."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or self._waiting)
                if self._closed:
                    return
                kind = next(each for each in QUEUED if each in self._waiting)
                message = self._waiting.pop(kind)
            try:
                self._compute(message)
            except Exception as error:  # the application goes on with the next values
                traceback.print_exc(file=sys.stderr)
                reason = f"the calculation failed ({type(error).__name__}): {error}"
                self._tell(message, "motion", {"status": "not computed", "reason": reason}, 0.0, True)

    def _compute(self, message: Mapping[str, Any]) -> None:
        """Compute the stages of one message and send each."""
        begin = time.perf_counter()
        try:
            design, settings = self._start.read(message["values"])
        except DesignError as error:
            faults = [{"name": fault.key, "text": fault.text} for fault in error.parts]
            refused = {"status": "refused", "reason": _lines(error), "faults": faults}
            self._tell(message, "motion", refused, 0.0, True)
            return
        calculation = Calculation(design, settings)
        for name, stage in (
            ("motion", calculation.motion),
            ("pattern", calculation.pattern),
            ("remarks", calculation.remarks),
        ):
            if name != "motion" and self._outdated(message):
                return
            result = stage()
            last = name == "remarks" or result.get("status", "solved") != "solved"
            self._tell(message, name, result, time.perf_counter() - begin, last)
            if last:
                break
        self._complete_at = time.perf_counter()

    def _outdated(self, message: Mapping[str, Any]) -> bool:
        """Return whether newer values wait, and the last complete picture is recent. The start is computed
        again later."""
        if "values" not in self._waiting:
            return self._closed
        if message["kind"] == "start":
            with self._changed:
                self._waiting.setdefault("start", message)
            return True
        return self._closed or time.perf_counter() - self._complete_at < PATIENCE_S

    def _tell(
        self, message: Mapping[str, Any], stage: str, result: Mapping[str, Any], seconds: float, last: bool
    ) -> None:
        """Send a result with the number of its message; `seconds`: time of the calculation so far."""
        kind = "start" if message["kind"] == "start" else "result"
        head = {"kind": kind, "id": message["id"], "stage": stage, "seconds": seconds, "last": last}
        if not self._closed:
            self._send(json.dumps({**head, **result}, allow_nan=False))


def _lines(error: Exception) -> str:
    """Return the message of an error in one line."""
    faults = error.faults if isinstance(error, DesignError) else (str(error),)
    return "; ".join(faults)
