#!/usr/bin/python3
"""Queries: an answer at once, beside the queue, and no job left behind."""
import os
import re
import select
import signal
import subprocess
import time

import grpc

from dccast.v1 import job_pb2, service_pb2
from support import BIN, ServiceTest, curve, fake_case, main, work_of
from waiting import until


def question(title="", columns=30, **rest):
    """The fake worker does what the title says; the figures of two cases are told apart by a key."""
    case = fake_case(title)
    case.mesh.columns = columns
    return service_pb2.QueryButtCurlRequest(case=case, **rest)


def parts(responses):
    """What came: accepted, steps, the end. The run before may still be ending: that wait is left out."""
    responses = [response for response in responses if not response.HasField("waiting")]
    kinds = [response.WhichOneof("what") for response in responses]
    assert kinds[0] == "accepted" and kinds[-1] == "ended", kinds
    return (responses[0].accepted, [r.step for r in responses if r.HasField("step")],
            responses[-1].ended)


class QueryTest(ServiceTest):
    def ask(self, *arguments, timeout=30, **rest):
        return self.client.stub.QueryButtCurl(question(*arguments, **rest), timeout=timeout)

    def jobs(self, **filters):
        return list(self.client.ask("ListJobs", **filters).jobs)

    def query_processes(self):
        """Those that compute a query now."""
        return [process for process in self.daemon.children()
                if work_of(process) == "dccast-query"]


class Queries(QueryTest):
    def test_the_curve_comes_as_it_is_computed_and_no_job_is_left(self):
        begin = time.monotonic()
        times = []
        answer = []
        for response in self.ask("steps=20 sleep_ms=20"):
            answer.append(response)
            times.append(time.monotonic() - begin)
        accepted, steps, ended = parts(answer)

        self.assertFalse(accepted.from_store)
        self.assertEqual(accepted.case.mesh.element, 3)  # complete: defaults are filled in
        self.assertEqual([step.step for step in steps], list(range(1, 21)))
        self.assertEqual(ended.state, job_pb2.SUCCEEDED)
        self.assertLess(times[1], times[-1] / 2)
        self.assertEqual(self.jobs(), [])
        self.assertEqual(os.listdir(self.in_folder("data", "jobs")), [])
        self.assertEqual(os.listdir(self.in_folder("data", "check")), [])

    def test_the_answer_is_that_of_a_job(self):
        job = self.client.submit(fake_case("steps=30", mesh={"columns": 7}))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        _, steps, _ = parts(self.ask("steps=30", columns=8))
        self.assertEqual(curve(steps), curve(self.client.steps(job.id)))

    def test_a_case_that_was_computed_before_is_answered_from_the_store(self):
        _, first, _ = parts(self.ask("steps=10", columns=9))
        begin = time.monotonic()
        accepted, second, ended = parts(self.ask("steps=10 under another title", columns=9))
        self.assertTrue(accepted.from_store)
        self.assertEqual(accepted.job, "")
        self.assertEqual(accepted.case.title, "steps=10 under another title")
        self.assertEqual(curve(first), curve(second))
        self.assertEqual(ended.state, job_pb2.SUCCEEDED)
        self.assertLess(time.monotonic() - begin, 1.0)
        accepted, _, _ = parts(self.ask("steps=10", columns=10))
        self.assertFalse(accepted.from_store)

    def test_a_job_answers_too_and_no_longer_once_it_is_deleted(self):
        job = self.client.submit(fake_case("steps=10", mesh={"columns": 11}))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        accepted, steps, ended = parts(self.ask("steps=10", columns=11))
        self.assertTrue(accepted.from_store)
        self.assertEqual(accepted.job, job.id)
        self.assertEqual(curve(steps), curve(self.client.steps(job.id)))
        self.assertEqual(ended.state, job_pb2.SUCCEEDED)
        self.client.ask("DeleteJob", id=job.id)
        accepted, _, _ = parts(self.ask("steps=10", columns=11))
        self.assertFalse(accepted.from_store)

    def test_a_run_that_fails_says_so_and_answers_nobody_else(self):
        for _ in range(2):
            accepted, steps, ended = parts(self.ask("steps=10 fail_at=4", columns=12))
            self.assertFalse(accepted.from_store)
            self.assertEqual(ended.state, job_pb2.FAILED)
            self.assertEqual(ended.failure.kind, job_pb2.Finding.SOLVE_FAILED)
            self.assertLess(len(steps), 10)

    def test_a_case_at_fault_is_refused_with_its_faults(self):
        request = question()
        request.case.section.half_width_m = -1.0
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.stub.QueryButtCurl,
                             request, timeout=10)
        self.assertIn("section.half_width", error.details())
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.ask, "check=fault")

    def test_a_worker_that_crashes_costs_one_answer(self):
        before = len(self.daemon.answering_processes())
        self.refused(grpc.StatusCode.INTERNAL, self.ask, "steps=10 crash_at=3", columns=13)
        _, steps, _ = parts(self.ask("steps=10", columns=13))
        self.assertEqual(len(steps), 10)
        until(lambda: len(self.daemon.answering_processes()) == before, 1.0)


class Cancelling(QueryTest):
    settings = {"queries__workers": 1}

    def test_cancelling_the_call_ends_the_run_at_once(self):
        waiting = len(self.daemon.answering_processes())
        call = self.ask("steps=100000 sleep_ms=5")
        for _, _ in zip(range(4), call):
            pass
        worker, = self.query_processes()
        call.cancel()
        until(lambda: worker not in self.daemon.children(), 0.5)
        until(lambda: len(self.daemon.answering_processes()) == waiting, 1.0)  # the next one
        _, steps, _ = parts(self.ask("steps=5", columns=14))
        self.assertEqual(len(steps), 5)
        self.assertEqual(self.jobs(), [])
        until(lambda: os.listdir(self.in_folder("data", "check")) == [], 1.0)

    def test_a_deadline_ends_it_too(self):
        self.refused(grpc.StatusCode.DEADLINE_EXCEEDED, self.ask, "steps=100000 sleep_ms=5",
                     timeout=0.3)
        _, steps, _ = parts(self.ask("steps=5", columns=15))
        self.assertEqual(len(steps), 5)

    def test_the_end_of_the_daemon_is_said(self):
        call = self.ask("steps=100000 sleep_ms=5")
        for _, _ in zip(range(4), call):
            pass
        self.daemon.terminate()
        self.refused(grpc.StatusCode.UNAVAILABLE, list, call)

    def test_a_job_runs_on_beside_queries_that_come_and_go(self):
        job = self.client.submit(fake_case("steps=60 sleep_ms=10", mesh={"columns": 16}))
        for _ in range(5):
            call = self.ask("steps=100000 sleep_ms=5")
            next(iter(call))
            call.cancel()
        done = self.client.until_state(job.id, job_pb2.SUCCEEDED)
        self.assertEqual(done.attempts, 1)


class SeveralAtOnce(QueryTest):
    settings = {"checks__workers": 1, "queries__workers": 3}

    def test_as_many_run_at_once_as_the_settings_say(self):
        calls = [self.ask("steps=100000 sleep_ms=5", columns=50 + number) for number in range(3)]
        for call in calls:
            self.assertTrue(any(response.HasField("step") for response in call))
        self.assertEqual(len(self.query_processes()), 3)
        for call in calls:
            call.cancel()

    def test_the_cases_of_a_comparison_are_computed_side_by_side(self):
        """Three of a second each in less than two."""
        new = subprocess.run([os.path.join(BIN, "dccast"), "new", "start-2d-thickness"],
                             capture_output=True, text=True,
                             timeout=10, check=True).stdout
        files = []
        for number in range(3):
            files.append(self.in_folder(f"case{number}.toml"))
            with open(files[-1], "w", encoding="utf-8") as file:
                file.write(re.sub(r"(?m)^title = .*$", 'title = "steps=40 sleep_ms=25"', new))
                file.write(f'\n[validity]\nmaximum_slip = "{7 + number} mm"\n')
        begin = time.monotonic()
        self.dccast("compare", *files)
        self.assertLess(time.monotonic() - begin, 2.0)


class Kept(QueryTest):
    def test_a_kept_run_is_a_job_like_any_other(self):
        change = job_pb2.CaseChange(key="mesh.columns", value="17")
        accepted, steps, ended = parts(self.ask("steps=12", columns=17, keep=True,
                                                changes=[change]))
        self.assertEqual(ended.state, job_pb2.SUCCEEDED)

        job = self.client.job(accepted.job)
        self.assertEqual(job.state, job_pb2.SUCCEEDED)
        self.assertEqual(list(job.changes), [change])
        self.assertEqual(job.last_step.step, 12)

        events = self.sound_events(list(self.client.watch(job.id)))
        self.assertEqual([e.step.step for e in events if e.HasField("step")], list(range(1, 13)))
        self.assertEqual(curve(self.client.steps(job.id)), curve(steps))
        self.assertTrue(self.client.fetch(job.id))

        self.daemon.kill()
        self.restart()
        self.assertEqual(self.client.job(job.id).state, job_pb2.SUCCEEDED)

        accepted, _, _ = parts(self.ask("steps=12", columns=17))
        self.assertEqual(accepted.job, job.id)

    def test_a_kept_run_that_failed_keeps_its_cause(self):
        accepted, _, ended = parts(self.ask("steps=12 fail_at=3", columns=18, keep=True))
        self.assertEqual(ended.state, job_pb2.FAILED)
        self.assertEqual(self.client.job(accepted.job).failure.kind, job_pb2.Finding.SOLVE_FAILED)

    def test_the_job_of_a_call_that_was_cancelled_is_cancelled(self):
        call = self.ask("steps=100000 sleep_ms=5", keep=True)
        for _, _ in zip(range(4), call):
            pass
        call.cancel()
        job, = self.jobs()
        until(lambda: self.client.job(job.id).state == job_pb2.CANCELLED, 10)

    def test_what_was_acknowledged_survives_the_daemon(self):
        call = self.ask("steps=200 sleep_ms=5", keep=True)
        accepted = next(iter(call)).accepted
        self.client.until_step(accepted.job, 5)
        self.daemon.kill()
        self.restart()
        self.client.until_state(accepted.job, job_pb2.SUCCEEDED)
        steps = [step.step for step in self.client.steps(accepted.job)]
        self.assertEqual(steps, list(range(1, 201)))


class Beside(QueryTest):
    settings = {"queries__workers": 1, "checks__maximum_waiting": 1, "workers__count": 2}

    def test_a_kept_query_does_not_wait_for_the_queue(self):
        for number in range(4):
            self.client.submit(fake_case("steps=1000000 sleep_ms=50", mesh={"columns": 60 + number}))
        until(lambda: len(self.jobs(states=[job_pb2.RUNNING])) == 2, 10)
        _, steps, ended = parts(self.ask("steps=10", columns=70, keep=True))
        self.assertEqual(ended.state, job_pb2.SUCCEEDED)
        self.assertEqual([step.step for step in steps], list(range(1, 11)))
        self.assertEqual(len(self.jobs(states=[job_pb2.RUNNING])), 2)

    def test_a_full_queue_delays_no_query(self):
        for number in range(20):
            self.client.submit(fake_case("steps=1000000 sleep_ms=50", mesh={"columns": 40 + number}))
        until(lambda: len(self.jobs(states=[job_pb2.RUNNING])) == 2, 10)
        first = []
        for number in range(11):
            begin = time.monotonic()
            for response in self.ask("steps=3", columns=100 + number):
                if response.HasField("step"):
                    first.append(time.monotonic() - begin)
                    break
        print(f"\nfirst point beside a full queue: {[round(t * 1e3, 1) for t in first]} ms")
        # The bound is 50 ms; the median, as other tests share the machine.
        self.assertLess(sorted(first)[5], 0.05)

    def test_too_many_queries_are_refused(self):
        calls = [self.ask("steps=100000 sleep_ms=5")]
        next(iter(calls[0]))
        calls.append(self.ask("steps=100000 sleep_ms=5", columns=41))
        self.assertTrue(any(response.HasField("waiting") for response in calls[1]))
        self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.ask, "steps=3")
        for call in calls:
            call.cancel()

    def test_workers_of_jobs_stand_back_behind_queries(self):
        self.client.submit(fake_case("steps=1000000 sleep_ms=50", mesh={"columns": 19}))
        until(lambda: self.daemon.worker_processes(), 10)
        process = self.daemon.worker_processes()[0]
        own = os.getpriority(os.PRIO_PROCESS, self.daemon.process.pid)
        self.assertEqual(os.getpriority(os.PRIO_PROCESS, process), min(own + 19, 19))


def state_of(process):
    """The letter that the system has for the state of a process: "T" is stopped; "" when it has gone."""
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
            return file.read().rsplit(")", 1)[1].split()[0]
    except OSError:
        return ""


ENDLESS = "steps=1000000 sleep_ms=5 estimate_s=60"


class BesideAComparison(QueryTest):
    """A comparison of 3D runs has every thread for queries, and jobs have every worker."""
    settings = {"queries__workers": 2, "workers__count": 2}

    def compare(self, *titles):
        """Starts `dccast compare` for cases of these titles."""
        new = subprocess.run([os.path.join(BIN, "dccast"), "new", "start-2d-thickness"],
                             capture_output=True, text=True, timeout=10, check=True).stdout
        files = []
        for number, title in enumerate(titles):
            files.append(self.in_folder(f"compared{number}.toml"))
            with open(files[-1], "w", encoding="utf-8") as file:
                file.write(re.sub(r"(?m)^title = .*$", f'title = "{title}"', new))
                file.write(f'\n[validity]\nmaximum_slip = "{7 + number} mm"\n')
        process = subprocess.Popen(self.client_command("compare", *files), stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end, process)
        return process

    @staticmethod
    def end(process):
        process.kill()
        process.communicate()

    def test_a_query_and_a_stored_answer_come_while_the_comparison_runs(self):
        self.assertFalse(parts(self.ask("steps=5 estimate_s=1", columns=20))[0].from_store)
        for number in range(2):
            self.client.submit(fake_case(ENDLESS, mesh={"columns": 60 + number}))
        until(lambda: len(self.jobs(states=[job_pb2.RUNNING])) == 2, 10)
        comparison = self.compare(ENDLESS, ENDLESS, ENDLESS)
        until(lambda: len(self.query_processes()) == 2, 10)

        begin = time.monotonic()
        _, steps, ended = parts(self.ask("steps=10 estimate_s=1", columns=21))
        elapsed = [time.monotonic() - begin]
        self.assertEqual((len(steps), ended.state), (10, job_pb2.SUCCEEDED))
        accepted, steps, _ = parts(self.ask("steps=5 estimate_s=1", columns=20))
        elapsed.append(time.monotonic() - begin - elapsed[0])
        self.assertEqual((accepted.from_store, len(steps)), (True, 5))
        _, steps, _ = parts(self.ask("steps=10 estimate_s=10", columns=22))
        self.assertEqual(len(steps), 10)

        self.assertIsNone(comparison.poll())
        self.assertEqual(len(self.query_processes()), 2)
        print(f"\nbeside a comparison: query {elapsed[0]:.3f} s, from the store {elapsed[1]:.3f} s")

    def test_runs_of_comparisons_and_jobs_stand_while_a_query_runs_and_go_on_after_it(self):
        job = self.client.submit(fake_case(ENDLESS, mesh={"columns": 60}))
        self.compare(ENDLESS, ENDLESS)
        until(lambda: len(self.query_processes()) == 2, 10)
        self.client.until_step(job.id, 1)
        others = self.query_processes() + self.daemon.worker_processes()
        self.assertEqual(len(others), 3)
        self.assertNotIn("T", [state_of(process) for process in others])

        call = self.ask("steps=1000000 sleep_ms=5 estimate_s=1", columns=21)
        until(lambda: [state_of(process) for process in others] == ["T"] * 3, 5)
        self.assertRegex(self.client.job(job.id).held, "query")
        self.assertTrue(any(response.HasField("step") for response in call))
        call.cancel()
        until(lambda: "T" not in [state_of(process) for process in others], 5)
        step = self.client.job(job.id).last_step.step
        self.client.until_step(job.id, step + 1)
        until(lambda: self.client.job(job.id).held == "", 5)

    def test_a_thickness_query_goes_before_a_draft(self):
        draft = self.ask("steps=1000000 sleep_ms=5 estimate_s=10", columns=23)
        until(lambda: len(self.query_processes()) == 1, 10)
        process, = self.query_processes()
        call = self.ask("steps=1000000 sleep_ms=5 estimate_s=1", columns=21)
        until(lambda: state_of(process) == "T", 5)
        call.cancel()
        until(lambda: state_of(process) != "T", 5)
        draft.cancel()

    def test_a_query_that_waits_is_told_what_for_and_how_long(self):
        calls = [self.ask("steps=1000000 sleep_ms=5 estimate_s=4", columns=24 + number)
                 for number in range(2)]
        until(lambda: len(self.query_processes()) == 2, 10)
        third = self.ask("steps=5 estimate_s=2", columns=26)
        waiting = next(iter(third)).waiting
        self.assertRegex(waiting.reason, "2 queries")
        self.assertGreater(waiting.expected_s, 1.0)
        self.assertLessEqual(waiting.expected_s, 4.0)
        for call in calls:
            call.cancel()
        accepted, steps, _ = parts(third)
        self.assertEqual((accepted.from_store, len(steps)), (False, 5))

    def test_the_client_prints_what_a_comparison_waits_for(self):
        comparison = self.compare(ENDLESS, ENDLESS, ENDLESS)
        self.assertTrue(select.select([comparison.stderr], [], [], 20)[0], "nothing is printed")
        line = comparison.stderr.readline()
        self.assertRegex(line, r"compared\d.toml: waiting for 2 queries, about .* (s|min)")


class StoppedWorkers(QueryTest):
    """What becomes of a worker that stands still for a query when its daemon goes."""

    def stopped_worker(self):
        job = self.client.submit(fake_case(ENDLESS, mesh={"columns": 60}))
        self.client.until_step(job.id, 1)
        worker, = self.daemon.worker_processes()
        self.call = self.ask("steps=1000000 sleep_ms=5 estimate_s=1", columns=21)
        until(lambda: state_of(worker) == "T", 5)
        return job, worker

    def test_a_worker_goes_on_when_its_daemon_is_killed(self):
        job, worker = self.stopped_worker()
        step = self.client.job(job.id).last_step.step
        self.daemon.kill()
        until(lambda: state_of(worker) not in ("T", ""), 5)
        self.restart()
        self.assertEqual(self.daemon.worker_processes(), [worker])
        self.client.until_step(job.id, step + 5)
        self.assertEqual(self.client.job(job.id).attempts, 1)

    def test_the_next_daemon_continues_a_worker_that_it_adopts(self):
        job, worker = self.stopped_worker()
        self.daemon.kill()
        os.kill(worker, signal.SIGSTOP)
        self.restart()
        step = self.client.job(job.id).last_step.step
        self.client.until_step(job.id, step + 5)
        call = self.ask("steps=1000000 sleep_ms=5 estimate_s=1", columns=22)
        until(lambda: state_of(worker) == "T", 5)
        call.cancel()
        until(lambda: state_of(worker) != "T", 5)

    def test_a_worker_that_no_one_continues_goes_on_by_itself(self):
        """A daemon that dies after it has adopted a worker is not its parent: the timer of the worker helps."""
        _, worker = self.stopped_worker()
        self.daemon.kill()
        os.kill(worker, signal.SIGSTOP)
        until(lambda: state_of(worker) == "T", 5)
        until(lambda: state_of(worker) not in ("T", ""), 70)

    def test_a_daemon_that_ends_takes_stopped_workers_with_it(self):
        job, worker = self.stopped_worker()
        self.assertEqual(self.daemon.terminate(), 0)
        self.assertEqual(state_of(worker), "")
        self.restart()
        self.client.until_state(job.id, job_pb2.RUNNING)
        self.assertEqual(self.client.job(job.id).attempts, 2)


class TimersOfStoppedWorkers(QueryTest):
    settings = {"workers__heartbeat_interval": "0.2 s", "workers__heartbeat_timeout": "1 s",
                "workers__stall_timeout": "1 s"}

    def test_a_worker_that_stands_still_for_a_query_is_not_taken_to_hang(self):
        job = self.client.submit(fake_case(ENDLESS, mesh={"columns": 60}))
        self.client.until_step(job.id, 1)
        worker, = self.daemon.worker_processes()
        call = self.ask("steps=1000000 sleep_ms=5 estimate_s=1", columns=21)
        until(lambda: state_of(worker) == "T", 5)
        time.sleep(2.5)  # longer than both timeouts
        call.cancel()
        step = self.client.job(job.id).last_step.step
        self.client.until_step(job.id, step + 5)
        self.assertEqual(self.client.job(job.id).attempts, 1)
        self.assertEqual(self.daemon.worker_processes(), [worker])


if __name__ == "__main__":
    main()
