#!/usr/bin/python3
"""A worker outlives its daemon, and the next daemon goes on with it as if nothing had happened."""
import os
import signal
import socket
import subprocess
import time

from adoption import SUCCEEDED, AdoptionTest
from dccast.v1 import job_pb2
from real_run_test import RealRunTest, physics
from support import BIN, curve, main, start_ticks
from waiting import until


class KilledDaemon(AdoptionTest):
    def test_the_same_worker_goes_on_in_the_same_attempt(self):
        expected = self.expected_curve()
        job_id, worker = self.running_job()
        self.daemon.kill()
        time.sleep(0.2)  # in which it makes steps without a daemon
        self.restart()
        self.assertEqual(self.client.job(job_id).state, job_pb2.RUNNING)
        self.client.until_step(job_id, 20, seconds=4)
        self.assertEqual(self.daemon.worker_processes(), [worker])
        self.ended_untouched(job_id, 60)
        self.assertEqual(curve(self.client.steps(job_id)), expected)

    def test_a_daemon_that_cannot_serve_leaves_it_to_the_next_one(self):
        job_id, worker = self.running_job()
        self.daemon.kill()
        with socket.socket(socket.AF_UNIX) as taken:
            taken.bind(self.in_folder("taken"))
            taken.listen()
            free = self.daemon.settings["listen__socket"]
            self.daemon.settings["listen__socket"] = f"unix:{taken.getsockname()}"
            with self.assertRaises(RuntimeError):
                self.daemon.start()
        self.daemon.settings["listen__socket"] = free
        self.restart()
        self.assertEqual(self.daemon.worker_processes(), [worker])
        self.ended_untouched(job_id, 60)

    def test_again_and_again(self):
        expected = self.expected_curve(100)
        job_id, worker = self.running_job("steps=100 checkpoint=7 sleep_ms=10 wait_at=85", 5)
        for step in (20, 50, 80):
            self.client.until_step(job_id, step)
            self.daemon.kill()
            self.restart()
            self.assertEqual(self.daemon.worker_processes(), [worker])
        self.ended_untouched(job_id, 100)
        self.assertEqual(curve(self.client.steps(job_id)), expected)

    def test_a_run_that_ended_meanwhile(self):
        job_id, _ = self.running_job("steps=40 checkpoint=7 wait_at=20 finding_at=30")
        self.daemon.kill()
        self.let_go(job_id)
        until(lambda: os.path.exists(self.job_file(job_id, "results.h5")), 10)
        self.restart()
        self.ended_untouched(job_id, 40)
        self.assertEqual([f.code for f in self.client.job(job_id).findings], ["bleed_out_at_exit"])
        self.assertTrue(self.client.fetch(job_id))

    def test_a_run_that_failed_meanwhile(self):
        job_id, worker = self.running_job("steps=40 checkpoint=7 wait_at=18 fail_at=20")
        self.daemon.kill()
        self.let_go(job_id)
        self.ends(worker)
        self.restart()
        job = self.client.until_state(job_id, job_pb2.FAILED)
        self.assertEqual((job.attempts, job.failure.kind), (1, job_pb2.Finding.SOLVE_FAILED))
        self.sound_events(list(self.client.watch(job_id)))

    def test_a_finding_is_told_once(self):
        job_id, _ = self.running_job("steps=60 checkpoint=7 sleep_ms=20 wait_at=20 finding_at=14", 14)
        self.daemon.kill()
        self.restart()
        self.ended_untouched(job_id, 60)
        events = list(self.client.watch(job_id))
        self.assertEqual([e.HasField("finding") for e in events].count(True), 1)

    def test_a_watched_job_can_be_paused_and_cancelled_afterwards(self):
        job_id, worker = self.running_job("steps=1000 checkpoint=7 sleep_ms=10")
        self.daemon.kill()
        self.restart()
        until(lambda: self.client.job(job_id).last_step.step > 30, 10)
        self.assertEqual(self.daemon.worker_processes(), [worker])
        self.client.cancel(job_id, "enough")
        self.client.until_state(job_id, job_pb2.CANCELLED)
        until(lambda: not self.daemon.worker_processes(), 5)
        self.sound_events(list(self.client.watch(job_id)))

    def test_an_adopted_worker_that_dies_is_replaced(self):
        expected = self.expected_curve()
        job_id, worker = self.running_job("steps=60 checkpoint=7 sleep_ms=20 wait_at=30")
        self.daemon.kill()
        self.restart()
        self.client.until_step(job_id, 25)
        os.kill(worker, signal.SIGKILL)
        self.assertGreaterEqual(self.resumed_once(job_id, expected), 21)

    def test_a_worker_that_dies_meanwhile_is_replaced(self):
        expected = self.expected_curve()
        job_id, worker = self.running_job()
        self.daemon.kill()
        os.kill(worker, signal.SIGKILL)
        self.restart()
        self.resumed_once(job_id, expected)

    def test_a_worker_that_hangs_meanwhile_is_replaced(self):
        self.daemon.settings.update(workers__heartbeat_timeout="1 s", workers__heartbeat_interval="0.2 s")
        expected = self.expected_curve()
        job_id, worker = self.running_job()
        self.daemon.kill()
        os.kill(worker, signal.SIGSTOP)
        self.restart()
        os.kill(worker, signal.SIGSTOP)  # again: the daemon has continued what it adopts
        self.resumed_once(job_id, expected)
        self.assertFalse(start_ticks(worker))

    def test_a_job_cancelled_before_ends_its_worker(self):
        job_id, worker = self.running_job("steps=10000 sleep_ms=5 deaf=1")
        self.client.cancel(job_id, "before the crash")
        self.daemon.kill()
        self.restart()
        self.assertEqual(self.client.job(job_id).state, job_pb2.CANCELLED)
        self.ends(worker)
        self.sound_events(list(self.client.watch(job_id)))

    def test_a_store_that_says_otherwise_is_corrected_from_the_folder(self):
        job_id, worker = self.running_job()
        self.daemon.kill()
        self.change_store(ahead=1, state=job_pb2.CANCELLED)
        self.restart()
        self.assertEqual(self.daemon.worker_processes(), [worker])
        self.ended_untouched(job_id, 60)

    def test_a_worker_of_another_attempt_is_ended(self):
        job_id, worker = self.running_job()
        self.daemon.kill()
        self.change_store(attempts=2)
        self.restart()
        self.assertFalse(start_ticks(worker))
        self.let_go(job_id)
        self.assertEqual(self.client.until_state(job_id, SUCCEEDED).attempts, 3)

    def test_a_worker_of_another_protocol_is_ended_and_its_job_resumed(self):
        expected = self.expected_curve()
        job_id, worker = self.running_job()
        self.daemon.kill()
        with open(self.job_file(job_id, "worker.lock"), "w", encoding="ascii") as file:
            file.write(f"2 1 {job_id}\n")
        self.restart()
        self.assertFalse(start_ticks(worker))
        self.resumed_once(job_id, expected)

    def test_a_damaged_history_costs_the_events_that_were_hit(self):
        expected = self.expected_curve()
        job_id, worker = self.running_job()
        self.daemon.kill()
        log = self.job_file(job_id, "events.log")
        with open(log, "r+b") as file:
            file.seek(os.path.getsize(log) // 2)
            file.write(b"\xff\x00\xff\x00")
        self.restart()
        self.assertEqual(self.daemon.worker_processes(), [worker])

        self.let_go(job_id)
        self.assertEqual(self.client.until_state(job_id, SUCCEEDED).attempts, 1)

        events = self.sound_events(list(self.client.watch(job_id)))
        self.assertTrue([event for event in events if "lost" in event.message.text])
        self.assertEqual(curve(self.client.steps(job_id))[-1], expected[-1])

    def test_nothing_is_repaired_under_a_worker(self):
        job_id, worker = self.running_job()
        self.daemon.kill()
        data = "data_directory=" + self.in_folder("data")
        check = subprocess.run([os.path.join(BIN, "dccastd"), "check", "--repair", "--set", data],
                               capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(check.returncode, 4)
        self.assertIn(f"job {job_id} still runs in process {worker}", check.stderr)
        self.restart()
        self.ended_untouched(job_id, 60)

    def test_its_files_are_the_owners_alone(self):
        job_id, _ = self.running_job()
        for name in ("worker.lock", "events.log"):
            self.assertEqual(os.stat(self.job_file(job_id, name)).st_mode & 0o777, 0o600, name)
        for path in (self.job_file(job_id, ""), self.in_folder("data")):
            self.assertEqual(os.stat(path).st_mode & 0o777, 0o700, path)
        self.let_go(job_id)
        self.client.until_state(job_id, SUCCEEDED)
        until(lambda: not os.path.exists(self.job_file(job_id, "worker.lock")), 5)

    def test_a_folder_that_is_gone_ends_its_worker(self):
        job_id, worker = self.running_job("steps=10000 sleep_ms=5")
        self.daemon.kill()
        os.rename(self.job_file(job_id, ""), self.in_folder("elsewhere"))
        self.ends(worker)


class DataDirectory(AdoptionTest):
    """Paths that are no address of a socket."""

    def goes_on_in(self, name):
        self.daemon.terminate()
        self.daemon.settings["data_directory"] = self.in_folder(name)
        self.restart()
        job_id, worker = self.running_job()
        self.daemon.kill()
        self.restart()
        self.assertEqual(self.daemon.worker_processes(), [worker])
        self.ended_untouched(job_id, 60)

    def test_longer_than_an_address(self):
        self.goes_on_in(2 * ("d" * 60 + "/"))

    def test_special_characters(self):
        self.goes_on_in("da ta %41?")


class RealCasting(RealRunTest):
    """The shipped start-up case on the real solver."""

    def test_killed_in_mid_casting(self):
        undisturbed = self.submit_case()
        expected = physics(self.finished_steps(undisturbed)[1])
        job_id = self.submit_case()
        self.client.until_step(job_id, 60, seconds=60)
        workers = self.daemon.worker_processes()
        self.daemon.kill()
        self.restart()
        self.assertEqual(self.daemon.worker_processes(), workers)

        events, steps = self.finished_steps(job_id)
        self.assertEqual(physics(steps), expected)
        self.assertEqual([event.step.step for event in events if event.HasField("step")],
                         list(range(1, len(expected) + 1)))
        self.assertFalse([event for event in events if event.HasField("resumed")])

        job = self.client.job(job_id)
        self.assertEqual(job.attempts, 1)
        self.assertEqual([artifact.sha256 for artifact in job.artifacts],
                         [artifact.sha256 for artifact in self.client.job(undisturbed).artifacts])


if __name__ == "__main__":
    main()
