#!/usr/bin/python3
"""Whatever dies, an acknowledged job is kept, goes on, and its watchers miss nothing."""
import os
import resource
import signal
import subprocess

import grpc

from dccast.v1 import job_pb2
from support import TERMINAL, ServiceTest, curve, fake_case, main
from waiting import until


class Crash(ServiceTest):
    settings = {"workers__restarts": 2}

    def expected_curve(self):
        """Of an uninterrupted run."""
        job = self.client.submit(fake_case("steps=60 checkpoint=7"))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        return curve(self.client.steps(job.id))

    def long_job(self):
        job = self.client.submit(fake_case("steps=60 checkpoint=7 sleep_ms=20"))
        self.client.until_step(job.id, 16)
        return job

    def test_a_watcher_that_drops_misses_nothing(self):
        job = self.long_job()
        events = []
        while not (events and events[-1].state_change.terminal):
            stream = self.new_client().watch(job.id, len(events) + 1)
            for event in stream:
                events.append(event)
                if len(events) % 17 == 0:
                    break
            stream.cancel()
        self.sound_events(events)
        self.assertEqual(events, list(self.client.watch(job.id)))

    def test_a_killed_client_harms_nobody(self):
        job = self.long_job()
        code = ("import os, sys, support\n"
                "client = support.Client(sys.argv[1])\n"
                "for event in client.watch(sys.argv[2]): print(event.sequence, flush=True)\n")
        watcher = subprocess.Popen(["/usr/bin/python3", "-c", code, self.daemon.address, job.id],
                                   stdout=subprocess.PIPE, cwd=os.path.dirname(__file__))
        watcher.stdout.readline()
        watcher.send_signal(signal.SIGKILL)
        watcher.wait()
        watcher.stdout.close()
        self.assertEqual(self.client.until_state(job.id, job_pb2.SUCCEEDED).attempts, 1)

    def test_a_watcher_that_does_not_read_stops_nobody(self):
        job = self.client.submit(fake_case("steps=20000"))
        stream = self.new_client().watch(job.id)
        next(stream)  # and no more: the window fills up
        self.client.until_state(job.id, job_pb2.SUCCEEDED, seconds=40)
        self.assertEqual(len([e for e in stream if e.HasField("step")]), 20000)

    def test_sigterm_in_the_middle_of_a_run(self):
        expected = self.expected_curve()
        job = self.long_job()
        stream = self.client.watch(job.id)
        events = [next(stream)]
        workers = self.daemon.worker_processes()

        self.assertEqual(len(workers), 1)
        self.assertEqual(self.daemon.terminate(), 0)
        with self.assertRaises(grpc.RpcError) as ended:
            events += list(stream)
        self.assertEqual(ended.exception.code(), grpc.StatusCode.UNAVAILABLE)
        self.assertFalse(os.path.exists(f"/proc/{workers[0]}"))

        self.restart()
        self.sound_events(list(self.client.watch(job.id)))
        self.assertEqual(curve(self.client.steps(job.id)), expected)
        self.assertEqual(self.client.job(job.id).attempts, 2)

    def test_sigkill_in_the_middle_of_a_run(self):
        expected = self.expected_curve()
        job = self.long_job()
        before = self.client.job(job.id).last_step.step
        self.daemon.kill_with_workers()
        self.restart()
        events = self.sound_events(list(self.client.watch(job.id)))
        resumed = [event.resumed.step for event in events if event.HasField("resumed")]
        self.assertEqual(len(resumed), 1)
        self.assertEqual(resumed[0] % 7, 0)
        self.assertLessEqual(resumed[0], before + 5)
        self.assertEqual(curve(self.client.steps(job.id)), expected)

    def test_worker_killed_goes_on_from_its_checkpoint(self):
        expected = self.expected_curve()
        job = self.long_job()
        os.kill(self.daemon.worker_processes()[0], signal.SIGKILL)
        events = self.sound_events(list(self.client.watch(job.id)))
        causes = " ".join(event.state_change.cause for event in events)
        self.assertIn("signal 9", causes)
        self.assertEqual(self.client.job(job.id).state, job_pb2.SUCCEEDED)
        self.assertEqual(self.client.job(job.id).attempts, 2)
        self.assertEqual(curve(self.client.steps(job.id)), expected)

    def test_worker_told_to_leave_goes_on_too(self):
        expected = self.expected_curve()
        job = self.long_job()
        os.kill(self.daemon.worker_processes()[0], signal.SIGTERM)
        self.sound_events(list(self.client.watch(job.id)))
        self.assertEqual(self.client.job(job.id).state, job_pb2.SUCCEEDED)
        self.assertEqual(curve(self.client.steps(job.id)), expected)

    def test_a_worker_that_always_dies_at_one_step_is_named(self):
        job = self.client.submit(fake_case("steps=10 crash_at=7 checkpoint=5 sleep_ms=10"))
        self.client.until_state(job.id, job_pb2.FAILED)
        failure = self.client.job(job.id).failure
        self.assertEqual(failure.kind, job_pb2.Finding.WORKER_LOST)
        self.assertIn("signal 6", failure.message)
        self.assertIn("3 times", failure.message)
        self.assertIn("twice in the step after 6", failure.message)
        self.assertEqual(self.client.job(job.id).attempts, 3)

    def test_a_worker_that_dies_once(self):
        job = self.client.submit(fake_case("steps=10 crash_once_at=7 checkpoint=5"))
        self.assertEqual(self.client.until_state(job.id, job_pb2.SUCCEEDED).attempts, 2)

    def test_a_daemon_killed_right_after_each_acknowledgement(self):
        ids = []
        for number in range(6):
            job = self.client.submit(fake_case(f"steps=3 number={number} sleep_ms=30"),
                                     request_id=f"n{number}")
            self.daemon.kill()
            ids.append(job.id)
            self.restart()
        for job_id in ids:
            self.client.until_state(job_id, job_pb2.SUCCEEDED)
            self.sound_events(list(self.client.watch(job_id)))

    def test_requested_actions_survive_a_crash(self):
        job = self.client.submit(fake_case("steps=10000 sleep_ms=5 deaf=1"))
        self.client.until_step(job.id, 1)
        self.client.cancel(job.id, "before the crash")
        self.daemon.kill()
        self.restart()
        self.assertEqual(self.client.job(job.id).state, job_pb2.CANCELLED)
        self.sound_events(list(self.client.watch(job.id)))

    def test_folders_of_jobs_never_acknowledged_are_moved_aside(self):
        self.daemon.kill()
        orphan = self.in_folder("data", "jobs", "0f2b9a4e-0000-4000-8000-000000000000")
        os.makedirs(orphan)
        self.restart()
        self.assertFalse(os.path.exists(orphan))
        info = self.client.ask("GetServerInfo")
        self.assertEqual(info.quarantined, 1)

    def test_two_daemons_on_one_folder(self):
        second = subprocess.run(self.daemon.command(), capture_output=True, text=True, timeout=20,
                                check=False)
        self.assertEqual(second.returncode, 4)
        self.assertIn("another dccastd", second.stderr)
        self.assertTrue(self.client.stub is not None and self.daemon.running())

    def limit_file_size(self, size):
        """No file of the daemon grows beyond this, as on a full disk; its workers still write theirs."""
        resource.prlimit(self.daemon.process.pid, resource.RLIMIT_FSIZE,
                         (size, resource.RLIM_INFINITY))

    def test_a_disk_that_takes_no_more_holds_the_queue(self):
        jobs = [self.client.submit(fake_case("steps=150 sleep_ms=10")) for _ in range(6)]
        self.client.until_step(jobs[0].id, 10)
        self.limit_file_size(1)
        until(lambda: all(self.client.job(job.id).held for job in jobs[2:]), 20)
        info = self.client.ask("GetServerInfo")
        self.assertTrue(info.storage_fault)

        self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.client.submit, fake_case("steps=1"))
        self.limit_file_size(resource.RLIM_INFINITY)
        for job in jobs:
            self.assertEqual(self.client.until_state(job.id, *TERMINAL, seconds=60).state,
                             job_pb2.SUCCEEDED)
            self.assertEqual([step.step for step in self.client.steps(job.id)],
                             list(range(1, 151)))
            self.sound_events(list(self.client.watch(job.id)))


if __name__ == "__main__":
    main()
