#!/usr/bin/python3
"""How workers leave: after their patience, with their daemon, when told to; and how they are left running."""
import os
import signal

from adoption import SUCCEEDED, AdoptionTest
from support import curve, fake_case, job_log, main, start_ticks
from waiting import stays, until


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


class NoDaemonComes(AdoptionTest):
    options = ("--worker-patience", "1")

    def test_the_run_stops_at_a_checkpoint_and_goes_on_later(self):
        expected = self.expected_curve(400)
        job_id, worker = self.running_job("steps=400 checkpoint=1000 sleep_ms=10")
        self.daemon.kill()
        stays(lambda: start_ticks(worker), 0.5)  # half of what it waits for a daemon
        self.ends(worker)
        self.restart()
        self.assertGreater(self.resumed_once(job_id, expected), 20)

    def test_a_daemon_that_comes_late_goes_on_with_a_run_that_has_not_stopped_yet(self):
        job_id, worker = self.running_job("steps=200 checkpoint=7 sleep_ms=20 deaf=1")
        log = job_log(worker)
        self.daemon.kill()
        until(lambda: "stopping at a checkpoint" in text_of(log), 10)
        self.restart()
        self.client.until_state(job_id, SUCCEEDED)
        self.sound_events(list(self.client.watch(job_id)))

    def test_told_to_leave_without_a_daemon(self):
        expected = self.expected_curve(200)
        job_id, worker = self.running_job("steps=200 checkpoint=7 sleep_ms=20")
        self.daemon.kill()
        os.kill(worker, signal.SIGTERM)
        self.ends(worker, 0.8)
        self.restart()
        self.resumed_once(job_id, expected)


class NoPatience(AdoptionTest):
    """The worker dies with its daemon; nobody else would end it."""
    options = ("--worker-patience", "0")

    def test_a_job_goes_on_from_its_checkpoint(self):
        expected = self.expected_curve()
        job_id, worker = self.running_job()
        self.daemon.kill()
        self.ends(worker)
        self.restart()
        self.assertEqual(self.resumed_once(job_id, expected) % 7, 0)


class CtrlC(AdoptionTest):
    """A terminal sends its signals to all processes of a group, not to the daemon alone."""
    before_exec = staticmethod(os.setpgrp)

    def test_the_run_stops_at_a_checkpoint(self):
        expected = self.expected_curve(400)
        job_id, worker = self.running_job("steps=400 checkpoint=1000 sleep_ms=10", 50)
        self.assertEqual(self.interrupt(), 0)
        self.assertFalse(start_ticks(worker))
        self.restart()
        self.assertGreaterEqual(self.resumed_once(job_id, expected), 50)


class RestartedByItsManager(AdoptionTest):
    """systemctl restart sends SIGUSR1, systemctl stop SIGTERM: deploy/debian/dccastd.service."""

    def test_sigusr1_leaves_the_worker_to_the_next_daemon(self):
        job_id, worker = self.running_job()
        self.daemon.process.send_signal(signal.SIGUSR1)
        self.assertEqual(self.daemon.wait(), 0)
        self.assertEqual(self.daemon.worker_processes(), [worker])
        self.restart()
        self.ended_untouched(job_id, 60)


class LeftRunning(AdoptionTest):
    before_exec = staticmethod(os.setpgrp)
    options = ("--worker-patience", "60", "--leave-workers")

    def test_ctrl_c_leaves_the_worker_too(self):
        job_id, worker = self.running_job()
        self.assertEqual(self.interrupt(), 0)
        self.assertEqual(self.daemon.worker_processes(), [worker])
        self.restart()
        self.ended_untouched(job_id, 60)

    def test_sigterm_leaves_the_worker_to_the_next_daemon(self):
        expected = self.expected_curve()
        job_id, worker = self.running_job()
        waiting = [self.client.submit(fake_case("steps=3")) for _ in range(3)]
        self.assertEqual(self.daemon.terminate(), 0)
        self.assertIn(worker, self.daemon.worker_processes())
        self.restart()
        self.ended_untouched(job_id, 60)
        self.assertEqual(curve(self.client.steps(job_id)), expected)
        for job in waiting:
            self.client.until_state(job.id, SUCCEEDED)


if __name__ == "__main__":
    main()
