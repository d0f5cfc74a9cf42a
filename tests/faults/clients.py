"""Clients that ask too much, say nonsense, or do not go: nobody else notices."""
import contextlib
import os
import resource
import signal
import threading
import time

import grpc

from cases import REAL, coarse, fake
from dccast.v1 import case_pb2, service_pb2
from fault import Fault
from oracle import all_jobs, must
from scene import limit, signal_process
from support import connected, start_ticks
from waiting import pause, turns, until

SERVICE = "/dccast.v1.SimulationService/"
METHODS = ("ValidateCase", "SubmitJob", "GetJob", "ListJobs", "WatchJob", "CancelJob", "PauseJob",
           "ResumeJob", "DeleteJob", "FetchResult", "QueryResult", "ListAlloys", "GetServerInfo")
MOST_MEMORY = 400e6  # bytes of a daemon that took texts of megabytes
ANSWER = 2.0     # seconds within which a status is answered, on a machine that does other things too
# An answer that blames the service, or that says nothing a client can act on.
NO_ANSWERS = (grpc.StatusCode.INTERNAL, grpc.StatusCode.UNKNOWN, grpc.StatusCode.UNIMPLEMENTED)


class IdleConnections(Fault):
    """1,100 idle connections at a limit of 1,024 descriptors"""
    short, long = 1, 5
    patience = 20.0
    connections = 1100
    settings = {"through": ("prlimit", "--nofile=1024:1024")}

    def begin(self, scene):
        limit(os.getpid(), resource.RLIMIT_NOFILE, 4096)
        scene.submit(fake("steps=20"))  # connects, before the others

    def disturb(self, scene, count):
        idle = self.connect(scene)
        try:
            for _ in range(5):
                scene.submit(fake("steps=20"))
            judge_refusals(scene, count)
            must(count, lambda: scene.info(ANSWER).version, "no status beside idle connections", 5)
            self.wait_a_while(scene)
        finally:
            for connection in idle:
                connection.close()

    def look_back(self, scene, count):
        for job_id in scene.acknowledged:
            attempts = scene.client.job(job_id).attempts
            if attempts > 1:
                count.found("wrong", f"job {job_id} was started {attempts} times")

    def connect(self, scene):
        idle = []
        for _ in range(self.connections):
            try:
                idle.append(connected(scene.daemon.address, timeout=1))
            except OSError:
                break  # refused: that is one way to bound them
        time.sleep(0.5)  # nothing says that the daemon has taken them all
        return idle

    @staticmethod
    def wait_a_while(scene):
        with contextlib.suppress(AssertionError):
            until(lambda: all(map(scene.ended, scene.acknowledged)), 3, every_s=0.1)


class HeavyChecks(Fault):
    """16 checks of cases with 100,000 monitors at once, beside status requests"""
    short, long = 1, 3
    checks, monitors = 16, 100000

    worker = REAL

    def begin(self, scene):
        scene.submit(coarse())

    def disturb(self, scene, count):
        heavy = case_pb2.Case()
        heavy.CopyFrom(coarse())
        for number in range(self.monitors):
            heavy.monitor.add(name=f"m{number}", x_m=0.1, y_m=0.0)
        stub = scene.connected().stub
        calls = [stub.ValidateCase.future(service_pb2.ValidateCaseRequest(case=heavy), timeout=30)
                 for _ in range(self.checks)]
        self.ask_for_status(scene, calls, count)
        for call in calls:
            call.cancel()

    @staticmethod
    def ask_for_status(scene, calls, count):
        slowest = 0.0
        for _ in turns(8, 0.05):
            if all(call.done() for call in calls):
                break
            begin = time.monotonic()
            try:
                scene.info(timeout=10)
            except grpc.RpcError:
                pass  # the time it took says it
            slowest = max(slowest, time.monotonic() - begin)
        if slowest > ANSWER:
            count.found("wrong", f"a status took {slowest:.1f} s")


class OversizeStrings(Fault):
    """Titles, names and ids of many megabytes"""
    short, long = 5, 30

    at_once = 5
    patience = 20.0

    def begin(self, scene):
        scene.submit(fake("steps=20"))
        self.kinds = ["title", "monitor", "alloy", "request_id", "study"]

    def disturb(self, scene, count):
        many = "x" * scene.chance.randrange(2 << 20, 6 << 20)
        kind = self.kinds.pop()
        case, rest = fake("steps=20"), {}
        if kind == "title":
            case.title = many
        elif kind == "monitor":
            case.monitor[0].name = many
        elif kind == "alloy":
            case.alloy.card = many
        else:
            rest[kind] = many
        self.must_be_refused(scene, case, rest, count)

    def look(self, scene, count):
        must(count, lambda: all_jobs(scene.connected()), "the jobs cannot be listed", ANSWER)
        peak = memory_of(scene.daemon.process.pid, "VmHWM")
        if peak > MOST_MEMORY:
            count.found("wrong", f"the daemon took {peak / 1e6:.0f} MB")

    @staticmethod
    def must_be_refused(scene, case, rest, count):
        try:
            scene.foreign_jobs.add(scene.client.submit(case, **rest).id)
            count.found("wrong", "a text of megabytes was accepted")
        except grpc.RpcError as error:
            if error.code() in NO_ANSWERS or not 0 < len(error.details()) < 2000:
                count.found("wrong", f"it is refused with {error.code().name} and "
                            f"{len(error.details())} bytes of words")


class MalformedMessages(Fault):
    """Random bytes and mutated messages to every call"""
    short, long = 300, 4000
    seconds = 8.0

    at_once = 300
    patience = 30.0

    def begin(self, scene):
        scene.submit(fake("steps=20"))
        self.sound = service_pb2.SubmitJobRequest(case=fake("steps=3")).SerializeToString()

    def disturb(self, scene, count):
        method = scene.chance.choice(METHODS)
        body = (mutated(scene.chance, self.sound) if method == "SubmitJob"
                else scene.chance.randbytes(scene.chance.randrange(1, 200)))
        call = scene.client.channel.unary_stream(SERVICE + method)
        try:
            list(call(body, timeout=10))
        except grpc.RpcError as error:
            if error.code() in NO_ANSWERS or not error.details():
                count.found("wrong", f"{method} answers {error.code().name} \"{error.details()}\"")

    def look(self, scene, count):
        if not scene.daemon.running():
            count.found("wrong", "the daemon has died")
            scene.come_back()
        self.forget_accepted(scene)

    @staticmethod
    def forget_accepted(scene):
        """A mutated message may be a sound one: what came of it is nobody's."""
        for job in all_jobs(scene.client):
            if job.id not in scene.acknowledged:
                scene.foreign_jobs.add(job.id)
                scene.client.cancel(job.id)


class KillCheck(Fault):
    """kill -9 of the process that checks a submitted case"""
    short, long = 3, 40
    seconds = 15.0

    at_once = 5
    patience = 30.0
    worker = REAL
    # Any worker without a job may be the one that checks; one that has just been handed a job looks the same, and
    # three deaths of it would be a fault of the case.
    settings = {"workers__count": 1, "workers__restarts": 100}

    def disturb(self, scene, count):
        """Kills a process that checks cases while a submission is on its way."""
        answered = threading.Event()
        killer = threading.Thread(target=self.kill, args=(scene, answered))
        killer.start()
        scene.submit(coarse())
        answered.set()
        killer.join()

    @staticmethod
    def kill(scene, answered):
        pause(scene.chance, 0.01)
        while not answered.is_set():
            killed = [signal_process((process, start_ticks(process)), signal.SIGKILL)
                      for process in scene.daemon.answering_processes()]
            if any(killed):
                return

    def look(self, scene, count):
        for expected in scene.unsure:
            if expected.refusal.code() != grpc.StatusCode.UNAVAILABLE:
                count.found("wrong", f"a killed check gives {expected.refusal.code().name}: "
                            + expected.refusal.details())


def judge_refusals(scene, count):
    for expected in scene.unsure:
        if expected.refusal.code() in NO_ANSWERS:
            count.found("wrong", f"a submission gets {expected.refusal.code().name}: "
                        + expected.refusal.details())


def mutated(chance, message):
    body = bytearray(message)
    for _ in range(chance.randrange(1, 8)):
        what = chance.randrange(3)
        at = chance.randrange(len(body))
        if what == 0:
            body[at] = chance.randrange(256)
        elif what == 1:
            del body[at:at + chance.randrange(1, 8)]
        else:
            body[at:at] = chance.randbytes(chance.randrange(1, 8))
        if not body:
            return chance.randbytes(8)
    return bytes(body)


def memory_of(process, which):
    """A figure of /proc/PID/status, in bytes."""
    with open(f"/proc/{process}/status", encoding="ascii") as file:
        for line in file:
            if line.startswith(which + ":"):
                return int(line.split()[1]) * 1024
    raise KeyError(which)
