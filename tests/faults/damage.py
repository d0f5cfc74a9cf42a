"""Flipped bits in every file of a state folder. Damage is told; what it did not hit is as it was."""
import atexit
import contextlib
import functools
import os
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time

import grpc

from cases import FAKE, REAL, coarse, failing_check, fake
from dccast.v1 import follow_pb2, line_pb2, service_pb2
from fault import Fault
from oracle import Count, judge, must
from scene import Scene
from support import BIN

OLD_STORE = "jobs.sqlite.old"  # a backup made on the way
CHECKPOINT_VERSION = 8  # first byte of the version in the file: core/results/CHECKPOINT.md


class Template:
    """A state folder with ended, running and waiting jobs, whose daemon is gone; copied for each try."""

    def __init__(self, worker, kill):
        self.worker = worker
        self.folder = tempfile.mkdtemp(prefix="dccast-faults-template-")
        atexit.register(shutil.rmtree, self.folder, ignore_errors=True)
        # A folder of the daemon's, not the scene's own, which goes with it.
        with Scene(None, worker, workers__count=1) as scene:
            self.fill(scene)
            scene.kill_daemon() if kill else scene.daemon.terminate()
            shutil.copytree(scene.data(), self.folder, dirs_exist_ok=True, ignore=sockets)
            self.acknowledged = dict(scene.acknowledged)

    def fill(self, scene):
        if self.worker == REAL:
            self.ended = [scene.submit(coarse())]
            scene.wait_until_ended()
            self.running = scene.submit(failing_check())
            self.waiting = [scene.submit(coarse())]
            scene.client.until_step(self.running, 60)
            return
        self.ended = [scene.submit(fake("steps=30 checkpoint=7")) for _ in range(3)]
        back_up(scene.data("jobs.sqlite"), scene.data(OLD_STORE))
        scene.wait_until_ended()
        self.running = scene.submit(fake("steps=60 checkpoint=7 sleep_ms=20"))
        self.waiting = [scene.submit(fake("steps=20")) for _ in range(3)]
        scene.client.until_step(self.running, 16)

    def copy(self, chance):
        """A scene on a copy, not yet begun."""
        def put_in_place(scene):
            shutil.copytree(self.folder, scene.data())
            scene.acknowledged = dict(self.acknowledged)
        return Scene(chance, self.worker, prepare=put_in_place, workers__count=2)


def back_up(store, target):
    """As an administrator does it, with SQLite's own means, while the daemon runs."""
    with contextlib.closing(sqlite3.connect(store)) as source, \
         contextlib.closing(sqlite3.connect(target)) as copy:
        source.backup(copy)


def sockets(folder, names):
    return [name for name in names if name.endswith(".sock")]


@functools.cache
def template(worker=FAKE, kill=True):
    return Template(worker, kill)


def flip_a_bit(chance, path, first=0, end=None):
    """One bit of the file, of its bytes from `first` to before `end`. Returns where."""
    size = os.path.getsize(path)
    at = chance.randrange(first, min(end or size, size))
    with open(path, "r+b") as file:
        file.seek(at)
        byte = file.read(1)[0] ^ 1 << chance.randrange(8)
        file.seek(at)
        file.write(bytes([byte]))
    return at


def begin_or_repair(scene, count):
    """Starts the daemon; where it refuses, does what it says is the remedy. Returns whether it runs."""
    try:
        scene.come_back()
        return True
    except RuntimeError as refused:
        if "dccastd check --repair" not in str(refused):
            count.found("wrong", f"it refuses to start without a remedy: {refused}")
    try:
        scene.state_command("check", "--repair")
        scene.come_back()
        return True
    except RuntimeError as refused:
        for job_id in scene.acknowledged:
            count.found("lost", f"job {job_id}: it does not start again: {refused}")
        return False


class Damage(Fault):
    """A copy of a template, damaged, started, repaired where it asks for it, and judged."""
    short, long = 2, 60
    seconds = 12.0
    patience = 20.0
    kill = True

    def attempt(self, chance, most):
        count = Count(tried=1)
        there = template(self.worker, self.kill)
        scene = there.copy(chance)
        try:
            torn = self.damage(chance, scene, there)
            if self.start(scene, count):
                self.judge(scene, there, count, torn or ())
        finally:
            scene.clear_away()
        return count

    def start(self, scene, count):
        return begin_or_repair(scene, count)

    def judge(self, scene, there, count, torn):
        count.add(judge(scene, self.patience, torn))

    def damage(self, chance, scene, there):
        """Returns ids of jobs whose event log was hit, if any was."""
        raise NotImplementedError


class FlipEventLog(Damage):
    """One bit flipped in the event log of an ended, running or waiting job"""

    def damage(self, chance, scene, there):
        job_id = chance.choice(list(scene.acknowledged))
        flip_a_bit(chance, scene.data("jobs", job_id, "events.log"))
        return [job_id]


class OverwriteEventLogBeginning(Damage):
    """Header and first event of the event log of a waiting job overwritten: it runs all the same"""
    short, long = 2, 20

    def damage(self, chance, scene, there):
        job_id = chance.choice(there.waiting)
        with open(scene.data("jobs", job_id, "events.log"), "r+b") as file:
            file.write(chance.randbytes(chance.randrange(17, 40)))
        return [job_id]


class ReplaceEventLog(Damage):
    """The event log of a waiting job replaced by a folder, a link or a named pipe: it runs all the same"""
    short, long = 3, 18
    kinds = (os.mkdir, os.mkfifo, lambda path: os.symlink(path + ".elsewhere", path))

    def damage(self, chance, scene, there):
        job_id = chance.choice(there.waiting)
        path = scene.data("jobs", job_id, "events.log")
        os.remove(path)
        chance.choice(self.kinds)(path)
        return [job_id]


class FlipStore(Damage):
    """One bit flipped in jobs.sqlite after an orderly stop"""
    kill = False

    def damage(self, chance, scene, there):
        flip_a_bit(chance, scene.data("jobs.sqlite"))


class FlipWalHeader(Damage):
    """One bit flipped in the header of jobs.sqlite-wal after kill -9"""

    def damage(self, chance, scene, there):
        flip_a_bit(chance, scene.data("jobs.sqlite-wal"), end=32)


class FlipWalPage(Damage):
    """One bit flipped in the pages of jobs.sqlite-wal after kill -9"""

    def damage(self, chance, scene, there):
        flip_a_bit(chance, scene.data("jobs.sqlite-wal"), first=32)


class FlipJournal(Damage):
    """One bit flipped in journal.bin of a killed real casting"""
    worker = REAL

    def damage(self, chance, scene, there):
        flip_a_bit(chance, scene.data("jobs", there.running, "journal.bin"))


class FlipCheckpoint(Damage):
    """One bit flipped in checkpoint.bin of a killed real casting"""
    worker = REAL

    def damage(self, chance, scene, there):
        flip_a_bit(chance, scene.data("jobs", there.running, "checkpoint.bin"))


class OtherCheckpointVersion(Damage):
    """checkpoint.bin of another version in a killed real casting"""
    short, long = 1, 10
    worker = REAL

    def damage(self, chance, scene, there):
        path = scene.data("jobs", there.running, "checkpoint.bin")
        with open(path, "r+b") as file:
            file.seek(CHECKPOINT_VERSION)
            file.write(bytes([chance.randrange(2, 256)]))


class TruncateFile(Damage):
    """journal.bin, checkpoint.bin or events.log of a killed real casting cut short"""
    short, long = 2, 30
    worker = REAL

    def damage(self, chance, scene, there):
        name = chance.choice(("journal.bin", "checkpoint.bin", "events.log"))
        path = scene.data("jobs", there.running, name)
        os.truncate(path, chance.randrange(os.path.getsize(path)))
        return [there.running] if name == "events.log" else []


class FlipAnyFile(Damage):
    """One bit flipped in any file of the state folder but results and texts for people"""
    short, long = 3, 120
    seconds = 20.0
    worker = REAL
    # Their digest is compared when they are fetched: FlipResults.
    left_out = ("results.h5", "results.xdmf", "results-end.xdmf", "run.json", "worker.log", "lock",
                OLD_STORE)

    def damage(self, chance, scene, there):
        files = sorted(os.path.join(folder, name) for folder, _, names in os.walk(scene.data())
                       for name in names if name not in self.left_out)
        path = chance.choice([path for path in files if os.path.getsize(path) > 0])
        flip_a_bit(chance, path)
        folder, name = os.path.split(path)
        return [os.path.basename(folder)] if name == "events.log" else []


class StrangeFiles(Fault):
    """A pipe in place of a line, a study or the key of TLS, a file in place of a folder: named, all go on"""
    short = long = 1

    def disturb(self, scene, count):
        scene.submit(fake("steps=20"))
        scene.tell_daemon(signal.SIGTERM)
        for folder in ("lines", "studies"):
            os.makedirs(scene.data(folder), exist_ok=True)
        os.mkfifo(scene.data("lines", "strange.bin"))
        os.mkfifo(scene.data("studies", "00000000-0000-4000-8000-000000000000.bin"))
        with open(scene.data("quarantine"), "wb"):
            pass
        scene.come_back()

        stub = scene.client.stub
        stub.GetServerInfo(service_pb2.GetServerInfoRequest(), timeout=5)
        lines = stub.ListLines(line_pb2.ListLinesRequest(), timeout=5)
        if list(lines.damaged) != ["strange"]:
            count.found("wrong", f"the strange line is not named: {lines}")
        scene.submit(fake("steps=20"))

        scene.tell_daemon(signal.SIGTERM)
        for name in ("lines", "studies", "uploads"):
            if os.path.isdir(scene.data(name)):
                os.rename(scene.data(name), scene.data(name + ".before"))
            with open(scene.data(name), "wb"):
                pass
        scene.come_back()
        if scene.client.ask("ListLines").lines:
            count.found("wrong", "a file in place of the lines has lines")
        for name in ("lines", "studies", "uploads"):
            if f"{scene.data(name)}.aside" not in scene.daemon.said():
                count.found("wrong", f"the file in place of {name} is not named")
        scene.submit(fake("steps=20"))

        scene.tell_daemon(signal.SIGTERM)
        self.replace_key(scene, count)
        scene.come_back()

    @staticmethod
    def replace_key(scene, count):
        """A daemon whose key is a pipe ends with a reason, and does not wait for it."""
        key = os.path.join(scene.folder, "key.pem")
        os.mkfifo(key)
        command = [*scene.daemon.command(), "--set", "listen.tls=127.0.0.2:0", "--set",
                   f"tls.certificate={key}", "--set", f"tls.key={key}", "--set", f"tls.ca={key}"]
        ended = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
        if ended.returncode == 0 or "named pipe" not in ended.stderr:
            count.found("wrong", f"a key that is a pipe: {ended.returncode}, {ended.stderr}")


class CastingKeptFromItsLine(Fault):
    """kill -9 between a job and its line, as the disk shows it: the next daemon adds the casting, once"""
    short = long = 1

    def disturb(self, scene, count):
        following = follow_pb2.Following(line="pit-3")
        casting = scene.submit(fake("steps=100000 sleep_ms=10"), following=following)
        scene.acknowledged.pop(casting)
        scene.foreign_jobs.add(casting)
        for there in (False, True):  # the line without it, then with it
            scene.kill_daemon()
            if not there:
                os.remove(scene.data("lines", "pit-3.bin"))
            scene.come_back()
            line = scene.client.ask("GetLine", id="pit-3")
            if [each.job for each in line.castings] != [casting]:
                count.found("lost", f"castings of the line: {[each.job for each in line.castings]}")
        scene.client.cancel(casting)
        must(count, lambda: scene.ended(casting), "the casting does not end", 30)


class DamageOfOneJob(Fault):
    """A file of one job's folder flipped, cut, emptied, missing, a pipe, a link or a folder: no queue is held"""
    short, long = 6, 200
    seconds = 250.0
    worker = REAL
    others = 3
    longest = 60.0  # seconds for the jobs of others: half a second each, at nice 19 on a busy machine

    def begin(self, scene):
        """A job that follows a casting, whose daemon and worker are killed."""
        following = follow_pb2.Following(gauges=[follow_pb2.Gauge(monitor="corner", noise_m=1e-3)])
        self.job = scene.submit(coarse(), following=following)
        scene.acknowledged.pop(self.job)
        scene.foreign_jobs.add(self.job)
        readings = [follow_pb2.Reading(number=number, time_s=-61.0 + number)
                    for number in range(1, 101)]
        scene.client.ask("AppendReadings", id=self.job, readings=readings)
        scene.client.until_step(self.job, 10)
        scene.kill_daemon()

    def disturb(self, scene, count):
        folder = scene.data("jobs", self.job)
        files = sorted(name for name in os.listdir(folder)
                       if os.path.isfile(os.path.join(folder, name)))
        damage, name = scene.chance.choice(DAMAGES), scene.chance.choice(files)
        path = os.path.join(folder, name)
        damage(scene.chance, path)
        if not begin_or_repair(scene, count):
            return
        self.submit_others(scene, count, f"{name} {damage.__name__}")

    def submit_others(self, scene, count, damaged):
        ids = []
        for _ in range(self.others):
            ids.append(scene.submit(coarse()))
            if ids[-1] is None:
                count.found("wrong", f"{damaged}: a submission is refused: "
                            f"{scene.unsure[-1].refusal.details()}")
            time.sleep(0.5)  # the pace of the others
        must(count, lambda: all(map(scene.ended, filter(None, ids))),
             f"{damaged}: jobs of others do not end", self.longest)
        if held := scene.info().storage_fault:
            count.found("wrong", f"{damaged}: the queue is held: {held}")
        with contextlib.suppress(grpc.RpcError):  # it may have failed or be gone
            scene.client.cancel(self.job)


def flipped(chance, path):
    if os.path.getsize(path) > 0:
        flip_a_bit(chance, path)


def cut(chance, path):
    os.truncate(path, chance.randrange(os.path.getsize(path) + 1))


def emptied(_, path):
    os.truncate(path, 0)


def missing(_, path):
    os.remove(path)


def a_pipe(_, path):
    os.remove(path)
    os.mkfifo(path)


def a_link(_, path):
    os.rename(path, path + ".elsewhere")
    os.symlink(path + ".elsewhere", path)


def a_folder(_, path):
    os.remove(path)
    os.mkdir(path)


DAMAGES = (flipped, cut, emptied, missing, a_pipe, a_link, a_folder)


class FlipResults(Damage):
    """One bit flipped in results.h5: fetch, frames and reports refuse it"""
    short, long = 2, 20
    worker = REAL

    def damage(self, chance, scene, there):
        flip_a_bit(chance, scene.data("jobs", there.ended[0], "results.h5"))

    def judge(self, scene, there, count, torn):
        self.fetch(scene, there.ended[0], count)
        self.show(scene, there.ended[0], count)

    @staticmethod
    def fetch(scene, job_id, count):
        target = os.path.join(scene.folder, "fetched.h5")
        ended = subprocess.run([os.path.join(BIN, "dccast"), "--server", scene.daemon.address,
                                "fetch", job_id, "-o", target], capture_output=True, text=True,
                               timeout=60, check=False)
        if ended.returncode == 0 or os.path.exists(target):
            count.found("wrong", "a damaged result was fetched as if it were sound")
        elif not ended.stderr.strip():
            count.found("wrong", "fetch failed without a word")

    @staticmethod
    def show(scene, job_id, count):
        """A frame is refused; a report says that it goes without, and ends as a fetch does."""
        not_what_was_written = 4  # exit code, docs/commands.md
        try:
            scene.client.ask("QueryResult", id=job_id, frame=True)
            count.found("wrong", "a frame of a damaged result was shown")
        except grpc.RpcError as error:
            if error.code() is not grpc.StatusCode.DATA_LOSS:
                count.found("wrong", f"a frame: {error.code().name}: {error.details()}")
        report = os.path.join(scene.folder, "report.html")
        ended = subprocess.run([os.path.join(BIN, "dccast"), "--server", scene.daemon.address,
                                "report", job_id, "-o", report], capture_output=True, text=True,
                               timeout=60, check=False)
        if ended.returncode != not_what_was_written or "without a picture" not in ended.stderr:
            count.found("wrong", f"the report: {ended.returncode}, {ended.stderr}")
