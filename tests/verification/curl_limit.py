#!/usr/bin/python3
"""What the curl of start-2d-thickness tends to, and what each mesh, step and element is off it.

    curl_limit.py VERIFY FOLDER [--finest 4]

VERIFY is the program dccast-verify. The curve of each run is kept in FOLDER and not computed again. Prints the
tables of docs/developers/discretisation.md: studies of the mesh and of the steps, each with its order, and error
against seconds.
"""
import argparse
import csv
import math
import os
import re
import subprocess

GRADED = []
UNIFORM = ["--columns", "30", "--rows", "44", "--growth-cell", "5e-3"]
MESHES = {"30 x 22, graded to 3 mm": GRADED, "30 x 44, uniform": UNIFORM}


class Run:
    """The curl against time and the processor seconds of one run of `dccast-verify history`."""

    def __init__(self, study, *options):
        path = os.path.join(study.folder, re.sub(r"[^a-z0-9._]+", "-", " ".join(options) or "plain")) + ".csv"
        said = path[:-4] + ".txt"
        if not os.path.exists(said):
            environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
            text = subprocess.run([study.verify, "history", *options, "-o", path], env=environment, check=True,
                                  capture_output=True, text=True).stdout
            with open(said, "w", encoding="utf-8") as file:
                file.write(text)
        with open(said, encoding="utf-8") as file:
            text = file.read()
        self.nodes, self.steps = (int(re.search(word + r" (\d+)", text)[1]) for word in ("nodes", "steps"))
        self.seconds = float(re.search(r"cpu ([0-9.]+)", text)[1])
        with open(path, encoding="utf-8", newline="") as file:
            rows = [row for row in csv.reader(file)][1:]
        self.time, self.curl = ([float(row[i]) for row in rows] for i in (0, 1))

    def at(self, t):
        """Linear in time [mm]."""
        low, high = 0, len(self.time) - 1
        if t >= self.time[high]:
            return self.curl[high]
        if t <= self.time[low]:
            return self.curl[low]
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.time[middle] <= t else (low, middle)
        share = (t - self.time[low]) / (self.time[high] - self.time[low])
        return self.curl[low] + share * (self.curl[high] - self.curl[low])


class Study:
    def __init__(self, verify, folder):
        self.verify, self.folder = os.path.abspath(verify), folder
        os.makedirs(folder, exist_ok=True)

    def run(self, mesh, refinement=1, steps=1, element="q1_bending"):
        return Run(self, "--element", element, "--refinement", str(refinement), "--divide-steps", str(steps), *mesh)


LEVELS = (1, 2, 4)  # by which cells are divided
INSTANTS = [0.25 * i for i in range(1, 581)]  # [s] from the start of casting to the end


def history(run):
    return [run.at(t) for t in INSTANTS]


def root_mean_square(curve):
    return math.sqrt(sum(value * value for value in curve) / len(curve))


def off(curve, limit):
    """Root mean square of what a history is off another, over that of the other [1]."""
    return root_mean_square([a - b for a, b in zip(curve, limit)]) / root_mean_square(limit)


def extrapolated(curves):
    """Limit and order of the last three of curves whose cells or steps halve.

    One ratio for the whole history, by least squares, the order then kept between 1/2 and 1 as in docs/error-bars.md.
    """
    coarse, middle, fine = curves[-3:]
    earlier = [b - a for a, b in zip(coarse, middle)]
    later = [b - a for a, b in zip(middle, fine)]
    ratio = sum(a * b for a, b in zip(earlier, later)) / sum(a * a for a in earlier)
    if not 0.0 < ratio < 1.0:
        return fine, None
    order = -math.log2(ratio)
    rest = 1.0 / (2.0 ** min(max(order, 0.5), 1.0) - 1.0)
    return [c + rest * ratio * d for c, d in zip(fine, earlier)], order


def order_of_ends(ends):
    """Of the last three [1]; none where they do not close in."""
    ratio = (ends[-1] - ends[-2]) / (ends[-2] - ends[-3])
    return -math.log2(ratio) if 0.0 < ratio < 1.0 else None


def text_of(order):
    return "-" if order is None else "%.2f" % order


def study_row(label, runs):
    """One line of a table. @return the limit of the history, the last level where it has no order"""
    ends = [run.curl[-1] for run in runs]
    limit, order = extrapolated([history(run) for run in runs])
    print("| %s | %s | %s | %s | %s | %.0f |" % (
        label, ", ".join("%.3f" % end for end in ends), text_of(order_of_ends(ends)), text_of(order),
        "-" if order is None else "%.3f" % limit[-1], runs[-1].seconds))
    return limit


def studies(study, finest):
    """Mesh at fixed steps, then steps at a fixed mesh."""
    print("| study | end of the curl by level [mm] | order of the ends | of the histories | limit [mm] | finest [s] |")
    print("|---|---|---|---|---|---|")
    for name, mesh in MESHES.items():
        levels = (*LEVELS, 8) if finest == 8 and mesh is GRADED else LEVELS
        study_row("cells of %s divided by %s" % (name, ", ".join(map(str, levels))),
                  [study.run(mesh, level) for level in levels])
    study_row("steps on 30 x 44 divided by 1, 2, 4, 8", [study.run(UNIFORM, steps=n) for n in (1, 2, 4, 8)])


def without_steps(study, mesh, refinement):
    """The history that the steps tend to on a mesh. They are of first order, so that steps divided by 4 still have a
    third of what they differ by from undivided ones."""
    undivided, divided = (history(study.run(mesh, refinement, steps=n)) for n in (1, 4))
    print("%s, divided by %d, steps by 1, 4: %.3f, %.3f mm" % (
        "uniform" if mesh is UNIFORM else "graded", refinement, undivided[-1], divided[-1]))
    return [b + (b - a) / 3 for a, b in zip(undivided, divided)]


def best(study, finest):
    """The converged history: the mean of what the steps tend to on the finest mesh of each family."""
    print()
    uniform, graded = without_steps(study, UNIFORM, 4), without_steps(study, GRADED, finest)
    print("\nThey tend to %.3f and %.3f mm at the end; the two histories differ by %.1f %% (rms).\n" % (
        uniform[-1], graded[-1], 100 * off(graded, uniform)))
    return [(a + b) / 2 for a, b in zip(uniform, graded)]


def error_row(label, run, limit):
    end = run.curl[-1] / limit[-1] - 1.0
    print("| %s | %d | %d | %.1f | %.3f | %+.1f %% | %.1f %% |" % (
        label, run.nodes, run.steps, run.seconds, run.curl[-1], 100 * end, 100 * off(history(run), limit)))


def errors(study, limit):
    print("| element and mesh | nodes at the end | steps | processor [s] | end [mm] | end, error | history, rms |")
    print("|---|---|---|---|---|---|---|")
    for element in ("p1", "q1", "q1_bending"):
        for refinement in LEVELS:
            error_row("`%s`, refinement %d" % (element, refinement),
                      study.run(GRADED, refinement, element=element), limit)
    for refinement in LEVELS:
        error_row("`q1_bending` on 30 x 44, refinement %d" % refinement, study.run(UNIFORM, refinement), limit)
    for quality in ("draft", "engineering", "fine"):
        error_row(quality, study.run(["--quality", quality]), limit)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("verify")
    parser.add_argument("folder")
    parser.add_argument("--finest", type=int, choices=(4, 8), default=4, help="graded cells; 8: 11 min more")
    options = parser.parse_args()
    study = Study(options.verify, options.folder)
    studies(study, options.finest)
    errors(study, best(study, options.finest))


if __name__ == "__main__":
    main()
