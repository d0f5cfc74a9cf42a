#!/usr/bin/python3
"""Jobs that Slurm runs: a real Slurm of one machine, killed, drained and restarted while it has them.
With --nightly: a sweep of 50 runs with kills of everything, and the time limit of a minute."""
import math
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import unittest

import support
from dccast.v1 import job_pb2, study_pb2
from real_run_test import RealRunTest, physics
from slurm_cluster import Cluster, missing_programs
from support import ServiceTest, curve, fake_case, start_ticks
from waiting import pause, until

NIGHTLY = "--nightly" in sys.argv
SUCCEEDED, CANCELLED = job_pb2.SUCCEEDED, job_pb2.CANCELLED


def setUpModule():
    if missing := missing_programs():
        raise unittest.SkipTest("not installed: " + " ".join(missing))
    start_cluster()


def tearDownModule():
    end_cluster()


def start_cluster():
    global cluster
    cluster = Cluster(tempfile.mkdtemp(prefix="dccast-slurm-"))
    cluster.start()


def end_cluster():
    cluster.stop()
    shutil.rmtree(cluster.folder)


def replace_cluster():
    """After its controller was killed: a controller that counts from 1 again may take a late message about a
    job that it has lost for one about a job of a later test."""
    end_cluster()
    start_cluster()


class SlurmTest(ServiceTest):
    settings = {"executor": "slurm", "slurm__interval": "0.5 s", "workers__heartbeat_interval": "0.5 s",
                "slurm__jobs": 8}

    def tearDown(self):
        until(cluster.node_is_ready, 60)
        cluster.run("scancel", "--me")
        cluster.until_empty()
        super().tearDown()

    def job_file(self, job_id, name):
        return os.path.join(self.daemon.settings["data_directory"], "jobs", job_id, name)

    def let_go(self, job_id):
        with open(self.job_file(job_id, "go"), "wb"):
            pass

    def workers(self):
        """Not slurmstepd, which has their log open, too."""
        return [process for process in self.daemon.worker_processes()
                if support.work_of(process) == "dccast-job"]

    def running_job(self, words="steps=60 checkpoint=7 sleep_ms=20 wait_at=20", step=16):
        """In the middle of its run, and the process id of its worker. It goes on after let_go()."""
        job = self.client.submit(fake_case(words))
        self.client.until_step(job.id, step, 60)
        worker, = self.workers()
        return job.id, worker

    def succeeds(self, job_id, attempts=1, steps=60):
        """With the history of an undisturbed run, each step once. attempts: None for any number"""
        def ended():
            cluster.node_is_ready()  # resumed by its administrator, where Slurm has drained it
            return self.client.job(job_id).state in support.TERMINAL
        until(ended, 120, every_s=0.2)
        job = self.client.job(job_id)
        self.assertEqual(job.state, SUCCEEDED, job.failure)
        self.assertIn(attempts, (job.attempts, None), self.log_lines_of(job_id))
        self.sound_events(list(self.client.watch(job_id)))
        self.assertEqual([step.step for step in self.client.steps(job_id)],
                         list(range(1, steps + 1)))
        self.assertEqual([name for name in os.listdir(self.job_file(job_id, ""))
                          if name.startswith("worker.") and name != "worker.log"], [])
        return job

    def log_lines_of(self, job_id):
        """What the daemon did with a job, for the message of a failure."""
        return "\n".join(line for line in self.daemon.said().splitlines() if job_id in line)

    def expected_curve(self, steps=60):
        value, values = 0.0, []
        for step in range(1, steps + 1):
            value = 0.9 * value + 1e-3 * math.sin(step)
            values.append((step, value))
        return values


class OneJob(SlurmTest):
    def test_runs_and_shows_what_it_waits_for(self):
        cluster.run("scontrol", "update", f"NodeName={cluster.host}", "State=DRAIN", "Reason=test")
        job = self.client.submit(fake_case("steps=60"))
        until(lambda: "waits in Slurm" in self.client.job(job.id).held, 30)
        line, = cluster.jobs()
        self.assertIn(f"dccast-{job.id}.1", line)
        cluster.resume_node()
        job = self.succeeds(job.id)
        self.assertEqual(job.held, "")
        self.assertEqual(curve(self.client.steps(job.id)), self.expected_curve())

    def test_cancel_of_a_running_one(self):
        job_id, worker = self.running_job()
        self.client.cancel(job_id)
        self.let_go(job_id)
        self.client.until_state(job_id, CANCELLED)
        until(lambda: not start_ticks(worker), 20)
        cluster.until_empty()

    def test_cancel_of_one_that_waits_in_slurm(self):
        cluster.run("scontrol", "update", f"NodeName={cluster.host}", "State=DRAIN", "Reason=test")
        job = self.client.submit(fake_case("steps=60"))
        until(cluster.jobs, 30)
        self.client.cancel(job.id)
        self.client.until_state(job.id, CANCELLED, seconds=60)
        self.assertEqual(cluster.jobs(), [])
        cluster.resume_node()

    def test_scancel_by_an_administrator_cancels_the_job(self):
        job_id, _ = self.running_job()
        cluster.run("scancel", f"--name=dccast-{job_id}.1")
        self.client.until_state(job_id, CANCELLED, seconds=60)
        self.assertIn("cancelled in Slurm", self.client.job(job_id).cause)

    def test_a_refused_submission_holds_the_queue_with_slurms_reason(self):
        self.daemon.terminate()
        self.daemon.settings["slurm__options"] = "--partition=nowhere"
        self.restart()
        job = self.client.submit(fake_case("steps=60"))
        until(lambda: "invalid partition" in self.client.job(job.id).held, 30)
        self.daemon.terminate()
        self.daemon.settings["slurm__options"] = "--partition=batch"
        self.restart()
        self.succeeds(job.id)

    def test_a_query_does_not_wait_for_slurm(self):
        cluster.run("scontrol", "update", f"NodeName={cluster.host}", "State=DRAIN", "Reason=test")
        answers = list(self.client.ask("QueryButtCurl", case=fake_case("steps=20")))
        self.assertTrue(answers)
        cluster.resume_node()


class Restarts(SlurmTest):
    def test_daemon_killed_in_the_middle(self):
        job_id, worker = self.running_job()
        self.daemon.kill()
        self.restart()
        self.assertEqual(self.workers(), [worker])
        self.let_go(job_id)
        self.succeeds(job_id)

    def test_an_orderly_stop_leaves_it_to_slurm(self):
        job_id, worker = self.running_job()
        self.daemon.terminate()
        self.assertEqual(self.workers(), [worker])
        self.let_go(job_id)
        until(lambda: not start_ticks(worker), 30)
        self.restart()
        self.succeeds(job_id)

    def test_controller_killed_in_the_middle(self):
        self.addCleanup(replace_cluster)
        job_id, worker = self.running_job()
        time.sleep(7)  # until Slurm has written what it knows; see the nightly sweep for earlier
        cluster.restart("slurmctld", away=2)
        self.let_go(job_id)
        self.assertEqual(self.workers(), [worker])
        self.succeeds(job_id)

    def test_a_job_that_slurm_has_lost_is_submitted_again(self):
        self.addCleanup(replace_cluster)
        job_id, worker = self.running_job()
        # What kill -9 of slurmctld a moment after a submission does in one of three tries. The signal
        # is sent by a thread of slurmctld, which must not be killed before.
        cluster.run("scancel", "--me", "--signal=KILL", "--full")
        until(lambda: not start_ticks(worker), 30)
        cluster.kill("slurmctld")
        for name in os.listdir(cluster.path("state")):
            if name.startswith(("job_state", "hash.")):
                path = os.path.join(cluster.path("state"), name)
                shutil.rmtree(path) if os.path.isdir(path) else os.remove(path)
        cluster.start_program("slurmctld")
        self.let_go(job_id)
        self.assertGreater(self.succeeds(job_id, attempts=None).attempts, 1)

    def test_killed_worker(self):
        job_id, worker = self.running_job()
        os.kill(worker, signal.SIGKILL)
        self.let_go(job_id)
        self.succeeds(job_id, attempts=2)

    def test_requeued_by_slurm_it_goes_on_from_its_checkpoint(self):
        job_id, _ = self.running_job()
        number = cluster.jobs()[0].split()[0]
        cluster.run("scontrol", "requeue", number)
        until(lambda: "PENDING" in " ".join(cluster.jobs()), 60)
        cluster.run("scontrol", "update", f"JobId={number}", "StartTime=now")
        self.let_go(job_id)
        job = self.succeeds(job_id, attempts=None)
        self.assertEqual(curve(self.client.steps(job.id)), self.expected_curve())


class RealCasting(SlurmTest, RealRunTest):
    worker = "dccast-worker"

    def test_the_same_bits_as_on_this_machine(self):
        of_slurm = physics(self.finished_steps(self.submit_case())[1])
        self.daemon.terminate()
        self.daemon.settings["executor"] = "local"
        self.restart()
        self.assertEqual(physics(self.finished_steps(self.submit_case())[1]), of_slurm)


@unittest.skipUnless(NIGHTLY, "nightly")
class Nightly(SlurmTest):
    settings = {**SlurmTest.settings, "workers__restarts": 100}

    def test_a_time_limit_stops_it_at_a_checkpoint_and_it_goes_on(self):
        self.daemon.terminate()
        self.daemon.settings.update(slurm__time_limit="60 s", slurm__checkpoint_before="30 s")
        self.restart()
        job = self.client.submit(fake_case("steps=80 sleep_ms=1000 checkpoint=1000"))
        job = self.client.until_state(job.id, SUCCEEDED, seconds=300)
        self.assertGreater(job.attempts, 1)
        resumed = [event.resumed.step for event in self.client.watch(job.id)
                   if event.HasField("resumed")]
        self.assertEqual(len(resumed), job.attempts - 1)
        self.assertGreater(resumed[0], 1)
        self.assertEqual(curve(self.client.steps(job.id)), self.expected_curve(80))

    def test_a_sweep_of_50_runs_under_kills_of_everything(self):
        chance = random.Random(7)
        plan = study_pb2.SweepPlan(design=study_pb2.SweepPlan.GRID)
        plan.axes.add(key="time.end", values=[f"{100 + i} s" for i in range(50)])
        study = self.client.ask("CreateStudy", case=fake_case("steps=40 checkpoint=5 sleep_ms=20"),
                                sweep=plan)
        kills = 0
        end = time.monotonic() + 600
        while time.monotonic() < end:
            jobs = list(self.client.ask("ListJobs", study=study.id, page_size=1000).jobs)
            if len(jobs) == 50 and all(job.state in support.TERMINAL for job in jobs):
                break
            pause(chance, 3, 0.5)
            if kills < 40:
                kills += 1
                self.kill_something(chance)

        self.assertGreater(kills, 10)
        self.assertEqual({job.state for job in jobs}, {SUCCEEDED})
        self.assertEqual(len({job.id for job in jobs}), 50)
        for job in jobs:
            self.assertEqual(curve(self.client.steps(job.id)), self.expected_curve(40))
            self.sound_events(list(self.client.watch(job.id)))

        print(f"{kills} kills, {sum(job.attempts for job in jobs)} attempts at 50 runs")

    def kill_something(self, chance):
        what = chance.choice(("slurmctld", "slurmctld", "slurmd", "daemon", "worker"))
        if what == "daemon":
            self.daemon.kill()
            pause(chance, 2)
            self.restart()
        elif what == "worker":
            if workers := self.workers():
                try:
                    os.kill(chance.choice(workers), signal.SIGKILL)
                except ProcessLookupError:
                    pass
        else:
            cluster.restart(what, away=chance.uniform(0, 2))
            until(cluster.node_is_ready, 60)


if __name__ == "__main__":
    sys.argv = [word for word in sys.argv if word != "--nightly"]
    support.main()
