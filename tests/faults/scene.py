"""A daemon with a folder of its own, and the book of what it has acknowledged."""
import contextlib
import hashlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import tempfile
import uuid

import grpc

from cases import FAKE
from dccast.v1 import job_pb2
from support import BIN, TERMINAL, Client, Daemon, start_ticks
from waiting import pause, until

# Whatever the harness starts dies with it, also when the harness is killed.
TIED = ("setpriv", "--pdeathsig", "KILL")

# Of the request ids that the command line client derives, proto/values/digests.cpp.
CLIENT_IDS = uuid.UUID("5c1be90a-7d42-4f06-9a33-60d82eb791c4")


def preloading(library, **variables):
    """The words before a command that give it a library of this folder. The loader starts a program also
    without a library that is not there."""
    path = os.path.join(BIN, library)
    if not os.path.exists(path):
        raise FileNotFoundError(f"{path}: build it first")
    return ("env", f"LD_PRELOAD={path}", *(f"{name}={value}" for name, value in variables.items()))


class Daemons(Daemon):
    """A daemon started through other programs, which set its limits and then become it."""
    through = ()

    def command(self):
        return [*TIED, *self.through, *super().command()]


class Scene:
    """One try of a fault: begins with a running daemon, ends with nothing left of it."""

    def __init__(self, chance, worker=FAKE, through=(), folder=None, prepare=None, options=(),
                 **settings):
        """prepare: called with the scene before the daemon starts, to set up what needs its folder."""
        self.chance = chance
        self.worker = worker
        self.folder = folder or tempfile.mkdtemp(prefix="dccast-faults-")
        self.daemon = Daemons(self.folder, worker, options=options,
                              **{"workers__stop_grace": "5 s", **settings})
        self.daemon.through = through
        self.acknowledged = {}  # id of a job -> Expected
        self.unsure = []        # submissions whose answer never came
        self.foreign_jobs = set()  # ids of jobs that came of nonsense, which nobody answers for
        self.clients = []
        self.numbers = 0
        if prepare:
            prepare(self)

    def __enter__(self):
        try:
            self.come_back()
        except BaseException:
            self.clear_away()
            raise
        return self

    def __exit__(self, *_):
        self.clear_away()

    def clear_away(self):
        self.stop_everything()
        shutil.rmtree(self.folder, ignore_errors=True)

    def stop_everything(self):
        for client in self.clients:
            client.close()
        self.clients.clear()
        if self.daemon.running():
            self.daemon.kill()
        self.daemon.end_workers()

    def come_back(self):
        """Starts the daemon on its folder and connects to it."""
        self.daemon.start()
        self.client = self.connected()

    def connected(self):
        self.clients.append(Client(self.daemon.address))
        return self.clients[-1]

    def data(self, *names):
        return os.path.join(self.folder, "data", *names)

    def job_workers(self):
        """Workers that run a job."""
        return [(process, start_ticks(process)) for process in self.daemon.worker_processes()]

    def busy_workers(self):
        """Workers that have a file of a job open."""
        return [worker for worker in self.job_workers()
                if any(name.startswith(self.data("jobs")) for name in open_files(worker[0]))]

    def tell_daemon(self, number):
        """Sends it a signal that ends it. Returns its exit code; its workers may run on."""
        self.daemon.process.send_signal(number)
        return self.daemon.wait()

    def kill_daemon(self):
        """kill -9; its workers are ended too, as when the machine stops."""
        self.tell_daemon(signal.SIGKILL)
        self.daemon.end_workers()

    def claims(self):
        """Folders of jobs that a living process claims. Returns attempts by job."""
        with open("/proc/locks", encoding="ascii") as file:
            locked = {line.split()[-3].rsplit(":", 1)[1] for line in file if " POSIX " in line}
        found = {}
        for job_id in self.acknowledged:
            path = self.data("jobs", job_id, "worker.lock")
            with contextlib.suppress(OSError):
                if str(os.stat(path).st_ino) in locked:
                    with open(path, encoding="ascii") as file:
                        found[job_id] = int(file.read().split()[1])
        return found

    def next_request(self, case, state):
        self.numbers += 1
        return Expected(case, state, f"request-{self.numbers}")

    def submit(self, case, state=None, **rest):
        """Submits, and notes what came of it. Returns the job's id, or None without an answer.

        state: what the job must end in; None for what an undisturbed run ends in.
        """
        return self.send(self.next_request(case, state), **rest)

    def submit_command(self, expected):
        """The command line client with this submission."""
        return [os.path.join(BIN, "dccast"), "--server", self.daemon.address, "submit",
                "--request-id", expected.given, expected.file]

    def send_by_client_program(self, expected):
        ended = subprocess.run([*self.submit_command(expected), "--json"], capture_output=True,
                               text=True, timeout=60, check=False)
        if ended.returncode != 0:
            raise RuntimeError(ended.stderr)
        self.acknowledged[json.loads(ended.stdout)["id"]] = expected

    def send(self, expected, **rest):
        if expected.file:
            return self.send_by_client_program(expected)
        try:
            job = self.client.submit(expected.case, request_id=expected.request_id, **rest)
        except grpc.RpcError as error:
            expected.refusal = error
            self.unsure.append(expected)
            return None
        self.acknowledged[job.id] = expected
        return job.id

    def send_again(self):
        """What every client does without an answer: the same request once more."""
        unsure, self.unsure = self.unsure, []
        for expected in unsure:
            self.send(expected)

    def wait_until_ended(self, seconds=60):
        until(lambda: all(self.ended(job_id) for job_id in self.acknowledged), seconds)

    def ended(self, job_id):
        return self.client.job(job_id).state in TERMINAL

    def running(self):
        return [job_id for job_id in self.acknowledged
                if self.client.job(job_id).state == job_pb2.RUNNING]

    def info(self, timeout=5):
        return self.client.ask("GetServerInfo", timeout=timeout)

    def state_command(self, *words):
        """`dccastd check`, `backup` or `restore` of the folder; raises RuntimeError when it fails."""
        ended = subprocess.run([os.path.join(BIN, "dccastd"), *words, "--set",
                                f"data_directory={self.data()}"], capture_output=True, text=True,
                               timeout=60, check=False)
        if ended.returncode != 0:
            raise RuntimeError(f"dccastd {words[0]} ended with {ended.returncode}: {ended.stdout}"
                               + ended.stderr)


class Expected:
    """A job the daemon owes us."""

    def __init__(self, case, state, request_id):
        self.case = case
        self.state = state
        self.given = request_id       # to the command line client
        self.request_id = request_id  # what the job has
        self.file = None              # of a submission by the command line client
        self.refusal = None           # the error instead of an answer

    def come_from(self, file):
        """Lets the command line client submit this file. It derives the request id from the id
        given, the file's name and its text, so that each of many files has its own."""
        with open(file, "rb") as text:
            digest = hashlib.sha256(text.read()).hexdigest()
        self.file = file
        self.request_id = str(uuid.uuid5(
            CLIENT_IDS, "\n".join((self.given, os.path.basename(file), digest))))


def open_files(process):
    """Paths of the files a process has open; none when it has gone."""
    folder = f"/proc/{process}/fd"
    try:
        return [os.readlink(os.path.join(folder, name)) for name in os.listdir(folder)]
    except OSError:
        return []


def alive(worker):
    return worker[1] != 0 and start_ticks(worker[0]) == worker[1]


def signal_process(worker, number):
    """To this very process, or to none."""
    if not alive(worker):
        return False
    try:
        os.kill(worker[0], number)
    except ProcessLookupError:
        return False
    return True


def limit(process, which, soft):
    """Sets a soft limit of a running process; returns the one before."""
    before = resource.prlimit(process, which)
    resource.prlimit(process, which, (soft, before[1]))
    return before[0]


def at_some_step(scene, job_id, last, meanwhile=lambda: None):
    """Waits for a random instant of a job's life: of its start, of one of its steps, or of its end."""
    step = scene.chance.randint(-last // 8, last)

    def reached():
        meanwhile()
        return scene.client.job(job_id).last_step.step >= step or scene.ended(job_id)
    if step > 0:
        until(reached, 60)
    pause(scene.chance, 0.02 if step > 0 else 0.2)


def chance_of(seed, name, number):
    """The random numbers of one try: the same for the same seed, fault and number."""
    return random.Random(f"{seed} {name} {number}")
