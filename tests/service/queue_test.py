#!/usr/bin/python3
"""The queue as its users drive it from the command line: jobs after jobs, the case of a job once more,
several cases under one request id, lists and usage."""
import json
import os
import pwd
import subprocess

import grpc

from dccast.v1 import job_pb2
from support import BIN, ServiceTest, fake_case, main, until

SUCCEEDED, CANCELLED = job_pb2.SUCCEEDED, job_pb2.CANCELLED
SHIPPED = os.path.join(os.path.dirname(__file__), "..", "..", "cases", "start-2d-thickness.toml")


class QueueTest(ServiceTest):
    def dccast(self, *words, code=0):
        ended = subprocess.run([os.path.join(BIN, "dccast"), "--server", self.daemon.address, *words],
                               capture_output=True, timeout=60, check=False)
        self.assertEqual(ended.returncode, code, ended.stderr.decode())
        return ended.stdout.decode() if code == 0 else ended.stderr.decode()

    def case_file(self, name, title):
        with open(SHIPPED, encoding="utf-8") as file:
            lines = [f'title = "{title}"' if line.startswith("title =") else line.rstrip("\n")
                     for line in file]
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n# a comment with ü and  two blanks")
        return path

    def state(self, job_id):
        return self.client.job(job_id).state


class After(QueueTest):
    def waiting(self, title="steps=20 wait_at=3"):
        """A job that runs until let_go(), and one that comes after it."""
        first = self.client.submit(fake_case(title))
        second = self.client.submit(fake_case("steps=5"), after=[first.id])
        self.client.until_step(first.id, 3)
        return first.id, second.id

    def let_go(self, job_id):
        with open(os.path.join(self.daemon.settings["data_directory"], "jobs", job_id, "go"), "wb"):
            pass

    def test_starts_when_the_job_before_has_succeeded(self):
        first, second = self.waiting()
        job = self.client.job(second)
        self.assertEqual((job.state, job.queue_position, list(job.after)),
                         (job_pb2.QUEUED, 0, [first]))
        self.assertIn(first, job.held)
        self.let_go(first)
        self.assertEqual(self.client.until_state(second, SUCCEEDED).held, "")
        ended = self.client.job(first).end_time.ToNanoseconds()
        self.assertLessEqual(ended, self.client.job(second).start_time.ToNanoseconds())

    def test_a_chain_ends_with_the_job_that_fails_and_says_so(self):
        first, second = self.waiting("steps=20 wait_at=3 fail_at=10")
        third = self.client.submit(fake_case("steps=5"), after=[second]).id
        self.let_go(first)
        for job_id, before, how in ((second, first, "failed"), (third, second, "cancelled")):
            self.client.until_state(job_id, CANCELLED)
            end = list(self.client.watch(job_id))[-1].state_change.cause
            self.assertIn(before, end)
            self.assertIn(how, end)

    def test_it_waits_through_a_restart_and_a_kill(self):
        first, second = self.waiting()
        self.daemon.terminate()
        self.restart()
        self.assertEqual(list(self.client.job(second).after), [first])
        self.client.until_step(first, 3)
        self.assertEqual(self.state(second), job_pb2.QUEUED)
        self.daemon.kill()
        self.let_go(first)
        self.restart()
        self.client.until_state(second, SUCCEEDED)

    def test_it_can_be_paused_resumed_and_cancelled(self):
        first, second = self.waiting()
        third = self.client.submit(fake_case("steps=5"), after=[first, second]).id
        self.dccast("pause", second)
        self.dccast("resume", second)
        self.assertEqual(self.state(second), job_pb2.QUEUED)
        self.dccast("cancel", second)
        self.client.until_state(third, CANCELLED)
        self.let_go(first)
        self.client.until_state(first, SUCCEEDED)
        self.assertEqual(self.state(second), CANCELLED)

    def test_what_can_never_start_is_refused(self):
        failed = self.client.submit(fake_case("steps=5 fail_at=2")).id
        self.client.until_state(failed, job_pb2.FAILED)
        self.refused(grpc.StatusCode.FAILED_PRECONDITION, self.client.submit, fake_case("steps=5"),
                     after=[failed])
        self.refused(grpc.StatusCode.NOT_FOUND, self.client.submit, fake_case("steps=5"),
                     after=["0f2b9a4e-0000-4000-8000-000000000000"])
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, fake_case("steps=5"),
                     after=["last"])
        done = self.client.submit(fake_case("steps=5")).id
        self.client.until_state(done, SUCCEEDED)
        after = self.dccast("submit", "--after", done[:8], self.case_file("a.toml", "steps=5"))
        self.client.until_state(after.strip(), SUCCEEDED)


class Cases(QueueTest):
    def test_the_submitted_file_byte_by_byte_and_once_more_changed(self):
        path = self.case_file("a.toml", "steps=5")
        first = self.dccast("submit", path, "--set", "mesh.rows=9").strip()
        with open(path, encoding="utf-8") as file:
            self.assertEqual(self.dccast("case", first), file.read())
        second = json.loads(self.dccast("submit", "--json", "--from", first, "--set",
                                        "schedule.hold=4 s"))
        self.assertEqual([change["key"] for change in second["changes"]],
                         ["mesh.rows", "schedule.hold"])
        self.assertEqual(self.dccast("case", second["id"]), self.dccast("case", first))
        self.client.until_state(first, SUCCEEDED)
        self.daemon.terminate()
        self.restart()
        with open(path, encoding="utf-8") as file:
            self.assertEqual(self.dccast("case", first), file.read())

    def test_a_job_is_compared_with_itself_changed(self):
        first = self.dccast("submit", self.case_file("a.toml", "steps=5")).strip()
        self.client.until_state(first, SUCCEEDED)
        compared = json.loads(self.dccast("compare", first, "--set", "schedule.hold=4 s", "--json"))
        self.assertTrue(compared)

    def test_a_job_without_a_file_has_one_by_its_case(self):
        job = self.client.submit(fake_case("steps=5"))
        path = os.path.join(self.folder, "by_its_case.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.dccast("case", job.id))
        again = [self.dccast("submit", path).strip(), self.dccast("submit", "--from", job.id).strip()]
        for one in again:
            self.assertEqual(self.client.job(one).case_sha256, job.case_sha256)
        self.dccast("submit", code=2)

    def test_logs(self):
        waiting = [self.client.submit(fake_case("steps=9 sleep_ms=50")).id for _ in range(3)]
        self.assertIn("has not begun", self.dccast("logs", waiting[2], code=5))
        self.client.until_state(waiting[0], SUCCEEDED)
        self.dccast("logs", waiting[0])

    def test_several_files_under_one_request_id_are_submitted_once(self):
        files = [self.case_file(f"{name}.toml", f"steps=5 {name}") for name in "abc"]
        first = self.dccast("submit", "--request-id", "trial-7", *files).split()
        again = self.dccast("submit", "--request-id", "trial-7", *files).split()
        self.assertEqual(first, again)
        self.assertEqual(len(set(first)), 3)


class Lists(QueueTest):
    def listed(self, *words):
        return self.dccast("list", "--ids", *words).split()

    def test_mine_since_and_by_name(self):
        one = self.client.submit(fake_case("line 3 morning")).id
        two = self.client.submit(fake_case("line 4 [x]")).id
        self.assertEqual(self.listed("--mine", "--since", "yesterday", "--name", "line 3*"), [one])
        self.assertEqual(self.listed("--name", "line ?*"), [two, one])
        self.assertEqual(self.listed("--since", "2 h"), [two, one])
        self.assertEqual(self.listed("--since", "2099-01-01"), [])
        self.dccast("list", "--since", "long ago", code=2)
        self.dccast("list", "--name", "*a*a*a*a*a*a*", code=2)

    def test_a_command_is_run_for_each_job_that_has_ended(self):
        jobs = [self.client.submit(fake_case(title)).id for title in ("steps=5", "steps=5 fail_at=2")]
        told = os.path.join(self.folder, "told")
        self.dccast("wait", "--notify", f'echo "$DCCAST_JOB $DCCAST_STATE $DCCAST_TITLE" >> {told}',
                    *jobs, code=3)
        with open(told, encoding="utf-8") as file:
            self.assertEqual(file.read().splitlines(), [f"{jobs[0]} succeeded steps=5",
                                                        f"{jobs[1]} failed steps=5 fail_at=2"])

    def test_usage(self):
        for title in ("steps=5", "steps=5", "steps=5 fail_at=3"):
            job = self.client.submit(fake_case(title), labels=["trial-7"])
            self.client.until_state(job.id, SUCCEEDED, job_pb2.FAILED)
        me = pwd.getpwuid(os.getuid()).pw_name
        usage, = json.loads(self.dccast("usage", "--by", "owner", "--json"))
        self.assertEqual((usage["owner"], usage["jobs"], usage["succeeded"], usage["failed"]),
                         (me, 3, 2, 1))
        self.assertIn("trial-7", self.dccast("usage", "--by", "label"))
        until(lambda: json.loads(self.dccast("usage", "--json", "--since", "2099-01-01")) == [], 5)


if __name__ == "__main__":
    main()
