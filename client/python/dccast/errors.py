"""What went wrong, as the server states it."""
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import grpc

from dccast.v1 import job_pb2, refusal_pb2, service_pb2

ERROR_INFO_URL = "type.googleapis.com/google.rpc.ErrorInfo"


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with a case, or with a change to it."""

    field: str  #: path of the key, e.g. "schedule.casting_speed"
    value: str  #: what was given
    message: str
    permitted: str  #: with its unit
    remedy: str
    line: int = 0  #: in the text of the case; 0: in a change, or not known

    def __str__(self) -> str:
        place = f"line {self.line}: " if self.line else ""
        value = f" = {self.value}" if self.value else ""
        rest = [part for part in (self.permitted and f"permitted: {self.permitted}", self.remedy) if part]
        return place + "; ".join([f"{self.field}{value}: {self.message}", *rest])


class DccastError(Exception):
    """A call or a run that failed.

    >>> try:
    ...     dccast.connect().submit("start-3d", schedule__casting_speed="55 m")
    ... except dccast.DccastError as error:
    ...     print(error.code, error.field)
    INVALID_ARGUMENT schedule.casting_speed
    """

    def __init__(self, code: str, message: str, faults: Iterable[Fault] = (), field: str = "",
                 remedy: str = "", reason: str = "", limit: str = "") -> None:
        super().__init__(message)
        self.reason = reason  #: of a refused call, e.g. "LIMIT_REACHED", as in refusal.proto; else empty
        self.limit = limit  #: setting of the server that refuses, e.g. "limits.maximum_queued"; else empty
        self.code = code  #: of a call its status, e.g. "NOT_FOUND"; of a run, e.g. "SOLVE_FAILED"
        self.faults = tuple(faults)  #: all that is wrong with the case
        first = self.faults[0] if self.faults else None
        self.field = field or (first.field if first else "")  #: key of the first fault; else empty
        self.remedy = remedy or (first.remedy if first else "")  #: what to do instead; may be empty


class UnknownState(DccastError):
    """A state, priority or kind whose name or number this version of the package does not have."""


def number_of(kind: Any, name: str) -> Any:
    """The value of an enumeration of the contract. @raises UnknownState

    >>> from dccast import errors
    >>> from dccast.v1 import job_pb2
    >>> errors.number_of(job_pb2.JobState, "running") == job_pb2.RUNNING
    True
    """
    try:
        return kind.Value(name.upper())
    except ValueError:
        raise UnknownState("INVALID_ARGUMENT", f"{name!r} is no {kind.DESCRIPTOR.name}",
                           remedy=f"permitted: {', '.join(kind.keys()[1:])}") from None


def name_of(kind: Any, number: int) -> str:
    """The name of a value of the contract. @raises UnknownState  the server is newer than this package"""
    try:
        return str(kind.Name(number))
    except ValueError:
        raise UnknownState("UNIMPLEMENTED", f"the server has a {kind.DESCRIPTOR.name} of number {number}",
                           remedy="install the package of the server's version") from None


def invalid_case(faults: Iterable[job_pb2.Fault], lines: Iterable[int] = ()) -> DccastError:
    """All faults of a case as one error."""
    places = list(lines)
    found = [Fault(f.field, f.value, f.message, f.permitted, f.remedy,
                   places[i] if i < len(places) else 0) for i, f in enumerate(faults)]
    return DccastError("INVALID_ARGUMENT", "\n".join(map(str, found)), found)


def missing(module: str, package: str) -> DccastError:
    """For a module that is imported only when asked for."""
    return DccastError("MISSING_PACKAGE", f"{module} is not installed: {package}", remedy=package)


def _details(error: grpc.RpcError) -> tuple[refusal_pb2.ErrorInfo, service_pb2.ValidateCaseResponse]:
    """Why the server refuses, and the faults of a case; both empty where gRPC itself refuses."""
    status = refusal_pb2.StatusDetails()
    for key, value in error.trailing_metadata() or ():
        if key == "grpc-status-details-bin":
            status.ParseFromString(value)
    info, verdict = refusal_pb2.ErrorInfo(), service_pb2.ValidateCaseResponse()
    for detail in status.details:
        if detail.type_url == ERROR_INFO_URL:
            info.ParseFromString(detail.value)
        elif detail.Is(verdict.DESCRIPTOR):
            detail.Unpack(verdict)
    return info, verdict


def of_call(error: grpc.RpcError, server: str) -> DccastError:
    """The failure of a call."""
    code: str = error.code().name
    info, verdict = _details(error)
    facts = info.metadata
    if verdict.faults:
        failure = invalid_case(verdict.faults)
        failure.code, failure.reason, failure.limit = code, info.reason, facts.get("limit", "")
        return failure
    if code == "UNAVAILABLE":
        return DccastError(code, f"no answer from {server}: {error.details()}", reason=info.reason,
                           remedy=facts.get("remedy", "")
                           or "is dccastd running there? Another address: connect(...) or DCCAST_SERVER")
    return DccastError(code, error.details() or f"{server} could not answer: {code}", reason=info.reason,
                       remedy=facts.get("remedy", ""), limit=facts.get("limit", ""))
