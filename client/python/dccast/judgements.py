"""What the server concludes from runs: sentences, tables and charts."""
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from dccast import errors
from dccast.runs import Table, structured
from dccast.v1 import job_pb2, judgement_pb2


def _suffix(unit: str) -> str:
    """"_m_per_s" for "m/s"; nothing for pure numbers and shares."""
    plain = {"degC": "c", "1": ""}.get(unit, unit).replace("/", "_per_").replace(" ", "_").lower()
    return f"_{plain}" if plain else ""


def _cells(column: Any, cell: Any) -> Iterator[tuple[str, Any]]:
    """The figures of a cell by their names, which carry the unit."""
    suffix = _suffix(column.unit or cell.unit)
    if cell.HasField("value"):
        yield column.key + suffix, cell.value
        if cell.HasField("until"):
            yield f"{column.key}_until{suffix}", cell.until
        if cell.code:
            yield f"{column.key}_code", cell.code
    elif text := cell.text or cell.case_value or cell.code:
        yield column.key, text
    if column.has_error:
        known = cell.HasField("upper_error")
        yield f"{column.key}_lower_error{suffix}", cell.lower_error if known else np.nan
        yield f"{column.key}_upper_error{suffix}", cell.upper_error if known else np.nan


def table_of(message: judgement_pb2.Table) -> Table:
    """A table as a structured array: columns named by key and unit, in SI and degrees Celsius. A number
    that is not known is NaN, a text empty."""
    rows = [dict(figure for column, cell in zip(message.columns, row.cells)
                 for figure in _cells(column, cell)) for row in message.rows]
    names = dict.fromkeys(name for row in rows for name in row)
    columns = {}
    for name in names:
        texts = any(isinstance(row.get(name), str) for row in rows)
        columns[name] = np.array([row.get(name, "" if texts else np.nan) for row in rows])
    return structured(columns)


class Judgement:
    """Sentences, tables by their keys, charts. Printed, it is its sentences."""

    def __init__(self, message: judgement_pb2.Judgement) -> None:
        self.message = message  #: as in judgement.proto, with the charts and all properties of columns

    def __repr__(self) -> str:
        return "\n".join([self.message.heading, *self.sentences])

    @property
    def sentences(self) -> list[str]:
        """The conclusion, the most important first."""
        return list(self.message.sentences)

    @property
    def tables(self) -> dict[str, Table]:
        """What it rests on, by key: one row each, columns with their units in the name."""
        return {part.table.key: table_of(part.table) for part in self.message.parts
                if part.HasField("table")}

    @property
    def charts(self) -> list[judgement_pb2.Chart]:
        """Lines with their bands, in SI (judgement.proto)."""
        return [part.chart for part in self.message.parts if part.HasField("chart")]


@dataclass(frozen=True)
class Difference:
    """The curl of one monitor in a run less that in the first one."""

    run: int  #: from 2, as the runs were given
    monitor: str
    difference_m: float
    error_m: float  #: that of the pair, by mesh and time steps; NaN: not known
    verdict: str  #: "real", "within_its_error", "no_difference", "of_unknown_error"

    @property
    def is_real(self) -> bool:
        """Larger than its error."""
        return self.verdict == "real"


class Comparison(Judgement):
    """Runs compared with the first one.

    >>> service = dccast.connect()
    >>> runs = [service.query("start-2d-thickness", quality="draft", time__end="20 s",
    ...                       schedule__casting_speed=f"{speed} mm/min") for speed in (40, 80)]
    >>> service.compare(*runs).differences[0].verdict in ("real", "within_its_error")
    True
    """

    def __init__(self, message: judgement_pb2.Comparison) -> None:
        super().__init__(message.judgement)
        self.runs = list(message.runs)  #: name, job, title, state, findings of each

    @property
    def differences(self) -> list[Difference]:
        """Of every monitor and every run but the first."""
        table = self.tables.get("differences")
        if table is None:
            return []
        return [Difference(int(row["run"]), str(row["monitor"]), float(row["difference_m"]),
                           float(row["difference_upper_error_m"]), str(row["verdict"]))
                for row in table if row["verdict"]]

    @property
    def states(self) -> list[str]:
        """"SUCCEEDED", "FAILED", ... of each run."""
        return [errors.name_of(job_pb2.JobState, run.state) for run in self.runs]
