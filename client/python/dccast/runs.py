"""What a run computed: its curl with the error of mesh and time steps, and its history."""
from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from dccast import errors
from dccast.text import millimetres, span
from dccast.v1 import case_pb2, job_pb2

if TYPE_CHECKING:
    from collections.abc import Mapping

Floats = npt.NDArray[np.float64]
Table = npt.NDArray[np.void]  # structured: columns by name, one row for each step
CURL = ("curl_m", "curl_lower_error_m", "curl_upper_error_m")  # of a MonitorValue


@dataclass(frozen=True)
class Band:
    """The curl of one monitor, and how far the true one may lie below and above it; NaN where nothing is
    known."""

    monitor: str
    time_s: Floats
    cast_length_m: Floats
    curl_m: Floats
    lower_error_m: Floats
    upper_error_m: Floats

    def __repr__(self) -> str:
        if not len(self.time_s):
            return f"<dccast.Band {self.monitor!r} without steps>"
        end = millimetres(float(self.curl_m[-1]), float(self.lower_error_m[-1]),
                          float(self.upper_error_m[-1]))
        return (f"<dccast.Band {self.monitor!r} {end} at the end; {len(self.time_s)} steps, "
                f"{span(float(self.time_s[0]), float(self.time_s[-1]), 's')}>")


def _figure(monitor: Any, name: str) -> float:
    """A figure of a monitor; NaN where it has none."""
    return float(getattr(monitor, name)) if monitor.HasField(name) else np.nan


def curls_of(step: job_pb2.StepReport) -> str:
    """The curls of a step: "corner 5.25 ± 0.21 mm, mid 1.20 ± 0.05 mm"."""
    shown = [f"{monitor.name} " + millimetres(*(_figure(monitor, name) for name in CURL))
             for monitor in step.monitors if monitor.HasField("curl_m")]
    return ", ".join(shown) or "no curl"


def curls_text(step: job_pb2.StepReport) -> str:
    """The curls of a step with its time: "corner 5.25 ± 0.21 mm at 145 s"."""
    return f"{curls_of(step)} at {step.time_s:.4g} s"


def band_of(curve: Any) -> Band:
    """A CurlCurve of the server."""
    curl = np.array(curve.curl_m)
    error = np.array(curve.uncertainty_m) if curve.uncertainty_m else np.full(len(curl), np.nan)
    return Band(curve.monitor, np.array(curve.time_s), np.array(curve.cast_length_m), curl, error, error)


def structured(columns: Mapping[str, npt.NDArray[Any]]) -> Table:
    """One row for each element of the columns, which are of equal length."""
    rows = len(next(iter(columns.values()))) if columns else 0
    table: Table = np.zeros(rows, dtype=[(name, array.dtype) for name, array in columns.items()])
    for name, array in columns.items():
        table[name] = array
    return table


def _structured(columns: Mapping[str, Iterable[Any]], kinds: Mapping[str, type]) -> Table:
    return structured({name: np.asarray(list(values), dtype=kinds.get(name, np.float64))
                       for name, values in columns.items()})


def _numbers(message: Any) -> dict[str, type]:
    """The plain figures of a message, by name."""
    field = message.DESCRIPTOR.fields
    kinds: dict[int, type] = {1: np.float64, 3: np.int64, 5: np.int64, 8: np.bool_}
    return {f.name: kinds[f.type] for f in field if f.type in kinds and f.label != f.LABEL_REPEATED}


class Run:
    """The figures of a run that has steps."""

    @property
    def case(self) -> case_pb2.Case:
        """As it was run, with all defaults and the alloy card. SI and degrees Celsius."""
        raise NotImplementedError

    @property
    def steps(self) -> Sequence[job_pb2.StepReport]:
        """The accepted steps so far, each once."""
        raise NotImplementedError

    @property
    def valid_until_s(self) -> float:
        """The time from which the figures are no answer any more; infinite for a valid run."""
        raise NotImplementedError

    @property
    def monitors(self) -> list[str]:
        """The names of the points whose curl was computed."""
        return [monitor.name for monitor in self.steps[0].monitors] if self.steps else []

    @functools.cached_property
    def _bands(self) -> list[Band]:
        time = np.array([step.time_s for step in self.steps])
        length = np.array([step.cast_length_m for step in self.steps])
        bands = []
        for name in self.monitors:
            found = [next((m for m in step.monitors if m.name == name), job_pb2.MonitorValue())
                     for step in self.steps]
            bands.append(Band(name, time, length,
                              *(np.array([_figure(m, figure) for m in found]) for figure in CURL)))
        return bands

    def band(self, monitor: str = "") -> Band:
        """The curl of a monitor with its error; without a name, of the one that has curled most.

        >>> job = dccast.connect().submit("start-2d-thickness", quality="draft", time__end="20 s").wait()
        >>> job.band().monitor
        'corner'
        """
        bands = self._bands
        if not monitor and bands:
            return max(bands, key=lambda band: float(abs(np.nan_to_num(band.curl_m[-1]))))
        for band in bands:
            if band.monitor == monitor:
                return band
        raise errors.DccastError("NOT_FOUND", f"no monitor {monitor!r}; there are {self.monitors}")

    @property
    def curl(self) -> Table:
        """One row for each step; the columns are those of `dccast curl --csv`: time_s, cast_length_m, of
        each monitor NAME_curl_m, NAME_lower_error_m and NAME_upper_error_m, and beyond_validity."""
        columns: dict[str, Iterable[Any]] = {
            "time_s": [step.time_s for step in self.steps],
            "cast_length_m": [step.cast_length_m for step in self.steps]}
        for band in self._bands:
            columns[f"{band.monitor}_curl_m"] = band.curl_m
            columns[f"{band.monitor}_lower_error_m"] = band.lower_error_m
            columns[f"{band.monitor}_upper_error_m"] = band.upper_error_m
        columns["beyond_validity"] = [step.beyond_validity or step.time_s >= self.valid_until_s - 1e-9
                                      for step in self.steps]
        return _structured(columns, {"beyond_validity": np.bool_})

    def curl_frame(self) -> Any:
        """`curl` as a pandas.DataFrame, by time."""
        try:
            import pandas
        except ImportError:
            raise errors.missing("pandas", "apt install python3-pandas") from None
        return pandas.DataFrame(self.curl).set_index("time_s")

    @property
    def history(self) -> Table:
        """Every figure of every step, e.g. history["sump_depth_m"], named and explained in job.proto.
        Those of SectionFigures have its unit, which depends on the section, e.g. history["side_heat"]."""
        kinds, section = _numbers(job_pb2.StepReport), _numbers(job_pb2.SectionFigures)
        columns = {name: [getattr(step, name) for step in self.steps] for name in kinds}
        columns |= {name: [getattr(step.section, name) for step in self.steps] for name in section}
        return _structured(columns, kinds | section)

    def plot(self, monitor: str = "", axes: Any = None, label: str = "") -> Any:
        """Draws the curl with its band, and returns the matplotlib axes. See plot_curl."""
        from dccast.plots import plot_curl
        band = self.band(monitor)
        return plot_curl({label or f"{self.case.title}, {band.monitor}": band}, axes)


class Answer(Run):
    """What a query computed. Nothing of it stays on the server, unless it was kept as a job."""

    def __init__(self) -> None:
        self._case = case_pb2.Case()
        self._steps: list[job_pb2.StepReport] = []
        self.from_store = False  #: computed before: no solver ran
        self.job = ""  #: id of the job that was kept, or found; may be empty
        self.key = ""  #: names the answer to the server where there is no job
        self.state = ""  #: "SUCCEEDED", "FAILED"
        self.findings: list[job_pb2.Finding] = []
        self.validity_loss: job_pb2.Finding | None = None
        self.failure: job_pb2.Finding | None = None

    def __repr__(self) -> str:
        steps = f": {curls_text(self._steps[-1])}" if self._steps else ""
        return f"<dccast.Answer {self.state or 'RUNNING'} {self._case.title!r}{steps}>"

    @property
    def case(self) -> case_pb2.Case:
        return self._case

    @property
    def steps(self) -> Sequence[job_pb2.StepReport]:
        return self._steps

    @property
    def valid_until_s(self) -> float:
        return self.validity_loss.time_s if self.validity_loss else np.inf

    def take(self, response: Any) -> None:
        """One message of the stream."""
        kind = response.WhichOneof("what")
        if kind == "accepted":
            self._case, self.job = response.accepted.case, response.accepted.job
            self.key = response.accepted.answer
            self.from_store = response.accepted.from_store
        elif kind == "step":
            self._steps.append(response.step)
        elif kind == "finding":  # of one code the last one holds
            self.findings = [f for f in self.findings if f.code != response.finding.code]
            self.findings.append(response.finding)
        elif kind == "validity_lost":
            self.validity_loss = response.validity_lost
        elif kind == "ended":
            self.state = errors.name_of(job_pb2.JobState, response.ended.state)
            self.failure = response.ended.failure if response.ended.HasField("failure") else None
