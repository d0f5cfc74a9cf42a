#!/usr/bin/python3
"""How good is the forecast of a casting that is followed? (docs/forecasts.md)

    forecast_castings.py CASE [--castings 60] [--members 64] [--quality draft] [--pairs] [--cast KEY=VALUE]
                         [--server ADDRESS]

Hidden castings are runs of the plan with data drawn from their ranges by another seed, times a factor
from the band of mesh and time steps of their quality, which a real casting has too. Their curl is
read every second with noise; every 10 s the forecast for 30, 60 and 120 s ahead is compared with what
came, beside the mean of the ensemble and that mean plus the last difference. The daemon must be
running; the studies are kept and taken up again by the same command.

With --pairs the ensemble is that of `dccast follow --prepare`, with its runs at engineering quality. With
--unprepared there is none: the forecast is a draft of the plan plus the last difference.

With --cast the hidden castings leave the plan. Their levers are read too, and the followed run computes what
these do; with --blind the forecast takes the levers as planned.

With --fault-at SECOND it is counted how soon a warning follows a fault: --slip-mm of the gauge, or what
--cast does from then on, whose levers are then not read (--unreported). A gauge that is wrong by --gauge-scale
has its fault at 0.
"""
import argparse
import collections
import math
import pathlib
import random
import re
import subprocess
import sys
import types
import zlib

import grpc
import numpy

import plant
from dccast.v1 import case_pb2, follow_pb2, job_pb2, service_pb2, service_pb2_grpc, study_pb2
from waiting import until

AHEAD = (30, 60, 120)
PHASES = (("all", 20, 1e9), ("20..60 s", 20, 61), ("70..100 s", 70, 101), ("110 s on", 110, 1e9))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case")
    parser.add_argument("--castings", type=int, default=60)
    parser.add_argument("--members", type=int, default=64)
    parser.add_argument("--quality", default="draft", help="of the hidden castings")
    parser.add_argument("--pairs", action="store_true", help="tell the error of the mesh by pairs")
    parser.add_argument("--unprepared", action="store_true", help="forecast by the run of the plan alone")
    parser.add_argument("--cast", action="append", default=[], metavar="KEY=VALUE",
                        help="what is cast instead of the plan, e.g. schedule.water_flow.scale=0.7")
    parser.add_argument("--blind", action="store_true", help="the forecast takes the levers as planned")
    parser.add_argument("--unreported", action="store_true", help="the levers are not read")
    parser.add_argument("--fault-at", type=float, metavar="SECOND", help="when a fault begins")
    parser.add_argument("--slip-mm", type=float, default=0.0, help="the gauge slips by it at --fault-at")
    parser.add_argument("--gauge-scale", type=float, default=1.0, help="what the gauge shows over the curl")
    parser.add_argument("--monitor", default="corner")
    parser.add_argument("--noise-mm", type=float, default=1.0)
    parser.add_argument("--zero-mm", type=float, default=0.0, help="standard deviation, hidden")
    parser.add_argument("--model-error", type=float, default=0.0,
                        help="standard deviation of a factor on the hidden curl")
    parser.add_argument("--server", default="unix:/run/dccast/dccastd.sock")
    parser.add_argument("--dccast", default="dccast")
    options = parser.parse_args()
    if options.gauge_scale != 1.0:
        options.fault_at = 0.0
    return options


def study(options, seed, runs, quality, changes=()):
    """Runs of the plan, or of a changed one, with drawn data. Returns (id, curves of those that count)."""
    key = f"forecast-{pathlib.Path(options.case).stem}-{seed}-{runs}-{quality}"
    if changes:
        key += f"-{zlib.crc32(repr(changes).encode()):08x}"
    changed = [word for change in changes for word in ("--set", change)]
    command = [options.dccast, "--server", options.server, "uncertainty", "--json"]

    there = with_label(options, key)
    if there:
        command += ["--study", there.id]
    else:
        command += [options.case, "--set", f"quality={quality}", *changed, "--runs", str(runs), "--seed",
                    str(seed), "--label", key]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    found = there or with_label(options, key)
    return found.id, curves_of(options, found.id)


def with_label(options, label):
    """The newest study with a label; None if there is none."""
    request = study_pb2.ListStudiesRequest(labels=[label], page_size=1)
    return next(iter(options.stub.ListStudies(request, timeout=30).studies), None)


def prepared(options):
    """Studies of `dccast follow --prepare`: its ensemble and its pairs."""
    said = subprocess.run([options.dccast, "--server", options.server, "follow", "--prepare",
                           options.case], check=True, capture_output=True, text=True).stderr
    return re.findall(r"^study (\S+), \d+ runs$", said, re.MULTILINE)[:2]


def evaluated(options, study):
    request = study_pb2.EvaluateStudyRequest(id=study, curves=True)
    return options.stub.EvaluateStudy(request, timeout=120)


def mesh_band_of(options, study):
    """How far the true curl may lie below and above that of the runs, relative to it."""
    error = next((run.mesh_error for run in evaluated(options, study).runs
                  if run.HasField("mesh_error")), None)
    return (error.lower, error.upper) if error else (0.0, 0.0)


def curves_of(options, study):
    """Times and curls of the runs of a study that count."""
    result = evaluated(options, study)
    curves = [curve for run in result.runs if run.state == 4 and not run.beyond_validity
              for curve in run.curves if curve.monitor == options.monitor]
    return [(numpy.array(c.time_s), numpy.nan_to_num(numpy.array(c.curl_m))) for c in curves]


def plan_case(options):
    with open(options.case, encoding="utf-8") as file:
        case = options.stub.ReadCase(service_pb2.ReadCaseRequest(text=file.read()), timeout=30).case
    case.quality = case_pb2.DRAFT
    return case


def run_of_plan(options):
    """A draft of the plan that has succeeded. Returns (id, its curve)."""
    job = options.stub.SubmitJob(service_pb2.SubmitJobRequest(case=plan_case(options)), timeout=60).id
    for _ in options.stub.WatchJob(service_pb2.WatchJobRequest(id=job)):
        pass
    answer = options.stub.QueryResult(service_pb2.QueryResultRequest(id=job), timeout=60)
    points = [(step.time_s, next(each.curl_m for each in step.monitors if each.name == options.monitor))
              for step in answer.steps]
    return job, tuple(numpy.nan_to_num(numpy.array(column)) for column in zip(*points))


def followed(options, **basis):
    """A job that holds the record of a casting."""
    gauge = follow_pb2.Gauge(monitor=options.monitor, noise_m=1e-3 * options.noise_mm,
                             zero_m=1e-3 * options.zero_mm)
    return options.stub.SubmitJob(service_pb2.SubmitJobRequest(
        case=plan_case(options), following=follow_pb2.Following(gauges=[gauge], **basis)), timeout=60).id


def levers_of(options, study):
    """The levers of its first run: what is read at a time besides the curl."""
    job = evaluated(options, study).runs[0].job
    casting = plant.Casting(types.SimpleNamespace(server=options.server, monitor=options.monitor, job=job))
    return lambda t: {"casting_speed_m_per_s": casting.speed_m_per_s(t),
                      "water_flow_m2_per_s": casting.water_l_per_min_m(t) / 6e4,
                      "casting_temperature_c": casting.metal_c(t)}


def wait_for_run(options, job, t):
    """Until the run that follows the casting is near the last reading: a step is up to 2 s long."""
    def is_near():
        now = options.stub.GetJob(service_pb2.GetJobRequest(id=job), timeout=30)
        return now.last_step.time_s >= t - 2 or now.state not in (job_pb2.RUNNING, job_pb2.QUEUED)
    until(is_near, 60, every_s=0.1)


def errors_of(options, basis, mean, truth, band, shots, levers=None):
    """Rows (t, ahead, forecast, plan, last difference, within its band, width of it) of one hidden
    casting [m], and its warnings."""
    at = lambda t: numpy.interp(t, *truth)
    plan = lambda t: numpy.interp(t, *mean)
    zero = shots.gauss(0, 1e-3 * options.zero_mm)
    factor = (1 + shots.gauss(0, options.model_error)) * (1 + shots.uniform(-band[0], band[1]))
    job = followed(options, **basis)
    rows = []
    end = int(truth[0][-1])
    for t in range(0, end - min(AHEAD)):
        slip = 1e-3 * options.slip_mm if options.fault_at is not None and t >= options.fault_at else 0.0
        measured = options.gauge_scale * (factor * at(t) + zero + slip
                                          + shots.gauss(0, 1e-3 * options.noise_mm))
        curl = follow_pb2.MeasuredCurl(monitor=options.monitor, curl_m=measured)
        options.stub.AppendReadings(follow_pb2.AppendReadingsRequest(
            id=job, readings=[follow_pb2.Reading(number=t + 1, time_s=t, curls=[curl],
                                                 **(levers(t) if levers else {}))]), timeout=30)
        if t < 20 or t % 10:
            continue
        if levers:
            wait_for_run(options, job, t)
        whole = options.stub.ForecastJob(follow_pb2.ForecastJobRequest(id=job), timeout=30)
        forecast = whole.curls[0]
        for ahead in AHEAD:
            s = t + ahead
            if s > end:
                continue
            come = factor * at(s)
            value = numpy.interp(s, forecast.time_s, forecast.curl_m)
            lower, upper = (numpy.interp(s, forecast.time_s, end)
                            for end in (forecast.lower_m, forecast.upper_m))
            rows.append((t, ahead, value - come, plan(s) - come,
                         plan(s) + measured - plan(t) - come, lower <= come <= upper, upper - lower))
    options.stub.CancelJob(service_pb2.CancelJobRequest(id=job), timeout=30)
    return numpy.array(rows, dtype=float), list(whole.warnings)


def print_warnings(options, outcomes):
    """Which castings had warnings; where there is a fault, how soon it was found."""
    begin = math.inf if options.fault_at is None else options.fault_at
    without_cause = [[each for each in warnings if each.time_s < begin] for _, warnings in outcomes]
    print(f"{sum(map(bool, without_cause))} of {len(outcomes)} had warnings without a cause")
    for warnings in filter(None, without_cause):
        print("  " + "; ".join(each.text for each in warnings))
    if begin == math.inf:
        return

    first = [next((each for each in warnings if each.time_s >= begin), None) for _, warnings in outcomes]
    found = [each for each in first if each]
    after = numpy.median([each.time_s - begin for each in found]) if found else math.nan
    print(f"the fault was found in {len(found)} of {len(outcomes)}, after {after:.0f} s (median)")
    for cause, count in collections.Counter(each.causes[0] for each in found).most_common():
        print(f"  {count}: {cause}")


def main():
    options = arguments()
    channel = grpc.insecure_channel(options.server)
    options.stub = service_pb2_grpc.SimulationServiceStub(channel)
    if options.unprepared:
        job, curve = run_of_plan(options)
        basis, members = {"plan_job": job}, [curve]
    elif options.pairs:
        ensemble, pairs = prepared(options)
        basis, members = {"ensemble": ensemble, "pairs": pairs}, curves_of(options, ensemble)
    else:
        ensemble, members = study(options, 0, options.members, "draft")
        basis = {"ensemble": ensemble}
    hidden, truths = study(options, 1, options.castings, options.quality, options.cast)
    levers = levers_of(options, hidden) if options.cast and not options.unreported else None
    if levers and not options.blind:
        basis["plan_job"] = run_of_plan(options)[0]
    band = mesh_band_of(options, hidden)
    times = numpy.arange(0, members[0][0][-1])
    mean = (times, numpy.mean([numpy.interp(times, *member) for member in members], axis=0))

    shots = random.Random(1)
    outcomes = [errors_of(options, basis, mean, truth, band, shots, levers) for truth in truths]
    castings = [rows for rows, _ in outcomes]
    print(f"{len(castings)} castings, {len(members)} members")
    print_warnings(options, outcomes)
    print("rms mm at 30 / 60 / 120 s ahead; share of 90 % bands that hold, and their width in mm, at 60 s")
    for name, begin, stop in PHASES:
        cells = []
        for column in (2, 3, 4):
            values = []
            for ahead in AHEAD:
                chosen = numpy.concatenate([c[(c[:, 1] == ahead) & (c[:, 0] >= begin) & (c[:, 0] < stop),
                                              column] for c in castings])
                values.append(f"{1e3 * numpy.sqrt(numpy.mean(chosen ** 2)):.1f}" if len(chosen) else "-")
            cells.append(" / ".join(values))
        at_60 = [c[(c[:, 1] == 60) & (c[:, 0] >= begin) & (c[:, 0] < stop)] for c in castings]
        held = [numpy.mean(c[:, 5]) for c in at_60 if len(c)]
        width = 1e3 * numpy.mean(numpy.concatenate([c[:, 6] for c in at_60]))
        print(f"{name:10} forecast {cells[0]:18} plan {cells[1]:18} last difference {cells[2]:18} "
              f"{100 * numpy.mean(held):.0f} +- {164.5 * numpy.std(held) / len(held) ** 0.5:.0f} %, "
              f"{width:.1f} mm")
    return 0


if __name__ == "__main__":
    sys.exit(main())
