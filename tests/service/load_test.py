#!/usr/bin/python3
"""Many clients at once: what one of them asks for does not hold up the others.

Prints latencies, rates, processor time and memory; the bounds that are asserted are wide, as other
programs share the machine. With --long in front of unittest's own words it asks for ten times as
much.
"""
import os
import resource
import sys
import threading
import time

import grpc

from dccast.v1 import job_pb2, service_pb2
from support import ServiceTest, connected, fake_case, main
from waiting import until

LONG = "--long" in sys.argv
if LONG:
    sys.argv.remove("--long")
CLOCK_TICKS = os.sysconf("SC_CLK_TCK")
PAGE = os.sysconf("SC_PAGE_SIZE")


def timed(call, *arguments, **rest):
    begin = time.monotonic()
    call(*arguments, **rest)
    return time.monotonic() - begin


def percentile(delays, share):
    return sorted(delays)[min(int(share * len(delays)), len(delays) - 1)]


def say(what, delays):
    print(f"{what}: p50 {percentile(delays, 0.5) * 1e3:.1f} ms, "
          f"p99 {percentile(delays, 0.99) * 1e3:.1f} ms, most {max(delays) * 1e3:.1f} ms")


def processor_s(pid, with_children):
    """Seconds of processor of a process, and of its children that it has collected."""
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    ticks = int(fields[11]) + int(fields[12])
    if with_children:
        ticks += int(fields[13]) + int(fields[14])
    return ticks / CLOCK_TICKS


def resident_mb(pid):
    with open(f"/proc/{pid}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * PAGE / 1e6


class Load(ServiceTest):
    settings = {"workers__count": 1, "workers__stop_grace": "1 s"}

    def info(self):
        return self.client.ask("GetServerInfo")

    def occupy(self):
        """A job that keeps the only worker busy, so that others stay queued."""
        running = self.client.submit(fake_case("steps=1000000 sleep_ms=50"))
        self.client.until_step(running.id, 1)

    def processor_of_service(self):
        """Of the daemon, of the children it has collected, and of those that are alive."""
        return processor_s(self.daemon.process.pid, True) + sum(
            processor_s(pid, False) for pid in self.daemon.children())


class Checks(Load):
    def test_checks_of_large_cases_hold_up_nobody(self):
        """A case of many monitors is counted in full before its check says no."""
        large = fake_case("check_ms=300")
        for i in range(20000):
            monitor = large.monitor.add()
            monitor.name, monitor.x_m, monitor.y_m = f"m{i}", 0.1, 0.01
        request = service_pb2.ValidateCaseRequest(case=large)
        codes = []

        def validate():
            try:
                self.new_client().stub.ValidateCase(request, timeout=30)
                codes.append("OK")
            except grpc.RpcError as error:
                codes.append(error.code().name)
        threads = [threading.Thread(target=validate) for _ in range(16)]
        for thread in threads:
            thread.start()
        delays = []
        def have_ended():
            delays.append(timed(self.info))
            return not any(thread.is_alive() for thread in threads)
        until(have_ended, 60)
        for thread in threads:
            thread.join()
        print()
        say(f"GetServerInfo beside 16 checks with 20,000 monitors ({len(delays)} calls)", delays)
        self.assertEqual(len(codes), 16)
        self.assertLess(percentile(delays, 0.99), 1.0)


class IdleConnections(Load):
    """More of them than the daemon has file descriptors."""
    descriptors = 1024
    settings = {**Load.settings, "workers__count": 2}

    @staticmethod
    def before_exec():
        limit = IdleConnections.descriptors
        resource.setrlimit(resource.RLIMIT_NOFILE, (limit, limit))

    def test_connections_that_say_nothing_take_nothing_from_jobs(self):
        most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
        self.info()  # this client is connected
        idle = [connected(self.daemon.address) for _ in range(1100)]
        jobs = [self.client.submit(fake_case(f"steps=3 number={i}")) for i in range(10)]
        for job in jobs:
            job = self.client.until_state(job.id, job_pb2.SUCCEEDED, job_pb2.FAILED)
            self.assertEqual((job.state, job.attempts), (job_pb2.SUCCEEDED, 1))
        # A silent one gives way to whoever comes now.
        self.new_client().stub.GetServerInfo(service_pb2.GetServerInfoRequest(), timeout=10,
                                             wait_for_ready=True)
        for connection in idle:
            connection.close()
        begin = time.monotonic()
        self.new_client().stub.GetServerInfo(service_pb2.GetServerInfoRequest(),
                                             timeout=20, wait_for_ready=True)
        print(f"\na new client after 1100 idle connections: {time.monotonic() - begin:.2f} s")


class Submissions(Load):
    def test_a_script_that_queues_many_cases(self):
        self.occupy()
        number = 3000 if LONG else 300
        before, begin = self.processor_of_service(), time.monotonic()
        delays = [timed(self.client.submit, fake_case(f"steps=1 number={i}"))
                  for i in range(number)]
        seconds = time.monotonic() - begin
        spent = self.processor_of_service() - before
        print(f"\n{number} submissions: {number / seconds:.0f} a second, "
              f"{spent / number * 1e3:.1f} ms of processor each, "
              f"daemon {resident_mb(self.daemon.process.pid):.0f} MB resident")
        say("SubmitJob", delays)
        self.assertEqual(self.info().queued, number)
        self.assertGreater(number / seconds, 5)


class Queue(Load):
    def test_a_long_queue_is_as_quick_as_a_short_one(self):
        self.occupy()
        number = 10000 if LONG else 2000
        ids, errors = [], []

        def fill(share):
            try:
                client = self.new_client()
                for i in range(share):
                    ids.append(client.submit(fake_case(f"steps=1 number={i}")).id)
            except grpc.RpcError as error:
                errors.append(error)
        begin = time.monotonic()
        threads = [threading.Thread(target=fill, args=(number // 4,)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(errors, [])
        print(f"\n{number} jobs queued by 4 clients in {time.monotonic() - begin:.1f} s, "
              f"daemon {resident_mb(self.daemon.process.pid):.0f} MB resident")
        listing = service_pb2.ListJobsRequest()
        calls = {"GetJob": lambda i: self.client.job(ids[i * 7 % len(ids)]),
                 "ListJobs of 50": lambda i: self.client.stub.ListJobs(listing, timeout=30),
                 "SubmitJob": lambda i: self.client.submit(fake_case(f"steps=1 later={i}")),
                 "GetServerInfo": lambda i: self.info()}
        for name, call in calls.items():
            delays = [timed(call, i) for i in range(200)]
            say(f"{name} with {number} queued", delays)
            self.assertLess(percentile(delays, 0.5), 1.0)


if __name__ == "__main__":
    main()
