"""A casting while it is cast: readings of the plant, the forecast, and what it rests on."""
from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Union

import numpy as np

from dccast import errors
from dccast.runs import Band
from dccast.studies import Study
from dccast.transport import Deadline, Transport
from dccast.v1 import follow_pb2, study_pb2

MOST_READINGS = 1000  # of a call, follow.proto
CURL = "_curl_m"  # behind the monitor of a gauge, as in Run.curl

#: Figures of one time by name: "time_s", "casting_speed_m_per_s", "casting_temperature_c",
#: "water_flow_m2_per_s", "narrow_water_flow_m2_per_s", "second_water_flow_m2_per_s", "water_temperature_c",
#: "metal_level_m", and MONITOR_curl_m of each gauge. What is absent or NaN was not measured.
Reading = Union[Mapping[str, float], follow_pb2.Reading]


def rows_of(readings: Any) -> Iterable[Reading]:
    """The readings of a pandas table, a structured array, a mapping of columns, or those of an iterable.

    >>> from dccast import castings
    >>> list(castings.rows_of({"time_s": [0, 1], "corner_curl_m": [0.0, 1e-4]}))
    [{'time_s': 0, 'corner_curl_m': 0.0}, {'time_s': 1, 'corner_curl_m': 0.0001}]
    """
    if hasattr(readings, "to_dict"):
        whole = readings if "time_s" in readings else readings.reset_index()
        return list(whole.to_dict("records"))
    if getattr(getattr(readings, "dtype", None), "names", None):
        return [dict(zip(readings.dtype.names, row.tolist())) for row in readings]
    if isinstance(readings, Mapping):
        return [dict(zip(readings, row)) for row in zip(*readings.values(), strict=True)]
    return readings  # type: ignore[no-any-return]


def message_of(reading: Reading, number: int) -> follow_pb2.Reading:
    """A reading as AppendReadings takes it. @raises DccastError  a name that no reading has"""
    message = follow_pb2.Reading()
    if isinstance(reading, follow_pb2.Reading):
        message.CopyFrom(reading)
    else:
        known = follow_pb2.Reading.DESCRIPTOR.fields_by_name
        for name, value in reading.items():
            if not name.endswith(CURL) and (name not in known or name in ("number", "closes", "curls")):
                raise errors.DccastError("INVALID_ARGUMENT", f"a reading has no figure {name!r}", field=name,
                                         remedy="see dccast.castings.Reading for those it has")
            if math.isnan(value):
                continue
            if name.endswith(CURL):
                message.curls.add(monitor=name.removesuffix(CURL), curl_m=value)
            else:
                setattr(message, name, value)
    message.number = number
    return message


def _batches(readings: Iterable[Reading]) -> Iterator[Sequence[Reading]]:
    """A table in calls of full size; of a plant that sends them each reading at once."""
    if not isinstance(readings, Sequence):
        for reading in readings:
            yield [reading]
        return
    for first in range(0, len(readings), MOST_READINGS):
        yield readings[first:first + MOST_READINGS]


def append_readings(transport: Transport, job: str, readings: Any,
                    close: bool) -> follow_pb2.AppendReadingsResponse:
    """Adds readings to the record of a job; those that it has already, by their time, are left out.

    The answer has all values that no plant has; a warning tells the first one of each sensor.
    """
    left_out: dict[str, list[follow_pb2.LeftOutValue]] = {}
    kept: follow_pb2.AppendReadingsResponse = transport.call(
        "AppendReadings", follow_pb2.AppendReadingsRequest(id=job))
    for batch in _batches(rows_of(readings)):
        request = follow_pb2.AppendReadingsRequest(id=job)
        for reading in batch:
            message = message_of(reading, kept.number + len(request.readings) + 1)
            if not kept.HasField("time_s") or message.time_s > kept.time_s:
                request.readings.append(message)
        if request.readings:
            kept = transport.call("AppendReadings", request)
            for value in kept.left_out:
                if value.name not in left_out:
                    time_s = request.readings[value.number - request.readings[0].number].time_s
                    warnings.warn(f"reading {value.number}, {time_s:g} s: {value.reason}; this value alone is "
                                  "left out, and so are others that no plant has", stacklevel=3)
                left_out.setdefault(value.name, []).append(value)
    if close and not kept.closed:
        kept = transport.call("AppendReadings", follow_pb2.AppendReadingsRequest(
            id=job, readings=[follow_pb2.Reading(number=kept.number + 1, closes=True)]))
    del kept.left_out[:]
    kept.left_out.extend(value for values in left_out.values() for value in values)
    return kept


class Forecast:
    """The curls to come of a casting, from what was measured so far."""

    def __init__(self, message: follow_pb2.Forecast) -> None:
        self.message = message  #: as in follow.proto, with line, levers and what was measured

    def __repr__(self) -> str:
        return f"<dccast.Forecast at {self.time_s:.4g} s: {', '.join(map(repr, self.bands.values()))}>"

    @property
    def time_s(self) -> float:
        """Of the last reading."""
        return float(self.message.time_s)

    @property
    def bands(self) -> dict[str, Band]:
        """By monitor, from now to the end of the casting. Nine castings in ten stay inside the band."""
        bands = {}
        for curl in self.message.curls:
            expected = np.array(curl.curl_m)
            bands[curl.monitor] = Band(curl.monitor, np.array(curl.time_s), np.full(len(expected), np.nan),
                                       expected, expected - np.array(curl.lower_m),
                                       np.array(curl.upper_m) - expected)
        return bands

    @property
    def warnings(self) -> list[str]:
        """What is off, and its likeliest causes, newest last."""
        return ["; ".join([warning.text, *warning.causes]) for warning in self.message.warnings]

    @property
    def advice(self) -> list[str]:
        """What can still be done, or that no lever does enough; empty: not known."""
        return list(self.message.advice)

    @property
    def notes(self) -> list[str]:
        """What the forecast rests on less than it could."""
        return list(self.message.notes)


class Preparation:
    """What the forecast of a casting rests on: an ensemble of drafts, pairs of some of them at engineering
    quality, drafts with levers moved, and the run of the plan."""

    def __init__(self, transport: Transport, asked: Callable[[], study_pb2.Preparation]) -> None:
        self._transport, self._asked = transport, asked
        self.message = asked()

    def __repr__(self) -> str:
        parts = ", ".join(f"{name} {study.message.succeeded + study.message.failed} of {study.message.runs}"
                          for name, study in self.studies.items())
        return f"<dccast.Preparation {'ready' if self.ready else 'under way'}: {parts or 'not begun'}>"

    @property
    def studies(self) -> dict[str, Study]:
        """Those that are begun: "ensemble", "pairs", "levers"."""
        return {name: Study(self._transport, getattr(self.message, name))
                for name in ("ensemble", "pairs", "levers") if self.message.HasField(name)}

    @property
    def plan_job(self) -> str:
        """Id of the job that computes the case as it is."""
        return str(self.message.plan_job)

    @property
    def ready(self) -> bool:
        """Whether all studies have ended."""
        return bool(self.message.ready)

    def refresh(self) -> Preparation:
        """Asks again, and has the server begin what can be begun now."""
        self.message = self._asked()
        return self

    def wait(self, timeout_s: float | None = None) -> Preparation:
        """Waits until all studies have ended. @raises DccastError  one was cancelled, or the time is over"""
        deadline = Deadline(timeout_s)
        while not self.ready:
            for study in self.studies.values():
                if study.wait(check=False, timeout_s=deadline.left()).state == "CANCELLED":
                    raise errors.DccastError("CANCELLED", f"study {study.id} was cancelled",
                                             remedy="prepare the casting again")
            self.refresh()
        return self
