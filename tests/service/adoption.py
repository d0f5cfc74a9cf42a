"""What the tests of workers that outlive their daemon share."""
import os
import signal

from dccast.v1 import job_pb2
from rows import change_rows
from support import ServiceTest, curve, fake_case, start_ticks
from waiting import until

SUCCEEDED = job_pb2.SUCCEEDED


class AdoptionTest(ServiceTest):
    settings = {"workers__restarts": 2}
    options = ("--worker-patience", "60")

    def expected_curve(self, steps=60):
        """Of an undisturbed run."""
        job = self.client.submit(fake_case(f"steps={steps} checkpoint=7"))
        self.client.until_state(job.id, SUCCEEDED)
        return curve(self.client.steps(job.id))

    def running_job(self, words="steps=60 checkpoint=7 sleep_ms=20 wait_at=20", step=16):
        """A job in the middle of its run, and the process id of its worker. It goes on after let_go()."""
        job = self.client.submit(fake_case(words))
        self.client.until_step(job.id, step)
        worker, = self.daemon.worker_processes()
        return job.id, worker

    def change_store(self, ahead=0, **values):
        """Gives the jobs in the store these values. @param ahead  see change_rows()"""
        def change(job):
            for name, value in values.items():
                setattr(job, name, value)
        change_rows(self.in_folder("data", "jobs.sqlite"), change, ahead)

    def let_go(self, job_id):
        """Of a run that waits, so that it does not end before the test is where it wants to be."""
        with open(self.job_file(job_id, "go"), "wb"):
            pass

    def interrupt(self):
        """Ctrl-C in the terminal of a daemon that leads its group. Returns its exit code."""
        os.killpg(self.daemon.process.pid, signal.SIGINT)
        return self.daemon.wait()

    def job_file(self, job_id, name):
        return os.path.join(self.daemon.settings["data_directory"], "jobs", job_id, name)

    @staticmethod
    def ends(worker, seconds=5):
        until(lambda: not start_ticks(worker), seconds)

    def ended_untouched(self, job_id, steps):
        """It succeeded in its first attempt, and its events are those of an undisturbed run."""
        self.let_go(job_id)
        job = self.client.until_state(job_id, SUCCEEDED)
        self.assertEqual(job.attempts, 1)
        events = self.sound_events(list(self.client.watch(job_id)))
        self.assertEqual([event.step.step for event in events if event.HasField("step")],
                         list(range(1, steps + 1)))
        self.assertFalse([event for event in events if event.HasField("resumed")])
        self.assertEqual([event.state_change.state for event in events
                          if event.HasField("state_change")],
                         [job_pb2.QUEUED, job_pb2.RUNNING, SUCCEEDED])
        until(lambda: not self.daemon.worker_processes(), 5)

    def resumed_once(self, job_id, expected):
        """It succeeded in its second attempt, from a checkpoint, with the figures of the first."""
        self.let_go(job_id)
        self.assertEqual(self.client.until_state(job_id, SUCCEEDED).attempts, 2)
        events = self.sound_events(list(self.client.watch(job_id)))
        resumed, = [event.resumed.step for event in events if event.HasField("resumed")]
        self.assertEqual(curve(self.client.steps(job_id)), expected)
        return resumed
