"""Jobs: what was submitted, what it reports, what it leaves."""
from __future__ import annotations

import asyncio
import functools
import os
import pathlib
import tempfile
from collections.abc import AsyncIterator, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dccast import errors
from dccast.castings import Forecast, append_readings
from dccast.download import download
from dccast.frames import Frames
from dccast.judgements import Judgement
from dccast.runs import Run, Table, curls_of, curls_text
from dccast.text import show_progress
from dccast.transport import Deadline, Transport
from dccast.v1 import case_pb2, follow_pb2, job_pb2, judgement_pb2, service_pb2

READINGS = 5  # of a history, while its job goes back to a checkpoint


@dataclass(frozen=True)
class Event:
    """One record of a job. `body` is the message of its kind in job.proto."""

    sequence: int  #: from 1, without holes
    kind: str  #: state_change, step, message, resumed, validity_lost, finding, run_ended
    body: Any

    @property
    def state(self) -> str:
        """Of a change of state, e.g. "RUNNING"; else empty."""
        return errors.name_of(job_pb2.JobState, self.body.state) if self.kind == "state_change" else ""


class Watch:
    """The events of a job until it has ended, past ones first; for `for` and `async for`. The job's own
    attributes follow its state."""

    def __init__(self, transport: Transport, job: Job, from_sequence: int,
                 timeout_s: float | None) -> None:
        self._transport, self._job, self._next = transport, job, max(from_sequence, 1)
        self._deadline = Deadline(timeout_s)
        self._stream: Any = None

    def __iter__(self) -> Iterator[Event]:
        def opened() -> Any:
            return self._transport.stream(
                "WatchJob", service_pb2.WatchJobRequest(id=self._job.id, from_sequence=self._next),
                self._deadline.left())

        def is_last(event: job_pb2.JobEvent) -> bool:
            return event.HasField("state_change") and event.state_change.terminal

        def on_stream(stream: Any) -> None:
            self._stream = stream

        for event in self._transport.resumed(opened, is_last, on_stream):
            if event.sequence < self._next:
                continue
            self._next = event.sequence + 1
            kind = event.WhichOneof("what") or ""
            if is_last(event):
                self._job.refresh()
            elif kind == "state_change":
                self._job.message.state = event.state_change.state
            yield Event(event.sequence, kind, getattr(event, kind) if kind else None)

    async def __aiter__(self) -> AsyncIterator[Event]:
        events = iter(self)
        try:
            while (event := await asyncio.to_thread(lambda: next(events, None))) is not None:
                yield event
        finally:
            self.close()

    def close(self) -> None:
        """Ends the watch. The job goes on."""
        if self._stream is not None:
            self._stream.cancel()


class Job(Run):
    """A job on the server. Its attributes are those of the last look: `refresh` looks again."""

    def __init__(self, transport: Transport, message: job_pb2.Job) -> None:
        self._transport, self.message = transport, message

    def __repr__(self) -> str:
        shown = f"<dccast.Job {self.id[:8]} {self.state} {self.message.title!r}"
        # A run that failed has a last step, but no curl as of a good one.
        has_curl = self.state != "FAILED" and not self.message.HasField("validity_loss")
        if has_curl and self.message.HasField("last_step"):
            shown += f": {curls_text(self.message.last_step)}"
        return shown + ">"

    @property
    def id(self) -> str:
        """A UUID."""
        return str(self.message.id)

    @property
    def state(self) -> str:
        """QUEUED, RUNNING, PAUSED, SUCCEEDED, FAILED or CANCELLED."""
        return errors.name_of(job_pb2.JobState, self.message.state)

    @property
    def ended(self) -> bool:
        """Whether it has succeeded, failed or was cancelled."""
        return self.state in ("SUCCEEDED", "FAILED", "CANCELLED")

    @property
    def findings(self) -> list[job_pb2.Finding]:
        """What an engineer should know of this casting (docs/findings.md)."""
        return list(self.message.findings)

    @property
    def valid_until_s(self) -> float:
        return self.message.validity_loss.time_s if self.message.HasField("validity_loss") else np.inf

    def refresh(self) -> Job:
        """Looks at the job again; forgets steps that were read."""
        return self._became(self._transport.call("GetJob", service_pb2.GetJobRequest(id=self.id)))

    def watch(self, from_sequence: int = 1, timeout_s: float | None = None) -> Watch:
        """Its events from a sequence number on, until it has ended.

        @raises DccastError  of code DEADLINE_EXCEEDED when the time is over; the job goes on

        >>> job = dccast.connect().submit("start-2d-thickness", quality="draft", time__end="20 s")
        >>> [event.state for event in job.watch() if event.state]
        ['QUEUED', 'RUNNING', 'SUCCEEDED']
        """
        return Watch(self._transport, self, from_sequence, timeout_s)

    def wait(self, check: bool = True, timeout_s: float | None = None, progress: bool = False) -> Job:
        """Waits until it has ended, or raises as `watch`.

        @param progress  draw a bar with the curl so far on standard error
        @param check  raise DccastError for a job that did not succeed; its `code` is the cause, e.g.
                      "SHELL_MELTED_THROUGH" or "CANCELLED"
        """
        for event in self.watch(timeout_s=timeout_s):
            if progress and event.kind == "step":
                step = event.body
                show_progress(step.time_s / self.case.time.end_s, f"{step.time_s:.4g} s, {curls_of(step)}")
        if progress:
            show_progress(1.0, self.state, last=True)
        if check and self.state != "SUCCEEDED":
            failure = self.message.failure
            code = errors.name_of(job_pb2.Finding.Kind, failure.kind) if failure.kind else self.state
            raise errors.DccastError(code, f"job {self.id} is {self.state}: {failure.message}",
                                     field=failure.code)
        return self

    def cancel(self, reason: str = "") -> Job:
        """Asks it to stop; `wait` waits for that."""
        return self._became(self._transport.call(
            "CancelJob", service_pb2.CancelJobRequest(id=self.id, reason=reason)))

    def pause(self) -> Job:
        """Stops it at a checkpoint and keeps it out of the queue."""
        return self._once("PauseJob", service_pb2.PauseJobRequest(id=self.id))

    def resume(self) -> Job:
        """Queues it again; it goes on from its checkpoint."""
        return self._once("ResumeJob", service_pb2.ResumeJobRequest(id=self.id))

    def delete(self) -> None:
        """Removes an ended job and its files."""
        self._transport.call("DeleteJob", service_pb2.DeleteJobRequest(id=self.id), repeat=False)

    def label(self, *labels: str, remove: Sequence[str] = ()) -> Job:
        """Adds labels; "key=value" takes the place of the label with that key.

        @param remove  these labels, or those with these keys
        """
        return self._became(self._transport.call("UpdateJob", service_pb2.UpdateJobRequest(
            id=self.id, set_labels=labels, remove_labels=remove)))

    def prioritize(self, priority: str) -> Job:
        """Gives it another priority, "low", "normal" or "high", as long as it has not started."""
        return self._became(self._transport.call("UpdateJob", service_pb2.UpdateJobRequest(
            id=self.id, priority=errors.number_of(job_pb2.Priority, priority))))

    def pin(self, pinned: bool = True) -> Job:
        """Keeps it for good, or no longer."""
        return self._became(self._transport.call(
            "UpdateJob", service_pb2.UpdateJobRequest(id=self.id, pinned=pinned)))

    def append(self, readings: Any = (), close: bool = False) -> follow_pb2.AppendReadingsResponse:
        """Adds to the record of a job that follows a casting, and says how far the record goes.

        @param readings  a table (pandas, structured array, mapping of columns), or an iterable of
                         castings.Reading, which is sent reading by reading
        @param close     no reading follows: the job ends with the last one
        """
        return append_readings(self._transport, self.id, readings, close)

    def forecast(self) -> Forecast:
        """The curls to come of a casting that it follows."""
        return Forecast(self._transport.call("ForecastJob", follow_pb2.ForecastJobRequest(id=self.id)))

    def report(self) -> Judgement:
        """What `dccast report` has: sentences, tables, and the charts of histories and of the last frame,
        which is left out where the job has none."""
        request = judgement_pb2.CompareRunsRequest(runs=[judgement_pb2.ComparedRun(job=self.id)],
                                                   with_frame=True)
        return Judgement(self._transport.call("CompareRuns", request).judgement)

    @property
    def logs(self) -> str:
        """What its workers have written; the times of its attempts: watch()."""
        with tempfile.TemporaryDirectory() as folder:
            return self.fetch(folder, "worker.log").read_text("utf-8", "replace")

    @property
    def case(self) -> case_pb2.Case:
        return self._result.case

    @property
    def steps(self) -> Sequence[job_pb2.StepReport]:
        return list(self._result.steps)

    @property
    def frames(self) -> Frames:
        """The stored fields of a job that has ended, by time."""
        return Frames(self._transport, self.id)

    def probe(self, at_m: Sequence[float], to_m: Sequence[float] | None = None, points: int = 21,
              time_s: float | None = None, fields: Sequence[str] = ()) -> Table:
        """The fields at a point over time, or along a line at one instant, from the stored frames; as
        `dccast probe`.

        @param at_m    the point in the undeformed slab, or the begin of the line: x and y from the middle,
                       z above the block; of a section x and y
        @param to_m    the end of the line
        @param time_s  of a line: the nearest stored frame; None: the last one
        @param fields  further fields of the frames, e.g. "von_mises_pa"
        @return        columns time_s, cast_length_m, x_m, y_m (z_m), temperature_c, displacement_x_m,
                       displacement_y_m (displacement_z_m), then the further fields; NaN where there is no metal

        >>> job = dccast.connect().submit("start-2d-thickness", quality="draft", time__end="20 s").wait()
        >>> bool(job.probe((0.0, 0.05))["temperature_c"][-1] > job.probe((0.28, 0.05))["temperature_c"][-1])
        True
        """
        places = np.array([at_m], dtype=np.float64)
        if to_m is not None:
            share = np.linspace(0.0, 1.0, points)[:, None]
            places = (1.0 - share) * places + share * np.array([to_m])

        request = service_pb2.ProbeResultRequest(id=self.id, fields=fields)
        for place in places:
            request.points.add(coordinate_m=place)
        if to_m is not None and time_s is None:
            request.last = True
        elif time_s is not None:
            request.time_s = time_s
        found = self._transport.call("ProbeResult", request)

        coordinates = ["x_m", "y_m", "z_m"][:places.shape[1]]
        names = ["time_s", "cast_length_m", *coordinates, *(field.name for field in found.fields)]
        table: Table = np.zeros(len(found.instants) * len(places), dtype=[(name, "f8") for name in names])
        for i, instant in enumerate(found.instants):
            rows = table[i * len(places):(i + 1) * len(places)]
            rows["time_s"], rows["cast_length_m"] = instant.time_s, instant.cast_length_m
            values = np.reshape(instant.values, (len(places), -1))
            for name, column in zip(names[2:], np.hstack([places, values]).T):
                rows[name] = column
        return table

    def fetch(self, path: str | os.PathLike[str], artifact: str = "results.h5",
              overwrite: bool = False) -> pathlib.Path:
        """Downloads a result file and checks its SHA-256. A cut stream is taken up again.

        @param path      a file, or a folder for a file of the artifact's name
        @param artifact  "results.h5"; beside it "results.xdmf" for ParaView, "results-end.xdmf" of the last
                         frame for meshio; "run.json", what the run had of its machine
        @raises DccastError  of code ALREADY_EXISTS where the file is there, without `overwrite`
        """
        def opened(offset: int, _: str) -> Any:
            return self._transport.stream("FetchResult", service_pb2.FetchResultRequest(
                id=self.id, artifact=artifact, offset=offset))
        return download(self._transport, opened, path, artifact, overwrite)

    def _once(self, method: str, request: Any) -> Job:
        return self._became(self._transport.call(method, request, repeat=False))

    def _became(self, message: job_pb2.Job) -> Job:
        self.message = message
        for name in ("_result", "_bands"):
            self.__dict__.pop(name, None)
        return self

    @functools.cached_property
    def _result(self) -> service_pb2.QueryResultResponse:
        """All pages. A job that goes back to a checkpoint meanwhile is read again."""
        for reading in range(1, READINGS + 1):
            result, request = service_pb2.QueryResultResponse(), service_pb2.QueryResultRequest(id=self.id)
            try:
                while True:
                    page = self._transport.call("QueryResult", request)
                    result.MergeFrom(page)
                    request.page_token = page.next_page_token
                    if not page.next_page_token:
                        return result
            except errors.DccastError as error:
                if error.code != "ABORTED" or reading == READINGS:
                    raise
        raise AssertionError("not reached")
