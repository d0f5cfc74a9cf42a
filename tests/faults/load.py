#!/usr/bin/python3
"""What the service does under load: submissions per second, latencies beside a long queue, memory, starts.

    tests/faults/load.py                            of build/release/bin
    tests/faults/load.py --bin OLD --bin NEW        side by side

The case is a coarse real one, complete as the client makes it; the worker program checks nothing and
sleeps instead of computing, so that the processor is the service's.
"""
import argparse
import contextlib
import os
import subprocess
import sys
import threading
import time

import run


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", action="append", metavar="DIR",
                        help="folder of the programs; several are shown side by side")
    parser.add_argument("--queued", type=int, default=2000, help="jobs that wait (default 2000)")
    parser.add_argument("--calls", type=int, default=300, help="calls of each kind (default 300)")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args()


def measure(options):
    """Prints `name<TAB>value` for each figure of one folder of programs."""
    run.set_up_imports(options.bin[0])
    import random
    from cases import FAKE, coarse, fake
    from scene import Scene
    case = coarse()
    with Scene(random.Random(1), FAKE, workers__count=1, limits__maximum_queued=100000,
               workers__stall_timeout="0 s") as scene:
        scene.submit(fake("steps=1000000 sleep_ms=1000"))
        case.title = "steps=3"
        process = scene.daemon.process.pid
        tell("memory at the start, MB", memory(process))
        fill_queue(scene, case, options.queued)
        tell(f"memory with {options.queued} waiting jobs, MB", memory(process))
        measure_calls(scene, case, options.calls)
        tell("memory at the end, MB", memory(process))
        tell("largest memory, MB", memory(process, "VmHWM"))
        measure_starts(scene)


def tell(name, value):
    print(f"{name}\t{value:.3g}", flush=True)


def memory(process, which="VmRSS"):
    from clients import memory_of
    return memory_of(process, which) / 1e6


def processor_seconds(scene):
    """Of the daemon and of every child that it has collected, in seconds."""
    seconds = 0.0
    for process in [scene.daemon.process.pid, *scene.daemon.worker_processes()]:
        with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        seconds += sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
    return seconds


def fill_queue(scene, case, queued):
    """Half of it by one client, half by four at once."""
    for clients in (1, 4):
        count = queued // 2
        processor, begin = processor_seconds(scene), time.monotonic()
        threads = [threading.Thread(target=submit_some, args=(scene.connected(), case, number,
                                                             clients, count))
                   for number in range(clients)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        seconds = time.monotonic() - begin
        tell(f"submissions per second, {clients} client{'s' * (clients > 1)}", count / seconds)
        tell(f"processor per submission, {clients} client{'s' * (clients > 1)}, ms",
             (processor_seconds(scene) - processor) / count * 1e3)


def submit_some(client, case, first, step, count):
    for number in range(first, count, step):
        client.submit(case, request_id=f"{step} {number}")


def measure_calls(scene, case, calls):
    from dccast.v1 import service_pb2
    stub, client = scene.client.stub, scene.client
    ids = [job.id for job in stub.ListJobs(service_pb2.ListJobsRequest(page_size=1000)).jobs]
    kinds = {
        "GetJob": lambda n: client.job(ids[n % len(ids)]),
        "ListJobs, a page of 50": lambda n: stub.ListJobs(service_pb2.ListJobsRequest(), timeout=20),
        "GetServerInfo": lambda n: scene.info(timeout=20),
        "SubmitJob": lambda n: client.submit(case, request_id=f"measured {n}"),
        "CancelJob, of a waiting job": lambda n: client.cancel(ids[n]),
    }
    for name, call in kinds.items():
        times = []
        for number in range(calls):
            begin = time.monotonic()
            call(number)
            times.append((time.monotonic() - begin) * 1e3)
        times.sort()
        tell(f"{name}, p50, ms", times[len(times) // 2])
        tell(f"{name}, p99, ms", times[len(times) * 99 // 100])


def measure_starts(scene):
    """A start with the index, and one that makes each row again from its folder."""
    for name, lost in (("a start", ()), ("a start without the index", ("", "-wal", "-shm"))):
        scene.kill_daemon()
        for end in lost:
            with contextlib.suppress(FileNotFoundError):
                os.remove(scene.data("jobs.sqlite" + end))
        begin = time.monotonic()
        scene.come_back()
        tell(f"{name}, s", time.monotonic() - begin)


def figures_of(programs, options):
    """In a process of its own: the programs' folder is fixed when the shared code is imported."""
    out = subprocess.run([sys.executable, __file__, "--measure", "--bin", programs, "--queued",
                          str(options.queued), "--calls", str(options.calls)],
                         stdout=subprocess.PIPE, text=True, check=True).stdout
    return dict(line.split("\t") for line in out.splitlines())


def main():
    options = arguments()
    if options.measure:
        return measure(options)
    folders = options.bin or [os.path.join(run.BUILD, "bin")]
    columns = [figures_of(folder, options) for folder in folders]
    print("| figure | " + " | ".join(f"`{os.path.basename(os.path.normpath(folder))}`"
                                     for folder in folders) + " |")
    print("|---|" + "---|" * len(folders))
    for name in columns[0]:
        print(f"| {name} | " + " | ".join(column.get(name, "") for column in columns) + " |")


if __name__ == "__main__":
    main()
