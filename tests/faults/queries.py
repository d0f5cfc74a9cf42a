#!/usr/bin/python3
"""How long a query takes beside its solver: on a daemon with nothing else to do, and on one whose
batch lane is full of real castings. Prints the table of docs/queries.md.

    tests/faults/queries.py                    of build/release/bin
    tests/faults/queries.py --calls 50 --cancellations 20
"""
import argparse
import os
import time

import run


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default=os.path.join(run.BUILD, "bin"), metavar="DIR",
                        help="folder of the programs")
    parser.add_argument("--calls", type=int, default=100, help="queries of each kind (default 100)")
    parser.add_argument("--cancellations", type=int, default=20, help="calls cancelled (default 20)")
    return parser.parse_args()


class Times(dict):
    """Milliseconds by what was measured."""

    def add(self, name, seconds):
        self.setdefault(name, []).append(seconds * 1e3)

    def text(self, name):
        values = sorted(self.get(name, []))
        if not values:
            return ""
        return " / ".join(f"{values[min(len(values) - 1, int(len(values) * q))]:.3g}"
                          for q in (0.5, 0.99))


def ask(stub, case, times, kind):
    """One query, timed on this side of the wire."""
    from dccast.v1 import service_pb2
    begin = time.monotonic()
    first, ended = None, None
    for response in stub.QueryButtCurl(service_pb2.QueryButtCurlRequest(case=case), timeout=300):
        if first is None and response.HasField("step"):
            first = time.monotonic() - begin
        if response.HasField("ended"):
            ended = response.ended
    whole = time.monotonic() - begin
    times.add(f"{kind}: first point", first)
    times.add(f"{kind}: whole answer", whole)
    if kind != "from the store":
        times.add(f"{kind}: whole answer less the solver's time", whole - ended.solver_s)


def varied(case, number):
    """The same work, but no answer of before."""
    other = type(case)()
    other.CopyFrom(case)
    other.monitor[0].name = f"corner {number}"
    return other


def measure(scene, options, times):
    from cases import coarse, read_by_the_client, shipped
    stub = scene.client.stub
    small, large = coarse(), read_by_the_client(shipped())
    ask(stub, small, Times(), "warm up")
    for number in range(options.calls):
        measure.number += 1
        ask(stub, varied(small, measure.number), times, "coarse case")
    for number in range(max(1, options.calls // 10)):
        measure.number += 1
        ask(stub, varied(large, measure.number), times, "start-2d-thickness")
    for _ in range(options.calls):
        ask(stub, small, times, "from the store")
    for _ in range(options.cancellations):
        measure.number += 1
        cancel(scene, varied(large, measure.number), times)


measure.number = 0


def query_workers(scene):
    found = {}
    for process in scene.daemon.children():
        try:
            with open(f"/proc/{process}/cmdline", "rb") as file:
                if b"--serve-queries" in file.read():
                    found[process] = processor_time(process)
        except OSError:
            pass  # it ended while we looked
    return found


def processor_time(process):
    with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
        return sum(map(int, file.read().rsplit(")", 1)[1].split()[11:13]))


def cancel(scene, case, times):
    """From the cancellation of a call to the end of the process that worked for it."""
    from dccast.v1 import service_pb2
    before = set(query_workers(scene))
    call = scene.client.stub.QueryButtCurl(service_pb2.QueryButtCurlRequest(case=case), timeout=60)
    for response in call:
        if response.HasField("step") and response.step.step >= 5:
            break
    begin = time.monotonic()
    call.cancel()
    while before <= set(query_workers(scene)):
        if time.monotonic() - begin > 10:
            raise AssertionError("a cancelled call kept its worker")
        time.sleep(0.001)
    times.add("cancellation to the end of its run", time.monotonic() - begin)


def fill_batch_lane(scene):
    """Castings that compute for minutes, more of them than workers."""
    from cases import read_by_the_client, shipped
    case = read_by_the_client(shipped())
    case.mesh.refinement = 4
    for number in range(20):
        scene.submit(varied(case, f"batch {number}"))
    end = time.monotonic() + 30
    while scene.info().running < scene.info().workers or not steps_taken(scene):
        if time.monotonic() > end:
            raise AssertionError("the batch lane does not fill")
        time.sleep(0.1)


def steps_taken(scene):
    from dccast.v1 import job_pb2, service_pb2
    running = scene.client.stub.ListJobs(service_pb2.ListJobsRequest(states=[job_pb2.RUNNING]))
    return all(scene.client.job(job.id).last_step.step > 2 for job in running.jobs)


def main():
    options = arguments()
    run.set_up_imports(options.bin)
    import random
    from cases import REAL
    from scene import Scene
    columns = []
    with Scene(random.Random(1), REAL, workers=0, checkers=0) as scene:
        for full in (False, True):
            if full:
                fill_batch_lane(scene)
            columns.append(Times())
            measure(scene, options, columns[-1])
    print("| p50 / p99, ms | idle | batch lane full |\n|---|---|---|")
    for name in columns[0]:
        print(f"| {name} | {columns[0].text(name)} | {columns[1].text(name)} |")


if __name__ == "__main__":
    main()
