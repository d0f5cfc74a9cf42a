#!/usr/bin/python3
"""A cooling block by dccast and by CalculiX, in turn: processor seconds and the lift of its centre.

    calculix_block.py BUILD [--element q1|p1] [--pairs N] [--tolerance T] [--within PERCENT] [--keep FOLDER]

BUILD is a build folder of the whole project. CalculiX is Debian's `calculix-ccx`, which nothing else needs.

The block is a thickness section, 0.28 x 0.10 m, 30 x 22 cells, that neither melts nor grows: 600 degC everywhere
at first, then cooled for 145 s in steps of 1 s, on a rigid block that it may leave. dccast's heat solver gives the
temperatures; both programs then compute the mechanics alone on the same nodes and elements at the same
instants. CalculiX has no plane elements of its own: it takes one layer of bricks (C3D8, whose mean dilatation is
that of q1) or wedges (C3D6, for p1) that is held across, on GAPUNI elements.
"""
import argparse
import json
import math
import os
import pathlib
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile

import h5py

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from waiting import until

STEPS = 145
HOT = 600.0  # [degC] at the start, below the solidus
CASE = """title = "Cooling block"
[section]
half_width = "0.28 m"
initial_depth = "0.10 m"
[mesh]
columns = 30
rows = 22
side_cell = "9.34 mm"
bottom_cell = "4.55 mm"
element = "{element}"
growth = false
[alloy]
card = "paper"
coherency_solid_fraction = 1.0
[schedule]
casting_speed = "0 mm/min"
casting_temperature = "600 degC"
water_flow = "3.0e-3 m2/s"
[[cooling.zone]]
name = "air"
from = "0 mm"
to = "65 mm"
liquid_coefficient = "150 W/(m2 K)"
solid_coefficient = "150 W/(m2 K)"
[cooling.water]
from = "65 mm"
start = "0 s"
critical_heat_flux = "4 MW/m2"
[cooling.bottom_block]
contact_coefficient = "500 W/(m2 K)"
temperature = "80 degC"
{thermal}
[mechanics]
start = "0 s"
[coupling]
gap_feedback = false
[time]
end = "145 s"
step = "1 s"
[[monitor]]
name = "centre"
x = "0 m"
y = "0 m"
[output]
frame_interval = "{frames} s"
[checkpoint]
every_steps = 0
every = "0 s"
"""


class Service:
    """A daemon in a folder of its own, and its client."""

    def __init__(self, build, folder):
        self.bin = os.path.join(os.path.abspath(build), "bin")
        self.folder = folder
        port = os.path.join(folder, "port")
        settings = {"listen.socket": f"unix:{folder}/socket", "listen.port_file": port,
                    "data_directory": os.path.join(folder, "data"), "workers.count": 1}
        words = [word for item in settings.items() for word in ("--set", "%s=%s" % item)]
        with open(os.path.join(folder, "daemon.log"), "wb") as log:
            self.daemon = subprocess.Popen([os.path.join(self.bin, "dccastd"), *words], stderr=log)
        until(lambda: os.path.exists(port) or self.daemon.poll() is not None, 15)
        if self.daemon.poll() is not None:
            raise SystemExit("dccastd does not start, see " + folder)
        with open(port, encoding="ascii") as file:
            self.address = file.read().strip()

    def client(self, *words):
        return subprocess.run([os.path.join(self.bin, "dccast"), "--server", self.address, *words],
                              check=True, capture_output=True, text=True).stdout

    def run(self, name, text):
        """The finished job, as `dccast show --json` prints it."""
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        job = json.loads(self.client("submit", "--json", path))["id"]
        self.client("wait", job)
        return job, json.loads(self.client("show", "--json", job))

    def stop(self):
        self.daemon.terminate()
        self.daemon.wait()


class Temperatures:
    """Nodes, elements and the temperatures of every step of a run with a frame each second."""

    def __init__(self, path):
        with h5py.File(path) as file:
            frames = [file["frames"][key] for key in sorted(file["frames"])]
            self.node = frames[0]["node_m"][:]
            self.element = frames[0]["element_node"][:]
            self.time = [frame.attrs["time_s"] for frame in frames]
            self.value = [frame["temperature_c"][:] for frame in frames]

    def write(self, path):
        with h5py.File(path, "w") as file:
            file["time_s"] = self.time
            file["temperature_c"] = self.value


# The paper's card, cases/alloys/paper.toml, as CalculiX takes it.
def between(table, x):
    """Linear, held at the ends."""
    x = min(max(x, table[0][0]), table[-1][0])
    for (low, a), (high, b) in zip(table, table[1:]):
        if x <= high:
            return a + (b - a) * (x - low) / (high - low)
    return table[-1][1]


def young(t):
    return between([(126.9, 67e9), (326.9, 58e9), (526.9, 40e9)], t)


def poisson(t):
    return between([(126.9, 0.3134), (326.9, 0.3448), (526.9, 0.45)], t)


def stretch(t):
    """Length over that at the liquidus [1]."""
    return (2360.0 / (2700.0 - 0.23 * t)) ** (1.0 / 3.0)


def secant_expansion(t):
    """Thermal strain between HOT and t over their distance [1/K]."""
    t = t if abs(t - HOT) > 1e-3 else HOT - 1e-3
    return (stretch(t) - stretch(HOT)) / (t - HOT)


def creep_factor(t):
    """A of `rate = A mises^5` [MPa^-5/s]: theta_0 exp(-G / (R T)) |s|^4 s in the words of von Mises' stress."""
    q, resistance, shear, energy = 6.0, 4.0e12, 15.72e6, 156063.2
    kappa = resistance / (math.sqrt(2.0) * shear) ** q * math.exp(-energy / (8.314 * (t + 273.0)))
    return 1e30 * kappa * (2.0 / 3.0) ** (q / 2.0)


def material():
    steps = range(20, 602, 4)  # CalculiX takes the creep at the temperatures of the moduli
    lines = ["*MATERIAL, NAME=METAL", "*ELASTIC"]
    lines += ["%.9g, %.9g, %g" % (1e-6 * young(t), poisson(t), t) for t in steps]
    lines += ["*EXPANSION, ZERO=%g" % HOT]
    lines += ["%.12g, %g" % (secant_expansion(t), t) for t in range(0, 601, 20)]
    lines += ["*CREEP, LAW=NORTON"]
    lines += ["%.12g, 5., 0., %g" % (creep_factor(t), t) for t in steps]
    return lines + ["*DENSITY", "2562e-12", "*SOLID SECTION, ELSET=BLOCK, MATERIAL=METAL"]


def bricks(heat):
    """Two layers of nodes a metre apart, the elements between, gaps under them [mm]."""
    count = len(heat.node)
    lines = ["*NODE, NSET=ALL"]
    for layer in (0, 1):
        lines += ["%d, %.15g, %.15g, %d" % (1 + i + layer * count, 1e3 * x, 1e3 * y, 1000 * layer)
                  for i, (x, y) in enumerate(heat.node)]
    bottom = [i for i, (_, y) in enumerate(heat.node) if abs(y) < 1e-12]
    bottom += [i + count for i in bottom]
    lines += ["*NODE, NSET=GROUND"]
    lines += ["%d, %.15g, 0, %d" % (1 + i + 2 * count, 1e3 * heat.node[i % count][0], 1000 * (i // count))
              for i in bottom]
    lines += ["*ELEMENT, TYPE=%s, ELSET=BLOCK" % ("C3D8" if heat.element.shape[1] == 4 else "C3D6")]
    for number, nodes in enumerate(heat.element):
        both = [1 + n for n in nodes] + [1 + n + count for n in nodes]
        lines.append(", ".join(str(n) for n in [number + 1] + both))
    lines += ["*ELEMENT, TYPE=GAPUNI, ELSET=GAPS"]
    first = len(heat.element) + 1
    lines += ["%d, %d, %d" % (first + k, 1 + i + 2 * count, 1 + i) for k, i in enumerate(bottom)]
    lines += ["*GAP, ELSET=GAPS", "0., 0., 1., 0."]
    axis = [1 + i for i, (x, _) in enumerate(heat.node) if abs(x) < 1e-12]
    centre = 1 + min(bottom[:len(bottom) // 2], key=lambda i: heat.node[i][0])
    lines += ["*NSET, NSET=AXIS"] + ["%d" % (i + layer * count) for i in axis for layer in (0, 1)]
    lines += ["*NSET, NSET=CENTRE", "%d" % centre]
    return lines + ["*BOUNDARY", "ALL, 3, 3", "AXIS, 1, 1", "GROUND, 1, 3"]


def amplitudes(heat):
    """The temperature of each node against time, the metre-apart pair sharing one."""
    count, lines, loads = len(heat.node), [], []
    for n in range(count):
        pairs = ["%.10g, %.10g" % (t, row[n]) for t, row in zip(heat.time, heat.value)]
        lines += ["*AMPLITUDE, NAME=T%d" % n]
        lines += [", ".join(pairs[i:i + 4]) for i in range(0, len(pairs), 4)]
        loads += ["*TEMPERATURE, AMPLITUDE=T%d" % n, "%d, 1." % (1 + n), "%d, 1." % (1 + n + count)]
    return lines, loads


def deck(heat, tolerance):
    lines, loads = amplitudes(heat)
    begin = ["*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, %g" % HOT, "GROUND, %g" % HOT]
    step = ["*STEP, INC=1000, NLGEOM=NO", "*VISCO, DIRECT, CETOL=1.", "1., %d." % STEPS]
    step += ["*CONTROLS, PARAMETERS=TIME INCREMENTATION", "60, 60, 9, 100, 10, 4, , 5, , "]
    if tolerance:
        step += ["*CONTROLS, PARAMETERS=FIELD", "%g, %g" % (tolerance, 2.0 * tolerance)]
    weight = ["*DLOAD", "BLOCK, GRAV, 9810., 0., -1., 0."]
    output = ["*NODE PRINT, NSET=CENTRE, FREQUENCY=%d" % STEPS, "U", "*END STEP"]
    return bricks(heat) + material() + begin + lines + step + weight + loads + output


def calculix(folder):
    """Processor seconds, lift of the centre [mm], iterations."""
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ended = subprocess.run(["ccx", "-i", "block"], cwd=folder, env=environment, capture_output=True, text=True,
                           check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(os.path.join(folder, "block.dat"), encoding="ascii") as file:
        rows = [line.split() for line in file if re.match(r"\s*\d+\s+[-\d]", line)]
    if not rows:
        raise SystemExit("CalculiX did not come to the end:\n" + ended.stdout[-2000:])
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, float(rows[-1][2]), len(re.findall(r"^ iteration \d", ended.stdout, re.MULTILINE))


def parsed():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--element", choices=("q1", "p1"), default="q1")
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--tolerance", type=float, help="of CalculiX, relative; absent: its own, 5e-3")
    parser.add_argument("--within", type=float, help="percent by which the lifts may differ; more ends with 1")
    parser.add_argument("--keep", help="folder for the files of both; absent: a scratch folder")
    return parser.parse_args()


def prepare(service, options, folder):
    """The temperatures, for both."""
    job, _ = service.run("heat.toml", CASE.format(thermal="", frames=1, element=options.element))
    service.client("fetch", job, "-o", os.path.join(folder, "heat.h5"), "--force")
    heat = Temperatures(os.path.join(folder, "heat.h5"))
    heat.write(os.path.join(folder, "temperature.h5"))
    with open(os.path.join(folder, "block.inp"), "w", encoding="ascii") as file:
        file.write("\n".join(deck(heat, options.tolerance)) + "\n")


def compare(options, folder):
    """One pair after the other: the last step of dccast, and what calculix() says."""
    service = Service(options.build, folder)
    try:
        prepare(service, options, folder)
        text = CASE.format(thermal='[thermal]\nfile = "temperature.h5"', frames=STEPS, element=options.element)
        for _ in range(options.pairs):
            yield service.run("block.toml", text)[1]["last_step"], calculix(folder)
    finally:
        service.stop()


def main():
    options = parsed()
    if shutil.which("ccx") is None:
        raise SystemExit("there is no ccx: install Debian's calculix-ccx")

    ratios, apart = [], 0.0
    with tempfile.TemporaryDirectory(prefix="calculix-block-") as scratch:
        for step, (seconds, lift, iterations) in compare(options, options.keep or scratch):
            ratios.append((seconds / step["process_s"], seconds / step["solver_s"]))
            ours = 1e3 * step["monitors"][0]["displacement_m"][1]
            apart = max(apart, 100.0 * abs(ours / lift - 1.0))
            print("dccast %.3f s (solver %.3f), centre %.4f mm; CalculiX %.2f s, %d iterations, centre %.4f mm" % (
                step["process_s"], step["solver_s"], ours, seconds, iterations, lift), flush=True)
    print("CalculiX over dccast, medians: whole process %.1f, solver %.1f" % tuple(
        statistics.median(column) for column in zip(*ratios)))
    if options.within is not None and apart > options.within:
        raise SystemExit(f"the lifts of the centre differ by {apart:.1f} %; {options.within:g} % are permitted")


if __name__ == "__main__":
    main()
