"""The table of faults as markdown, written into a document between two marks."""
import os
import subprocess

BEGIN = "<!-- table of faults: begin; written by tests/faults/run.py, not by hand -->"
END = "<!-- table of faults: end -->"


class Row:
    def __init__(self, family, fault, count, options):
        self.family = family
        self.fault = fault
        self.count = count
        form = "--long" if options.long else "--short"
        self.command = f"tests/faults/run.py {form} --only {fault.name()} --seed {options.seed}"

    def markdown(self):
        count = self.count
        figures = ([count.tried, count.lost, count.duplicated, count.wrong] if count.tried
                   else ["not tried", "", "", ""])
        return "| " + " | ".join([self.fault.says(), *map(str, figures),
                                  f"`{self.command}`"]) + " |"


def version(programs):
    said = subprocess.run([os.path.join(programs, "dccastd"), "--version"], capture_output=True,
                          text=True, timeout=20, check=False)
    return said.stdout.strip() or "dccastd"


def table(rows, options):
    lines = [f"{version(options.bin)}, {os.cpu_count()} processors, seed {options.seed}.", "",
             "| fault | tried | lost | duplicated | wrong | command |", "|---|---|---|---|---|---|"]
    lines += [row.markdown() for row in rows]
    sums = [sum(getattr(row.count, name) for row in rows)
            for name in ("tried", "lost", "duplicated", "wrong")]
    lines.append("| all | " + " | ".join(map(str, sums)) + " | |")
    return "\n".join(lines)


def write_table(path, rows, options):
    """Replaces what stands between the marks; a file without them gets the table at its end."""
    text = ""
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            text = file.read()
    block = f"{BEGIN}\n\n{table(rows, options)}\n\n{END}"
    if BEGIN in text and END in text:
        text = text[:text.index(BEGIN)] + block + text[text.index(END) + len(END):]
    else:
        text += block + "\n"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
