#!/usr/bin/python3
"""What an administrator's tools read: metrics, alert rules, dashboard, health, lines of the log."""
import contextlib
import json
import os
import re
import resource
import shutil
import socket
import subprocess
import sys
import unittest
import urllib.error
import urllib.request

import grpc

from dccast.v1 import follow_pb2, job_pb2
from follow_test import FollowTest
from support import ServiceTest, fake_case
from waiting import until

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
HOSTILE = "a\nERROR forged \x1b[2J \"quoted\" \\"


def text_of(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


def own_names(expression):
    """Metrics of ours that an expression names."""
    return set(re.findall(r"\b(?:dccast|process)_[a-z_]+", expression))


def family(name):
    return re.sub(r"_(bucket|sum|count)$", "", name)


class MetricsTest(ServiceTest):
    settings = {"listen__metrics": "127.0.0.1:0", "listen__tls": "127.0.0.2:0", "workers__count": 1,
                "per_user__maximum_streams": 1}

    def page(self):
        address = re.findall(r"metrics on (http://\S+)", self.daemon.said())[-1]
        with urllib.request.urlopen(address, timeout=10) as answer:
            self.assertIn("version=0.0.4", answer.headers["Content-Type"])
            return answer.read().decode()

    def families(self, page):
        return dict(re.findall(r"^# TYPE (\S+) (\S+)$", page, re.MULTILINE))

    def value(self, sample, page=None):
        found = re.search(rf"^{re.escape(sample)} (\S+)$", page or self.page(), re.MULTILINE)
        return float(found[1]) if found else None

    def some_work(self):
        done = self.client.submit(fake_case("steps=5")).id
        failed = self.client.submit(fake_case("steps=5 fail_at=2")).id
        self.client.until_state(done, job_pb2.SUCCEEDED)
        self.client.until_state(failed, job_pb2.FAILED)
        running = self.client.submit(fake_case("steps=1000 wait_at=3")).id
        self.client.until_step(running, 3)
        waiting = self.client.submit(fake_case("steps=5")).id
        return running, waiting


class Scrape(MetricsTest):
    def test_the_page_lists_every_metric_of_a_scrape_with_its_type(self):
        self.some_work()
        listed = dict(re.findall(r"^\| `([a-z_]+)` \| (\w+) \|", text_of("docs", "metrics.md"),
                                 re.MULTILINE))
        self.assertEqual(self.families(self.page()), listed)

    def test_rules_and_dashboard_name_only_metrics_that_exist(self):
        self.some_work()
        there = set(self.families(self.page()))
        board = json.loads(text_of("deploy", "monitoring", "dashboard.json"))
        expressions = [target["expr"] for panel in board["panels"] for target in panel["targets"]]
        rules = text_of("deploy", "monitoring", "alerts.yml")
        alarms = re.findall(r"- alert: (\w+)", rules)
        named = {family(name) for text in expressions + [rules] for name in own_names(text)}
        self.assertGreater(len(named), 20)
        self.assertEqual(named - there, set())
        page = text_of("docs", "metrics.md")
        self.assertEqual([alarm for alarm in alarms if f"| `{alarm}` |" not in page], [])

    def test_what_happened_is_counted(self):
        running, waiting = self.some_work()
        page = self.page()
        self.assertEqual(self.value('dccast_jobs_ended_total{state="SUCCEEDED"}', page), 1)
        self.assertEqual(self.value('dccast_job_failures_total{cause="SOLVE_FAILED"}', page), 1)
        self.assertEqual(self.value("dccast_job_run_seconds_count", page), 2)
        self.assertEqual(self.value("dccast_job_wait_seconds_count", page), 3)
        self.assertEqual(self.value("dccast_jobs_running", page), 1)

        owner = self.client.job(running).owner
        for state in ("RUNNING", "QUEUED"):
            self.assertEqual(self.value(f'dccast_jobs{{state="{state}",owner="{owner}"}}', page), 1)
        self.assertGreater(self.value("dccast_queue_oldest_wait_seconds"), 0)
        self.assertEqual(
            self.value('dccast_call_seconds_count{method="SubmitJob",code="OK"}', page), 4)
        self.assertGreater(self.value("dccast_fsync_seconds_count", page), 4)
        self.assertGreater(self.value(f'dccast_jobs_disk_bytes{{owner="{owner}"}}', page), 1000)
        self.assertGreater(self.value("process_resident_memory_bytes", page), 1e6)
        self.assertGreater(
            self.value('dccast_worker_resident_memory_bytes{name="dccast-job"}', page), 1e5)

        self.client.cancel(waiting)
        self.assertEqual(self.value('dccast_jobs_ended_total{state="CANCELLED"}'), 1)

    def test_a_refusal_is_counted_by_its_limit(self):
        running, _ = self.some_work()
        watch = self.client.watch(running)
        next(watch)
        self.assertEqual(self.value("dccast_streams_open"), 1)
        self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.new_client().watch, running)
        self.assertEqual(
            self.value('dccast_refused_calls_total{limit="per_user.maximum_streams"}'), 1)
        watch.cancel()
        until(lambda: self.value("dccast_streams_open") == 0, 10)

    def test_only_the_page_is_served_and_only_to_this_machine(self):
        address = re.findall(r"metrics on (http://\S+)/metrics", self.daemon.said())[-1]
        with self.assertRaises(urllib.error.HTTPError) as caught:
            urllib.request.urlopen(address + "/../etc/passwd", timeout=10)
        self.assertEqual(caught.exception.code, 404)

        # Silent connections hold its few threads only as long as its own time limit.
        host, port = address.split("//")[1].split(":")
        with contextlib.ExitStack() as silent:
            for _ in range(4):
                silent.enter_context(socket.create_connection((host, int(port)), 10))
            self.assertIn("dccast_jobs", self.wait_for_page())
        self.daemon.terminate()
        self.daemon.settings["listen__metrics"] = "0.0.0.0:0"
        with self.assertRaises(RuntimeError) as refused:
            self.daemon.start()
        self.assertIn("loopback", str(refused.exception))

    def wait_for_page(self):
        address = re.findall(r"metrics on (http://\S+)", self.daemon.said())[-1]
        with urllib.request.urlopen(address, timeout=30) as answer:
            return answer.read().decode()


class Castings(FollowTest, MetricsTest):
    settings = {"listen__metrics": "127.0.0.1:0"}

    def figures(self):
        page = self.page()
        return tuple(self.value("dccast_" + name, page)
                     for name in ("castings_followed", "casting_warnings", "reading_age_seconds"))

    def test_castings_under_way_their_warnings_and_the_age_of_readings_are_counted(self):
        self.assertEqual(self.figures(), (0, 0, 0))
        gauge = follow_pb2.Gauge(monitor="corner", noise_m=5e-4)
        job_id = self.follow(ensemble=self.ensemble(), gauges=[gauge])
        self.append(job_id, *[follow_pb2.Reading(number=t + 1, time_s=t, curls=[follow_pb2.MeasuredCurl(
            monitor="corner", curl_m=0.05 if t > 20 else 0.0)]) for t in range(30)])
        self.forecast(job_id)
        castings, warnings, _ = self.figures()
        self.assertEqual(castings, 1)
        self.assertGreater(warnings, 0)
        until(lambda: self.figures()[2] > 1, 10)

        self.client.cancel(job_id)
        self.client.until_state(job_id, job_pb2.CANCELLED)
        self.assertEqual(self.figures(), (0, 0, 0))


class Guarded(MetricsTest):
    """What the port does not do for strangers on the machine."""
    settings = {**MetricsTest.settings, "access__read": "own"}

    def test_other_names_are_refused(self):
        address = re.findall(r"metrics on (http://\S+)", self.daemon.said())[-1]
        for host, status in (("evil.example", 403), ("127.0.0.1.evil.example:9117", 403),
                             ("localhost", 200), ("[::1]:8000", 200), ("127.0.0.1:9117", 200)):
            request = urllib.request.Request(address, headers={"Host": host})
            try:
                with urllib.request.urlopen(request, timeout=10) as answer:
                    self.assertEqual(answer.status, status, host)
            except urllib.error.HTTPError as refused:
                self.assertEqual(refused.code, status, host)

    def test_names_of_users_are_not_shown_where_each_sees_only_their_own_jobs(self):
        self.some_work()
        page = self.page()
        self.assertNotIn("owner=", page)
        self.assertEqual(self.value('dccast_jobs{state="RUNNING"}', page), 1)
        self.assertGreater(self.value("dccast_jobs_disk_bytes", page), 1000)
        self.assertIsNotNone(self.value("dccast_processor_seconds_total", page))


class Promtool(MetricsTest):
    """Nightly: its package brings 320 MB."""

    def promtool(self, *words, given=""):
        ended = subprocess.run(["promtool", *words], input=given, capture_output=True, text=True,
                               timeout=60, check=False)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""), ended.stdout)

    def test_it_takes_rules_their_test_and_a_scrape(self):
        self.assertTrue(shutil.which("promtool"), "deploy/install_packages nightly")
        folder = os.path.join(ROOT, "deploy", "monitoring")
        self.promtool("check", "rules", os.path.join(folder, "alerts.yml"))
        self.promtool("test", "rules", os.path.join(folder, "alerts_test.yml"))
        self.some_work()
        self.promtool("check", "metrics", given=self.page())


class Health(ServiceTest):
    settings = {"listen__metrics": "127.0.0.1:0"}
    NAMES = ("", "alive", "ready", "dccast.v1.SimulationService")
    SERVING, NOT_SERVING = 1, 2

    def statuses(self):
        """Answers of the standard health service: the one field is an enum."""
        call = self.client.channel.unary_unary("/grpc.health.v1.Health/Check")
        answers = [call(b"\x0a" + bytes([len(name)]) + name.encode() if name else b"", timeout=5)
                   for name in self.NAMES]
        return [answer[1] if answer else 0 for answer in answers]

    def code(self, name):
        """Of what a load balancer or `curl -f` asks."""
        address = re.findall(r"metrics on (http://\S+)/metrics", self.daemon.said())[-1]
        try:
            with urllib.request.urlopen(f"{address}/{name}", timeout=10) as answer:
                return answer.status
        except urllib.error.HTTPError as refused:
            return refused.code

    def limit_file_size(self, size):
        resource.prlimit(self.daemon.process.pid, resource.RLIMIT_FSIZE,
                         (size, resource.RLIM_INFINITY))

    def test_alive_and_ready_are_apart_while_the_queue_is_held(self):
        until(lambda: self.statuses() == [self.SERVING] * 4, 5)
        self.assertEqual((self.code("ready"), self.code("alive")), (200, 200))
        jobs = [self.client.submit(fake_case("steps=150 sleep_ms=10")).id for _ in range(4)]
        self.client.until_step(jobs[0], 10)
        self.limit_file_size(1)
        held = [self.SERVING, self.SERVING, self.NOT_SERVING, self.NOT_SERVING]
        until(lambda: self.statuses() == held, 20)
        self.assertEqual((self.code("ready"), self.code("alive")), (503, 200))
        self.limit_file_size(resource.RLIM_INFINITY)
        until(lambda: self.statuses() == [self.SERVING] * 4, 20)
        for job in jobs:
            self.client.until_state(job, job_pb2.SUCCEEDED, seconds=60)


class Logs(ServiceTest):
    def lines_after_hostile_texts(self):
        job = self.client.submit(fake_case("steps=5 sleep_ms=20"))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        for call in (lambda: self.client.submit(fake_case(HOSTILE)),
                     lambda: self.client.submit(fake_case('steps=5 "quoted" \\ ü'))):
            with contextlib.suppress(grpc.RpcError):
                call()
        return self.daemon.said().splitlines()

    def test_text(self):
        for line in self.lines_after_hostile_texts():
            self.assertRegex(line, r"^\[20\d\d-.*\] \[dccastd\] \[\w+\] ")


class JsonLogs(Logs):
    settings = {"log__format": "json"}

    def test_text(self):
        events = [json.loads(line) for line in self.lines_after_hostile_texts()]
        self.assertGreater(len(events), 4)
        for event in events:
            self.assertLessEqual({"time", "level", "message"}, set(event))
        # What belongs to a job can be selected by its id.
        job = next(event["job"] for event in events if "QUEUED: submitted" in event["message"])
        self.assertTrue([event for event in events if event.get("job") == job
                         and "RUNNING -> SUCCEEDED" in event["message"]])
        self.assertTrue([event for event in events if '"quoted" \\' in event["message"]])


class JournalLogs(Logs):
    settings = {"log__format": "journal"}

    def test_text(self):
        for line in self.lines_after_hostile_texts():
            self.assertRegex(line, r"^<[2-7]>\S")


if __name__ == "__main__":
    nightly = "--nightly" in sys.argv
    if nightly:
        sys.argv.remove("--nightly")
    unittest.main(defaultTest="Promtool" if nightly else ["Scrape", "Guarded", "Health", "Logs",
                                                          "JsonLogs", "JournalLogs"])
