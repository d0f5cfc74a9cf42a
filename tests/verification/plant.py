#!/usr/bin/python3
"""A plant that casts what a job has computed, and measures it as plants do (docs/following.md).

    plant.py JOB [--pace 50] [--server ADDRESS] | dccast follow CASE --zero "2 mm" --line pit-3

JOB is the hidden casting: a run of the plan with other data (`dccast submit --set ...`), at any quality. Its
levers and its curl are written as a table, a line for each second of casting, at the pace of the plant or
faster, with the errors that the options name. What was done wrong goes to standard error at the end.
"""
import argparse
import math
import pathlib
import random
import sys
import time

import grpc
import numpy

from dccast.v1 import options_pb2, service_pb2, service_pb2_grpc

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from waiting import wait_for_clock


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("job")
    parser.add_argument("--server", default="unix:/run/dccast/dccastd.sock")
    parser.add_argument("--monitor", default="corner")
    parser.add_argument("--pace", type=float, default=1.0, help="how many times faster than the casting; 0: at once")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--model-error", type=float, default=0.0, help="standard deviation of a factor on the curl")
    parser.add_argument("--noise-mm", type=float, default=1.0)
    parser.add_argument("--zero-mm", type=float, default=0.0, help="standard deviation of the gauge's zero")
    parser.add_argument("--drift-mm", type=float, default=0.0, help="what the gauge drifts in 100 s")
    parser.add_argument("--slip", default="", help="SECOND:MM, when the gauge slips and by how much")
    for name, what in (("dropouts", "begins a gap of 2 to 20 s"), ("late", "comes after the next one"),
                       ("doubled", "comes twice"), ("empty", "has no curl")):
        parser.add_argument("--" + name, type=float, default=0.0, help="probability that a line " + what)
    return parser.parse_args()


class Casting:
    """What is cast: the levers of a job's case, and the length and the curl that it has computed."""

    def __init__(self, options):
        stub = service_pb2_grpc.SimulationServiceStub(grpc.insecure_channel(options.server))
        answer = stub.QueryResult(service_pb2.QueryResultRequest(id=options.job), timeout=60)
        self.schedule = answer.case.schedule
        steps = list(answer.steps)
        while answer.next_page_token:
            answer = stub.QueryResult(service_pb2.QueryResultRequest(
                id=options.job, page_token=answer.next_page_token), timeout=60)
            steps += answer.steps

        begin = -self.schedule.hold_s
        self.times = range(math.ceil(begin), int(steps[-1].time_s) + 1)
        self.time_s = [begin] + [step.time_s for step in steps]
        self.length_m = [0.0] + [step.cast_length_m for step in steps]
        self.curl_m = [0.0] + [next((each.curl_m for each in step.monitors
                                     if each.name == options.monitor), 0.0) for step in steps]

    def length_mm(self, t):
        return 1e3 * numpy.interp(t, self.time_s, self.length_m)

    def curl_mm(self, t):
        return 1e3 * numpy.interp(t, self.time_s, numpy.nan_to_num(self.curl_m))

    def value_of(self, curve, t):
        """A lever at a time; its table stands against time or cast length."""
        if len(curve.value) < 2:
            return curve.value[0] if curve.value else 1.0  # of a factor that is absent
        place = 1e-3 * self.length_mm(t) if curve.abscissa == options_pb2.CAST_LENGTH else t
        return numpy.interp(place, curve.at, curve.value)

    def water_l_per_min_m(self, t):
        per_l_per_min_m = 6e4
        schedule = self.schedule
        flow = self.value_of(schedule.water_flow_m2_per_s, t - schedule.water_flow_shift_s)
        return per_l_per_min_m * self.value_of(schedule.water_flow_factor, t) * flow

    def speed_m_per_s(self, t):
        schedule = self.schedule
        speed = self.value_of(schedule.casting_speed_m_per_s, t - schedule.casting_speed_shift_s)
        return self.value_of(schedule.casting_speed_factor, t) * speed if t > 0 else 0.0

    def metal_c(self, t):
        return self.value_of(self.schedule.casting_temperature_c, t)


class Gauge:
    """What is shown for a curl."""

    def __init__(self, options, chance):
        self.options, self.chance = options, chance
        self.factor = 1.0 + chance.gauss(0, options.model_error)
        self.zero_mm = chance.gauss(0, options.zero_mm)
        second, _, slip = options.slip.partition(":")
        self.slip = (float(second), float(slip)) if slip else (math.inf, 0.0)

    def shown_mm(self, curl_mm, t):
        drift = self.options.drift_mm * max(t, 0) / 100.0
        slip = self.slip[1] if t >= self.slip[0] else 0.0
        return self.factor * curl_mm + self.zero_mm + drift + slip + self.chance.gauss(0, self.options.noise_mm)


class Plant:
    """Lines in the order in which a faulty logger writes them, and what it did wrong."""

    def __init__(self, options):
        self.options, self.chance = options, random.Random(options.seed)
        self.casting, self.gauge = Casting(options), Gauge(options, self.chance)
        self.wrong = {"dropouts": 0, "late": 0, "doubled": 0, "empty": 0}

    def happens(self, fault):
        if self.chance.random() >= getattr(self.options, fault):
            return False
        self.wrong[fault] += 1
        return True

    def line(self, t):
        curl = "" if self.happens("empty") else "%.3f" % self.gauge.shown_mm(self.casting.curl_mm(t), t)
        return "%d, %.3f, %.3f, %.2f, %s" % (t, self.casting.length_mm(t), self.casting.water_l_per_min_m(t),
                                            self.casting.metal_c(t), curl)

    def lines(self):
        """Yields (second, line)."""
        yield self.casting.times[0], "time [s], cast length [mm], water [l/min/m], metal [degC], curl %s [mm]" % (
            self.options.monitor)
        gap_end, held = -math.inf, None
        for t in self.casting.times:
            text = self.line(t)
            if t < gap_end:
                continue
            if self.happens("dropouts"):
                gap_end = t + self.chance.randint(2, 20)
                continue
            if held is None and self.happens("late"):
                held = text
                continue
            for each in [text] * (2 if self.happens("doubled") else 1) + ([held] if held else []):
                yield t, each
            held = None


def main():
    options = arguments()
    plant = Plant(options)
    begin, first = time.monotonic(), plant.casting.times[0]
    for t, line in plant.lines():
        due = begin + (t - first) / options.pace if options.pace > 0 else begin
        wait_for_clock(due)
        print(line, flush=True)
    print("factor %.3f, zero %.2f mm; %s" % (plant.gauge.factor, plant.gauge.zero_mm, ", ".join(
        "%d %s" % (count, fault) for fault, count in plant.wrong.items())), file=sys.stderr)


if __name__ == "__main__":
    main()
