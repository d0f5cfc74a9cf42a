#!/usr/bin/python3
"""How long after a reading is what follows from it known? (docs/forecasts.md)

    follow_latency.py CASE [--quality draft] [--seconds 120] [--server ADDRESS]

Sends a reading each second, as a plant does, and waits for the steps that it permits. A step that ends at a
time of the casting cannot begin before a reading of that time has come; the delay of a step runs from there to
its arrival at a client. The readings before --begin are sent at once.
"""
import argparse
import pathlib
import sys
import threading
import time

import grpc
import numpy

from dccast.v1 import case_pb2, follow_pb2, service_pb2, service_pb2_grpc

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from waiting import until, wait_for_clock


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case")
    parser.add_argument("--quality", default="draft", choices=("draft", "engineering"))
    parser.add_argument("--begin", type=int, default=60, help="second of casting at which the plant is live")
    parser.add_argument("--seconds", type=int, default=120)
    parser.add_argument("--server", default="unix:/run/dccast/dccastd.sock")
    return parser.parse_args()


class Live:
    """A job that follows, and when each of its steps has arrived."""

    def __init__(self, options):
        self.stub = service_pb2_grpc.SimulationServiceStub(grpc.insecure_channel(options.server))
        with open(options.case, encoding="utf-8") as file:
            case = self.stub.ReadCase(service_pb2.ReadCaseRequest(text=file.read()), timeout=30).case
        case.quality = case_pb2.Quality.Value(options.quality.upper())
        self.job = self.stub.SubmitJob(service_pb2.SubmitJobRequest(
            case=case, following=follow_pb2.Following()), timeout=60).id
        self.hold_s = int(case.schedule.hold_s)
        self.sent = 0
        self.arrived = {}  # time of the casting [s]: clock [s]
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        for event in self.stub.WatchJob(service_pb2.WatchJobRequest(id=self.job, from_sequence=1)):
            if event.HasField("step"):
                self.arrived[event.step.time_s] = time.monotonic()

    def send(self, *times):
        readings = [follow_pb2.Reading(number=self.sent + i + 1, time_s=t) for i, t in enumerate(times)]
        self.stub.AppendReadings(follow_pb2.AppendReadingsRequest(id=self.job, readings=readings), timeout=30)
        self.sent += len(times)


def main():
    options = arguments()
    live = Live(options)
    live.send(*range(-live.hold_s, options.begin))
    until(lambda: max(live.arrived, default=-1e9) >= options.begin - 3, 600)

    came = {}
    begin = time.monotonic()
    for second in range(options.seconds):
        wait_for_clock(begin + second)
        came[options.begin + second] = time.monotonic()
        live.send(options.begin + second)
    time.sleep(10)  # in which the last steps arrive; which is the last is not known
    live.stub.CancelJob(service_pb2.CancelJobRequest(id=live.job), timeout=30)

    delays = [clock - came[int(numpy.ceil(t))] for t, clock in live.arrived.items()
              if options.begin < t and int(numpy.ceil(t)) in came]
    print("%s: %d readings, %d steps; delay of a step: median %.2f s, 95 %% %.2f s, largest %.2f s" % (
        options.quality, options.seconds, len(delays), *numpy.quantile(delays, (0.5, 0.95, 1.0))))


if __name__ == "__main__":
    main()
