#!/usr/bin/python3
"""Does a lever do what the advice of a forecast states? (docs/forecasts.md)

    advice_runs.py CASE [--at 30 60] [--members 64] [--quality engineering] [--server ADDRESS]

The casting under way is the plan itself at another quality, whose curl is read every second. What the advice
states at the times asked for is compared with runs at that quality whose levers are moved then, at equal cast
length. The daemon must be running; the studies are kept and taken up again by the same command.
"""
import argparse
import sys

import grpc
import numpy

import forecast_castings
from dccast.v1 import case_pb2, follow_pb2, options_pb2, service_pb2, service_pb2_grpc, study_pb2

# Words of the advice, key of the schedule, factor on its table, and what is added to it.
LEVERS = (("cast 10 % slower", "casting_speed", 0.9, 0.0),
          ("cast 10 % faster", "casting_speed", 1.1, 0.0),
          ("use 20 % less water", "water_flow", 0.8, 0.0),
          ("use 20 % more water", "water_flow", 1.2, 0.0),
          ("pour 10 K colder", "casting_temperature", 1.0, -10.0),
          ("pour 10 K hotter", "casting_temperature", 1.0, 10.0))
UNITS = {"casting_speed": ("_m_per_s", "m/s"), "water_flow": ("_m2_per_s", "m2/s"),
         "casting_temperature": ("_c", "degC")}
JUMP = 1e-3  # s


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case")
    parser.add_argument("--at", type=float, nargs="+", default=[30, 60], help="s")
    parser.add_argument("--members", type=int, default=64, help="of the ensemble on which the forecast rests")
    parser.add_argument("--quality", default="engineering", help="of the casting")
    parser.add_argument("--monitor", default="corner")
    parser.add_argument("--server", default="unix:/run/dccast/dccastd.sock")
    parser.add_argument("--dccast", default="dccast")
    return parser.parse_args()


class Plan:
    """The case with its tables against time."""

    def __init__(self, options):
        with open(options.case, encoding="utf-8") as file:
            request = service_pb2.ReadCaseRequest(text=file.read())
        self.case = options.stub.ReadCase(request, timeout=30).case
        self.end = self.case.time.end_s

    def table(self, key):
        curve = getattr(self.case.schedule, key + UNITS[key][0])
        if len(curve.value) > 1 and curve.abscissa != options_pb2.TIME:
            sys.exit(f"schedule.{key} must be a table against time")
        return numpy.array(curve.at if len(curve.value) > 1 else [0.0]), numpy.array(curve.value)

    def moved(self, key, begin, factor, offset):
        """The table of a lever that is moved, as in a case file."""
        at, value = self.table(key)
        then = lambda t: numpy.interp(t, at, value)
        points = [(t, then(t)) for t in [*at[at < begin - JUMP], begin - JUMP]]
        points += [(t, factor * then(t) + offset) for t in [begin, *at[at > begin]]]
        texts = (f"[{float(t)!r} s, {float(v)!r} {UNITS[key][1]}]" for t, v in points)
        return "[" + ", ".join(texts) + "]"

    def end_of(self, key, begin, factor):
        """When the length of the plan is cast."""
        if key != "casting_speed":
            return self.end
        times = numpy.arange(0, 2 * self.end, 0.01)
        speed = numpy.interp(times, *self.table(key))
        length = lambda v: numpy.concatenate([[0], numpy.cumsum(0.5 * (v[1:] + v[:-1]) * 0.01)])
        moved = length(numpy.where(times < begin, 1.0, factor) * speed)
        return float(numpy.interp(numpy.interp(self.end, times, length(speed)), moved, times))


def until_ended(options, study):
    for _ in options.stub.WatchStudy(study_pb2.WatchStudyRequest(id=study)):
        pass
    request = study_pb2.EvaluateStudyRequest(id=study, curves=True)
    return options.stub.EvaluateStudy(request, timeout=60)


def advised(options, plan, measured):
    """By time and words: what the forecast states of a casting with this curl."""
    study = options.stub.CreateStudy(study_pb2.CreateStudyRequest(
        request_id=f"advice-runs-levers-{plan.case.title}", case=plan.case, levers=study_pb2.LeversPlan()),
                                     timeout=30)
    until_ended(options, study.id)
    ensemble, _ = forecast_castings.study(options, 0, options.members, "draft")

    case = case_pb2.Case()
    case.CopyFrom(plan.case)
    case.quality = case_pb2.DRAFT
    gauge = follow_pb2.Gauge(monitor=options.monitor, noise_m=1e-3)
    job = options.stub.SubmitJob(service_pb2.SubmitJobRequest(case=case, following=follow_pb2.Following(
        ensemble=ensemble, levers=study.id, gauges=[gauge])), timeout=60).id
    stated = {}
    for t in range(int(max(options.at)) + 1):
        curl = numpy.interp(t, measured.time_s, numpy.nan_to_num(measured.curl_m))
        options.stub.AppendReadings(follow_pb2.AppendReadingsRequest(id=job, readings=[follow_pb2.Reading(
            number=t + 1, time_s=t, curls=[follow_pb2.MeasuredCurl(monitor=options.monitor, curl_m=curl)])]),
                                    timeout=30)
        if t not in options.at:
            continue
        forecast = options.stub.ForecastJob(follow_pb2.ForecastJobRequest(id=job), timeout=30)
        end = forecast.curls[0]
        print(f"at {t} s the {options.monitor} is forecast to end at {1e3 * end.curl_m[-1]:.1f} mm "
              f"({1e3 * end.lower_m[-1]:.1f} to {1e3 * end.upper_m[-1]:.1f}); " + "; ".join(forecast.advice))
        for lever in forecast.levers:
            stated[t, lever.words] = lever
    options.stub.CancelJob(service_pb2.CancelJobRequest(id=job), timeout=30)
    return stated


def computed(options, plan, asked):
    """The curl of the plan; for each lever asked for more curl [m], and findings that the plan has not."""
    keys = list(UNITS)
    itself = {key: plan.moved(key, 0.0, 1.0, 0.0) for key in keys}
    rows = [{**itself, "end": plan.end}]
    for begin, (_, key, factor, offset) in asked:
        rows.append({**itself, key: plan.moved(key, begin, factor, offset),
                     "end": plan.end_of(key, begin, factor)})
    request = study_pb2.CreateStudyRequest(
        request_id=f"advice-runs-{options.quality}-{plan.case.title}", case=plan.case)
    request.case.quality = case_pb2.Quality.Value(options.quality.upper())
    request.sweep.design = study_pb2.SweepPlan.LIST
    for key in keys:
        request.sweep.axes.add(key=f"schedule.{key}", values=[row[key] for row in rows])
    request.sweep.axes.add(key="time.end", values=[f"{row['end']:.2f} s" for row in rows])
    study = options.stub.CreateStudy(request, timeout=60)
    runs = until_ended(options, study.id).runs
    curves = [next(c for c in run.curves if c.monitor == options.monitor) for run in runs]
    base = curves[0]
    effects = []
    codes = lambda run: {f.code for f in run.findings if f.severity > 1}
    for run, curve in zip(runs[1:], curves[1:]):
        length = min(curve.cast_length_m[-1], base.cast_length_m[-1])
        at = lambda c: numpy.interp(length, c.cast_length_m, numpy.nan_to_num(c.curl_m))
        effects.append((at(curve) - at(base), sorted(codes(run) - codes(runs[0]))))
    return base, effects


def main():
    options = arguments()
    options.stub = service_pb2_grpc.SimulationServiceStub(grpc.insecure_channel(options.server))
    plan = Plan(options)
    asked = [(begin, lever) for lever in LEVERS for begin in sorted(options.at)]
    measured, effects = computed(options, plan, asked)
    stated = advised(options, plan, measured)
    inside = 0
    print(f"{'lever':20} {'at s':>5} {'stated mm':>10} {'band':>14} {options.quality + ' mm':>15}")
    for (begin, lever), (curl, findings) in zip(asked, effects):
        ahead = stated[begin, lever[0]]
        effect = ahead.curls[0]
        inside += effect.lower_m <= curl <= effect.upper_m
        band = f"{1e3 * effect.lower_m:+.1f} to {1e3 * effect.upper_m:+.1f}"
        print(f"{lever[0]:20} {begin:5.0f} {1e3 * effect.curl_m:+10.2f} {band:>14} {1e3 * curl:+15.2f}  "
              f"worse: {', '.join(ahead.worse) or '-'}; in this casting: {', '.join(findings) or '-'}")
    print(f"{inside} of {len(asked)} inside their band")
    return 0


if __name__ == "__main__":
    sys.exit(main())
