#!/usr/bin/python3
"""Files of cases: what an upload costs the daemon, who may upload, how much, and what stays of it."""
import concurrent.futures
import hashlib
import os
import re
import subprocess
import threading

import grpc

from dccast.v1 import job_pb2, service_pb2, study_pb2
from support import BIN, SANITIZED, ServiceTest, fake_case, main, until


def case_with(*attachments):
    """A request for a case that names one file."""
    case = fake_case("steps=1")
    case.mesh.file = attachments[0].name
    return {"case": case, "attachments": attachments}


class Uploads(ServiceTest):
    settings = {"workers__count": 1, "per_user__maximum_uploads": "2 GB"}

    def uploaded(self):
        return os.listdir(os.path.join(self.folder, "data", "uploads"))

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
        path = os.path.join(self.folder, "data", "jobs", job.id, "attachments", "slab.msh")
        with open(path, "rb") as file:
            self.assertEqual(file.read(), b"mesh")
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        self.assertEqual(self.uploaded(), [])  # cleaned at the start

        # The file itself is gone, and the refusal says what to do.
        error = self.refused(grpc.StatusCode.ABORTED, self.client.submit, **case_with(named))
        self.assertIn("upload it", error.details())
        self.client.upload("slab.msh", b"mesh")
        self.client.submit(**case_with(named))

    def test_what_the_server_has_is_not_sent_again(self):
        content = b"x" * 1_000_000
        named = self.client.upload("slab.msh", content)
        self.assertTrue(self.client.upload_as(named, content).was_there)
        self.assertEqual(len(self.uploaded()), 1)

    def test_what_is_not_as_announced_is_refused_and_removed(self):
        invalid = grpc.StatusCode.INVALID_ARGUMENT
        named = job_pb2.Attachment(name="slab.msh", sha256=hashlib.sha256(b"mesh").hexdigest(),
                                   size_bytes=4)
        for content in (b"mes", b"mashy", b"mash", b""):
            self.refused(invalid, self.client.upload_as, named, content)
        for faulty in (job_pb2.Attachment(name="a"), job_pb2.Attachment(name="a", sha256="A" * 64),
                       job_pb2.Attachment(name="a", sha256=named.sha256, size_bytes=-1)):
            self.refused(invalid, self.client.upload_as, faulty, b"mesh")
        self.refused(invalid, self.client.stub.UploadAttachment, iter([]), timeout=10)
        self.refused(invalid, self.client.stub.UploadAttachment, iter(
            [service_pb2.UploadAttachmentRequest(chunk=b"mesh")]), timeout=10)
        self.refused(invalid, self.client.upload, "slab.msh", b"x" * 300_000, 300_000)
        until(lambda: self.uploaded() == [], 5)

    def test_an_upload_that_is_cancelled_leaves_nothing(self):
        cancelled = threading.Event()

        def endless():
            yield service_pb2.UploadAttachmentRequest(attachment=job_pb2.Attachment(
                name="slab.msh", sha256="0" * 64, size_bytes=50_000_000))
            yield service_pb2.UploadAttachmentRequest(chunk=b"x" * 1000)
            cancelled.wait(30)
        call = self.client.stub.UploadAttachment.future(endless())
        until(lambda: len(self.uploaded()) == 1, 10)
        call.cancel()
        cancelled.set()
        until(lambda: self.uploaded() == [], 10)

    def test_a_study_keeps_the_files_of_its_case(self):
        named = self.client.upload("slab.msh", b"mesh")
        request = study_pb2.CreateStudyRequest(**case_with(named))
        request.sweep.design = study_pb2.SweepPlan.LIST
        request.sweep.axes.add(key="schedule.casting_speed", values=["50 mm/min", "60 mm/min"])
        study = self.client.stub.CreateStudy(request, timeout=20)
        self.daemon.kill_with_workers()
        self.restart()

        def found():
            return self.client.stub.GetStudy(study_pb2.GetStudyRequest(id=study.id), timeout=10)
        until(lambda: found().state == study_pb2.STUDY_SUCCEEDED, 20)
        kept = os.path.join(self.folder, "data", "studies", study.id + ".attachments")
        self.assertEqual(os.listdir(kept), ["slab.msh"])
        self.client.stub.DeleteStudy(study_pb2.DeleteStudyRequest(id=study.id), timeout=10)
        self.assertFalse(os.path.exists(kept))

    def test_the_command_line_uploads_a_file_once(self):
        path = os.path.join(self.folder, "slab.toml")
        with open(os.path.join(self.folder, "slab.msh"), "w", encoding="ascii") as file:
            file.write("mesh")
        with open(path, "w", encoding="utf-8") as file:
            file.write('title = "steps=1"\n[section]\nhalf_width = "0.25 m"\n'
                       'initial_depth = "5 cm"\n[time]\nend = "145 s"\n[mesh]\nfile = "slab.msh"\n'
                       '[[monitor]]\nname = "corner"\nx = "0.25 m"\ny = "0 m"\n')
        for _ in range(2):
            ended = subprocess.run(
                [os.path.join(BIN, "dccast"), "--server", self.daemon.address, "submit", path],
                capture_output=True, text=True, timeout=30, check=False)
            self.assertEqual(ended.returncode, 0, ended.stderr)
            self.client.until_state(ended.stdout.strip(), job_pb2.SUCCEEDED)
        self.assertEqual(len(self.uploaded()), 1)


class Quota(ServiceTest):
    settings = {"workers__count": 1, "per_user__maximum_uploads": "1 MB", "limits__maximum_uploads": "2 MB",
                "retention__upload_lifetime": "2 s"}

    def test_the_refusal_names_the_quota_and_used_files_give_way(self):
        first = self.client.upload("first.msh", b"a" * 600_000)
        error = self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.client.upload, "second.msh",
                             b"b" * 600_000)
        self.assertIn("per_user.maximum_uploads = 1 MB", error.details())
        info, verdict = self.details(error)
        self.assertEqual(info.metadata["limit"], "per_user.maximum_uploads")
        [fault] = verdict.faults
        self.assertEqual(fault.field, "attachments")
        self.assertIn("second.msh", fault.value)
        self.assertIn("per_user.maximum_uploads", fault.permitted)
        self.assertIn("submit", fault.remedy)

        self.client.submit(**case_with(first))
        self.client.upload("second.msh", b"b" * 600_000)  # the job has its own copy of the first

    def test_an_upload_that_stands_still_is_ended(self):
        ended = threading.Event()

        def stalled():
            yield service_pb2.UploadAttachmentRequest(attachment=job_pb2.Attachment(
                name="slab.msh", sha256="0" * 64, size_bytes=500_000))
            yield service_pb2.UploadAttachmentRequest(chunk=b"x" * 1000)
            ended.wait(20)
        error = self.refused(grpc.StatusCode.DEADLINE_EXCEEDED,
                             self.client.stub.UploadAttachment, stalled(), timeout=15)
        ended.set()
        self.assertIn("did not come", error.details())
        until(lambda: os.listdir(os.path.join(self.folder, "data", "uploads")) == [], 5)

    def test_files_that_are_not_used_expire(self):
        self.client.upload("first.msh", b"a" * 600_000)
        until(lambda: os.listdir(os.path.join(self.folder, "data", "uploads")) == [], 10)
        self.client.upload("second.msh", b"b" * 600_000)


class Viewer(ServiceTest):
    settings = {"workers__count": 1, "access__local_role": "viewer"}

    def test_a_viewer_is_refused_before_the_first_chunk(self):
        """As nobody, as root is an admin."""
        os.chmod(self.folder, 0o755)
        code = ("import os, sys; os.setuid(65534); import grpc; from support import Client\n"
                "client = Client(sys.argv[1])\n"
                "try: client.upload('slab.msh', b'x' * 1000000)\n"
                "except grpc.RpcError as error: print(error.code().name, error.details())\n")
        ended = subprocess.run(["/usr/bin/python3", "-c", code, self.daemon.address],
                               capture_output=True, text=True, timeout=30, check=True,
                               cwd=os.path.dirname(os.path.abspath(__file__)))
        self.assertTrue(ended.stdout.startswith("PERMISSION_DENIED"), ended.stdout)
        self.assertIn("viewer", ended.stdout)
        self.assertEqual(os.listdir(os.path.join(self.folder, "data", "uploads")), [])


if __name__ == "__main__":
    main()
