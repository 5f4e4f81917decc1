"""Processes that work for a command, and end with it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from .process import undoing

if TYPE_CHECKING:
    from concurrent.futures import Executor


@contextmanager
def workers(number: int) -> Iterator[Executor]:
    """Start fresh processes, as on all systems. Signals are the parent's business from their first moment."""
    import multiprocessing
    import signal
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import resource_tracker, util

    untyped: Any = util

    def ended() -> str:
        """Kill the processes, without a word."""
        for child in multiprocessing.active_children():
            child.kill()
        untyped._run_finalizers(0)  # or the tracker of resources complains of semaphores that are left
        return ""

    context, unheard = multiprocessing.get_context("spawn"), (signal.SIGINT, signal.SIG_IGN)
    with undoing(ended), ProcessPoolExecutor(number, context, signal.signal, unheard) as pool:
        if hasattr(signal, "pthread_sigmask"):  # what is blocked here stays so in the processes started
            resource_tracker.ensure_running()  # it would end the blocking
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        for _ in range(number):  # each starts a process, as none is idle so soon
            pool.submit(int)
        if hasattr(signal, "pthread_sigmask"):
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        yield pool
