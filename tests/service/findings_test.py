#!/usr/bin/python3
"""What a run finds is told once, kept with the job, and said by every command of the client."""
import json
import os
import signal

from dccast.v1 import job_pb2
from support import ServiceTest, fake_case, main

SCRIPT = "steps=60 checkpoint=7 sleep_ms=20 finding_at=10"


class Findings(ServiceTest):
    settings = {"workers__restarts": 2}

    def job_past_its_finding(self):
        """Behind the checkpoint of step 14, which knows of the finding of step 10."""
        job = self.client.submit(fake_case(SCRIPT))
        self.client.until_step(job.id, 16)
        return job.id

    def told_once(self, job_id):
        self.client.until_state(job_id, job_pb2.SUCCEEDED, seconds=60)
        events = self.sound_events(list(self.client.watch(job_id)))
        told = [event.finding for event in events if event.HasField("finding")]
        self.assertEqual(len(told), 1)
        self.assertEqual(list(self.client.job(job_id).findings), told)
        return told[0]

    def test_as_the_worker_said_it(self):
        found = self.told_once(self.job_past_its_finding())
        self.assertEqual((found.code, found.severity), ("bleed_out_at_exit", job_pb2.Finding.DANGER))
        self.assertEqual((found.time_s, list(found.place_m)), (10.0, [0.28, 0.04]))
        self.assertEqual((found.value, found.limit, found.unit), (3e-3, 5e-3, "m"))
        self.assertEqual(found.key, "plausibility.minimum_shell")

    def test_not_again_after_a_killed_worker(self):
        job_id = self.job_past_its_finding()
        os.kill(self.daemon.worker_processes()[0], signal.SIGKILL)
        self.told_once(job_id)
        self.assertEqual(self.client.job(job_id).attempts, 2)

    def test_not_again_after_a_killed_daemon(self):
        job_id = self.job_past_its_finding()
        self.daemon.kill()
        self.restart()
        self.assertEqual(len(self.client.job(job_id).findings), 1, "known before it goes on")
        self.told_once(job_id)
        self.daemon.terminate()
        self.restart()
        self.assertEqual(len(self.client.job(job_id).findings), 1, "kept in the store")

    def test_not_again_after_a_pause(self):
        job_id = self.job_past_its_finding()
        self.run_dccast("pause", job_id)
        self.client.until_state(job_id, job_pb2.PAUSED)
        self.run_dccast("resume", job_id)
        self.told_once(job_id)

    def test_with_the_first_page_of_a_history_and_in_lists(self):
        job_id = self.job_past_its_finding()
        found = self.told_once(job_id)
        pages = self.client.ask("QueryResult", id=job_id, page_size=10)
        self.assertEqual(list(pages.findings), [found])
        listed = self.client.ask("ListJobs")
        self.assertEqual(list(listed.jobs[0].findings), [found])

    def test_every_command_says_it(self):
        job_id = self.job_past_its_finding()
        self.told_once(job_id)
        line = r"danger: bleed_out_at_exit at 10\.00 s: The shell leaves the mould 3 mm thick\."
        self.assertRegex(self.dccast("show", job_id), "finding +" + line)
        self.assertRegex(self.dccast("watch", job_id), line)
        self.assertRegex(self.run_dccast("curl", job_id).stderr, line)
        self.assertRegex(self.dccast("list"), r"FINDINGS.*\n.* 1 danger ")

        for words in (["show"], ["curl"]):
            said = json.loads(self.dccast(*words, "--json", job_id))
            self.assertEqual(said["findings"][0]["code"], "bleed_out_at_exit")
        events = [json.loads(text) for text in
                  self.dccast("watch", "--json", job_id).splitlines()]
        told = [event for event in events if event["event"] == "finding"]
        self.assertEqual([event["finding"]["code"] for event in told], ["bleed_out_at_exit"])

    def test_only_the_strict_fail_for_it(self):
        job_id = self.job_past_its_finding()
        self.run_dccast("watch", job_id)
        self.assertIn("--strict", self.dccast("watch", "--strict", job_id, code=3))


if __name__ == "__main__":
    main()
