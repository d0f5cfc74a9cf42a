"""kill -9 while a study is fed: every run has one job, none is done twice, and the figures stay."""
import signal

from cases import FAKE, REAL, coarse, fake
from dccast.v1 import service_pb2, study_pb2
from fault import Fault
from oracle import all_jobs
from scene import Expected, pause
from support import until

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
        return scene.client.stub.GetStudy(study_pb2.GetStudyRequest(id=self.study.id), timeout=10)

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
            answer = scene.client.stub.QueryResult(
                service_pb2.QueryResultRequest(id=job.id), timeout=30)
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
