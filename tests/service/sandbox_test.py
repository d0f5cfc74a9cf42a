#!/usr/bin/python3
"""What holds the workers of a daemon: stated to its admin, and in force in their processes."""
import ctypes
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

from dccast.v1 import job_pb2
from support import SANITIZED, Daemon, ServiceTest, fake_case, main

CREATE_RULESET, VERSION = 444, 1  # landlock_create_ruleset(2) and its flag


def status_of(process):
    with open(f"/proc/{process}/status", encoding="ascii") as file:
        return dict(line.rstrip("\n").split(":\t", 1) for line in file if ":\t" in line)


class Sandbox(ServiceTest):
    settings = {"workers__count": 1, "workers__memory": "1 GB", "workers__file_size": "50 MB"}

    @staticmethod
    def landlock():
        """What the kernel has of it, as a worker words it."""
        version = ctypes.CDLL(None).syscall(CREATE_RULESET, None, 0, VERSION)
        return f"(Landlock {version})" if version > 0 else "(Landlock: "

    def test_the_worker_of_a_job_is_held_and_says_by_what(self):
        job = self.client.submit(fake_case("steps=5 wait_at=2"))
        self.client.until_step(job.id, 2)
        process, = self.daemon.worker_processes()
        self.assertEqual(status_of(process)["Seccomp"], "2")
        self.assertEqual(status_of(process)["NoNewPrivs"], "1")
        for which, most in ((resource.RLIMIT_DATA, -1 if SANITIZED else 1e9),
                            (resource.RLIMIT_FSIZE, 50e6), (resource.RLIMIT_CORE, 0)):
            self.assertEqual(resource.prlimit(process, which), (most, most))

        folder = self.in_folder("data", "jobs", job.id)
        with open(os.path.join(folder, "go"), "wb"):
            pass
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        with open(os.path.join(folder, "worker.log"), encoding="utf-8") as file:
            said = file.read()
        self.assertIn("no network, no other processes (seccomp)", said)
        self.assertIn(self.landlock(), said)
        self.assertIn(folder if "beneath" in said else "reads and writes where", said)

        memory = "memory without a bound (sanitizer)" if SANITIZED else "memory up to 1000 MB"
        self.assertIn(memory + ", files up to 50 MB", said)

    @unittest.skipIf(SANITIZED, "a sanitizer looks for leaks from a second process")
    def test_other_processes_of_its_user_do_not_reach_into_the_daemon(self):
        """A worker is one: it could write the memory of its daemon, and read the keys there."""
        user = int(os.geteuid()) or 65534

        def become_user():
            if os.geteuid() == 0:
                os.setgroups([])
                os.setgid(user)
                os.setuid(user)

        folder = tempfile.mkdtemp(prefix="dccast-sandbox-")
        self.addCleanup(shutil.rmtree, folder)
        os.chown(folder, user if os.geteuid() == 0 else -1, -1)
        daemon = Daemon(folder, before_exec=become_user).start()
        self.addCleanup(daemon.stop)
        self.assertEqual(status_of(daemon.process.pid)["Uid"].split()[0], str(user))
        for name, mode in (("mem", "r+b"), ("mem", "rb"), ("environ", "rb"), ("fd/0", "rb")):
            tried = subprocess.run(
                [sys.executable, "-c", f"open('/proc/{daemon.process.pid}/{name}', '{mode}')"],
                preexec_fn=become_user, capture_output=True, text=True, timeout=30, check=False)
            self.assertIn("PermissionError", tried.stderr, f"{name} {mode}")

    def test_info_and_the_daemon_s_log_say_what_holds_workers_that_answer(self):
        said = json.loads(self.dccast("info", "--json"))["worker_sandbox"]
        self.assertIn("no network, no other processes (seccomp)", said)
        self.assertIn(self.landlock(), said)
        self.assertIn("workers: " + said, self.daemon.said())
        for process in self.daemon.answering_processes():
            self.assertEqual(status_of(process)["Seccomp"], "2")

    def test_a_file_beyond_its_bound_fails_the_job_and_holds_no_queue(self):
        job = self.client.submit(fake_case("steps=5 big=60000000"))
        ended = self.client.until_state(job.id, job_pb2.FAILED)
        self.assertEqual(ended.failure.kind, job_pb2.Finding.INVALID_CASE)
        self.assertIn("larger than 50 MB", ended.failure.message)
        self.assertEqual(ended.attempts, 1)


if __name__ == "__main__":
    main()
