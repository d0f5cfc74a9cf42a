"""Result files, from the server to the disk."""
from __future__ import annotations

import hashlib
import os
import pathlib
from collections.abc import Callable
from typing import Any

from dccast import errors
from dccast.transport import Transport


def download(transport: Transport, open_stream: Callable[[int, str], Any],
             path: str | os.PathLike[str], name: str, overwrite: bool) -> pathlib.Path:
    """Writes chunks to PATH.part, and names it PATH when its SHA-256 is right.

    @param open_stream  (offset, SHA-256 of the chunks so far)
    """
    target = pathlib.Path(path)
    target = target / name if target.is_dir() else target
    if target.is_file() and not overwrite:
        raise errors.DccastError("ALREADY_EXISTS", f"{target} is there already",
                                 remedy="give another path, or overwrite=True")
    part = target.with_name(target.name + ".part")
    digest, total, sha256 = hashlib.sha256(), -1, ""
    written = 0

    def opened() -> Any:
        return open_stream(written, sha256)

    def is_last(chunk: Any) -> bool:
        return bool(chunk.offset + len(chunk.data) >= chunk.total_size_bytes)

    try:
        with open(part, "wb", opener=_without_links) as file:
            for chunk in transport.resumed(opened, is_last):
                file.write(chunk.data)
                digest.update(chunk.data)
                written += len(chunk.data)
                total, sha256 = chunk.total_size_bytes, chunk.sha256
        if written != total or digest.hexdigest() != sha256:
            raise errors.DccastError("DATA_LOSS", f"{name} did not arrive as the server has it",
                                     remedy="fetch it again")
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
    return target


def _without_links(path: str, flags: int) -> int:
    """A link in the place of the part file could lead anywhere."""
    return os.open(path, flags | getattr(os, "O_NOFOLLOW", 0), 0o666)
