"""Castings that are followed, beside the jobs of others: who follows one stops no one else."""
import contextlib
import threading
import time

import grpc

from cases import REAL, coarse
from dccast.v1 import follow_pb2, job_pb2
from fault import Fault
from oracle import must
from support import until


class BesideAFollower(Fault):
    """Jobs beside a casting that is followed."""
    short, long = 3, 20
    at_once = 3
    worker = REAL
    longest = 5.0  # seconds; alone it takes half a second

    def begin(self, scene):
        self.follower = scene.submit(coarse(), following=follow_pb2.Following())
        scene.acknowledged.pop(self.follower)
        scene.foreign_jobs.add(self.follower)
        until(lambda: scene.client.job(self.follower).state == job_pb2.RUNNING, 10)
        self.leaving = threading.Event()
        self.feeder = threading.Thread(target=self.feed, args=(scene,), daemon=True)
        self.feeder.start()

    def feed(self, scene):
        """Readings for the follower, until it is left."""

    def disturb(self, scene, count):
        begin = time.monotonic()
        job_id = scene.submit(coarse())
        must(count, lambda: scene.ended(job_id), f"job {job_id} does not end", 60)
        taken = time.monotonic() - begin
        if taken > self.longest:
            count.found("wrong", f"a job took {taken:.1f} s")
        count.measured("s", taken)

    def look(self, scene, count):
        self.leaving.set()
        self.feeder.join(10)
        scene.client.cancel(self.follower)
        must(count, lambda: scene.ended(self.follower), "the follower does not end", 30)


class IdleFollower(BesideAFollower):
    """A followed casting that is never fed: jobs beside it begin and end at once"""


class FedFollower(BesideAFollower):
    """A followed casting that is fed ten readings a second: jobs beside it begin and end at once"""

    def feed(self, scene):
        client = scene.connected()
        for number in range(1, 10_000):
            reading = follow_pb2.Reading(number=number, time_s=-60.0 + number)
            with contextlib.suppress(grpc.RpcError):  # the casting has ended
                client.stub.AppendReadings(
                    follow_pb2.AppendReadingsRequest(id=self.follower, readings=[reading]), timeout=20)
            if self.leaving.wait(0.1):
                return


class UnfedFollower(Fault):
    """A followed casting that is never fed ends after six times workers.stall_timeout, with that cause"""
    short, long = 1, 5
    worker = REAL
    settings = {"workers__stall_timeout": "0.4 s"}

    def disturb(self, scene, count):
        follower = scene.submit(coarse(), job_pb2.FAILED, following=follow_pb2.Following())
        must(count, lambda: scene.ended(follower), "a follower that is never fed does not end", 20)
        failure = scene.client.job(follower).failure
        if failure.kind != job_pb2.Finding.TIME_LIMIT or "no reading" not in failure.message:
            count.found("wrong", f"the follower ended for another reason: {failure.message}")
