"""The table of faults as markdown, written into a document between two marks.

A row that is tried again takes the place of the one before; the others stay. So the table can be renewed
in parts, also by several runs at once.
"""
import fcntl
import os
import re
import subprocess

BEGIN = "<!-- table of faults: begin; written by tests/faults/run.py, not by hand -->"
END = "<!-- table of faults: end -->"
HEAD = ["| fault | tried | lost | duplicated | wrong | seconds | `run.py --only` |",
        "|---|---|---|---|---|---|---|"]
ROW = re.compile(r"^\| .* \| (\d+) \| (\d+) \| (\d+) \| (\d+) \| \d+ \| `([\w-]+) .*` \|$")


def markdown(fault, count, seconds, options):
    """The row of a fault. Its last cell goes on from the head of the table, see `table`."""
    command = f"{fault.name()} --seed {options.seed}" + ("" if options.long else " --short")
    measured = "".join(f"; {value:.3g} {unit}" for unit, value in count.figures.items())
    figures = [count.tried, count.lost, count.duplicated, count.wrong, round(seconds)]
    return "| " + " | ".join([fault.says() + measured, *map(str, figures), f"`{command}`"]) + " |"


def version(programs):
    said = subprocess.run([os.path.join(programs, "dccastd"), "--version"], capture_output=True,
                          text=True, timeout=20, check=False)
    return said.stdout.strip() or "dccastd"


def table(rows, options):
    """@param rows  markdown by name of the fault, in the order of --list"""
    sums = [sum(int(ROW.match(row).group(figure)) for row in rows.values()) for figure in (1, 2, 3, 4)]
    lines = [f"{version(options.bin)}, {os.cpu_count()} processors.",
             "`tests/faults/run.py --only` with the last cell makes a row again, with `--long` unless the",
             "cell says `--short`.", "", *HEAD, *rows.values(),
             "| all | " + " | ".join(map(str, sums)) + " | | |"]
    return "\n".join(lines)


def rows_in(text):
    found = {}
    for line in text.splitlines():
        if row := ROW.match(line):
            found[row.group(5)] = line
    return found


def write_row(path, name, row, order, options):
    """Puts one row into the table between the marks; a file without them gets the table at its end.

    @param order  names of all faults, as --list gives them
    """
    with open(path, "a+", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        file.seek(0)
        text = file.read()
        begin, end = text.find(BEGIN), text.find(END)
        if begin < 0 or end < 0:
            begin = end = len(text)
        rows = {**rows_in(text[begin:end]), name: row}
        rows = {known: rows[known] for known in order if known in rows}
        block = f"{BEGIN}\n\n{table(rows, options)}\n\n{END}"
        rest = text[end + len(END):] if end < len(text) else "\n"
        file.truncate(0)
        file.write(text[:begin] + block + rest)
