"""Exit statuses, signals, standard streams and worker processes of the commands.

Python answers Ctrl-C by an exception in whatever code runs: an import, a progress bar, or the bindings of a
library that ignore it. Here, a signal handler removes unfinished files, reports them in one line, and ends
the process at once. It is installed before anything large is imported."""

from __future__ import annotations

import io
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from importlib import import_module
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from concurrent.futures import Executor

NO_CONTACT, NOT_COMPUTED = 1, 4
"""Exit statuses: no contact, or a pair that cannot be assembled; a failed calculation."""
CANNOT_WRITE = 2
"""Exit status if standard output cannot be written; bad input has the same status. Status 3 means that OpenGL
is missing, and 70 an error of the program. A signal gives 128 plus its number: 130 for Ctrl-C."""

_unfinished: list[Callable[[], str]] = []


@contextmanager
def undoing(step: Callable[[], str]) -> Iterator[None]:
    """Call `step` if the process ends within the context. Its text, if any, is part of the message."""
    _unfinished.append(step)
    try:
        yield
    finally:
        _unfinished.remove(step)


def leave(status: int, reason: str = "") -> NoReturn:
    """Undo the registered steps, write one line on standard error, and end the process at once."""
    undone = []
    for step in reversed(_unfinished):
        with suppress(Exception):
            undone.append(step())
    undone = [text for text in undone if text]
    if len(undone) > 2:  # many files that are written together
        undone = [f"{undone[-1]}, nor are {len(undone) - 1} others"]
    if words := [*filter(None, [reason]), *undone]:
        # os.write, because a signal may come while sys.stderr is being written. A line break ends the line of
        # a progress bar.
        line = f"{chr(10) * _Stream.within_line}Error: {': '.join(words)}\n"
        with suppress(OSError):
            os.write(2, line.encode(errors="surrogateescape"))
    os._exit(status)


def run(module: str) -> None:
    """Run the function `main` of a module as a command."""
    _handle_signals()
    for number, name in ((1, "stdout"), (2, "stderr")):
        setattr(sys, name, _stream(number, getattr(sys, name)))
    try:
        source_date()  # checked first, because libraries that write files read the variable, too
    except ValueError as error:
        leave(2, str(error))
    try:
        import_module(module).main()
    except Exception:
        import traceback

        traceback.print_exc()
        leave(70)


def source_date() -> datetime | None:
    """Return the time in SOURCE_DATE_EPOCH, which files have in place of the present time, or None.

    Raises ValueError with the name of the variable if its value is not a time."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if not epoch:
        return None
    try:
        return datetime.fromtimestamp(int(epoch), UTC)
    except (ValueError, OverflowError, OSError):
        cure = "correct it or unset it"
        raise ValueError(
            f"SOURCE_DATE_EPOCH must be whole seconds since 1970, got {epoch!r}: {cure}"
        ) from None


@contextmanager
def workers(number: int) -> Iterator[Executor]:
    """Yield an executor with a number of new processes, which end with this one and ignore Ctrl-C."""
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import util

    untyped: Any = util

    def kill() -> str:
        """End the processes without a message."""
        for child in multiprocessing.active_children():
            child.kill()
        untyped._run_finalizers(0)  # otherwise the resource tracker reports leaked semaphores
        return ""

    context, ignore = multiprocessing.get_context("spawn"), (signal.SIGINT, signal.SIG_IGN)
    with undoing(kill), ProcessPoolExecutor(number, context, signal.signal, ignore) as pool:
        with _postponed(signal.SIGINT):
            for _ in range(number):  # each call starts a process, because none is idle yet
                pool.submit(int)
        yield pool


@contextmanager
def _postponed(number: int) -> Iterator[None]:
    """Handle a signal that comes within the context at its end, and not at all in processes started there.

    The initializer of a worker is too late for a Ctrl-C during its start; blocked signals are inherited."""
    if sys.platform == "win32":  # no signals can be blocked there
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # its start would end the blocking
    signal.pthread_sigmask(signal.SIG_BLOCK, [number])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [number])


def _handle_signals() -> None:
    """Install the handler, except for signals that the parent process has set to be ignored."""
    parent = os.getpid()

    def end(number: int, _: FrameType | None) -> None:
        """End the process."""
        if os.getpid() != parent:  # a forked copy, whose parent reports and removes unfinished files
            os._exit(128 + number)
        signal.signal(number, signal.SIG_IGN)
        leave(128 + number, "interrupted")

    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, end)


class _Stream(io.FileIO):
    """Standard output or standard error; write errors on the latter are ignored."""

    within_line = False
    """Whether the last text on standard error has no line break at its end, as that of a progress bar."""

    def write(self, data: Any, /) -> int:
        """Write data; end the process if standard output cannot be written."""
        if self.fileno() == 2:
            _Stream.within_line = not data.tobytes().endswith(b"\n")
        try:
            return super().write(data)
        except OSError as error:
            if self.fileno() == 2:
                return len(data)
            if isinstance(error, BrokenPipeError):
                leave(141)  # as for programs that SIGPIPE ends: the reader has stopped (`| head`)
            leave(CANNOT_WRITE, f"cannot write to standard output: {error.strerror}")


def _stream(number: int, given: Any) -> Any:
    """Return the stream that replaces a standard stream, which is None if it was closed (`2>&-`)."""
    if given is None:  # otherwise a file that is opened later would get its number
        os.dup2(os.open(os.devnull, os.O_RDONLY if number == 1 else os.O_WRONLY), number)
    binary = getattr(given, "buffer", None)
    if given is not None and type(getattr(binary, "raw", binary)) is not io.FileIO:
        return given  # a console of Windows, or a stream of a test
    errors = getattr(given, "errors", "strict")
    return io.TextIOWrapper(
        io.BufferedWriter(_Stream(number, "w", closefd=False)),
        encoding=getattr(given, "encoding", "utf-8"),
        # Names of files may have characters that the encoding of a console or pipe does not have.
        errors="backslashreplace" if errors in ("strict", "surrogateescape") else errors,
        line_buffering=number == 2 or os.isatty(number),
    )
