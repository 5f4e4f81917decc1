"""Text files of users: limited in size, in the encodings that editors and shells write."""

from __future__ import annotations

import codecs
from os import PathLike


class TextFileError(ValueError):
    """File that is too long, or that is not text."""


def read_text(path: str | PathLike[str], max_bytes: int, fallback: str | None = None) -> str:
    """Return the text of a file in UTF-8 or UTF-16, without its byte order mark.

    Parameters
    ----------
    path : str or PathLike
        File to read. No more than `max_bytes` + 1 bytes of it are read, so that devices are safe.
    max_bytes : int
        Largest accepted size.
    fallback : str, optional
        Encoding of texts that are not UTF-8, in which bytes without a character become U+FFFD.

    Returns
    -------
    str

    Raises
    ------
    TextFileError
        If the file is longer, or not in one of these encodings.
    OSError, ValueError
        If the file cannot be read, or `path` is not a valid path.
    """
    with open(path, "rb") as file:
        data = file.read(max_bytes + 1)
    if len(data) > max_bytes:
        raise TextFileError(f"is longer than {max_bytes:,} bytes")
    # PowerShell's `>` and Excel's "Unicode text" write UTF-16, marked by the first two bytes.
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        if fallback and not wide:
            return data.decode(fallback, errors="replace")
        raise TextFileError(f"is not UTF-{16 if wide else 8} text (byte {error.start})") from None
