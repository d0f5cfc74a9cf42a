"""Slurm broken while it runs the jobs: tests/service/slurm_cluster.py starts a real one."""
import contextlib
import os
import shutil
import signal

from cases import fake
from fault import Fault
from scene import Scene, at_some_step, signal_process
from slurm_cluster import Cluster, missing_programs
from support import work_of
from waiting import pause, until

RUNS = "steps=40 checkpoint=5 sleep_ms=20"


class SlurmScene(Scene):
    def __init__(self, *arguments, **settings):
        super().__init__(*arguments, prepare=SlurmScene.start_cluster, executor="slurm",
                         slurm__interval="0.5 s", workers__heartbeat_interval="0.5 s", **settings)

    def start_cluster(self):
        self.cluster = Cluster(os.path.join(self.folder, "slurm"))
        self.cluster.start()

    def workers(self):
        """Not slurmstepd, which has their log open, too."""
        return [worker for worker in self.job_workers() if work_of(worker[0]) == "dccast-job"]

    def clear_away(self):
        self.cluster.run("scancel", "--me")
        self.stop_everything()
        self.cluster.stop()
        shutil.rmtree(self.folder, ignore_errors=True)


class OfSlurm(Fault):
    at_once = 3
    short = 3
    long = 20
    seconds = 60.0
    patience = 240.0
    settings = {"workers__restarts": 100}

    def attempt(self, chance, most):
        if missing := missing_programs():
            raise RuntimeError("not installed: " + " ".join(missing))
        return super().attempt(chance, most)

    def scene(self, chance):
        return SlurmScene(chance, self.worker, options=self.options, **self.settings)

    def begin(self, scene):
        for _ in range(3):
            scene.submit(fake(RUNS))

    def disturb(self, scene, count):
        job_id = scene.submit(fake(RUNS))
        if scene.chance.random() < 0.7:  # else right after its submission
            # Slurm may drain the node long after an earlier strike: its administrator resumes it.
            at_some_step(scene, job_id, 40, meanwhile=scene.cluster.node_is_ready)
        pause(scene.chance, 1.0)
        self.strike(scene)
        until(scene.cluster.node_is_ready, 60)

    def strike(self, scene):
        raise NotImplementedError

    def look(self, scene, count):
        """Meanwhile the administrator resumes a node that Slurm has drained, as it does when it finds a
        job of a crash on it. What has not ended by then is the oracle's to report."""
        def ended():
            scene.cluster.node_is_ready()
            return all(scene.ended(job_id) for job_id in scene.acknowledged)
        with contextlib.suppress(AssertionError):
            until(ended, self.patience, every_s=0.3)


class KillSlurmctld(OfSlurm):
    """kill -9 of slurmctld: acknowledged jobs are lost, and their ids given to others"""

    def strike(self, scene):
        scene.cluster.restart("slurmctld", away=scene.chance.uniform(0, 2))


class KillSlurmd(OfSlurm):
    """kill -9 of slurmd while it starts or runs jobs"""

    def strike(self, scene):
        scene.cluster.restart("slurmd", away=scene.chance.uniform(0, 2))


class SlurmForgets(OfSlurm):
    """slurmctld forgets all running jobs, and counts from 1 again"""
    short, long = 1, 6
    at_once = 1

    def strike(self, scene):
        scene.cluster.kill("slurmctld")
        shutil.rmtree(scene.cluster.path("state"))
        os.makedirs(scene.cluster.path("state"))
        scene.cluster.start_program("slurmctld")


class KillDaemonOfSlurm(OfSlurm):
    """kill -9 of the daemon while Slurm has its jobs"""

    def strike(self, scene):
        scene.tell_daemon(signal.SIGKILL)
        pause(scene.chance, 2.0)
        scene.come_back()


class KillWorkerOfSlurm(OfSlurm):
    """kill -9 of a worker that Slurm has started"""

    def disturb(self, scene, count):
        at_some_step(scene, scene.submit(fake(RUNS)), 40)
        workers = scene.workers()
        return bool(workers) and signal_process(scene.chance.choice(workers), signal.SIGKILL)


class DrainNode(OfSlurm):
    """The node is drained, as after a failed launch, and resumed"""

    def strike(self, scene):
        scene.cluster.run("scontrol", "update", f"NodeName={scene.cluster.host}", "State=DRAIN",
                          "Reason=test")
        scene.submit(fake(RUNS))
        pause(scene.chance, 3.0)


class RequeuedBySlurm(OfSlurm):
    """Slurm requeues running jobs, as after a node failure"""
    short, long = 1, 6
    at_once = 1

    def strike(self, scene):
        for line in scene.cluster.jobs("--states=RUNNING"):
            scene.cluster.run("scontrol", "requeue", line.split()[0])
