#!/usr/bin/python3
"""Checks the record of castings, and scores predictions of any code against it.

    record.py check                      every entry, against what README.md promises
    record.py seal PREDICTION            writes PREDICTION.sha256: do it before you compare
    record.py score PREDICTION...        scores; a prediction without its sum is refused
    record.py page [--check] FILE PREDICTION     writes the table between the marks of a page of Markdown

Needs Python alone. Exit codes: 0 well; 1 a fault in entry or prediction; 2 wrong usage.

Scores, all of them smaller when better (Gneiting and Raftery 2007; Bracher and others 2021):
    rms         of median less measured, in the unit of the measurement
    interval    width of 5..95 % plus 20 times what the measured value lies outside of it
    weighted    mean over median and all intervals of the prediction, weighted by their share
"""
import argparse
import hashlib
import json
import math
import pathlib
import sys
from dataclasses import dataclass

FOLDER = pathlib.Path(__file__).resolve().parent
LEAST_UNSEEN = 5  # entries below which a share of hits says nothing
BEGIN, END = "<!-- record -->\n", "<!-- end of record -->\n"


class Fault(Exception):
    """An entry or a prediction that cannot be used."""


@dataclass
class Measured:
    """What is known of a measured value: that it lies in [low, high], both in its unit."""
    low: float
    high: float

    @property
    def middle(self):
        return 0.5 * (self.low + self.high)

    def mean_below(self, bound):
        """Mean of (bound - x) where x < bound, x uniform in [low, high]."""
        if self.high == self.low:
            return max(bound - self.low, 0.0)
        return (max(bound - self.low, 0.0) ** 2 - max(bound - self.high, 0.0) ** 2) / (2 * (self.high - self.low))

    def mean_above(self, bound):
        return Measured(-self.high, -self.low).mean_below(-bound)

    def mean_distance(self, point):
        return self.mean_below(point) + self.mean_above(point)

    def share_inside(self, low, high):
        if self.high == self.low:
            return 1.0 if low <= self.low <= high else 0.0
        return max(min(self.high, high) - max(self.low, low), 0.0) / (self.high - self.low)


def measured_of(figure):
    """The interval of a figure of an entry; None where there is no number."""
    if "low" in figure:
        return Measured(figure["low"], figure["high"])
    if figure.get("value") is None:
        return None
    scatter = figure["scatter"] or 0.0
    return Measured(figure["value"] - scatter, figure["value"] + scatter)


def interval_score(measured, low, high, share):
    """Score of the interval that is to hold `share` of what is measured; mean over what is known of the value."""
    return high - low + 2.0 / (1.0 - share) * (measured.mean_below(low) + measured.mean_above(high))


def weighted_score(measured, quantiles):
    """Weighted interval score of a median and central intervals. @param quantiles  {level: value}"""
    lows = [level for level in quantiles if level < 0.5]
    total = 0.5 * measured.mean_distance(quantiles[0.5])
    for level in lows:
        outside = 2.0 * level
        score = interval_score(measured, quantiles[level], quantiles[round(1 - level, 10)], 1 - outside)
        total += 0.5 * outside * score
    return total / (len(lows) + 0.5)


@dataclass
class Score:
    """Of one entry in one unit. Lists have an item for each measured figure."""
    entry: dict
    unit: str
    errors: list
    intervals: list
    weighted: list
    shares: list  # of what is known of the value, inside 5..95 %
    shown: list  # (figure, quantiles)

    @property
    def rms(self):
        return math.sqrt(sum(e * e for e in self.errors) / len(self.errors))

    @property
    def covered(self):
        return sum(self.shares) / len(self.shares)


def read(path):
    """@raises Fault  no JSON, or no such file"""
    try:
        return json.loads(pathlib.Path(path).read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise Fault(f"{path}: {error}") from error


def entries():
    return {path.stem: read(path) for path in sorted(FOLDER.glob("entries/*.json"))}


def faults_of(stem, entry):
    """What the schema of an entry cannot say."""
    if entry["name"] != stem:
        yield f"name is {entry['name']}; it must be that of the file"
    names = [figure["name"] for figure in entry["measured"]]
    for name in {name for name in names if names.count(name) > 1}:
        yield f"measured: {name} stands twice; give each a name of its own"
    for item in entry["cast"] + entry["measured"]:
        if item.get("source", next(iter(entry["sources"]))) not in entry["sources"]:
            yield f"{item.get('what', item.get('name'))}: source {item['source']} is none of its sources"
        if "low" in item and not item["low"] <= item["high"]:
            yield f"{item.get('what', item.get('name'))}: low is {item['low']}; it must not exceed high"
    if "points" in entry and not (FOLDER / entry["points"]).is_file():
        yield f"points: there is no {entry['points']}"
    unread = [f for f in entry["measured"] if "statement" not in f and measured_of(f) is None]
    if unread and "not_read" not in entry:
        yield f"measured: {unread[0]['name']} has no value; not_read must say what could not be read"


def check():
    """@return faults, as texts"""
    return [f"{stem}: {fault}" for stem, entry in entries().items() for fault in faults_of(stem, entry)]


def sum_of(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def sum_file(path):
    return pathlib.Path(f"{path}.sha256")


def seal(path):
    """Writes the sum of a prediction beside it, as sha256sum(1) does, and returns it."""
    prediction(path)
    sum_file(path).write_text(f"{sum_of(path)}  {pathlib.Path(path).name}\n", "utf-8")
    return sum_of(path)


def prediction(path):
    """{(entry, measurement): {level: value}} and the file. @raises Fault  not as prediction.schema.json has it"""
    made = read(path)
    known = entries()
    predicted = {}
    for item in made.get("predictions", []):
        try:
            key = item["entry"], item["measurement"]
            quantiles = {float(level): value for level, value in item["quantiles"].items()}
            names = [figure["name"] for figure in known[key[0]]["measured"] if "statement" not in figure]
        except (KeyError, TypeError, ValueError) as error:
            raise Fault(f"{path}: predictions: {item}: {error} is missing, or none of the record") from error
        if key[1] not in names:
            raise Fault(f"{path}: {key[0]} has no figure {key[1]}; it has {', '.join(names)}")
        if not {0.05, 0.5, 0.95} <= set(quantiles) <= {0.05, 0.25, 0.5, 0.75, 0.95} or (
                (0.25 in quantiles) != (0.75 in quantiles)):
            raise Fault(f"{path}: {key[0]} {key[1]}: quantiles must be 0.05, 0.5 and 0.95, with both of 0.25 and 0.75 "
                        "or none")
        ordered = [quantiles[level] for level in sorted(quantiles)]
        if ordered != sorted(ordered) or not all(math.isfinite(value) for value in ordered):
            raise Fault(f"{path}: {key[0]} {key[1]}: quantiles must be finite and must not fall: {ordered}")
        if key in predicted:
            raise Fault(f"{path}: {key[0]} {key[1]} is predicted twice; keep one")
        predicted[key] = quantiles
    return predicted, made


def sealed(path):
    """As `prediction`. @raises Fault  its sum is missing, or is that of another file"""
    result = prediction(path)
    if not sum_file(path).is_file():
        raise Fault(f"{path}: there is no {sum_file(path)}; seal a prediction before it is compared: record.py seal")
    if sum_file(path).read_text("utf-8").split()[0] != sum_of(path):
        raise Fault(f"{path}: it is not the file that was sealed; its sum differs from {sum_file(path)}")
    return result


def scores(predicted):
    """Scores of all entries with a figure that was measured and predicted."""
    found = []
    for name, entry in entries().items():
        by_unit = {}
        for figure in entry["measured"]:
            measured, quantiles = measured_of(figure), predicted.get((name, figure["name"]))
            if measured is None or quantiles is None:
                continue
            score = by_unit.setdefault(figure["unit"], Score(entry, figure["unit"], [], [], [], [], []))
            score.errors.append(quantiles[0.5] - measured.middle)
            score.intervals.append(interval_score(measured, quantiles[0.05], quantiles[0.95], 0.9))
            score.weighted.append(weighted_score(measured, quantiles))
            score.shares.append(measured.share_inside(quantiles[0.05], quantiles[0.95]))
            score.shown.append((figure, quantiles))
        found += by_unit.values()
    return found


def coverage(of):
    """What 5..95 % hold of the entries that were not seen, each with one vote."""
    unseen = {}
    for score in of:
        if not score.entry["seen"]:
            unseen.setdefault(score.entry["name"], []).extend(score.shares)
    if len(unseen) < LEAST_UNSEEN:
        return f"Coverage is not stated: {len(unseen)} entries were predicted unseen, {LEAST_UNSEEN} are needed."
    held = sum(sum(shares) / len(shares) for shares in unseen.values()) / len(unseen)
    return f"5..95 % hold {100 * held:.0f} % of {len(unseen)} unseen entries; 90 % are wanted."


def mean(values):
    return sum(values) / len(values)


def number(value):
    return f"{value:.3g}"


def table(of):
    """Markdown; what covers least comes first."""
    lines = ["| entry | seen | unit | figures | rms | interval score | weighted score | inside 5..95 % |",
             "|---|---|---|---|---|---|---|---|"]
    for score in sorted(of, key=lambda score: score.covered):
        lines.append("| %s | %s | %s | %d | %s | %s | %s | %.1f |" % (
            score.entry["name"], "yes" if score.entry["seen"] else "no", score.unit, len(score.errors),
            number(score.rms), number(mean(score.intervals)), number(mean(score.weighted)), sum(score.shares)))
    return "\n".join(lines)


def told(figure):
    """A measured figure as a reader wants it."""
    if "statement" in figure:
        return figure["statement"].rstrip(".")
    value = measured_of(figure)
    if value is None:
        return f"{figure['quantity']}: not read"
    shown = f"{value.low:g} to {value.high:g}" if value.high > value.low else f"{value.low:g}"
    return f"{figure['quantity']}: {shown} {figure['unit']}"


def measured_cell(entry, figures):
    if len(figures) > 3:
        return f"{len(figures)} figures ([entry](../tests/record/entries/{entry['name']}.json))"
    return "; ".join(told(figure) for figure in figures)


def computed_cell(score):
    if len(score.shown) > 3:
        return "rms %s %s; %.1f of %d inside 5..95 %%" % (number(score.rms), score.unit, sum(score.shares),
                                                          len(score.shares))
    return "; ".join("%s (%s to %s) %s" % (number(q[0.5]), number(q[0.05]), number(q[0.95]), figure["unit"])
                     for figure, q in score.shown)


def verdict(entry, of):
    """How a row is led by: missed first, then predicted, then what has no score."""
    if not of:
        has_number = any("statement" not in f and measured_of(f) for f in entry["measured"])
        return (2, "not predicted") if has_number else (3, "no number to compare")
    covered = mean([share for score in of for share in score.shares])
    how = "seen before" if entry["seen"] else "predicted blind"
    return (0, f"**missed** ({how})") if covered <= 0.5 else (1, how)


def page_table(predicted, made):
    by_entry = {}
    for score in scores(predicted):
        by_entry.setdefault(score.entry["name"], []).append(score)
    rows = []
    for name, entry in entries().items():
        of = by_entry.get(name, [])
        rank, words = verdict(entry, of)
        rows.append((rank, "| %s | %s | %s | %s | %s |" % (
            entry["title"], measured_cell(entry, entry["measured"]), "; ".join(map(computed_cell, of)) or "-", words,
            " ".join([made.get("answers", {}).get(name, ""), "Not read: " + entry["not_read"] if "not_read" in entry
                      else ""]).strip())))
    head = ["| entry | measured | computed: median (5 to 95 %) | verdict | comment |", "|---|---|---|---|---|"]
    return "\n".join(head + [row for _, row in sorted(rows, key=lambda row: row[0])]) + "\n\n" + coverage(
        [score for of in by_entry.values() for score in of]) + "\n"


def write_page(page, made, only_check):
    """@return exit code"""
    text = pathlib.Path(page).read_text("utf-8")
    if BEGIN not in text or END not in text:
        raise Fault(f"{page}: the marks {BEGIN.strip()} and {END.strip()} are missing")
    before, rest = text.split(BEGIN, 1)
    new = before + BEGIN + "\n" + page_table(*sealed(made)) + "\n" + END + rest.split(END, 1)[1]
    if only_check and new != text:
        raise Fault(f"{page}: its table is not that of record and prediction; write it anew")
    if not only_check:
        pathlib.Path(page).write_text(new, "utf-8")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("check")
    commands.add_parser("seal").add_argument("prediction")
    commands.add_parser("score").add_argument("prediction", nargs="+")
    page = commands.add_parser("page")
    page.add_argument("--check", action="store_true", help="write nothing; 1 where the page differs")
    page.add_argument("page")
    page.add_argument("prediction")
    return parser.parse_args()


def main():
    options = arguments()
    try:
        if options.command == "check":
            faults = check()
            print("\n".join(faults) if faults else f"{len(entries())} entries")
            return 1 if faults else 0
        if options.command == "seal":
            print(seal(options.prediction))
        elif options.command == "page":
            write_page(options.page, options.prediction, options.check)
        else:
            for path in options.prediction:
                predicted, made = sealed(path)
                of = scores(predicted)
                print(f"{made['code']} {made['version']}, {sum_of(path)}\n\n{table(of)}\n\n{coverage(of)}")
    except Fault as fault:
        print(fault, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
