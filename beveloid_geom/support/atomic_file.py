"""Files that are written completely or not at all."""

from __future__ import annotations

import errno
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .process import undoing


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path in the folder of `path`; the file written to it replaces `path` at the end.

    A symbolic link is followed. After an exception or a signal, the temporary file is removed. A file that
    is replaced keeps its mode; a new one has the mode that the umask allows.

    Parameters
    ----------
    path : Path
        The file to write.

    Yields
    ------
    Path
        The temporary file.

    Raises
    ------
    OSError
        If `path` is write-protected, a folder, or a device or pipe, whose replacement would affect other
        users.
    """
    target = Path(os.path.realpath(path))
    mode = replaceable_mode(target)
    if not target.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "No such folder", str(path.parent))
    part = target.parent / f".{target.name}.{secrets.token_hex(4)}.part"

    def remove() -> str:
        """Remove the temporary file; return a note if it was still there."""
        try:
            os.unlink(part)
        except FileNotFoundError:  # it has replaced the target
            return ""
        return f"{path} is not written"

    with undoing(remove):  # registered before the file exists, as a signal may come at any time
        try:
            os.close(os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            yield part
            if mode is not None:
                os.chmod(part, mode)
            os.replace(part, target)
        finally:
            remove()


def replaceable_mode(path: Path) -> int | None:
    """Return the mode of a file that may be replaced, None without a file. Raises as `atomic_file`."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "Not a regular file", str(path))
    if not (status.st_mode & 0o222 and os.access(path, os.W_OK)):  # root may write to any file
        raise PermissionError(errno.EACCES, "Write-protected", str(path))
    return stat.S_IMODE(status.st_mode)
