"""Castings that are followed, beside the jobs of others: who follows one stops no one else."""
import contextlib
import threading
import time

import grpc

from access import RemoteFault, admin, over_tls
from cases import REAL, coarse, fake
from clients import ANSWER, memory_of
from dccast.v1 import follow_pb2, job_pb2, service_pb2
from fault import Fault
from oracle import must
from waiting import turns, until


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
                client.ask("AppendReadings", id=self.follower, readings=[reading])
            if self.leaving.wait(0.1):
                return


class EndlessRecord(Fault):
    """A casting is fed as fast as the server takes readings, also 1e-7 s apart: calls of others go on"""
    short, long = 1, 5
    lasts, most = 10.0, 100_000
    most_memory = 300e6

    def begin(self, scene):
        self.follower = scene.submit(fake("steps=100000 sleep_ms=10"), following=follow_pb2.Following())
        scene.acknowledged.pop(self.follower)
        scene.foreign_jobs.add(self.follower)

    def feed(self, scene, spacing_s, leaving):
        """A batch that is refused is sent again, by each of several feeders."""
        client, number = scene.connected(), 0
        while not leaving.is_set():
            readings = [follow_pb2.Reading(number=number + i, time_s=spacing_s * (number + i))
                        for i in range(1, 1001)]
            with contextlib.suppress(grpc.RpcError):
                number = client.ask("AppendReadings", id=self.follower, readings=readings).number

    def disturb(self, scene, count):
        leaving = threading.Event()
        feeders = [threading.Thread(target=self.feed, args=(scene, spacing_s, leaving), daemon=True)
                   for spacing_s in (1e-7, 0.02)]
        for feeder in feeders:
            feeder.start()
        slowest = 0.0
        for _ in turns(self.lasts, 0.05):
            begin = time.monotonic()
            scene.client.job(self.follower)
            scene.info(timeout=20)
            slowest = max(slowest, time.monotonic() - begin)
        leaving.set()
        for feeder in feeders:
            feeder.join(30)
        job = scene.client.job(self.follower)
        peak = memory_of(scene.daemon.process.pid, "VmHWM")
        number = scene.client.ask("AppendReadings", id=job.id).number
        count.measured("s", slowest)
        count.measured("readings", number)
        if number > self.most:
            count.found("wrong", f"{number} readings were taken")
        if slowest > ANSWER:
            count.found("wrong", f"two calls took {slowest:.1f} s")
        if peak > self.most_memory:
            count.found("wrong", f"the daemon took {peak / 1e6:.0f} MB")

    def look(self, scene, count):
        scene.client.cancel(self.follower)
        must(count, lambda: scene.ended(self.follower), "the follower does not end", 30)


class SixtyFollowers(Fault):
    """A user follows 60 castings at once."""
    short, long = 1, 5
    followers, most_memory = 60, 300e6

    def begin(self, scene):
        self.ids = [scene.submit(fake("steps=100000 sleep_ms=50"), following=follow_pb2.Following())
                    for _ in range(self.followers)]
        for follower in self.ids:
            scene.acknowledged.pop(follower)
            scene.foreign_jobs.add(follower)

    def disturb(self, scene, count):
        begin = time.monotonic()
        job = scene.submit(fake("steps=20"))
        must(count, lambda: scene.ended(job), "a job beside them does not end", 30)
        count.measured("s", time.monotonic() - begin)

        jobs = [scene.client.job(follower) for follower in self.ids]
        running = [job for job in jobs if job.state == job_pb2.RUNNING]
        count.measured("running", len(running))
        if len(running) != self.most:
            count.found("wrong", f"{len(running)} are followed at once")
        if silent := [job.id for job in jobs if job.state == job_pb2.QUEUED and self.reason not in job.held]:
            count.found("wrong", f"{len(silent)} do not say why they wait")
        processes = [scene.daemon.process.pid, *scene.daemon.worker_processes(),
                     *scene.daemon.answering_processes()]
        memory = sum(memory_of(process, "VmRSS") for process in processes)
        count.measured("MB of daemon and workers", memory / 1e6)
        if memory > self.most_memory:
            count.found("wrong", f"daemon and workers take {memory / 1e6:.0f} MB")

    def look(self, scene, count):
        for follower in reversed(self.ids):
            scene.client.cancel(follower)
        must(count, lambda: all(map(scene.ended, self.ids)), "a follower does not end", 60)


class ManyFollowers(SixtyFollowers):
    """A user follows 60 castings at once: 8 run, the others wait and say so, a job beside them ends at once"""
    most, reason = 8, "per_user.maximum_followed = 8"
    settings = {"workers__count": 1}


class ManyFollowersOfAll(SixtyFollowers):
    """Castings of all users are followed, without a bound of each: 10 run, the others wait and say so"""
    most, reason = 10, "limits.maximum_followed = 10"
    settings = {"workers__count": 1, "per_user__maximum_followed": 60}


class FollowerOfLostUser(RemoteFault):
    """A user may follow no more."""
    longest = 5.0

    def disturb(self, scene, count):
        ids = {}
        for name in ("anna", "bert"):
            stub = over_tls(scene, self.ca(scene), self.enrol(scene, name))
            request = service_pb2.SubmitJobRequest(case=fake("steps=100000 sleep_ms=10"),
                                                   following=follow_pb2.Following())
            ids[name] = stub.SubmitJob(request, timeout=20).id
            scene.foreign_jobs.add(ids[name])
            scene.client.until_step(ids[name], 1)
        admin(scene, "user", self.command, "anna")
        must(count, lambda: scene.ended(ids["anna"]), "the follower goes on", self.longest)
        if self.cause not in scene.client.job(ids["anna"]).cause:
            count.found("wrong", f"its cause is: {scene.client.job(ids['anna']).cause}")
        if scene.ended(ids["bert"]):
            count.found("wrong", "the follower of another ended, too")
        for job_id in ids.values():
            scene.client.cancel(job_id)
            must(count, lambda: scene.ended(job_id), "a cancelled follower goes on", 30)


class FollowerOfDisabledUser(FollowerOfLostUser):
    """A user is disabled: the castings that this user follows end within seconds, those of others go on"""
    command, cause = "disable", "user anna is disabled"


class FollowerOfRemovedUser(FollowerOfLostUser):
    """A user is removed: the castings that this user follows end within seconds, those of others go on"""
    command, cause = "remove", "user anna was removed"


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
