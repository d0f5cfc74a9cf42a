#!/usr/bin/python3
"""A data folder that an earlier version left is gone on with: data/README.md."""
import os
import tarfile

from dccast.v1 import job_pb2, service_pb2
from support import ServiceTest, curve, fake_case, main

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "data", "folder-a60da8e.tar.xz")
ENDS = {"done": job_pb2.SUCCEEDED, "failed": job_pb2.FAILED, "cancelled": job_pb2.CANCELLED,
        "paused": job_pb2.PAUSED, "running": job_pb2.SUCCEEDED, "waiting": job_pb2.SUCCEEDED}


class Upgrade(ServiceTest):
    def setUp(self):
        super().setUp()
        self.daemon.terminate()
        self.daemon.settings["data_directory"] = os.path.join(self.folder, "old", "data")
        with tarfile.open(FOLDER) as old:
            old.extractall(os.path.join(self.folder, "old"))
        self.data = self.daemon.settings["data_directory"]

    def jobs(self):
        listed = self.client.stub.ListJobs(service_pb2.ListJobsRequest(), timeout=10).jobs
        return {job.request_id: job for job in listed}

    def goes_on(self):
        jobs = self.jobs()
        self.assertEqual(set(jobs), set(ENDS))
        for name, state in ENDS.items():
            self.client.until_state(jobs[name].id, state)
        resumed = self.client.stub.ResumeJob(service_pb2.ResumeJobRequest(id=jobs["paused"].id))
        self.client.until_state(resumed.id, job_pb2.SUCCEEDED)
        for job in self.jobs().values():
            self.sound_events(list(self.client.watch(job.id)))
        done = self.client.job(jobs["done"].id)
        self.assertEqual((list(done.labels), done.last_step.step, done.attempts), (["old"], 12, 1))
        self.assertEqual([finding.code for finding in done.findings], ["bleed_out_at_exit"])
        self.assertTrue(self.client.fetch(done.id))
        anew = self.client.submit(fake_case("steps=40 checkpoint=5"))
        self.client.until_state(anew.id, job_pb2.SUCCEEDED)
        self.assertEqual(curve(self.client.steps(jobs["running"].id)),
                         curve(self.client.steps(anew.id)))

    def test_as_it_was_left(self):
        self.restart()
        self.goes_on()

    def test_without_its_store(self):
        os.remove(os.path.join(self.data, "jobs.sqlite"))
        self.restart()
        self.goes_on()


if __name__ == "__main__":
    main()
