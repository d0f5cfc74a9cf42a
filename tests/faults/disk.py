"""A disk that refuses for a while: full, read-only, failing; and too few descriptors."""
import contextlib
import ctypes
import errno
import functools
import os
import resource
import shutil
import subprocess
import tempfile
import time

import grpc

from cases import FAKE, fake
from dccast.v1 import job_pb2, service_pb2
from fault import Fault
from oracle import Count, must
from scene import Scene, limit, preloading
from waiting import pause, turns

HELD = 10.0  # seconds until the queue must be seen to be held
HOLDING = "steps=3000 checkpoint=1000 sleep_ms=5"  # while the queue fills up
RUNNING = "steps=60 checkpoint=7 sleep_ms=20"
WAITING = "steps=3"
WRITES = "wson"  # write, sync, open for writing, rename: see README.md


class FailingDisk(Scene):
    """A scene on whose folder calls fail while an order to do so stands."""

    def __init__(self, chance, **settings):
        super().__init__(chance, FAKE, prepare=self.preload,
                         **{"workers__count": 1, "limits__minimum_free": "0 bytes", **settings})

    def preload(self, _):
        self.order = os.path.join(self.folder, "order")
        self.daemon.through = preloading("failing_disk.so", DCCAST_FAULT_FILE=self.order,
                                         DCCAST_FAULT_FOLDER=self.data())

    def fail(self, error, calls=WRITES, times=-1, part="-"):
        """From now on these calls fail so often in each process, on paths with this part."""
        with open(self.order + ".next", "w", encoding="ascii") as file:
            file.write(f"{error} {calls} {times} {part}")
        os.rename(self.order + ".next", self.order)

    def heal(self):
        if os.path.exists(self.order):
            os.remove(self.order)


def queue_up(scene, waiting=20):
    """One job that runs, others behind it. Returns the id of the last of them."""
    holder = scene.submit(fake(HOLDING), job_pb2.CANCELLED)
    for _ in range(waiting):
        last = scene.submit(fake(WAITING))
    running = scene.submit(fake(RUNNING), priority=job_pb2.HIGH)
    scene.client.cancel(holder)
    scene.client.until_step(running, 5)
    return last


def must_be_held(scene, count, waiting):
    """Clients see why nothing starts, and a submission is refused, not lost."""
    must(count, lambda: scene.info().storage_fault, "GetServerInfo does not say that the queue is held",
         HELD)
    must(count, lambda: scene.client.job(waiting).held, "a waiting job does not say why it waits", 2)
    scene.submit(fake(WAITING))
    for expected in scene.unsure:
        if expected.refusal.code() not in (grpc.StatusCode.RESOURCE_EXHAUSTED,
                                           grpc.StatusCode.UNAVAILABLE):
            count.found("wrong", f"a submission gets {expected.refusal.code().name}: "
                        + expected.refusal.details())


class Refusal(Fault):
    """One job runs and 20 wait while the disk refuses; then it is well again."""
    short, long = 1, 12
    seconds = 40.0
    patience = 40.0
    error, calls = 0, WRITES

    def scene(self, chance):
        return FailingDisk(chance)

    def disturb(self, scene, count):
        waiting = queue_up(scene)
        pause(scene.chance, 0.3)
        scene.fail(self.error, self.calls)
        must_be_held(scene, count, waiting)
        scene.heal()


class DiskFull(Refusal):
    """ENOSPC from every write; later there is space again"""
    error, calls = errno.ENOSPC, "won"


class DiskReadOnly(Refusal):
    """EROFS from every write and open; later writing works again"""
    error = errno.EROFS


class DiskFails(Refusal):
    """EIO from every write and sync; later they work again"""
    error, calls = errno.EIO, "ws"


class SyncFails(Refusal):
    """EIO from every fsync and nothing else"""
    error, calls = errno.EIO, "s"


class SlowDisk(Fault):
    """Every fsync takes 2 s while a job ends and two are cancelled; questions are answered in 50 ms"""
    short, long = 1, 6
    seconds = 60.0
    patience = 60.0
    slowest = 0.05

    def scene(self, chance):
        return FailingDisk(chance, workers__count=2)

    def disturb(self, scene, count):
        waiting = [scene.submit(fake(HOLDING), state) for state in (job_pb2.CANCELLED, None)]
        for job_id in waiting:
            scene.client.until_step(job_id, 1)
        ends = scene.submit(fake("steps=3"), priority=job_pb2.HIGH)
        idle = scene.submit(fake(WAITING), job_pb2.CANCELLED)
        scene.fail(0, "s")
        # Kept until they are answered: a call that no one refers to is cancelled, maybe before it is served.
        cancels = [scene.client.stub.CancelJob.future(service_pb2.CancelJobRequest(id=job_id))
                   for job_id in (waiting[0], idle)]
        calls = {
            "GetJob": lambda: scene.client.job(ends),
            "ListJobs": lambda: scene.client.ask("ListJobs"),
            # The first event of each: a later one may not have been made yet.
            "WatchJob of a job that runs": lambda: next(scene.client.watch(waiting[1])),
            "WatchJob of a job that ends": lambda: next(scene.client.watch(ends)),
        }
        slow = {}
        for _ in turns(10, 0.01):
            if scene.ended(ends):
                break
            for name, call in calls.items():
                begin = time.monotonic()
                call()
                slow[name] = max(slow.get(name, 0.0), time.monotonic() - begin)
        scene.heal()
        for cancel in cancels:
            cancel.result(timeout=20)
        for name, seconds in slow.items():
            if seconds > self.slowest:
                count.found("wrong", f"{name} took {seconds * 1e3:.0f} ms beside a slow disk")
        if not slow:
            count.found("wrong", "nothing was asked beside the slow disk")


class FilledDisk(Fault):
    """One job runs and 20 wait while a disk of their own is full; then it is emptied."""
    short, long = 1, 10
    seconds = 40.0
    patience = 40.0
    size = ""  # for mount

    def attempt(self, chance, most):
        if not mounts_of_our_own():
            return Count(notes=["not tried: only root can mount a disk"])
        self.disk = tempfile.mkdtemp(prefix="dccast-faults-disk-")
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", self.size, "tmpfs", self.disk],
                                 capture_output=True, text=True, check=False)
        try:
            if mounted.returncode != 0:
                return Count(notes=[f"not tried: {mounted.stderr.strip()}"])
            return super().attempt(chance, most)
        finally:
            subprocess.run(["umount", "--lazy", self.disk], stderr=subprocess.DEVNULL, check=False)
            os.rmdir(self.disk)

    def scene(self, chance):
        folder = os.path.join(self.disk, "scene")
        os.mkdir(folder)
        return Scene(chance, FAKE, folder=folder, workers__count=1, limits__minimum_free="1 MB")

    def disturb(self, scene, count):
        waiting = queue_up(scene)
        pause(scene.chance, 0.3)
        ballast = os.path.join(self.disk, "ballast")
        os.mkdir(ballast)
        self.fill(ballast)
        must_be_held(scene, count, waiting)
        shutil.rmtree(ballast)

    def fill(self, folder):
        raise NotImplementedError


class SmallDisk(FilledDisk):
    """A small tmpfs filled to the last byte; later emptied (root only)"""
    size = "size=48m"

    def fill(self, folder):
        fill(os.path.join(folder, "bytes"))


class ExhaustedInodes(FilledDisk):
    """A tmpfs with space and no inode left; later emptied (root only)"""
    size = "size=256m,nr_inodes=2000"

    def fill(self, folder):
        with contextlib.suppress(OSError):
            for number in range(4000):
                os.mknod(os.path.join(folder, str(number)))


@functools.cache
def mounts_of_our_own():
    """From now on what this process mounts is seen by it and its children alone, and goes with them."""
    new_mount_namespace = 0x00020000  # CLONE_NEWNS
    if ctypes.CDLL(None).unshare(new_mount_namespace) != 0:
        return False
    return subprocess.run(["mount", "--make-rprivate", "/"], check=False).returncode == 0


def fill(path):
    """Writes a file that takes all the space."""
    with open(path, "wb", buffering=0) as file:
        for size in (1 << 20, 1 << 12, 1):
            try:
                while True:
                    file.write(bytes(size))
            except OSError as error:
                if error.errno != errno.ENOSPC:
                    raise


class LimitedDescriptors(Fault):
    """The daemon gets no further descriptor (RLIMIT_NOFILE)"""
    short, long = 1, 10
    seconds = 40.0
    patience = 40.0
    settings = {"workers__count": 1, "workers__start_timeout": "3 s"}

    def disturb(self, scene, count):
        process = scene.daemon.process.pid
        try:
            open_now = len(os.listdir(f"/proc/{process}/fd"))
        except PermissionError:
            return False  # a daemon lets only root look into it
        queue_up(scene)
        before = limit(process, resource.RLIMIT_NOFILE, open_now)
        pause(scene.chance, 3.0)
        limit(process, resource.RLIMIT_NOFILE, before)
        return True

    def look_back(self, scene, count):
        """The daemon's own lack is no loss of a worker."""
        for job_id in scene.acknowledged:
            if "died" in scene.client.job(job_id).failure.message:
                count.found("wrong", f"job {job_id}: the daemon's lack counts as a worker's death")


class FailedStart(Fault):
    """The start of a waiting job fails with EROFS or EMFILE, a few times"""
    short, long = 2, 20
    patience = 20.0

    def scene(self, chance):
        return FailingDisk(chance)

    def disturb(self, scene, count):
        error, calls = scene.chance.choice(((errno.EROFS, WRITES), (errno.EMFILE, "or")))
        running = scene.submit(fake("steps=30 sleep_ms=10"))
        waiting = scene.submit(fake(WAITING))
        scene.fail(error, calls, scene.chance.randint(1, 6), waiting)
        must(count, lambda: scene.ended(running), "the running job does not end", 20)
        pause(scene.chance, 1.0)
        scene.heal()


class UnreadableJob(Fault):
    """EIO from every read of the description of one waiting job: it fails alone, and those behind it run"""
    short, long = 1, 10
    patience = 20.0

    def scene(self, chance):
        return FailingDisk(chance)

    def disturb(self, scene, count):
        running = scene.submit(fake("steps=30 sleep_ms=10"))
        unreadable = scene.submit(fake(WAITING), job_pb2.FAILED)
        waiting = scene.submit(fake(WAITING))
        scene.fail(errno.EIO, "r", -1, f"{unreadable}/description.bin")
        for job_id in (running, unreadable, waiting):
            must(count, lambda: scene.ended(job_id), f"job {job_id} does not end", 30)
        scene.heal()
        if scene.client.job(unreadable).failure.kind != job_pb2.Finding.STORAGE:
            count.found("wrong", "the job fails for another reason")


class FailedOrder(Fault):
    """What a cancel and a pause have in common: their first write fails, a later one does not."""
    short, long = 2, 20
    at_once = 2
    patience = 8.0
    wanted = job_pb2.CANCELLED

    def order(self, scene, job_id):
        raise NotImplementedError

    def scene(self, chance):
        return FailingDisk(chance)

    def begin(self, scene):
        running = scene.submit(fake("steps=2000 sleep_ms=10 checkpoint=50"), self.wanted)
        waiting = scene.submit(fake("steps=2000 sleep_ms=10"), self.wanted)
        scene.submit(fake(WAITING))
        scene.client.until_step(running, 3)
        scene.to_order = [running, waiting]

    def disturb(self, scene, count):
        self.order_against_a_failing_disk(scene, scene.to_order.pop(), count)

    def order_against_a_failing_disk(self, scene, job_id, count):
        scene.fail(errno.ENOSPC, "won", 4, "jobs.sqlite")
        try:
            self.order(scene, job_id)
        except grpc.RpcError as error:
            if error.code() == grpc.StatusCode.INTERNAL:
                count.found("wrong", f"an order gets INTERNAL: {error.details()}")
        scene.heal()
        must(count, lambda: self.obeyed(scene, job_id), "an order is refused for ever", 8)

    def obeyed(self, scene, job_id):
        self.order(scene, job_id)
        return True


class CancelWriteFails(FailedOrder):
    """A cancel whose first write fails (ENOSPC), of a running and of a waiting job"""

    def order(self, scene, job_id):
        scene.client.cancel(job_id)


class PauseWriteFails(FailedOrder):
    """A pause whose first write fails (ENOSPC), of a running and of a waiting job"""
    wanted = job_pb2.PAUSED

    def order(self, scene, job_id):
        scene.client.ask("PauseJob", id=job_id)


class RefusedCancel(Fault):
    """A cancel of a waiting job that fails and is not tried again"""
    short, long = 1, 10
    patience = 15.0

    def scene(self, chance):
        return FailingDisk(chance)

    def disturb(self, scene, count):
        running = scene.submit(fake("steps=40 sleep_ms=10"))
        waiting = scene.submit(fake(WAITING))
        scene.client.until_step(running, 3)
        scene.fail(errno.ENOSPC, "won", 4, scene.chance.choice(("jobs.sqlite", waiting)))
        try:
            scene.client.cancel(waiting)
            scene.acknowledged[waiting].state = job_pb2.CANCELLED
        except grpc.RpcError:
            pass  # not accepted: it runs on
        scene.heal()
