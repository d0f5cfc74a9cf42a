#!/usr/bin/python3
"""Data folders that earlier versions left are gone on with: data/README.md."""
import os
import tarfile

import h5py

from dccast.v1 import job_pb2, service_pb2
from support import ServiceTest, curve, fake_case, main

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "data")
ENDS = {"done": job_pb2.SUCCEEDED, "failed": job_pb2.FAILED, "cancelled": job_pb2.CANCELLED,
        "paused": job_pb2.PAUSED, "running": job_pb2.SUCCEEDED, "waiting": job_pb2.SUCCEEDED}


class Upgrade:
    """@cvar commit  whose daemon left the folder; @cvar ends  what becomes of its jobs, by request id"""
    ends = ENDS

    def setUp(self):
        super().setUp()
        self.daemon.terminate()
        self.daemon.settings["data_directory"] = os.path.join(self.folder, "old", "data")
        with tarfile.open(os.path.join(DATA, f"folder-{self.commit}.tar.xz")) as old:
            old.extractall(os.path.join(self.folder, "old"))
        self.data = self.daemon.settings["data_directory"]

    def jobs(self):
        listed = self.client.stub.ListJobs(service_pb2.ListJobsRequest(), timeout=10).jobs
        return {job.request_id: job for job in listed}

    def goes_on(self):
        jobs = self.jobs()
        self.assertEqual(set(jobs), set(self.ends))
        for name, state in self.ends.items():
            self.client.until_state(jobs[name].id, state)
        resumed = self.client.stub.ResumeJob(service_pb2.ResumeJobRequest(id=jobs["paused"].id))
        self.client.until_state(resumed.id, job_pb2.SUCCEEDED)
        for job in self.jobs().values():
            self.sound_events(list(self.client.watch(job.id)))
        done = self.client.job(jobs["done"].id)
        self.assertEqual((list(done.labels), done.last_step.step, done.attempts), (["old"], 12, 1))
        self.assertEqual([finding.code for finding in done.findings], ["bleed_out_at_exit"])
        self.assertEqual(jobs["failed"].failure.kind, job_pb2.Finding.SOLVE_FAILED)
        self.assertTrue(jobs["failed"].failure.message)
        for step in self.client.steps(done.id):
            self.assertEqual(step.monitors[0].curl_m, step.monitors[0].displacement_m[-1])
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


class FromA60da8e(Upgrade, ServiceTest):
    commit = "a60da8e"


class FromC3e3928a(Upgrade, ServiceTest):
    """The last version whose steps had figures twice, per metre and of the whole."""
    commit = "c3e3928a"
    ends = ENDS | {"real": job_pb2.SUCCEEDED}

    def test_figures_of_steps_are_kept(self):
        self.restart()
        real = self.jobs()["real"]
        steps = self.client.steps(real.id)
        with h5py.File(os.path.join(self.data, "jobs", real.id, "results.h5")) as file:
            for name, unit in (("side_heat", "w"), ("bottom_heat", "w"), ("metal_heat", "w"),
                               ("stored_heat", "w"), ("wall_heat_flux", "w"), ("weight", "n"),
                               ("bottom_reaction", "n"), ("pore_volume", "m3")):
                self.assertEqual([getattr(step.section, name) for step in steps],
                                 list(file[f"history/{name}_{unit}_per_m"]), name)
            relative = file.attrs["relative_curl_error"]
        self.assertGreater(steps[-1].section.side_heat, 0.0)
        self.assertEqual(steps[-1].section.extent, job_pb2.SectionFigures.METRE_OF_FACE)
        corner = steps[-1].monitors[0]
        self.assertAlmostEqual(corner.curl_upper_error_m, relative * abs(corner.curl_m), delta=1e-12)

    def test_what_was_converted_is_left_alone(self):
        self.restart()
        self.daemon.terminate()
        logs = {}
        for job in os.listdir(os.path.join(self.data, "jobs")):
            path = os.path.join(self.data, "jobs", job, "events.log")
            if os.path.exists(path):
                with open(path, "rb") as file:
                    logs[path] = file.read()
        self.restart()
        for path, before in logs.items():
            with open(path, "rb") as file:
                self.assertTrue(file.read().startswith(before), path)


if __name__ == "__main__":
    main()
