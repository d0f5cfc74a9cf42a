#!/usr/bin/python3
"""The queue as its users drive it from the command line: jobs after jobs, the case of a job once more,
several cases under one request id, lists and usage."""
import json
import os
import pwd
import resource
import subprocess

import grpc

from dccast.v1 import job_pb2
from support import BIN, ServiceTest, fake_case, main
from waiting import until

SUCCEEDED, CANCELLED = job_pb2.SUCCEEDED, job_pb2.CANCELLED
SHIPPED = os.path.join(os.path.dirname(__file__), "..", "..", "cases", "start-2d-thickness.toml")


class QueueTest(ServiceTest):
    def case_file(self, name, title):
        with open(SHIPPED, encoding="utf-8") as file:
            lines = [f'title = "{title}"' if line.startswith("title =") else line.rstrip("\n")
                     for line in file]
        path = self.in_folder(name)
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
        path = self.write_file("by_its_case.toml", self.dccast("case", job.id))
        again = [self.dccast("submit", path).strip(), self.dccast("submit", "--from", job.id).strip()]
        for one in again:
            self.assertEqual(self.client.job(one).case_sha256, job.case_sha256)
        self.dccast("submit", code=2)

    def test_logs(self):
        waiting = [self.client.submit(fake_case("steps=9 sleep_ms=50")).id for _ in range(3)]
        self.assertIn("queued: submitted", self.dccast("logs", waiting[2]))
        self.assertRegex(self.dccast("logs", "--follow", waiting[0]),
                         r"(?s)\d\d:\d\d:\d\d  attempt 1  running: started\n.*succeeded: finished")
        dies = self.client.submit(fake_case("steps=9 crash_once_at=3 sleep_ms=20")).id
        log = self.dccast("logs", "--follow", dies)
        self.assertRegex(log, r"attempt 1  queued: worker died with signal 6 .*restart 1 of")
        self.assertIn("attempt 2  running: started again", log)
        self.assertIn("written by its workers:\n", log)

    def test_several_files_under_one_request_id_are_submitted_once(self):
        files = [self.case_file(f"{name}.toml", f"steps=5 {name}") for name in "abc"]
        first = self.dccast("submit", "--request-id", "trial-7", *files).split()
        again = self.dccast("submit", "--request-id", "trial-7", *files).split()
        self.assertEqual(first, again)
        self.assertEqual(len(set(first)), 3)

        # A file between the others is a new job, and so is one that was changed; none is doubled.
        files.insert(1, self.case_file("aa.toml", "steps=5 new"))
        more = self.dccast("submit", "--request-id", "trial-7", *files).split()
        self.assertEqual([more[0], *more[2:]], first)
        self.assertNotIn(more[1], first)
        self.case_file("a.toml", "steps=6 changed")
        self.assertNotIn(self.dccast("submit", "--request-id", "trial-7", files[0]).strip(), more)

    def test_a_later_value_of_a_key_wins(self):
        path = self.case_file("a.toml", "steps=5")
        first = self.dccast("submit", "--set", "mesh.rows=20", "--set", "title=steps=6", path).strip()
        second = self.dccast("submit", "--from", first, "--set", "mesh.rows=30").strip()
        third = self.dccast("submit", "--from", second, "--set", "mesh.rows=40").strip()
        changes = {change.key: change.value for change in self.client.job(third).changes}
        self.assertEqual(changes, {"mesh.rows": "40", "title": "steps=6"})
        self.assertIn("mesh.rows = 40",
                      self.dccast("compare", second, "--set", "mesh.rows=40"))
        self.dccast("submit", "--from", first, "--set", "mesh.rows=3", "--set", "mesh.rows=4", code=2)


class Messages(QueueTest):
    """What a slip of the user is answered with."""

    def test_commands_and_choices(self):
        self.assertIn("there is no command 'sumbit'; did you mean 'submit'?",
                      self.dccast("sumbit", "my.toml", code=2))
        self.assertEqual(self.dccast("help", "submit"), self.dccast("submit", "--help"))
        self.assertIn("Commands to run jobs", self.dccast("help"))
        path = self.case_file("a.toml", "steps=5")
        self.assertIn("--priority: 'urgent' is none of high, low, normal",
                      self.dccast("submit", "--priority", "urgent", path, code=2))
        self.dccast("submit", "--priority", "HIGH", path)

    def test_a_directory_is_no_case(self):
        for command in (["validate"], ["query"], ["submit"], ["validate", "--local"]):
            self.assertIn("is a directory", self.dccast(*command, self.folder, code=2))

    def test_a_list_names_what_a_job_waits_for_and_fits_the_terminal(self):
        first = self.client.submit(fake_case("steps=1000 wait_at=3 " + "long " * 30),
                                   priority=job_pb2.HIGH).id
        self.client.until_step(first, 3)
        second = self.client.submit(fake_case("steps=5"), after=[first]).id
        table = self.dccast("list")
        self.assertRegex(table, rf"{second[:8]}  queued, after {first[:8]} ")
        self.assertIn("PRIORITY", table)
        self.assertGreater(max(map(len, table.splitlines())), 120)
        self.assertRegex(self.dccast("list", "--columns", "job,started,took"), r"STARTED +TOOK\n")
        shown = subprocess.run(
            ["script", "-qec", f"{os.path.join(BIN, 'dccast')} --server {self.daemon.address} list",
             "/dev/null"], capture_output=True, timeout=30, check=True, text=True,
            env={**os.environ, "COLUMNS": "80"}).stdout
        self.assertEqual(max(len(line.rstrip("\r")) for line in shown.splitlines()), 80)
        self.client.cancel(first)


class Many(QueueTest):
    """Commands on many jobs, by their ids or by a label."""
    settings = {"workers__count": 1}

    def test_ids_and_labels_select_jobs(self):
        running, *waiting = [self.client.submit(fake_case("steps=1000 wait_at=3"), labels=["night"]).id
                             for _ in range(4)]
        other = self.client.submit(fake_case("steps=5")).id
        self.client.until_step(running, 3)
        self.assertEqual(self.dccast("pause", "--label", "night").count("paused"), 4)
        self.client.until_state(other, SUCCEEDED)
        self.assertEqual(self.dccast("resume", *waiting[:2]).count("queued"), 2)
        self.assertIn("not paused", self.dccast("resume", *waiting, code=6))
        self.dccast("label", "--label", "night", "--add", "line=3", "--remove", "night")
        self.assertEqual(len(self.dccast("list", "--ids", "--label", "line=3").split()), 4)
        self.dccast("pin", "--label", "line=3")
        self.assertTrue(all(self.client.job(job).pinned for job in (running, *waiting)))
        self.assertEqual(self.dccast("cancel", "--label", "line=3").count("cancelled"), 4)
        self.dccast("delete", "--label", "line=3")
        self.assertEqual(self.dccast("list", "--ids", "--label", "line=3").split(), [])
        self.assertEqual(self.dccast("cancel", "--label", "line=3"), "")
        self.dccast("cancel", code=2)
        self.dccast("cancel", other, "--label", "night", code=2)

    def test_priority_of_waiting_jobs(self):
        running = self.client.submit(fake_case("steps=1000 wait_at=3")).id
        self.client.until_step(running, 3)
        waiting = [self.client.submit(fake_case("steps=5")).id for _ in range(3)]
        self.dccast("priority", "high", waiting[2])
        self.assertEqual([self.client.job(job).queue_position for job in waiting], [2, 3, 1])
        self.assertIn("priority      high", self.dccast("show", waiting[2]))
        self.daemon.kill()
        self.restart()
        self.assertEqual(self.client.job(waiting[2]).priority, job_pb2.HIGH)
        self.client.until_step(running, 3)
        self.assertIn("until it starts", self.dccast("priority", "low", running, code=6))
        self.dccast("priority", "urgent", waiting[0], code=2)
        self.client.cancel(running)

    def test_after_a_failure_or_any_end_and_at_a_time(self):
        first = self.client.submit(fake_case("steps=20 fail_at=10")).id
        path = self.case_file("a.toml", "steps=5")
        jobs = [self.dccast("submit", "--after", first, "--after-end", end, path).strip()
                for end in ("failure", "any")]
        soon = self.dccast("submit", "--begin", "1 d", path).strip()
        for job in jobs:
            self.client.until_state(job, SUCCEEDED)
        self.assertIn("waits until", self.client.job(soon).held)
        self.assertIn("begins", self.dccast("show", soon))
        self.assertRegex(self.dccast("list"), rf"{soon[:8]}  queued, from \d\d\d\d-")
        self.daemon.kill()
        self.restart()
        self.assertEqual(self.state(soon), job_pb2.QUEUED)
        self.assertIn("is FAILED; nothing can come after its success", self.dccast("submit", "--after", first, path, code=6))
        self.dccast("submit", "--begin", "banana", path, code=2)
        self.dccast("submit", "--begin", "2 d", "--after-end", "any", path, code=2)
        self.dccast("cancel", soon)


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
        told = self.in_folder("told")
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


class Marks(QueueTest):
    """Labels and pins: what may change of a job after its submission."""

    def test_labels_change_in_any_state_and_are_found_again(self):
        job = self.client.submit(fake_case("steps=200 sleep_ms=10"), labels=["trial-7", "line=2"]).id
        self.client.until_step(job, 3)
        self.dccast("label", job, "--add", "line=3", "--add", "checked")
        self.assertEqual(sorted(self.client.job(job).labels), ["checked", "line=3", "trial-7"])
        self.client.cancel(job)
        self.client.until_state(job, CANCELLED)
        self.dccast("label", job, "--remove", "line", "--remove", "trial-7")
        self.assertEqual(self.dccast("list", "--ids", "--label", "checked").split(), [job])
        self.assertEqual(self.dccast("list", "--ids", "--label", "line=3").split(), [])
        self.dccast("label", job, "--add", "x" * 65, code=2)
        self.dccast("label", job, *(f"--add=label-{i}" for i in range(21)), code=2)
        self.assertEqual(list(self.client.job(job).labels), ["checked"])

    def test_labels_that_are_refused_leave_a_running_job_as_it_was(self):
        job = self.client.submit(fake_case("steps=500 sleep_ms=10"), labels=["trial-7"]).id
        self.client.until_step(job, 3)
        self.dccast("label", job, *(f"--add=label-{i}" for i in range(21)), code=2)
        self.assertEqual(list(self.client.job(job).labels), ["trial-7"])
        self.client.cancel(job)

    def test_they_outlive_the_store(self):
        jobs = [self.client.submit(fake_case("steps=5"), labels=["before"]).id for _ in range(2)]
        for job in jobs:
            self.client.until_state(job, SUCCEEDED)
        self.dccast("label", jobs[0], "--add", "after", "--remove", "before")
        self.assertIn("pinned", self.dccast("pin", jobs[0]))

        self.daemon.terminate()
        data = self.daemon.settings["data_directory"]
        for name in os.listdir(data):
            if name.startswith("jobs.sqlite"):
                os.remove(os.path.join(data, name))
        self.restart()
        found = self.client.job(jobs[0])
        self.assertEqual((list(found.labels), found.pinned), (["after"], True))

        with open(os.path.join(data, "jobs", jobs[0], "marks"), "r+b") as file:
            file.write(b"damaged")
        self.assertEqual(list(self.client.job(jobs[1]).labels), ["before"])

    def test_a_waiting_job_keeps_them_through_a_restart(self):
        running = [self.client.submit(fake_case("steps=500 sleep_ms=10")).id for _ in range(2)]
        waiting = self.client.submit(fake_case("steps=5")).id
        self.dccast("label", waiting, "--add", "soon")
        self.daemon.terminate()
        self.restart()
        self.assertNotIn("made again", self.daemon.said())
        self.assertEqual(list(self.client.job(waiting).labels), ["soon"])
        for job in running:
            self.client.cancel(job)


class Retention(QueueTest):
    settings = {"retention__keep_time": "1 s"}

    def test_old_jobs_go_and_pinned_ones_stay(self):
        old, pinned, awaited = [self.client.submit(fake_case("steps=5")).id for _ in range(3)]
        self.dccast("pin", pinned)
        self.client.until_state(awaited, SUCCEEDED)
        running = self.client.submit(fake_case("steps=1000 wait_at=3")).id
        self.client.submit(fake_case("steps=5"), after=[awaited, running])
        until(lambda: old not in self.dccast("list", "--ids").split(), 30)
        self.assertEqual(self.state(pinned), SUCCEEDED)
        self.assertEqual(self.state(awaited), SUCCEEDED)
        self.dccast("unpin", pinned)
        until(lambda: pinned not in self.dccast("list", "--ids").split(), 30)
        self.assertFalse(os.path.exists(
            os.path.join(self.daemon.settings["data_directory"], "jobs", pinned)))


class RetentionBySize(QueueTest):
    def test_the_oldest_go_first(self):
        jobs = []
        for _ in range(4):
            jobs.append(self.client.submit(fake_case("steps=5")).id)
            self.client.until_state(jobs[-1], SUCCEEDED)
        self.daemon.terminate()
        folders = os.path.join(self.daemon.settings["data_directory"], "jobs")
        sizes = [sum(os.path.getsize(os.path.join(at, name)) for name in names)
                 for at, _, names in os.walk(os.path.join(folders, jobs[3]))]
        self.daemon.settings["retention__keep_size"] = f"{int(2.5 * sum(sizes))} bytes"
        self.restart()
        until(lambda: self.dccast("list", "--ids").split() == jobs[:1:-1], 30)


class Limits(QueueTest):
    settings = {"per_case__maximum_time": "60 s"}

    def test_a_job_ends_at_its_time_limit_and_says_what_to_do(self):
        path = self.case_file("a.toml", "steps=100000 sleep_ms=20")
        job = self.dccast("submit", "--time-limit", "2 s", path).strip()
        found = self.client.until_state(job, job_pb2.FAILED, seconds=30)
        self.assertEqual(found.failure.kind, job_pb2.Finding.TIME_LIMIT)
        self.assertIn(f"--from {job} --time-limit", found.failure.message)
        self.assertGreaterEqual(found.run_s, 2.0)
        self.assertLess(found.run_s, 30.0)
        self.assertIn("time limit", self.dccast("show", job))

    def test_the_time_before_a_pause_counts_and_a_cancel_wins(self):
        job = self.client.submit(fake_case("steps=100000 sleep_ms=20"), time_limit_s=4).id
        self.client.until_step(job, 50)
        self.dccast("pause", job)
        ran_s = self.client.job(job).run_s
        self.assertGreater(ran_s, 0.5)
        self.dccast("resume", job)
        found = self.client.until_state(job, job_pb2.FAILED, seconds=30)
        self.assertEqual(found.failure.kind, job_pb2.Finding.TIME_LIMIT)
        self.assertGreater(found.run_s, ran_s)

    def test_a_limit_beyond_that_of_the_server_is_refused(self):
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit,
                             fake_case("steps=5"), time_limit_s=61)
        self.assertIn("per_case.maximum_time = 60", error.details())
        for wrong in (-1.0, float("nan"), float("inf")):
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, fake_case("steps=5"),
                         time_limit_s=wrong)
        self.dccast("submit", "--time-limit", "60 mm", self.case_file("a.toml", "steps=5"), code=2)


class RunningLimit(QueueTest):
    settings = {"per_user__maximum_running": 1, "workers__stop_grace": "0.5 s"}

    def test_one_user_leaves_workers_to_others(self):
        first, second = [self.client.submit(fake_case("steps=1000 wait_at=3")).id for _ in range(2)]
        self.client.until_step(first, 3)
        job = self.client.job(second)
        self.assertEqual(job.state, job_pb2.QUEUED)
        self.assertIn("per_user.maximum_running = 1", job.held)
        self.client.cancel(first)
        self.client.until_step(second, 3)


class Times(QueueTest):
    settings = {"workers__count": 1}

    def test_start_and_end_are_foreseen_from_jobs_before(self):
        for _ in range(2):
            self.client.until_state(self.client.submit(fake_case("steps=100 sleep_ms=10")).id, SUCCEEDED)
        jobs = [self.client.submit(fake_case("steps=300 sleep_ms=10")).id for _ in range(3)]
        self.client.until_step(jobs[0], 30)
        running, *waiting = [self.client.job(job) for job in jobs]
        self.assertTrue(0 < running.ends_in_s < 30, running.ends_in_s)
        self.assertLess(waiting[0].starts_in_s, waiting[1].starts_in_s)
        self.assertLess(waiting[1].starts_in_s, waiting[1].ends_in_s)
        self.assertIn("starts in", self.dccast("show", jobs[2]))

    def test_nothing_is_foreseen_while_the_queue_is_held(self):
        self.client.until_state(self.client.submit(fake_case("steps=100 sleep_ms=10")).id, SUCCEEDED)
        jobs = [self.client.submit(fake_case("steps=400 sleep_ms=10")).id for _ in range(3)]
        self.client.until_step(jobs[0], 10)
        self.assertTrue(self.client.job(jobs[2]).HasField("starts_in_s"))
        self.limit_file_size(1)
        until(lambda: self.client.job(jobs[2]).held, 20)
        held = self.client.job(jobs[2])
        self.assertEqual((held.HasField("starts_in_s"), held.HasField("ends_in_s")), (False, False))
        self.limit_file_size(resource.RLIM_INFINITY)
        until(lambda: self.client.job(jobs[2]).HasField("starts_in_s"), 20)
        for job in jobs:
            self.client.cancel(job)

    def limit_file_size(self, size):
        resource.prlimit(self.daemon.process.pid, resource.RLIMIT_FSIZE,
                         (size, resource.RLIM_INFINITY))

    def test_nothing_is_foreseen_of_a_job_that_waits_for_another(self):
        first = self.client.submit(fake_case("steps=300 sleep_ms=10")).id
        after = self.client.submit(fake_case("steps=5"), after=[first])
        self.assertFalse(after.HasField("starts_in_s"))
        self.client.cancel(first)


class Hooks(QueueTest):
    def setUp(self):
        super().setUp()
        self.daemon.terminate()
        self.told = self.in_folder("told")
        hook = self.in_folder("hook")
        with open(hook, "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\n"
                       f'echo "$# $1 $2 $DCCAST_JOB $DCCAST_STATE $DCCAST_OWNER $DCCAST_MAIL" >>{self.told}\n'
                       f'printf "%s\\n" "$DCCAST_TITLE" >>{self.told}\n')
        os.chmod(hook, 0o700)
        self.daemon.settings["job_end_hook"] = hook
        self.restart()

    def lines(self):
        if not os.path.exists(self.told):
            return []
        with open(self.told, encoding="utf-8") as file:
            return file.read().splitlines()

    def test_it_is_run_once_a_job_and_no_shell_reads_a_title(self):
        title = 'steps=5 $(touch /tmp/x) `id` ; "a" %s'
        path = self.case_file("a.toml", title.replace('"', '\\"'))
        done = self.dccast("submit", "--mail", "anna@example.org", path).strip()
        me = self.client.job(done).owner
        until(lambda: len(self.lines()) == 2, 20)
        failed = self.client.submit(fake_case("steps=5 fail_at=2")).id
        until(lambda: len(self.lines()) == 4, 20)
        self.assertEqual(self.lines()[:3], [f"2 {done} SUCCEEDED {done} SUCCEEDED {me} anna@example.org",
                                            title, f"2 {failed} FAILED {failed} FAILED {me} "])
        self.restart_and_see_nothing_more()

    def restart_and_see_nothing_more(self):
        self.daemon.terminate()
        self.restart()
        self.client.until_state(self.client.submit(fake_case("steps=5")).id, SUCCEEDED)
        until(lambda: len(self.lines()) == 6, 20)

    def test_a_mail_that_is_no_address_is_refused(self):
        for wrong in ("anna", "-f@x", "a b@x", "@x", "a@x,b@y", "a\n@x"):
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, fake_case("steps=5"),
                         mail=wrong)

    def test_a_hook_that_cannot_be_run_is_an_invalid_setting(self):
        self.daemon.terminate()
        self.daemon.settings["job_end_hook"] = "/nowhere"
        ended = subprocess.run(self.daemon.command(), capture_output=True, timeout=20, check=False)
        self.assertEqual(ended.returncode, 2)

    def test_submit_waits_and_notifies(self):
        files = [self.case_file("a.toml", "steps=5"), self.case_file("b.toml", "steps=5 fail_at=2")]
        noted = self.in_folder("noted")
        self.dccast("submit", "--notify", f'echo "$DCCAST_STATE" >> {noted}', *files, code=3)
        with open(noted, encoding="utf-8") as file:
            self.assertEqual(file.read().split(), ["succeeded", "failed"])


if __name__ == "__main__":
    main()
