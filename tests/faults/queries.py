#!/usr/bin/python3
"""How long a query takes beside its solver: on a daemon with nothing else to do, and on one whose
batch lane is full of real castings. Prints the table of docs/developers/decisions.md.

    tests/faults/queries.py                    of build/release/bin
    tests/faults/queries.py --calls 50 --cancellations 20
    tests/faults/queries.py --quick            seconds: whether calls are answered and cancelled

A worker that has to share its core is slow for no fault of the service. What it waited for a core is
counted by the kernel (/proc/PID/schedstat), and the last row of each kind leaves it out.
"""
import argparse
import os
import time

import run

MEASURED = ("first point", "whole answer", "whole less the solver's time",
            "the same less the worker's waiting for a core")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default=os.path.join(run.BUILD, "bin"), metavar="DIR",
                        help="folder of the programs")
    parser.add_argument("--calls", type=int, default=100, help="queries of each kind (default 100)")
    parser.add_argument("--cancellations", type=int, default=20, help="calls cancelled (default 20)")
    parser.add_argument("--quick", action="store_true",
                        help="few calls of coarse castings; figures from it say nothing")
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


def ask(scene, case, times, kind):
    """One query, timed on this side of the wire."""
    from dccast.v1 import service_pb2
    waited = core_waits(scene)
    begin = time.monotonic()
    first, ended = None, None
    request = service_pb2.QueryButtCurlRequest(case=case)
    for response in scene.client.stub.QueryButtCurl(request, timeout=300):
        if first is None and response.HasField("step"):
            first = time.monotonic() - begin
        if response.HasField("ended"):
            ended = response.ended
    whole = time.monotonic() - begin
    found = [first, whole]
    if kind != "from the store":
        beyond = whole - ended.solver_s
        found += [beyond, beyond - waited_meanwhile(waited, core_waits(scene))]
    for name, seconds in zip(MEASURED, found):
        times.add(f"{kind}: {name}", seconds)


def varied(case, number):
    """The same work, but no answer of before."""
    other = type(case)()
    other.CopyFrom(case)
    other.monitor[0].name = f"corner {number}"
    return other


class Numbers:
    """Of the cases, so that no two are the same."""
    last = 0

    @classmethod
    def next(cls):
        cls.last += 1
        return cls.last


def measure(scene, options, times):
    from cases import coarse, read_by_the_client, shipped
    small = coarse()
    large = read_by_the_client(shipped())
    ask(scene, small, Times(), "warm up")
    for _ in range(options.calls):
        ask(scene, varied(small, Numbers.next()), times, "coarse case")
    for _ in range(0 if options.quick else max(1, options.calls // 10)):
        ask(scene, varied(large, Numbers.next()), times, "start-2d-thickness")
    for _ in range(options.calls):
        ask(scene, small, times, "from the store")
    for _ in range(options.cancellations):
        cancel(scene, varied(large, Numbers.next()), times)


def query_workers(scene):
    """Those that compute a query or wait for one."""
    return scene.daemon.answering_processes()


def core_waits(scene):
    """Seconds that each query worker has computed, and that it has waited for a core, so far."""
    found = {}
    for process in query_workers(scene):
        try:
            with open(f"/proc/{process}/schedstat", encoding="ascii") as file:
                found[process] = [int(word) * 1e-9 for word in file.read().split()[:2]]
        except OSError:
            pass  # it ended while we looked
    return found


def waited_meanwhile(before, after):
    """What the worker that did the work has waited: the one that computed most."""
    none = [0.0, 0.0]
    return max((now[0] - before.get(process, none)[0], now[1] - before.get(process, none)[1])
               for process, now in after.items())[1]


def cancel(scene, case, times):
    """From the cancellation of a call to the end of the process that worked for it."""
    from waiting import until
    call = scene.client.ask("QueryButtCurl", case=case)
    for response in call:
        if response.HasField("step") and response.step.step >= 5:
            break
    # Now, not before the call: the one that replaces the worker cancelled last may have come since,
    # and it is the next to be asked.
    working = set(query_workers(scene))
    begin = time.monotonic()
    call.cancel()
    until(lambda: not working <= set(query_workers(scene)), 10, every_s=0.001)
    times.add("cancellation to the end of its run", time.monotonic() - begin)


def fill_batch_lane(scene):
    """Castings that compute for minutes, more of them than workers."""
    from cases import read_by_the_client, shipped
    from waiting import until
    case = read_by_the_client(shipped())
    case.mesh.refinement = 4
    for number in range(20):
        scene.submit(varied(case, f"batch {number}"))
    until(lambda: scene.info().running >= scene.info().workers and steps_taken(scene), 30)


def steps_taken(scene):
    from dccast.v1 import job_pb2
    running = scene.client.ask("ListJobs", states=[job_pb2.RUNNING])
    return all(scene.client.job(job.id).last_step.step > 2 for job in running.jobs)


def load():
    return f"{os.getloadavg()[0]:.1f}"


def main():
    options = arguments()
    if options.quick:
        options.calls = 2
    run.set_up_imports(options.bin)
    import random
    from cases import REAL
    from scene import Scene
    columns, loads = [], [load()]
    with Scene(random.Random(1), REAL, workers__count=0, checks__workers=0) as scene:
        for full in (False, True):
            if full:
                fill_batch_lane(scene)
            columns.append(Times())
            measure(scene, options, columns[-1])
            loads.append(load())
    print("| p50 / p99, ms | idle | batch lane full |\n|---|---|---|")
    for name in columns[0]:
        print(f"| {name} | {columns[0].text(name)} | {columns[1].text(name)} |")
    print(f"\n{os.cpu_count()} cores; load before, after the first and after the second column: "
          f"{', '.join(loads)}.")


if __name__ == "__main__":
    main()
