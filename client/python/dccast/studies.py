"""Studies: many runs of one case that are asked, watched and read as one."""
from __future__ import annotations

import os
import pathlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from dccast import errors
from dccast.cases import Case, Changes, changes_of
from dccast.download import download
from dccast.judgements import Judgement
from dccast.runs import Band, Table, band_of
from dccast.text import millimetres, show_progress
from dccast.transport import Deadline, Transport
from dccast.v1 import job_pb2, judgement_pb2, study_pb2


@dataclass(frozen=True)
class Prediction:
    """The curl at values that were not run, by a response surface of the runs of a sweep."""

    bands: dict[str, Band]  #: by monitor, with the standard error of the surface alone
    cross_validated_error_m: float  #: root mean square over runs left out one by one, at the end
    relative_lower_error: float  #: of the mesh and steps of the runs, below a curl; NaN: not known
    relative_upper_error: float  #: the same above it
    runs: int  #: that the surface rests on
    next_run: dict[str, str]  #: where another run would add most

    def __repr__(self) -> str:
        ends = ", ".join(f"{name} " + millimetres(
            float(band.curl_m[-1]), float(band.lower_error_m[-1]), float(band.upper_error_m[-1]))
                         for name, band in self.bands.items())
        return f"<dccast.Prediction {ends}; {self.runs} runs>"


class Study:
    """A study on the server."""

    def __init__(self, transport: Transport, message: study_pb2.Study) -> None:
        self._transport, self.message = transport, message

    def __repr__(self) -> str:
        message = self.message
        return (f"<dccast.Study {self.id[:8]} {self.state} {message.title!r}, "
                f"{100 * message.progress:.0f} % of {message.runs} runs>")

    @property
    def id(self) -> str:
        """A UUID."""
        return str(self.message.id)

    @property
    def state(self) -> str:
        """RUNNING, SUCCEEDED, FAILED or CANCELLED."""
        return errors.name_of(study_pb2.StudyState, self.message.state).removeprefix("STUDY_")

    def refresh(self) -> Study:
        """Fetches the present state of the study from the server."""
        return self._became(self._transport.call("GetStudy", study_pb2.GetStudyRequest(id=self.id)))

    def watch(self, timeout_s: float | None = None) -> Iterator[Study]:
        """The study each time it has changed, until it has ended."""
        deadline = Deadline(timeout_s)

        def opened() -> Any:
            return self._transport.stream("WatchStudy", study_pb2.WatchStudyRequest(id=self.id),
                                          deadline.left())

        def is_last(message: study_pb2.Study) -> bool:
            return message.state != study_pb2.STUDY_RUNNING

        for message in self._transport.resumed(opened, is_last):
            yield self._became(message)

    def wait(self, check: bool = True, timeout_s: float | None = None, progress: bool = False) -> Study:
        """Waits until all runs have ended.

        @param progress  draw a bar on standard error
        @param check  raise DccastError unless every run has succeeded
        @raises DccastError  of code DEADLINE_EXCEEDED when the time is over; the study goes on
        """
        for study in self.watch(timeout_s):
            if progress:
                show_progress(study.message.progress, f"of {study.message.runs} runs",
                              last=study.state != "RUNNING")
        if check and self.state != "SUCCEEDED":
            raise errors.DccastError(self.state, f"study {self.id} is {self.state}: "
                                     f"{self.message.failed} of {self.message.runs} runs failed",
                                     remedy="its table names the cause of each run; wait(check=False)")
        return self

    def evaluate(self, curves: bool = False) -> study_pb2.StudyResult:
        """What the study shows so far, as in study.proto: also limits, mould, recipe."""
        answer: study_pb2.StudyResult = self._transport.call(
            "EvaluateStudy", study_pb2.EvaluateStudyRequest(id=self.id, curves=curves))
        return answer

    def judgement(self, monitor: str = "", *, line: str = "", assume_sound: bool = False) -> Judgement:
        """What the server concludes so far: the sentences and tables that the command of such a study
        prints. A calibration is judged once it has ended.

        @param monitor       whose curl; without one output.curl, or the largest
        @param line          of an uncertainty: given the castings of this line
        @param assume_sound  given 200 sound castings that nobody has recorded
        """
        answer = self._transport.call("JudgeStudy", judgement_pb2.JudgeStudyRequest(
            id=self.id, monitor=monitor, line=line, assume_sound=assume_sound))
        return Judgement(answer.judgement)

    def case_file(self, case: Case) -> str:
        """The text of a case file with what the study found: the values of a calibration with their ranges,
        or the chosen recipe. Empty where nothing was found.

        @param case  as its file was read, into which the findings are written
        """
        request = judgement_pb2.JudgeStudyRequest(id=self.id, case=case.message)
        return str(self._transport.call("JudgeStudy", request).case_file)

    @property
    def table(self) -> Table:
        """One row for each run: job, state, of a sweep its values in SI by key, and the curl of each
        monitor at the end, NAME_end_curl_m, with how far mesh and steps may have put the true one below and
        above it, NAME_lower_error_m and NAME_upper_error_m; NaN where there is none."""
        result = self.evaluate()
        runs = result.runs
        keys = [axis.key for axis in result.study.sweep.axes]
        columns: dict[str, list[Any]] = {"job": [run.job for run in runs], "state": [
            errors.name_of(job_pb2.JobState, run.state) for run in runs]}
        for i, key in enumerate(keys):
            columns[key] = [_at(run.numbers, i) for run in runs]
        for i, monitor in enumerate(result.monitors):
            columns[f"{monitor}_end_curl_m"] = [_at(run.end_curl_m, i) for run in runs]
            columns[f"{monitor}_lower_error_m"] = [_at(run.end_lower_error_m, i) for run in runs]
            columns[f"{monitor}_upper_error_m"] = [_at(run.end_upper_error_m, i) for run in runs]
        kinds = {"job": "U36", "state": "U24"}
        table: Table = np.zeros(len(runs), dtype=[(name, kinds.get(name, "f8")) for name in columns])
        for name, values in columns.items():
            table[name] = values
        return table

    def predict(self, changes: Changes | None = None, **keys: Any) -> Prediction:
        """The curl at values of the sweep's keys; those not given keep the value of the case."""
        answer = self._transport.call("PredictStudy", study_pb2.PredictStudyRequest(
            id=self.id, values=changes_of(changes, keys)))
        return Prediction({curve.monitor: band_of(curve) for curve in answer.curves},
                          answer.cross_validated_error_m, *_relative(answer), answer.runs,
                          {change.key: change.value for change in answer.next_run})

    def fetch(self, path: str | os.PathLike[str], overwrite: bool = False) -> pathlib.Path:
        """Downloads values, end curls and curves of every run so far as one HDF5 file."""
        def opened(offset: int, sha256: str) -> Any:
            return self._transport.stream("FetchStudy", study_pb2.FetchStudyRequest(
                id=self.id, offset=offset, sha256=sha256))
        return download(self._transport, opened, path, "study.h5", overwrite)

    def cancel(self, reason: str = "") -> Study:
        """Cancels what has not ended."""
        return self._became(self._transport.call(
            "CancelStudy", study_pb2.CancelStudyRequest(id=self.id, reason=reason)))

    def resume(self, failed: bool = False) -> Study:
        """Queues again what was cancelled or lost; with `failed` also what failed by its own case."""
        return self._became(self._transport.call(
            "ResumeStudy", study_pb2.ResumeStudyRequest(id=self.id, failed=failed), repeat=False))

    def delete(self) -> None:
        """Removes an ended study and its jobs."""
        self._transport.call("DeleteStudy", study_pb2.DeleteStudyRequest(id=self.id), repeat=False)

    def _became(self, message: study_pb2.Study) -> Study:
        self.message = message
        return self


def _relative(message: Any) -> tuple[float, float]:
    """The errors of mesh and steps below and above, relative to a curl; NaN: not known."""
    error = message.mesh_error
    return (error.lower, error.upper) if message.HasField("mesh_error") else (np.nan, np.nan)


def _at(values: Any, index: int) -> float:
    return float(values[index]) if index < len(values) else np.nan
