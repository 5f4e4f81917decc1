"""Files that appear whole or not at all."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .process import undoing


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a file beside `path` to write into; it takes the place of `path`, or of what that links to, when
    all went well and is removed when not. Raises OSError where `path` is neither a regular file nor
    free: a folder cannot be replaced, a device or pipe must not be, as that would take it from all."""
    given, path = path, Path(os.path.realpath(path))
    require_replaceable(path)
    name = str(path.parent / f".{path.name}.{secrets.token_hex(4)}.part")

    def give_up() -> str:
        """Remove the file beside, and say so if it was not in its place yet."""
        try:
            os.unlink(name)
        except FileNotFoundError:  # it is in its place
            return ""
        return f"{given} is not written"

    with undoing(give_up):  # before the file is there: a signal may come at any moment
        try:
            os.close(os.open(name, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))  # less the process's umask
            yield Path(name)
            os.replace(name, path)
        finally:
            give_up()


def require_replaceable(path: Path) -> None:
    """Raise OSError where something stands that is no regular file."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "Not a regular file", str(path))
