"""Processes that are there and do nothing, or are told to leave: the watchdog and the ways out."""
import os
import resource
import signal

from cases import REAL, coarse, failing_check, fake
from disk import FailingDisk
from dccast.v1 import job_pb2
from fault import Fault
from oracle import must, undisturbed
from scene import Scene, alive, at_some_step, signal_process
from support import SANITIZED
from waiting import pause, until

# Short times, and still long against a machine that does other things too.
WATCHFUL = {"workers__heartbeat_interval": "0.2 s", "workers__heartbeat_timeout": "2 s",
            "workers__start_timeout": "2 s", "workers__restarts": 20}
PATIENCE = 12.0  # seconds until the watchdog must have acted


class TwoCastings(Fault):
    """Two real castings, and something at a random instant of their life."""
    worker = REAL

    def begin(self, scene):
        castings = [scene.submit(coarse()), scene.submit(failing_check())]
        at_some_step(scene, scene.chance.choice(castings), len(undisturbed(REAL, coarse()).steps))


class StopWorker(TwoCastings):
    """SIGSTOP of a worker in the middle of a real casting"""
    short, long = 2, 20
    settings = WATCHFUL

    def disturb(self, scene, count):
        workers = scene.busy_workers()
        if not workers:
            return self.begin(scene) or False
        stopped = scene.chance.choice(workers)
        signal_process(stopped, signal.SIGSTOP)
        must(count, lambda: not alive(stopped), "a worker that hangs is not killed", PATIENCE)
        signal_process(stopped, signal.SIGKILL)


def aim_at_files(scene, *own):
    """Names each file of the data folder to a worker, besides those of its own folder. Returns their number."""
    own = scene.data(*own)
    targets = [scene.data("pki", "server.key"), scene.data("users.toml"), scene.data("users.lock")]
    os.makedirs(scene.data("pki"), exist_ok=True)
    for path in targets:
        with open(path, "a", encoding="ascii"):
            pass
    targets = [os.path.join(folder, name) for folder, _, names in os.walk(scene.data())
               if not folder.startswith(own) for name in names]
    with open(os.path.join(own, "targets"), "w", encoding="utf-8") as file:
        file.write("\n".join(targets) + "\n")
    with open(os.path.join(own, "go"), "wb"):
        return len(targets)


def report_attack(scene, count, *own):
    """What an attack did from this folder."""
    with open(scene.data(*own, "taken"), encoding="utf-8") as file:
        for worked in file.read().splitlines():
            if SANITIZED and worked == "a shared mapping past worker_memory":
                continue  # a sanitizer needs memory without a bound (docs/build.md)
            count.found("wrong", f"the worker could do this: {worked}")


class WorkerTakenOver(Fault):
    """A worker taken over by its file attacks its daemon, its memory bound, and each file of the data folder"""
    short, long = 1, 5
    settings = {"workers__count": 1, "workers__memory": "300 MB"}
    attack = "steps=20 wait_at=1 attack=600000000"

    def disturb(self, scene, count):
        process = scene.daemon.process.pid
        before = self.state(process)
        attacking, waiting = scene.submit(fake(self.attack)), scene.submit(fake("steps=20"))
        scene.client.until_step(attacking, 1)
        count.measured("files", aim_at_files(scene, "jobs", attacking))
        for job_id in (attacking, waiting):
            must(count, lambda: scene.ended(job_id), f"job {job_id} does not end", 30)
        report_attack(scene, count, "jobs", attacking)
        if self.state(process) != before:
            count.found("wrong", "the daemon has other limits or another priority")

    @staticmethod
    def state(process):
        return (os.getpriority(os.PRIO_PROCESS, process),
                resource.prlimit(process, resource.RLIMIT_NOFILE))


class QueryTakenOver(Fault):
    """A worker that answers a query is taken over by its file: it reaches no file of another query, a job, a user or the daemon"""
    short, long = 1, 5
    attack = "steps=400 sleep_ms=10 wait_at=1 attack=1000"

    def disturb(self, scene, count):
        scene.submit(fake("steps=20"))
        scene.wait_until_ended()
        case = fake(self.attack)
        case.time.end_s -= 1  # another one than the job's, whose answer is there
        case.mesh.file = "slab.msh"
        query = scene.client.ask("QueryButtCurl", case=case,
                                 attachments=[scene.client.upload("slab.msh", b"a mesh")])
        next(query)
        until(lambda: os.listdir(scene.data("check")), 10)
        own = "check", os.listdir(scene.data("check"))[0]
        other = scene.data("check", "of-another-query")
        os.makedirs(other)
        with open(os.path.join(other, "slab.msh"), "wb") as file:
            file.write(b"a mesh of another user")
        count.measured("files", aim_at_files(scene, *own))
        while next(query).step.step < 3:
            pass
        report_attack(scene, count, *own)
        query.cancel()


class LimitedMemory(Fault):
    """Real castings with a random part of the memory they need (workers.memory)"""
    short, long = 2, 20
    worker = REAL

    def scene(self, chance):
        return Scene(chance, REAL, workers__memory=f"{chance.randint(1, 40)} MB")

    def disturb(self, scene, count):
        castings = [scene.submit(coarse()) for _ in range(2)]
        must(count, lambda: all(map(scene.ended, castings)), "a worker without memory hangs", 30)
        for casting in castings:
            failure = scene.client.job(casting).failure
            if failure.kind == job_pb2.Finding.OUT_OF_MEMORY:
                scene.acknowledged[casting].state = job_pb2.FAILED
                if "memory" not in failure.message:
                    count.found("wrong", f"job {casting} fails without words about memory")


class SilentWorker(Fault):
    """A worker that does not begin its job, three times"""
    short, long = 1, 5
    patience = 30.0

    def scene(self, chance):
        return FailingDisk(chance, **{**WATCHFUL, "workers__start_timeout": "1 s"})

    def disturb(self, scene, count):
        """Its claim on the folder takes 2 s, until three were killed for that."""
        scene.fail(0, "o", 1, "worker.lock")
        jobs = [scene.submit(fake("steps=20")) for _ in range(3)]
        must(count, lambda: scene.client.job(jobs[0]).attempts > 3, "a silent worker is not killed",
             PATIENCE)
        scene.heal()


class StalledWorker(Fault):
    """A worker that lives and makes no step: its job fails with that cause"""
    short, long = 1, 5
    patience = 10.0
    settings = {**WATCHFUL, "workers__restarts": 1, "workers__stall_timeout": "1 s"}

    def disturb(self, scene, count):
        stalled = scene.submit(fake("steps=5 sleep_ms=100000"), job_pb2.FAILED)
        scene.submit(fake("steps=20"))
        must(count, lambda: scene.ended(stalled), "a worker without a step keeps its slot", PATIENCE)


class RunsThatEnd(Fault):
    """Runs end while no daemon follows them, and their workers are killed after that."""
    short, long = 1, 10
    settings = {"workers__restarts": 0}
    case = "steps=30 checkpoint=7 sleep_ms=5 wait_at=20"

    def begin(self, scene):
        self.jobs = [scene.submit(fake(self.case)) for _ in range(2)]
        for job_id in self.jobs:
            scene.client.until_step(job_id, 20)

    def disturb(self, scene, count):
        self.interrupt(scene)
        workers = scene.job_workers()
        for job_id in self.jobs:
            with open(scene.data("jobs", job_id, "go"), "wb"):
                pass
        until(lambda: all(os.path.exists(scene.data("jobs", job_id, "results.h5"))
                          for job_id in self.jobs), 10)
        pause(scene.chance, 1.0)
        for worker in workers:
            signal_process(worker, signal.SIGKILL)
        self.go_on(scene)

    def look_back(self, scene, count):
        for job_id in self.jobs:
            if scene.client.job(job_id).attempts != 1:
                count.found("wrong", f"job {job_id} had ended and was computed again")


class StopDaemonWhileRunsEnd(RunsThatEnd):
    """SIGSTOP of the daemon while runs end, and kill -9 of their workers: nothing is computed again"""

    @staticmethod
    def interrupt(scene):
        scene.daemon.process.send_signal(signal.SIGSTOP)

    @staticmethod
    def go_on(scene):
        scene.daemon.process.send_signal(signal.SIGCONT)


class KillDaemonWhileRunsEnd(RunsThatEnd):
    """kill -9 of the daemon before runs end, and of their workers after: the next daemon settles them"""
    options = ("--worker-patience", "60")

    @staticmethod
    def interrupt(scene):
        scene.tell_daemon(signal.SIGKILL)

    @staticmethod
    def go_on(scene):
        scene.come_back()


class StopWorkerAndLeave(TwoCastings):
    """SIGSTOP of a worker, then SIGTERM of the daemon"""
    short, long = 1, 10
    settings = {**WATCHFUL, "workers__stop_grace": "1 s"}

    def disturb(self, scene, count):
        for worker in scene.busy_workers()[:1]:
            signal_process(worker, signal.SIGSTOP)
        leave_and_come_back(scene, count)


class TellDaemon(TwoCastings):
    """SIGTERM of the daemon while real castings run"""
    short, long = 2, 30

    def disturb(self, scene, count):
        leave_and_come_back(scene, count)


class TellWorker(TwoCastings):
    """SIGTERM of a worker in the middle of a real casting"""
    short, long = 2, 30

    def disturb(self, scene, count):
        for worker in scene.busy_workers()[:1]:
            signal_process(worker, signal.SIGTERM)


def leave_and_come_back(scene, count):
    code = scene.tell_daemon(signal.SIGTERM)
    if code != 0:
        count.found("wrong", f"dccastd ended with {code} after SIGTERM")
    if scene.job_workers():
        count.found("wrong", "a worker outlives an orderly stop")
    scene.come_back()
