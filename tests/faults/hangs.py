"""Processes that are there and do nothing, or are told to leave: the watchdog and the ways out."""
import os
import signal

from cases import FAKE, REAL, coarse, failing_check, fake
from dccast.v1 import job_pb2
from fault import Fault
from oracle import Count, judge, must, undisturbed
from scene import Scene, alive, pause, signal_process
from support import BIN

# Short times, and still long against a machine that does other things too.
WATCHFUL = {"heartbeat_interval": "0.2 s", "heartbeat_timeout": "2 s",
            "worker_hello_timeout": "2 s", "worker_restarts": 20}
PATIENCE = 12.0  # seconds until the watchdog must have acted


class StopWorker(Fault):
    """SIGSTOP of a worker in the middle of a real casting: it hangs for ever"""
    short, long = 2, 20

    def attempt(self, chance, most):
        count = Count(tried=1)
        with Scene(chance, REAL, **WATCHFUL) as scene:
            scene.submit(coarse())
            scene.submit(failing_check())
            pause(chance, undisturbed(REAL, coarse()).seconds)
            workers = scene.job_workers()
            if not workers:
                return Count(tried=1) if scene.acknowledged else Count()
            stopped = chance.choice(workers)
            if signal_process(stopped, signal.SIGSTOP):
                must(count, lambda: not alive(stopped), "a worker that hangs is not killed", PATIENCE)
            signal_process(stopped, signal.SIGKILL)
            count.add(judge(scene))
        return count


class SilentWorker(Fault):
    """A worker program that sleeps instead of saying its first word, once for each of its starts"""
    short, long = 1, 5
    sleeper = """#!/bin/sh
case "$1" in --*) exec {worker} "$@";; esac
mkdir {folder}/slept-$DCCAST_WORKER_JOB 2>/dev/null && exec sleep 60
exec {worker} "$@"
"""

    def attempt(self, chance, most):
        count = Count(tried=1)
        with Scene(chance, FAKE, prepare=self.write_sleeper, **WATCHFUL) as scene:
            for _ in range(3):
                scene.submit(fake("steps=20"))
            count.add(judge(scene, seconds=30))
        return count

    def write_sleeper(self, scene):
        path = os.path.join(scene.folder, "sleeper")
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.sleeper.format(worker=os.path.join(BIN, FAKE), folder=scene.folder))
        os.chmod(path, 0o700)
        scene.daemon.settings["worker_program"] = path


class StalledWorker(Fault):
    """A worker that is alive and makes no step, ever"""

    short, long = 1, 5

    def attempt(self, chance, most):
        count = Count(tried=1)
        with Scene(chance, FAKE, stall_timeout="1 s", **{**WATCHFUL, "worker_restarts": 1}) as scene:
            stalled = scene.submit(fake("steps=5 sleep_ms=100000"), job_pb2.FAILED)
            scene.submit(fake("steps=20"))
            must(count, lambda: scene.ended(stalled), "a worker without a step keeps its slot",
                 PATIENCE)
            count.add(judge(scene, seconds=10))
        return count


class StopWorkerAndLeave(Fault):
    """SIGSTOP of a worker, then SIGTERM of the daemon; started again"""
    short, long = 1, 10

    def attempt(self, chance, most):
        count = Count(tried=1)
        with Scene(chance, REAL, **{**WATCHFUL, "stop_grace": "1 s"}) as scene:
            scene.submit(coarse())
            pause(chance, undisturbed(REAL, coarse()).seconds)
            for worker in scene.job_workers()[:1]:
                signal_process(worker, signal.SIGSTOP)
            leave_and_come_back(scene, count)
            count.add(judge(scene))
        return count


class TellDaemon(Fault):
    """SIGTERM of the daemon while real castings run; started again"""
    short, long = 2, 30

    def attempt(self, chance, most):
        count = Count(tried=1)
        with Scene(chance, REAL) as scene:
            scene.submit(coarse())
            scene.submit(failing_check())
            pause(chance, undisturbed(REAL, coarse()).seconds)
            leave_and_come_back(scene, count)
            count.add(judge(scene))
        return count


class TellWorker(Fault):
    """SIGTERM of a worker in the middle of a real casting"""
    short, long = 2, 30

    def attempt(self, chance, most):
        count = Count(tried=1)
        with Scene(chance, REAL) as scene:
            scene.submit(coarse())
            scene.submit(failing_check())
            pause(chance, undisturbed(REAL, coarse()).seconds)
            for worker in scene.job_workers()[:1]:
                signal_process(worker, signal.SIGTERM)
            count.add(judge(scene))
        return count


def leave_and_come_back(scene, count):
    code = scene.kill_daemon(signal.SIGTERM)
    if code != 0:
        count.found("wrong", f"dccastd ended with {code} after SIGTERM")
    scene.come_back()
