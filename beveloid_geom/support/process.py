"""How the process of a command starts, and ends before its time: signals, and output that fails.

Python's own answer to Ctrl-C is an exception in the middle of whatever runs: an import, a progress bar
that writes, the bindings of a library that swallow it or make something else of it. Here the handler
undoes what is unfinished, says so in a line and ends the process at once. It is in place before anything
large is imported. What is unfinished is the one thing that is known to all of the process.
"""

from __future__ import annotations

import io
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from types import FrameType
from typing import Any, NoReturn

SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
"""Exit status 128 and the number of the signal, as shells have it: 130 for Ctrl-C. Windows lacks the last."""
CANNOT_WRITE, FAULT, READER_LEFT = 2, 70, 141
"""Exit status where standard output cannot be written; of a fault of the program, since 1 says that there
is no contact; where a reader leaves early (`| head`), as programs that SIGPIPE ends."""

_unfinished: list[Callable[[], str]] = []


@contextmanager
def undoing(step: Callable[[], str]) -> Iterator[None]:
    """While this lasts the end of the process does `step` first, whose words, if any, are said."""
    _unfinished.append(step)
    try:
        yield
    finally:
        _unfinished.remove(step)


def leave(status: int, reason: str = "") -> NoReturn:
    """End the process with a line on standard error, past all that Python would still do."""
    words = [reason] * bool(reason)
    for step in reversed(_unfinished):
        with suppress(Exception):
            words += [said] if (said := step()) else []
    if words:
        with suppress(OSError):  # os.write, as a signal may come while sys.stderr is being written to
            line = f"Error: {': '.join(words)}\n".encode(errors="surrogateescape")
            os.write(2, b"\n" * _Stream.within_line + line)
    os._exit(status)


def run(module: str) -> None:
    """Run the command `main` of a module, with our answers to signals and to streams that fail."""
    _answer_signals()
    for number, name in ((1, "stdout"), (2, "stderr")):
        setattr(sys, name, _stream(number, getattr(sys, name)))
    try:
        import_module(module).main()
    except Exception:
        import traceback

        traceback.print_exc()
        leave(FAULT)


def _answer_signals() -> None:
    """Those that whoever started us lets be ignored stay ignored."""
    own = os.getpid()

    def answer(number: int, _: FrameType | None) -> None:
        """End the process on a signal, what is unfinished undone."""
        if os.getpid() != own:  # a copy of us, whose parent says and undoes it all
            os._exit(128 + number)
        signal.signal(number, signal.SIG_IGN)
        leave(128 + number, "interrupted")

    for name in SIGNALS:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, answer)


class _Stream(io.FileIO):
    """Standard output or error. What cannot be said on the latter is not said."""

    within_line = False
    """Whether standard error ends in the middle of a line, as that of a progress bar."""

    def write(self, data: Any, /) -> int:
        """Write; ends the process where standard output cannot be written to."""
        if self.fileno() == 2:
            _Stream.within_line = not data.tobytes().endswith(b"\n")
        try:
            return super().write(data)
        except OSError as error:
            if self.fileno() == 2:
                return len(data)
            if isinstance(error, BrokenPipeError):
                leave(READER_LEFT)
            leave(CANNOT_WRITE, f"cannot write to standard output: {error.strerror}")


def _stream(number: int, given: Any) -> Any:
    """Give the stream to be used in place of the one given, or None if that was closed (`2>&-`)."""
    if given is None:  # a file that is opened later must not take its place
        os.dup2(os.open(os.devnull, os.O_RDONLY if number == 1 else os.O_WRONLY), number)
    binary = getattr(given, "buffer", None)
    if given is not None and type(getattr(binary, "raw", binary)) is not io.FileIO:
        return given  # a console of Windows
    return io.TextIOWrapper(
        io.BufferedWriter(_Stream(number, "w", closefd=False)),
        encoding=getattr(given, "encoding", "utf-8"),
        errors=getattr(given, "errors", "backslashreplace"),
        line_buffering=number == 2 or os.isatty(number),
    )
