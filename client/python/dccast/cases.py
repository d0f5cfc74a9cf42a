"""Cases: from a file, a text or a shipped name to what the calls of the server take."""
from __future__ import annotations

import hashlib
import json
import os
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Union

from dccast import errors
from dccast.transport import Transport
from dccast.v1 import case_pb2, job_pb2, service_pb2

#: As in a case file: "55 mm/min", 12, True, [["0 s", "40 mm/min"], ["60 s", "60 mm/min"]].
Value = Union[str, int, float, bool, Sequence["Value"]]
Changes = Mapping[str, Value]


@dataclass(frozen=True)
class AttachedFile:
    """A file that a case names, which is uploaded with the first call about the case."""

    name: str  #: that the case gives it
    path: pathlib.Path
    sha256: str
    size: int

    @property
    def message(self) -> job_pb2.Attachment:
        """What names the file in a call."""
        return job_pb2.Attachment(name=self.name, sha256=self.sha256, size_bytes=self.size)


@dataclass
class Case:
    """A case that was read by the server, with the changes that were made to it."""

    message: case_pb2.Case
    files: list[AttachedFile] = field(default_factory=list)
    changes: list[job_pb2.CaseChange] = field(default_factory=list)
    text: str = ""  #: of its file, without the changes

    def __repr__(self) -> str:
        changed = ", ".join(f"{change.key} = {change.value}" for change in self.changes)
        return f"<dccast.Case {self.message.title!r}{': ' if changed else ''}{changed}>"


Source = Union[str, "os.PathLike[str]", Case]


def written(value: Value) -> str:
    """A value as a case file has it.

    >>> from dccast import cases
    >>> cases.written([["0 s", "40 mm/min"], ["60 s", "60 mm/min"]])
    '[["0 s", "40 mm/min"], ["60 s", "60 mm/min"]]'
    """
    if isinstance(value, str):
        return value
    return json.dumps(value)


def changes_of(changes: Changes | None, keys: Changes) -> list[job_pb2.CaseChange]:
    """Changes by path, and those given as keywords with two underscores for each dot."""
    merged = {**(changes or {}), **{key.replace("__", "."): value for key, value in keys.items()}}
    return [job_pb2.CaseChange(key=key, value=written(value)) for key, value in merged.items()]


def read_case(transport: Transport, source: Source, changes: list[job_pb2.CaseChange]) -> Case:
    """@raises DccastError  all faults of the text and of the changes, with their lines"""
    if isinstance(source, Case):
        return _changed(source, changes)
    request = service_pb2.ReadCaseRequest(changes=changes)
    folder = pathlib.Path()
    text = os.fspath(source)
    if "\n" in text or "=" in text:
        request.text = text
    elif os.path.isfile(text):
        folder = pathlib.Path(text).parent
        request.text = pathlib.Path(text).read_text("utf-8")
    elif os.path.dirname(text) or text.endswith(".toml"):
        raise errors.DccastError("NOT_FOUND", f"{text}: no such file",
                                 remedy="give the path of a case, its text, or the name of a shipped case")
    else:
        request.shipped = text
    read = transport.call("ReadCase", request)
    if read.faults:
        raise errors.invalid_case(read.faults, read.lines)
    return Case(read.case, [_attached(folder / name) for name in read.files], changes, read.text)


def _attached(path: pathlib.Path) -> AttachedFile:
    with path.open("rb") as file:
        return AttachedFile(path.name, path, hashlib.file_digest(file, "sha256").hexdigest(),
                            path.stat().st_size)


def _changed(case: Case, changes: list[job_pb2.CaseChange]) -> Case:
    if not changes:
        return case
    raise errors.DccastError("INVALID_ARGUMENT", "a case that was read takes no more changes",
                             remedy="give the changes to Service.read, or the file to this call")
