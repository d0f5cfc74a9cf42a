"""kill -9 at random instants: nothing acknowledged is lost, nothing is done twice."""
import contextlib
import os
import signal
import subprocess
import threading

import grpc

from cases import COARSE, REAL, coarse, failing_check, fake, shipped
from fault import Fault
from oracle import undisturbed
from scene import TIED, alive, at_some_step, signal_process
from waiting import pause, until

TINY = ("steps=3", "steps=25 checkpoint=7")


class Kill(Fault):
    """Keeps real castings running and kills at random instants of their life."""
    at_once = 6
    seconds = 30.0
    worker = REAL
    settings = {"workers__restarts": 100}  # so many kills in one run are no fault of the case

    def disturb(self, scene, count):
        at_some_step(scene, self.keep_busy(scene), len(undisturbed(REAL, coarse()).steps))
        return self.kill(scene)

    @staticmethod
    def keep_busy(scene):
        """Two castings at once. Returns one of them."""
        unfinished = [job_id for job_id in scene.acknowledged if not scene.ended(job_id)]
        while len(unfinished) < 2:
            unfinished.append(scene.submit(scene.chance.choice((coarse, failing_check))()))
        return scene.chance.choice(unfinished)

    def kill(self, scene):
        """Returns False when there was nobody at this instant."""
        raise NotImplementedError


class KillWorker(Kill):
    """kill -9 of a worker in the middle of a real casting"""
    short, long = 5, 70

    def kill(self, scene):
        workers = scene.job_workers()
        return bool(workers) and signal_process(scene.chance.choice(workers), signal.SIGKILL)


class KillDaemon(Kill):
    """kill -9 of the daemon while real castings run; the next one adopts their workers"""
    short, long = 4, 60

    def kill(self, scene):
        scene.tell_daemon(signal.SIGKILL)
        pause(scene.chance, 0.3)
        # By now the kernel has ended those that had not settled in yet.
        self.led = {**getattr(self, "led", {}), **scene.claims()}
        scene.come_back()

    def look_back(self, scene, count):
        """A worker that had claimed its job's folder was the last one of its job."""
        for job_id, attempt in self.led.items():
            if scene.client.job(job_id).attempts != attempt:
                count.found("wrong", f"job {job_id}: the worker of attempt {attempt} was replaced")


class KillDaemonWithWorkers(Kill):
    """kill -9 of the daemon and, with it, of the workers of real castings"""
    short, long = 2, 30
    options = ("--worker-patience", "0")

    def kill(self, scene):
        workers = scene.job_workers()
        scene.tell_daemon(signal.SIGKILL)
        until(lambda: not any(alive(worker) for worker in workers), 10)
        scene.come_back()


class KillDaemonThenWorker(Kill):
    """kill -9 of the daemon, then of a worker that it left running"""
    short, long = 3, 40

    def kill(self, scene):
        scene.tell_daemon(signal.SIGKILL)
        pause(scene.chance, 0.2)
        workers = scene.job_workers()
        killed = bool(workers) and signal_process(scene.chance.choice(workers), signal.SIGKILL)
        scene.come_back()
        return killed


class KillEverything(Kill):
    """kill -9 of workers, client and daemon at once"""
    short, long = 3, 40

    def kill(self, scene):
        client = submitting_client(scene)
        pause(scene.chance, 0.05)
        for worker in scene.job_workers():
            signal_process(worker, signal.SIGKILL)
        scene.daemon.process.send_signal(signal.SIGKILL)
        end(client)
        scene.kill_daemon()
        scene.come_back()
        scene.send_again()


class KillClient(Fault):
    """kill -9 of the client while it submits and watches; the same request again"""
    short, long = 5, 40
    at_once = 5
    worker = REAL

    def disturb(self, scene, count):
        client = submitting_client(scene)
        pause(scene.chance, 0.4)
        end(client)
        scene.send_again()


@contextlib.contextmanager
def daemon_killed_meanwhile(scene):
    """kill -9 of the daemon within half a second; at the end the next daemon is there."""
    killed = threading.Timer(scene.chance.uniform(0.0, 0.5),
                             scene.daemon.process.send_signal, (signal.SIGKILL,))
    killed.start()
    yield
    killed.join()
    scene.daemon.wait()
    scene.come_back()


class KillUnderLoad(Fault):
    """kill -9 of the daemon while a client submits one tiny job after another"""
    short, long = 3, 30
    at_once = 3
    jobs = 15  # for each kill

    def disturb(self, scene, count):
        with daemon_killed_meanwhile(scene):
            for _ in range(self.jobs):
                scene.submit(fake(scene.chance.choice(TINY)))
        scene.send_again()


class KillDuringUploads(Fault):
    """kill -9 of the daemon while clients upload files of cases: no job lacks its file"""
    short, long = 3, 60
    at_once = 3
    jobs = 12  # for each kill

    def disturb(self, scene, count):
        with daemon_killed_meanwhile(scene):
            for _ in range(self.jobs):
                self.submit(scene)
        if os.listdir(scene.data("uploads")):
            count.found("wrong", "uploads of a killed daemon are left")
        unsure, scene.unsure = scene.unsure, []
        for expected in unsure:  # a client uploads the file again, too
            self.send(scene, expected)

    def begin(self, scene):
        self.contents = {}  # of the file of a request

    def submit(self, scene):
        expected = scene.next_request(fake(scene.chance.choice(TINY)), None)
        self.contents[expected.request_id] = scene.chance.randbytes(
            scene.chance.choice((10, 300_000, 1_000_000)))
        with contextlib.suppress(grpc.RpcError):  # the daemon has gone
            self.send(scene, expected)

    def send(self, scene, expected):
        named = scene.client.upload("slab.msh", self.contents[expected.request_id])
        expected.case.mesh.file = named.name
        scene.send(expected, attachments=[named])
        expected.case.mesh.ClearField("file")  # the fake worker does the same without it

    def look_back(self, scene, count):
        for job_id, expected in scene.acknowledged.items():
            path = scene.data("jobs", job_id, "attachments", "slab.msh")
            with open(path, "rb") as file:
                if file.read() != self.contents[expected.request_id]:
                    count.found("lost", f"job {job_id}: its file")


def submitting_client(scene):
    """The real client with a request_id of its own; whether it was heard, nobody knows."""
    expected = scene.next_request(coarse(), None)
    path = os.path.join(scene.folder, "case.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(shipped(*COARSE))
    expected.come_from(path)
    scene.unsure.append(expected)
    return subprocess.Popen([*TIED, *scene.submit_command(expected), "--watch"],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def end(process):
    process.kill()
    process.wait()
