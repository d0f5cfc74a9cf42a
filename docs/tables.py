"""Computes the tables of figures in pages anew, for docs/samples. A mark stands above its table:

    <!-- table slow
    case start-3d-aa3104.toml quality=engineering
    columns corner | change of corner | findings
    -
    schedule.water_flow.scale=0.8
    schedule.casting_speed.scale=0.8; schedule.casting_speed.scale=1.2
    -->

`case` names the case of all rows and what is changed in each; `columns` the figure of every column after the
first, with changes of its own, or `-` where the cells stay as they are written. Then one line for each row:
what it changes, as for --set; `-` for nothing; a word that ends in .toml is a case of its own. Runs between
semicolons share the cells of their row.

Figures:
    MONITOR                 its curl at the end [mm]
    change of MONITOR       that against the first row, in percent
    MONITOR against COLUMN  the curl, and how far it is from the first number of that column, in percent
    least FIELD             smallest value of a field of StepReport while the block moves; of a length in mm
    sum of FIELD            over all steps
    last FIELD              at the end; of a length in mm
    findings                codes of the findings beyond notes, without those that are open
A run that fails has the code of its failure in place of each.

`.0` behind a figure sets its decimals, else 1 of a length, none of the others. The Python package is that of
build/release/python, or of $DCCAST_PYTHON.

Other tables of figures have programs of their own: tests/verification/write_tables.sh, curl_limit.py,
forecast_castings.py, advice_runs.py and line_castings.py; tests/faults/run.py --table, queries.py; tests/fuzz/run
--table; tests/benchmark.
"""
import functools
import os
import pathlib
import re
import shlex
import sys
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parent.parent
MARK = re.compile(r"<!-- table(?P<words>[^\n]*)\n(?P<spec>(?:[^\n]+\n)+?)-->\n\n?(?P<table>(?:\|[^\n]*\n)+)")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
LENGTH = "_m"


class Runs:
    """Castings computed by a daemon, each once."""

    def __init__(self, address, folder):
        self.address, self.folder = address, folder
        self.jobs = {}

    @functools.cached_property
    def service(self):
        sys.path.insert(0, os.environ.get("DCCAST_PYTHON", str(ROOT / "build/release/python")))
        import dccast  # of the build, which a page without a table does not need
        return dccast.connect(self.address)

    def job(self, case, changes):
        """The job of a casting, which is queued at its first mention."""
        key = (case, tuple(changes))
        if key not in self.jobs:
            changed = dict(change.split("=", 1) for change in changes)
            self.jobs[key] = self.service.submit(str(self.folder / case), changed)
        return self.jobs[key]


def curl_mm(run, monitor):
    return 1e3 * run.band(monitor).curl_m[-1]


def percent(value, base):
    """How far a value is from another, "+3 %"."""
    return f"{round(100 * (value / base - 1)):+d} %".replace("+0 %", "0 %")


def figure(words, run, first, against):
    """One figure of a run, as a text. @param against  number of the row in a column of the page"""
    decimals = [int(word[1:]) for word in words if re.fullmatch(r"\.\d", word)]
    words = [word for word in words if not re.fullmatch(r"\.\d", word)]

    def written(value, usual):
        return f"{value:,.{decimals[0] if decimals else usual}f}"

    if words == ["findings"]:
        return ", ".join(f.code for f in run.findings
                         if f.severity > f.NOTE and f.certainty != f.OPEN) or "none"
    if words[:2] == ["change", "of"]:
        return "" if run is first else percent(curl_mm(run, words[2]), curl_mm(first, words[2]))
    if words[:2] == ["sum", "of"]:
        return written(sum(getattr(step, words[2]) for step in run.steps), 0)
    if words[0] in ("least", "last"):
        values = [getattr(step, words[1]) for step in run.steps if step.cast_length_m > 0]
        value = min(values) if words[0] == "least" else values[-1]
        return written(1e3 * value, 1) if words[1].endswith(LENGTH) else written(value, 0)

    value = curl_mm(run, words[0])
    if words[1:2] == ["against"]:
        return f"{written(value, 1)}, {percent(value, against)}"
    return written(value, 1)


def of_job(words, job, first, against):
    """One figure of a job; of one that failed, the code of its failure."""
    run = job.wait(check=False)
    if run.state == "FAILED":
        return run.message.failure.code
    return figure(words, run, first, against)


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def case_in(words, usual):
    return next((word for word in words if word.endswith(".toml")), usual)


def changes_in(words):
    return [word for word in words if "=" in word]


@dataclass
class Table:
    """A table of a page, and the runs of its rows and columns."""

    case: list[str]  # words of all runs
    columns: list[list[str]]  # words of each column after the first
    rows: list[list[list[str]]]  # words of the runs of each row
    head: list[str]
    rule: str
    body: list[list[str]]

    def changes(self, row_run, column):
        """Those of the column come last: it may set another time or quality than its row."""
        return [*changes_in(self.case), *changes_in(row_run), *changes_in(column)]

    def text(self):
        lines = ["| " + " | ".join(cells) + " |" for cells in (self.head, *self.body)]
        return "\n".join([lines[0], self.rule, *lines[1:]]).replace("|  |", "| |") + "\n"


def table_of(mark):
    """@raises ValueError  the mark does not fit its table"""
    case, columns, *rows = [line for line in mark["spec"].split("\n") if line.strip()]
    head, rule, *body = mark["table"].rstrip("\n").split("\n")
    table = Table(case=shlex.split(case.removeprefix("case ")),
                  columns=[shlex.split(column) for column in columns.removeprefix("columns ").split("|")],
                  rows=[[shlex.split(run) for run in row.split(";")] for row in rows],
                  head=cells_of(head), rule=rule, body=[cells_of(line) for line in body])
    if len(table.rows) != len(table.body) or len(table.columns) != len(table.head) - 1:
        raise ValueError(f"{len(table.rows)} rows and {len(table.columns)} columns are marked, the table has "
                         f"{len(table.body)} and {len(table.head) - 1}: {head}")
    return table


def renewed(mark, runs):
    """The text of a mark and its table, with the figures of now."""
    table = table_of(mark)
    usual = case_in(table.case, "")
    computed = {i: column for i, column in enumerate(table.columns, start=1) if column != ["-"]}
    # All are queued before the first is waited for.
    jobs = [{i: [runs.job(case_in(run, usual), table.changes(run, column)) for run in row]
             for i, column in computed.items()} for row in table.rows]

    for row, cells in zip(jobs, table.body):
        for i, column in computed.items():
            words = [word for word in column if "=" not in word]
            against = None
            if "against" in words:
                of_column = cells[table.head.index(words[words.index("against") + 1])]
                against = float(NUMBER.search(of_column)[0])
            between = "; " if words == ["findings"] else ", "
            cells[i] = between.join(of_job(words, job, jobs[0][i][0], against) for job in row[i])
    return mark[0].replace(mark["table"], table.text())
