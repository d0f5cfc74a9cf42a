"""kill -9 while a study is fed: every run has one job, none is done twice, and the figures stay."""
import contextlib
import signal
import threading

import grpc

from cases import FAKE, REAL, coarse, fake, own_mesh
from dccast.v1 import follow_pb2, job_pb2, study_pb2
from fault import Fault
from oracle import all_jobs, content_of_results
from scene import Expected, signal_process
from waiting import pause, until

ENDED = (study_pb2.STUDY_SUCCEEDED, study_pb2.STUDY_FAILED, study_pb2.STUDY_CANCELLED)


class KilledStudy(Fault):
    """A study that is killed on its way."""
    at_once = 3
    seconds = 30.0
    settings = {"workers__restarts": 100}  # so many kills in one run are no fault of the case
    request = "a study"

    def plan(self):
        """The case and its sweep."""
        raise NotImplementedError

    def begin(self, scene):
        case, self.sweep = self.plan()
        self.question = study_pb2.CreateStudyRequest(request_id=self.request, case=case,
                                                     sweep=self.sweep)
        self.study = scene.client.stub.CreateStudy(self.question, timeout=30)

    def disturb(self, scene, count):
        pause(scene.chance, 0.6)
        if self.now(scene).state in ENDED:
            return False
        if scene.chance.random() < 0.5:
            scene.tell_daemon(signal.SIGKILL)
        else:
            scene.kill_daemon()
        scene.come_back()
        again = scene.client.stub.CreateStudy(self.question, timeout=30)
        if again.id != self.study.id:
            count.found("duplicated", "the same request made another study")
        return True

    def now(self, scene):
        return scene.client.ask("GetStudy", id=self.study.id)

    def look(self, scene, count):
        until(lambda: self.now(scene).state in ENDED, self.patience)
        study = self.now(scene)
        if (study.state, study.succeeded) != (study_pb2.STUDY_SUCCEEDED, self.study.runs):
            count.found("wrong", f"{study.succeeded} of {self.study.runs} runs succeeded: "
                        f"{study.message}")
        requests = {f"{study.id}/{number + 1}" for number in range(self.study.runs)}
        for job in all_jobs(scene.client):
            if job.request_id not in requests:
                continue  # the oracle finds what nobody asked for
            requests.remove(job.request_id)
            answer = scene.client.ask("QueryResult", id=job.id)
            scene.acknowledged[job.id] = Expected(answer.case, None, job.request_id)
        for request in requests:
            count.found("lost", f"run {request} has no job")


class KillUnderStudy(KilledStudy):
    """kill -9 of the daemon, with or without its workers, while it feeds a sweep of 24 runs"""
    short, long = 3, 30
    worker = FAKE

    def plan(self):
        sweep = study_pb2.SweepPlan(design=study_pb2.SweepPlan.GRID)
        sweep.axes.add(key="mesh.rows", values=[str(rows) for rows in range(1, 25)])
        return fake("steps=20 checkpoint=7 sleep_ms=4"), sweep


class KillAmidCastings(KilledStudy):
    """kill -9 of daemon, worker or both, amid jobs, files of cases, a study, and castings that are followed on a line"""
    short, long = 4, 300
    at_once = 10
    seconds = 200.0
    patience = 120.0
    worker = REAL
    batch, most_fed = 40, 200

    def plan(self):
        sweep = study_pb2.SweepPlan(design=study_pb2.SweepPlan.LATIN_HYPERCUBE, runs=8, seed=5)
        sweep.axes.add(key="alloy.conductivity.scale", values=["0.9", "1.1"])
        return coarse(), sweep

    def begin(self, scene):
        """One casting is followed before anything is killed, and one has a file: the others have their results
        to the last bit."""
        self.fed = {}  # readings of each casting that were acknowledged
        self.reference = self.follow(scene)
        self.feed_all(scene)
        self.with_file = []  # jobs, by the number of their request; None: whether it came, nobody knows
        self.send_file(scene, 0)
        until(lambda: scene.ended(self.reference) and scene.ended(self.with_file[0]), self.patience)
        super().begin(scene)

    def disturb(self, scene, count):
        self.keep_busy(scene)
        sending = threading.Thread(target=self.send_files, args=(scene,))
        sending.start()
        try:
            return self.kill(scene, count)
        finally:
            sending.join()

    def kill(self, scene, count):
        pause(scene.chance, 0.4)
        kind = scene.chance.choice(("worker", "daemon", "both"))
        workers = scene.job_workers()
        if kind == "worker":
            return bool(workers) and signal_process(scene.chance.choice(workers), signal.SIGKILL)
        if kind == "daemon":
            scene.tell_daemon(signal.SIGKILL)
        else:
            scene.kill_daemon()
        scene.come_back()
        for job_id, number in self.fed.items():
            if self.feed(scene, job_id, []).number < number:
                count.found("lost", f"readings of job {job_id}")
        return True

    def send_files(self, scene):
        """Uploads the file of one more case while something is killed, and of one whose answer never came."""
        unsure = [number for number, job in enumerate(self.with_file) if job is None]
        with contextlib.suppress(grpc.RpcError):  # the daemon has gone
            if not unsure and scene.ended(self.with_file[-1]):
                unsure = [len(self.with_file)]
            for number in unsure:
                self.send_file(scene, number)

    def send_file(self, scene, number):
        case, mesh = own_mesh()
        if number == len(self.with_file):
            self.with_file.append(None)
        client = scene.connected()
        attachments = [client.upload("slab.msh", mesh)]
        job = client.submit(case, request_id=f"file-{number}", attachments=attachments)
        scene.foreign_jobs.add(job.id)  # its twin is the first one
        self.with_file[number] = job.id

    def keep_busy(self, scene):
        """A job and a casting that is followed."""
        if all(map(scene.ended, scene.acknowledged)):
            scene.submit(coarse())
        followed = [job_id for job_id in self.fed if not scene.ended(job_id)]
        for job_id in followed or [self.follow(scene)]:
            self.feed_on(scene, job_id)

    def follow(self, scene):
        job_id = scene.submit(coarse(), following=follow_pb2.Following(line="pit-3"))
        scene.acknowledged.pop(job_id)  # its twin is the reference
        scene.foreign_jobs.add(job_id)
        self.fed[job_id] = 0
        return job_id

    def feed_all(self, scene):
        for job_id in self.fed:
            for _ in range(self.most_fed // self.batch + 1):
                self.feed_on(scene, job_id)

    def feed_on(self, scene, job_id):
        """The next readings; after the last ones the record is closed."""
        first = self.fed[job_id] + 1
        if first <= self.most_fed:
            readings = [follow_pb2.Reading(number=number, time_s=-61.0 + number,
                                           casting_speed_m_per_s=self.speed(number))
                        for number in range(first, first + self.batch)]
        elif first == self.most_fed + 1:
            readings = [follow_pb2.Reading(number=first, closes=True)]
        else:
            return
        with contextlib.suppress(grpc.RpcError):  # the casting has ended
            self.fed[job_id] = self.feed(scene, job_id, readings).number

    @staticmethod
    def speed(number):
        return 1e-3 + 1e-6 * (number % 7) if number > 61 else 0.0

    @staticmethod
    def feed(scene, job_id, readings):
        return scene.client.ask("AppendReadings", id=job_id, readings=readings)

    def look(self, scene, count):
        self.feed_all(scene)
        self.send_files(scene)
        super().look(scene, count)
        self.judge_castings(scene, count)
        line = scene.client.ask("GetLine", id="pit-3")
        on_line = [casting.job for casting in line.castings]
        if len(set(on_line)) < len(on_line):
            count.found("duplicated", f"castings on the line: {on_line}")
        for job_id in set(self.fed) - set(on_line):
            count.found("lost", f"job {job_id} is not on its line")

    def judge_castings(self, scene, count):
        self.judge_twins(scene, count, self.reference, self.fed)
        self.judge_twins(scene, count, self.with_file[0], self.with_file)
        count.measured("castings", len(self.fed))
        count.measured("cases with a file", len(self.with_file))
        requests = [job.request_id for job in all_jobs(scene.client) if job.request_id.startswith("file-")]
        if len(requests) != len(self.with_file):
            count.found("duplicated", f"jobs of {len(self.with_file)} requests: {sorted(requests)}")
        for job_id in self.with_file:
            with open(scene.data("jobs", job_id, "attachments", "slab.msh"), "rb") as file:
                if file.read() != own_mesh()[1]:
                    count.found("lost", f"job {job_id}: its file")

    def judge_twins(self, scene, count, reference, ids):
        until(lambda: all(map(scene.ended, ids)), self.patience)
        wanted = content_of_results(scene.client, scene.client.job(reference))
        for job in map(scene.client.job, ids):
            if job.state != job_pb2.SUCCEEDED:
                count.found("wrong", f"casting {job.id} has failed: {job.failure.message}")
            elif content_of_results(scene.client, job) != wanted:
                count.found("wrong", f"casting {job.id} has other results than an undisturbed one")


class KillUnderDataStudy(KilledStudy):
    """kill -9 of the daemon, with or without its workers, while a study over uncertain data runs"""
    short, long = 2, 20
    at_once = 2
    worker = REAL

    def plan(self):
        sweep = study_pb2.SweepPlan(design=study_pb2.SweepPlan.LATIN_HYPERCUBE, runs=8, seed=5)
        sweep.axes.add(key="alloy.conductivity.scale", values=["0.9", "1.1"])
        sweep.axes.add(key="schedule.casting_temperature.offset", values=["-5 K", "5 K"])
        return coarse(), sweep
