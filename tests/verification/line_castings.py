#!/usr/bin/python3
"""Do castings on a line make the forecast of the next one better? (docs/forecasts.md)

    line_castings.py CASE [--lines 3] [--castings 10] [--other KEY=VALUE] [--server ADDRESS]

A line has hidden data, drawn once from their ranges, and a factor from the band of mesh and time steps.
Each casting on it draws a share of every range anew (--scatter), and the zero of its gauge; its curl is
read every second with noise. After 0, 1, 3, 5 and 10 castings on the recipe of the case, the forecast
before the casting is compared with the castings that follow on the line: on this recipe, and on another
(the case with --other). Beside it stand the mean of the earlier castings, for the other recipe plus the
difference of the two ensembles, and their means without any casting.

The daemon must be running; the studies are kept and found again by the same command.
"""
import argparse
import hashlib
import random
import sys
import time

import grpc
import numpy

import forecast_castings
from dccast.v1 import follow_pb2, job_pb2, line_pb2, service_pb2, service_pb2_grpc, study_pb2

AFTER = (0, 1, 3, 5, 10)
APART_S = 10  # of the times at which a forecast is compared


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case")
    parser.add_argument("--lines", type=int, default=3)
    parser.add_argument("--castings", type=int, default=10, help="on each line")
    parser.add_argument("--members", type=int, default=64)
    parser.add_argument("--other", default="schedule.casting_speed.scale=1.2",
                        help="what another recipe changes of the case")
    parser.add_argument("--scatter", type=float, default=0.2,
                        help="share of each range that a casting draws anew")
    parser.add_argument("--monitor", default="corner")
    parser.add_argument("--noise-mm", type=float, default=1.0)
    parser.add_argument("--zero-mm", type=float, default=2.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--server", default="unix:/run/dccast/dccastd.sock")
    parser.add_argument("--dccast", default="dccast")
    return parser.parse_args()


class Recipe:
    """A case and its ensemble."""

    def __init__(self, options, changes):
        self.options = options
        with open(options.case, encoding="utf-8") as file:
            text = file.read()
        self.changes = [job_pb2.CaseChange(key=key, value=value)
                        for key, value in (each.split("=", 1) for each in changes)]
        self.changes.append(job_pb2.CaseChange(key="quality", value="draft"))
        self.case = options.stub.ReadCase(service_pb2.ReadCaseRequest(
            text=text, changes=self.changes), timeout=30).case
        ensemble, _ = forecast_castings.study(options, 0, options.members, "draft", changes)
        self.ensemble = options.stub.GetStudy(study_pb2.GetStudyRequest(id=ensemble), timeout=30)
        members = self.curves(self.ensemble)
        self.times = numpy.arange(APART_S, min(curve[0][-1] for curve in members.values()) + 1e-6,
                                  APART_S)
        self.mean = numpy.mean([numpy.interp(self.times, *curve) for curve in members.values()], axis=0)

    def study(self, plan):
        """A study of the recipe, when it has ended."""
        stub = self.options.stub
        request = study_pb2.CreateStudyRequest(case=self.case, sweep=plan, changes=self.changes)
        request.request_id = hashlib.sha256(request.SerializeToString(deterministic=True)).hexdigest()
        study = stub.CreateStudy(request, timeout=60)
        for study in stub.WatchStudy(study_pb2.WatchStudyRequest(id=study.id)):
            pass
        return study

    def curves(self, study):
        """Times and curls of the runs of a study that count, by their number."""
        request = study_pb2.EvaluateStudyRequest(id=study.id, curves=True)
        result = self.options.stub.EvaluateStudy(request, timeout=120)
        self.band = next(((run.mesh_error.lower, run.mesh_error.upper) for run in result.runs
                          if run.HasField("mesh_error")), (0.0, 0.0))
        found = {}
        for number, run in enumerate(result.runs):
            if run.state != job_pb2.SUCCEEDED or run.beyond_validity:
                continue
            curve = next(each for each in run.curves if each.monitor == self.options.monitor)
            found[number] = (numpy.array(curve.time_s), numpy.nan_to_num(numpy.array(curve.curl_m)))
        return found

    def castings(self, data):
        """Curves of hidden castings. @param data  (casting, axis) 0 to 1 of each range"""
        plan = study_pb2.SweepPlan(design=study_pb2.SweepPlan.LIST,
                                   purpose=study_pb2.SweepPlan.UNCERTAINTY)
        for number, axis in enumerate(self.ensemble.sweep.axes):
            low, high = (value.split(maxsplit=1) for value in axis.values)
            ends = float(low[0]), float(high[0])
            unit = low[1:]
            plan.axes.add(key=axis.key, values=[
                " ".join([repr(ends[0] + share * (ends[1] - ends[0]))] + unit)
                for share in data[:, number]])
        return self.curves(self.study(plan))


def forecast_before(options, recipe, line):
    """A job on the line, and its forecast before the first reading."""
    gauge = follow_pb2.Gauge(monitor=options.monitor, noise_m=1e-3 * options.noise_mm,
                             zero_m=1e-3 * options.zero_mm)
    job = options.stub.SubmitJob(service_pb2.SubmitJobRequest(
        case=recipe.case, following=follow_pb2.Following(
            ensemble=recipe.ensemble.id, gauges=[gauge], line=line)), timeout=60).id
    curl = options.stub.ForecastJob(follow_pb2.ForecastJobRequest(id=job), timeout=60).curls[0]
    at = lambda values: numpy.interp(recipe.times, curl.time_s, values)
    return job, at(curl.curl_m), at(curl.lower_m), at(curl.upper_m), curl.line


def end(options, job):
    """Ends a job, and waits until it has ended."""
    options.stub.CancelJob(service_pb2.CancelJobRequest(id=job), timeout=30)
    for _ in options.stub.WatchJob(service_pb2.WatchJobRequest(id=job), timeout=60):
        pass


def cast(options, job, curve, shots):
    """Sends the readings of a casting. Returns what was measured, at every second."""
    zero = shots.gauss(0, 1e-3 * options.zero_mm)
    times = numpy.arange(0, int(curve[0][-1]) + 1)
    measured = numpy.array([numpy.interp(t, *curve) + zero + shots.gauss(0, 1e-3 * options.noise_mm)
                            for t in times])
    readings = [follow_pb2.Reading(number=i + 1, time_s=t, curls=[follow_pb2.MeasuredCurl(
        monitor=options.monitor, curl_m=curl)]) for i, (t, curl) in enumerate(zip(times, measured))]
    options.stub.AppendReadings(follow_pb2.AppendReadingsRequest(id=job, readings=readings), timeout=60)
    return times, measured


class Errors:
    """Of forecasts against the castings that followed, by the number of castings before them."""

    def __init__(self):
        self.rows = {after: [] for after in AFTER}

    def add(self, after, recipe, forecast, simple, truths):
        _, curl, lower, upper, _ = forecast
        for truth in truths:
            come = numpy.interp(recipe.times, *truth)
            self.rows[after].append((curl - come, recipe.mean - come, simple - come,
                                     (lower <= come) & (come <= upper), upper - lower))

    def print(self, name):
        rms = lambda values: 1e3 * numpy.sqrt(numpy.mean(numpy.square(values)))
        print(f"{name}: rms mm of the forecast before the casting, every {APART_S} s and at the end")
        print(f"{'castings':>8} {'forecast':>15} {'plan':>15} {'earlier mean':>15} {'90 % holds':>11} "
              f"{'width mm':>9}")
        for after, rows in self.rows.items():
            if not rows:
                continue
            both = [f"{rms([row[i] for row in rows]):.2f} / {rms([row[i][-1] for row in rows]):.2f}"
                    for i in range(3)]
            held = 100 * numpy.mean([row[3] for row in rows])
            width = 1e3 * numpy.mean([row[4] for row in rows])
            print(f"{after:>8} {both[0]:>15} {both[1]:>15} {both[2] if after else '-':>15} "
                  f"{held:>9.0f} % {width:>9.1f}")


def run_line(options, number, recipes, truths, errors):
    """One line: castings on the first recipe; forecasts for both before each."""
    shots = random.Random(1000 * options.seed + number)
    line = f"verification-{options.seed}-{number}-{int(time.time())}"
    measured = []
    memory = None
    for casting in range(options.castings + 1):
        following = [{i: curve for i, curve in of.items() if i >= casting} for of in truths]
        job = None
        for recipe, error, truth in zip(reversed(recipes), reversed(errors), reversed(following)):
            if recipe is recipes[1] and casting not in AFTER:
                continue
            if job:
                end(options, job)
            forecast = forecast_before(options, recipe, line)
            job, memory = forecast[0], forecast[4]
            if casting in AFTER:
                mean = numpy.mean(measured, axis=0) if measured else recipes[0].mean
                simple = numpy.interp(recipe.times, recipes[0].times, mean - recipes[0].mean) + recipe.mean
                error.add(casting, recipe, forecast, simple, truth.values())
        if casting < options.castings and casting in truths[0]:
            read = cast(options, job, truths[0][casting], shots)
            measured.append(numpy.interp(recipes[0].times, *read))
        end(options, job)
    print(f"line {number + 1}: {memory.castings} castings count, scatter {100 * memory.scatter:.0f} % of "
          f"the variance, model error {100 * memory.model_error:.1f} %", flush=True)
    options.stub.DeleteLine(line_pb2.DeleteLineRequest(id=line), timeout=30)


def main():
    options = arguments()
    options.stub = service_pb2_grpc.SimulationServiceStub(grpc.insecure_channel(options.server))
    recipes = [Recipe(options, []), Recipe(options, [options.other])]

    # Data of all castings, as shares of their ranges.
    shots = numpy.random.default_rng(options.seed)
    axes = len(recipes[0].ensemble.sweep.axes)
    count = options.castings + 1
    shared = shots.random((options.lines, 1, axes))
    data = (1 - options.scatter) * shared + options.scatter * shots.random((options.lines, count, axes))
    lower, upper = recipes[0].band
    factors = 1 + shots.uniform(-lower, upper, options.lines)
    hidden = [recipe.castings(data.reshape(-1, axes)) for recipe in recipes]

    errors = Errors(), Errors()
    for number in range(options.lines):
        truths = [{run - number * count: (curve[0], factors[number] * curve[1])
                   for run, curve in of.items() if number * count <= run < (number + 1) * count}
                  for of in hidden]
        run_line(options, number, recipes, truths, errors)
    print(f"{options.lines} lines of {options.castings} castings; {len(hidden[0])} and {len(hidden[1])} of "
          f"{options.lines * count} hidden runs count")
    errors[0].print("the same recipe")
    errors[1].print(f"another recipe, {options.other}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
