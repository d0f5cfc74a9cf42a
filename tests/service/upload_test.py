#!/usr/bin/python3
"""Files of cases: what an upload costs the daemon, who may upload, how much, and what stays of it."""
import concurrent.futures
import os
import re

import grpc

from dccast.v1 import job_pb2, study_pb2
from support import SANITIZED, ServiceTest, fake_case, main
from waiting import until


def case_with(*attachments):
    """A request for a case that names one file."""
    case = fake_case("steps=1")
    case.mesh.file = attachments[0].name
    return {"case": case, "attachments": attachments}


class Uploads(ServiceTest):
    settings = {"workers__count": 1, "per_user__maximum_uploads": "2 GB"}

    def uploaded(self):
        return os.listdir(self.in_folder("data", "uploads"))

    def resident(self):
        with open(f"/proc/{self.daemon.process.pid}/status", encoding="ascii") as file:
            return {name: int(kb) * 1024 for name, kb in re.findall(r"(VmHWM|VmRSS):\s+(\d+) kB",
                                                                   file.read())}

    def test_twenty_uploads_at_once_take_little_memory(self):
        before = self.resident()["VmRSS"]
        contents = [bytes([number]) * 60_000_000 for number in range(20)]
        clients = [self.new_client() for _ in contents]
        with concurrent.futures.ThreadPoolExecutor(20) as threads:
            named = list(threads.map(lambda client, content: client.upload("slab.msh", content),
                                     clients, contents))
        if not SANITIZED:  # AddressSanitizer keeps what is freed for a while
            self.assertLess(self.resident()["VmHWM"] - before, 100e6)
        self.assertEqual(len(set(file.sha256 for file in named)), 20)
        self.assertEqual(len(self.uploaded()), 20)

    def test_an_upload_becomes_a_file_of_the_job_and_outlives_a_kill(self):
        named = self.client.upload("slab.msh", b"mesh")
        job = self.client.submit(**case_with(named))
        self.daemon.kill_with_workers()
        self.restart()
        path = self.in_folder("data", "jobs", job.id, "attachments", "slab.msh")
        with open(path, "rb") as file:
            self.assertEqual(file.read(), b"mesh")
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        self.assertEqual(self.uploaded(), [])  # cleaned at the start

        # The file itself is gone, and the refusal says what to do.
        error = self.refused(grpc.StatusCode.ABORTED, self.client.submit, **case_with(named))
        self.assertIn("upload it", error.details())
        self.client.upload("slab.msh", b"mesh")
        self.client.submit(**case_with(named))

    def test_a_file_of_a_job_is_taken_by_another_one(self):
        """As of a case that a page takes from a job: nothing is uploaded again."""
        job = self.client.submit(**case_with(self.client.upload("slab.msh", b"mesh")))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        self.daemon.kill_with_workers()
        self.restart()
        self.assertEqual(self.uploaded(), [])
        taken, = self.client.pages(job.id)[0].attachments
        self.assertEqual((taken.name, taken.size_bytes, taken.job), ("slab.msh", 4, job.id))

        other = self.client.submit(**case_with(taken))
        path = self.in_folder("data", "jobs", other.id, "attachments", "slab.msh")
        with open(path, "rb") as file:
            self.assertEqual(file.read(), b"mesh")
        self.client.until_state(other.id, job_pb2.SUCCEEDED)

        unknown = job_pb2.Attachment(name="slab.msh", sha256=64 * "0", job=job.id)
        self.refused(grpc.StatusCode.ABORTED, self.client.submit, **case_with(unknown))
        self.client.ask("DeleteJob", id=job.id)
        self.refused(grpc.StatusCode.NOT_FOUND, self.client.submit, **case_with(taken))

    def test_a_study_keeps_the_files_of_its_case(self):
        named = self.client.upload("slab.msh", b"mesh")
        request = study_pb2.CreateStudyRequest(**case_with(named))
        request.sweep.design = study_pb2.SweepPlan.LIST
        request.sweep.axes.add(key="schedule.casting_speed", values=["50 mm/min", "60 mm/min"])
        study = self.client.stub.CreateStudy(request, timeout=20)
        self.daemon.kill_with_workers()
        self.restart()

        def found():
            return self.client.ask("GetStudy", id=study.id)
        until(lambda: found().state == study_pb2.STUDY_SUCCEEDED, 20)
        kept = self.in_folder("data", "studies", study.id + ".attachments")
        self.assertEqual(os.listdir(kept), ["slab.msh"])
        self.client.ask("DeleteStudy", id=study.id)
        self.assertFalse(os.path.exists(kept))

    def test_the_command_line_uploads_a_file_once(self):
        path = self.in_folder("slab.toml")
        self.write_file("slab.msh", "mesh")
        with open(path, "w", encoding="utf-8") as file:
            file.write('title = "steps=1"\n[section]\nhalf_width = "0.25 m"\n'
                       'initial_depth = "5 cm"\n[time]\nend = "145 s"\n[mesh]\nfile = "slab.msh"\n'
                       '[[monitor]]\nname = "corner"\nx = "0.25 m"\ny = "0 m"\n')
        for _ in range(2):
            self.client.until_state(self.dccast("submit", path).strip(), job_pb2.SUCCEEDED)
        self.assertEqual(len(self.uploaded()), 1)


if __name__ == "__main__":
    main()
