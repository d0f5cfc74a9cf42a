#!/usr/bin/python3
"""What is not right is refused with a remedy, and the daemon goes on."""
import base64
import os
import re
import signal
import subprocess
import time
import zlib

import grpc

from dccast.v1 import job_pb2, service_pb2
from rows import change_rows
from support import BIN, ServiceTest, connected, fake_case, main, until, work_of


class Refusal(ServiceTest):
    settings = {"limits__maximum_queued": 3, "workers__count": 1,
                "per_case__maximum_attachment": "65536 bytes"}

    def tearDown(self):
        self.assertTrue(self.daemon.running())
        job = self.client.submit(fake_case("steps=1")) if not self.busy else None
        if job:
            self.client.until_state(job.id, job_pb2.SUCCEEDED)
        super().tearDown()

    busy = False  # the queue is full on purpose

    def test_ids_that_are_none(self):
        for job_id in ("", "7", "../../etc", "x" * 1000, "é" * 36,
                       "0F2B9A4E-0000-4000-8000-000000000000"):
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.job, job_id)
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.watch, job_id)
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.cancel, job_id)

    def test_studies_that_are_none(self):
        for study in ("7", "../../etc", "x" * 1000, "0F2B9A4E-0000-4000-8000-000000000000"):
            error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit,
                                 fake_case("steps=1"), study=study)
            self.assertIn("not a study id", error.details())
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.stub.ListJobs,
                         service_pb2.ListJobsRequest(study=study), timeout=10)
        listed = self.client.stub.ListJobs(service_pb2.ListJobsRequest(), timeout=10)
        self.assertEqual(len(listed.jobs), 0)

    def test_an_id_of_elsewhere(self):
        job_id = "0f2b9a4e-0000-4000-8000-000000000000"
        error = self.refused(grpc.StatusCode.NOT_FOUND, self.client.job, job_id)
        self.assertIn("the list of jobs", error.details())
        self.refused(grpc.StatusCode.NOT_FOUND, self.client.watch, job_id)
        self.refused(grpc.StatusCode.NOT_FOUND, self.client.fetch, job_id)
        self.refused(grpc.StatusCode.NOT_FOUND, self.client.steps, job_id)

    def test_a_sequence_beyond_the_log(self):
        job = self.client.submit(fake_case("steps=1"))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        self.refused(grpc.StatusCode.OUT_OF_RANGE, self.client.watch, job.id, 1000)

    def test_a_full_queue(self):
        self.busy = True
        running = self.client.submit(fake_case("steps=100000 sleep_ms=5"))
        self.client.until_step(running.id, 1)
        for _ in range(3):
            self.client.submit(fake_case("steps=1"))
        error = self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.client.submit,
                             fake_case("steps=1"))
        info, _ = self.details(error)
        self.assertEqual((info.reason, info.domain), ("LIMIT_REACHED", "dccast"))
        self.assertEqual(dict(info.metadata), {
            "cause": "the queue is full", "limit": "limits.maximum_queued",
            "permitted": str(self.settings["limits__maximum_queued"]), "remedy": "submit again later"})
        self.assertEqual(error.details(), "{cause}; {limit} = {permitted}; {remedy}".format(**info.metadata))

    def test_a_case_with_faults(self):
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit,
                             fake_case("check=fault"))
        info, verdict = self.details(error)
        self.assertEqual(info.reason, "INVALID_CASE")
        self.assertEqual([fault.field for fault in verdict.faults],
                         ["monitor[0].y", "limits.maximum_steps"])
        checked = self.client.stub.ValidateCase(
            service_pb2.ValidateCaseRequest(case=fake_case("check=fault")), timeout=10)
        self.assertEqual(checked.faults, verdict.faults)

    def test_values_out_of_range_all_at_once(self):
        case = fake_case()
        case.section.half_width_m = float("nan")
        case.mesh.columns = -3
        case.alloy.card = "unobtainium"
        checked = self.client.stub.ValidateCase(service_pb2.ValidateCaseRequest(case=case),
                                                timeout=10)
        fields = [fault.field for fault in checked.faults]
        self.assertIn("section.half_width", fields)
        self.assertIn("mesh.columns", fields)
        self.assertIn("alloy.card", fields)
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case)

    def test_faults_of_values_and_of_the_whole_come_together(self):
        case = fake_case("check=fault")
        case.mechanics.tolerance = 7
        checked = self.client.stub.ValidateCase(service_pb2.ValidateCaseRequest(case=case),
                                                timeout=10)
        self.assertEqual([fault.field for fault in checked.faults],
                         ["mechanics.tolerance", "monitor[0].y", "limits.maximum_steps"])

    def test_an_empty_case(self):
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, None)

    def test_a_check_that_dies(self):
        error = self.refused(grpc.StatusCode.INTERNAL, self.client.submit, fake_case("check=crash"))
        self.assertIn("signal 6", error.details())

    def test_texts_that_act_on_a_terminal_or_a_log(self):
        for text, name in (("\x1b]0;owned\x07", "ESC"), ("a\nb", "line feed"), ("a\0b", "NUL"),
                           ("\u009b31m", "CSI"), ("x\u202egnp", "U+202E"), ("\u2066x", "U+2066")):
            case = fake_case(f"steps=1 {text}")
            error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case)
            self.assertIn(name, error.details())
            case = fake_case("steps=1")
            case.monitor[0].name = text
            error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case)
            self.assertIn("monitor[0].name", error.details())
            case = fake_case("steps=1")
            case.cooling.zone.add(name=text)
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case)
            case = fake_case("steps=1")
            case.alloy.card = text
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case)
            sound = fake_case("steps=1")
            for rest in ({"request_id": text}, {"labels": [text]},
                         {"attachments": [self.client.upload(text, b"x")]},
                         {"changes": [job_pb2.CaseChange(key="title", value=text)]}):
                if "\n" in text and "changes" in rest:
                    continue  # the value of a key may have lines
                error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, sound,
                                     **rest)
                if "attachments" not in rest:  # a name with NUL is no plain name of a file either
                    self.assertIn(name, error.details())
                self.assertNotIn(text, error.details())
        said = self.daemon.said()
        self.assertNotIn("\x1b]0;", said)

    def test_attachments(self):
        case = fake_case("steps=1")
        for name in ("", "..", "a/b", "/etc/passwd", "x" * 300):
            attachment = self.client.upload(name, b"x")
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case,
                         attachments=[attachment])
        checked = self.client.stub.ValidateCase(service_pb2.ValidateCaseRequest(
            case=fake_case("check=fault"), attachments=[self.client.upload("a/b", b"")]),
            timeout=10)
        self.assertEqual([fault.field for fault in checked.faults], ["attachments"])
        self.assertEqual([fault.field for fault in checked.warnings if "wait" in fault.message],
                         ["attachments"])

        twice = [self.client.upload("a", b"x")] * 2
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case, attachments=twice)
        case.mesh.file = "slab.msh"
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case)
        self.assertIn("attachments", error.details())

        job = self.client.submit(case, attachments=[self.client.upload("slab.msh", b"mesh")])
        path = os.path.join(self.folder, "data", "jobs", job.id, "attachments", "slab.msh")
        with open(path, "rb") as file:
            self.assertEqual(file.read(), b"mesh")
        self.assertEqual(os.listdir(os.path.join(self.folder, "data", "check")), [])

    def test_a_message_too_large(self):
        self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.client.submit, fake_case("steps=1"),
                     case_file=b"x" * 2_200_000)

    def test_an_attachment_too_large(self):
        error = self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.client.upload, "slab.msh",
                             b"x" * 100000)
        self.assertIn("per_case.maximum_attachment", error.details())

    def test_garbage_on_the_socket(self):
        for garbage in (b"", b"GET / HTTP/1.1\r\n\r\n", os.urandom(5000),
                        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + os.urandom(2000)):
            with connected(self.daemon.address) as connection:
                connection.sendall(garbage)

    def test_a_broken_message(self):
        for method in ("SubmitJob", "GetJob", "WatchJob"):
            call = self.client.channel.unary_unary(
                f"/dccast.v1.SimulationService/{method}", request_serializer=lambda b: b,
                response_deserializer=lambda b: b)
            error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, call,
                                 b"\xff\xff\xff\x07nonsense", timeout=10)
            self.assertIn("cannot be read", error.details())


# Prescribed temperatures in which an address is damaged: HDF5 1.10 ends its process on it.
DAMAGED_HDF5 = zlib.decompress(base64.b64decode(
    "eNrr9HBx4+WS4mIAAQ4OBhYGAQZk8B8KEjhQ+TD5BCjNCKWhyhhWMMHEGcFyElBxQaj5MHNg6kKCXF1Bqv+j"
    "AZg9Biyo5g8cEKBEsyjDKCALeLg6BoDoCChfAUqfYEJVV5KZmxpfDKRTcwtSixJLSotS45OR0qcBifYyMrBC"
    "9DLC+JCUbM8IEWCGqkPQEmClggr2DB/AqdeBwYSbweQ/VAErMAWD5JmYmBgh6RliHjMjLGlLoLmgY1DFQ7Cf"
    "vwsjAxM8F1Sw4lcPy68KzKNpGH+60oDQTLjSFe50BgljYtOZBDRKPNBcVDEaKSMeqDhAaDsH7OImaPIuUNoT"
    "SvtB6IZAKD/EAQApP0iL"))


class RealWorker(ServiceTest):
    """Faults of the machine and of files that only the real worker reads."""
    worker = "dccast-worker"

    def test_a_compressed_message_is_not_unpacked(self):
        """400 KB that stand for 400 MB: a daemon that unpacks them has to hold them."""
        def largest_memory():
            with open(f"/proc/{self.daemon.process.pid}/status", encoding="ascii") as file:
                return int(re.search(r"VmHWM:\s+(\d+) kB", file.read())[1]) * 1024
        before = largest_memory()
        for compression in (grpc.Compression.Gzip, grpc.Compression.Deflate):
            for method in ("GetJob", "SubmitJob"):
                call = self.client.channel.unary_unary(
                    f"/dccast.v1.SimulationService/{method}", request_serializer=lambda b: b,
                    response_deserializer=lambda b: b)
                error = self.refused(grpc.StatusCode.UNIMPLEMENTED, call, bytes(400_000_000),
                                     compression=compression, timeout=60)
                self.assertIn("ompression", error.details())
        self.assertLess(largest_memory() - before, 100e6)

        self.client.submit(fake_case("steps=1"))

    def test_a_mesh_with_a_text_that_is_no_utf8(self):
        case = fake_case("mesh")
        case.mesh.file = "slab.msh"
        mesh = ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n1 1 \"bott\u00e9m\"\n"
                "$EndPhysicalNames\n").encode("latin-1")
        checked = self.client.stub.ValidateCase(service_pb2.ValidateCaseRequest(
            case=case, attachments=[self.client.upload("slab.msh", mesh)]), timeout=10)
        self.assertTrue(checked.faults)
        broken = b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$bott\xe9m\n"
        checked = self.client.stub.ValidateCase(service_pb2.ValidateCaseRequest(
            case=case, attachments=[self.client.upload("slab.msh", broken)]), timeout=10)
        self.assertTrue(checked.faults)

    def test_a_file_that_ends_its_worker_costs_one_answer(self):
        case = fake_case("temperatures")
        case.mesh.growth = False
        case.thermal.file = "temperatures.h5"
        attachment = self.client.upload("temperatures.h5", DAMAGED_HDF5)
        error = self.refused(grpc.StatusCode.INTERNAL, self.client.submit, case,
                             attachments=[attachment])
        self.assertIn("dccast-worker ended with signal 11", error.details())
        self.assertEqual(self.client.stub.ListJobs(service_pb2.ListJobsRequest(), timeout=10).jobs[:], [])
        self.client.submit(fake_case("steps=1"))


class LittleMemory(ServiceTest):
    """A worker whose memory is bounded: the job fails and says what it lacks."""
    worker = "dccast-worker"
    settings = {"workers__count": 1, "workers__memory": "250 MB"}

    def test_a_run_that_gets_no_more_memory_fails_with_words_about_memory(self):
        case = fake_case("large")
        case.mesh.columns, case.mesh.rows = 300, 300
        job = self.client.submit(case)
        ended = self.client.until_state(job.id, job_pb2.FAILED, seconds=60)
        with open(os.path.join(self.folder, "data", "jobs", job.id, "worker.log"),
                  encoding="utf-8") as file:
            self.assertEqual(ended.failure.kind, job_pb2.Finding.OUT_OF_MEMORY, file.read())
        self.assertIn("memory", ended.failure.message)
        self.assertEqual(ended.attempts, 1)


class Checks(ServiceTest):
    """What one check costs the others."""
    settings = {"checks__workers": 1, "queries__workers": 1, "checks__maximum_waiting": 2,
                "checks__timeout": "20 s"}

    def validate(self, title):
        return self.client.stub.ValidateCase.future(
            service_pb2.ValidateCaseRequest(case=fake_case(title)), timeout=30)

    def checking(self):
        return [process for process in self.daemon.children()
                if work_of(process) == "dccast-check"]

    def test_workers_that_check_are_kept(self):
        """One for checks, one for queries, one for the next job."""
        until(lambda: len(self.daemon.answering_processes()) == 3, 10)
        before = self.daemon.answering_processes()
        for i in range(5):
            self.validate(f"steps=1 number={i}").result()
        self.assertEqual(self.daemon.answering_processes(), before)

    def test_a_worker_that_is_killed_costs_one_answer_that_can_be_asked_again(self):
        check = self.validate("check_ms=15000")
        until(lambda: self.checking(), 10)
        os.kill(self.checking()[0], signal.SIGKILL)
        error = self.refused(grpc.StatusCode.UNAVAILABLE, check.result)
        self.assertIn("try again", error.details())
        self.client.submit(fake_case("steps=1"))

    def test_more_checks_than_may_wait(self):
        checks = [self.validate("check_ms=1500") for _ in range(6)]
        begin = time.monotonic()
        self.client.stub.GetServerInfo(service_pb2.GetServerInfoRequest(), timeout=5)
        self.assertLess(time.monotonic() - begin, 1.0)
        errors = [check.exception() for check in checks]
        refused = [error for error in errors if error is not None]
        self.assertIn(len(refused), (3, 4))  # the first may not have been begun when others came
        for error in refused:
            self.assertEqual(error.code(), grpc.StatusCode.RESOURCE_EXHAUSTED)
            self.assertIn("try again", error.details())

    def test_a_case_that_was_validated_is_not_checked_again(self):
        self.validate("check_ms=3000 steps=1").result()
        begin = time.monotonic()
        self.client.submit(fake_case("check_ms=3000 steps=1"))
        self.assertLess(time.monotonic() - begin, 2.5)

    def test_a_check_nobody_waits_for_is_stopped(self):
        check = self.validate("check_ms=15000")
        until(self.checking, 10)
        check.cancel()
        begin = time.monotonic()
        self.client.submit(fake_case("steps=1"))  # there is one checker: it is free again
        self.assertLess(time.monotonic() - begin, 5)

    def test_a_check_that_was_cancelled_before_its_turn_is_not_begun(self):
        first = self.validate("check_ms=2000")
        until(self.checking, 10)
        begin = time.monotonic()
        self.validate("check_ms=15000").cancel()
        self.client.submit(fake_case("steps=1"))
        self.assertLess(time.monotonic() - begin, 8)
        self.assertEqual(len(first.result().faults), 0)


class SlowChecks(ServiceTest):
    settings = {"checks__timeout": "0.3 s"}

    def test_a_check_beyond_its_time(self):
        error = self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.client.submit,
                             fake_case("check_ms=15000"))
        self.assertIn("checks.timeout", error.details())
        self.assertIn("try again", error.details())


class Ceilings(ServiceTest):
    settings = {"per_case__maximum_nodes": 1000, "per_case__maximum_steps": 50,
                "per_case__maximum_memory": "1 MB"}

    def test_a_case_may_not_permit_itself_more_than_the_daemon_does(self):
        case = fake_case("steps=51 nodes=1001 memory=1100000")
        case.limits.maximum_nodes = 10000000
        case.limits.maximum_steps = 100000000
        checked = self.client.stub.ValidateCase(service_pb2.ValidateCaseRequest(case=case),
                                                timeout=10)

        self.assertEqual([fault.field for fault in checked.faults], ["mesh", "time", "mesh"])
        self.assertEqual([fault.permitted for fault in checked.faults],
                         ["at most 1000", "at most 50", "at most 0.001 GB"])
        for fault in checked.faults:
            self.assertTrue(fault.value and fault.remedy)
        self.assertFalse(checked.HasField("estimate"))

        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, case)
        self.client.submit(fake_case("steps=50 nodes=1000 memory=1000000"))
        info = self.client.stub.GetServerInfo(service_pb2.GetServerInfoRequest(), timeout=10)
        self.assertEqual((info.maximum_nodes, info.maximum_steps, info.maximum_memory_bytes),
                         (1000, 50, 1e6))


class OldStore(ServiceTest):
    """A store that was filled, or damaged, by something else than this daemon."""

    def store(self):
        return os.path.join(self.folder, "data", "jobs.sqlite")

    def change(self, **values):
        """Below the running daemon."""
        change_rows(self.store(), lambda job: job.MergeFrom(job_pb2.Job(**values)))

    def ended_jobs(self, number):
        ids = [self.client.submit(fake_case(f"steps=1 number={i}")).id for i in range(number)]
        for job_id in ids:
            self.client.until_state(job_id, job_pb2.SUCCEEDED)
        return ids

    def test_a_list_of_large_titles(self):
        ids = self.ended_jobs(5)
        self.change(title="é" * 2500000)
        listed = self.client.stub.ListJobs(service_pb2.ListJobsRequest(), timeout=10)
        self.assertEqual({job.id for job in listed.jobs}, set(ids))
        self.assertLess(listed.ByteSize(), 2**20)

    def test_a_list_is_cut_by_bytes(self):
        ids = self.ended_jobs(30)
        failure = job_pb2.Finding(message="x" * 1000000, residual_history=[1.0] * 100000)
        self.change(failure=failure, state=job_pb2.FAILED)
        seen, token = [], ""
        while True:
            page = self.client.stub.ListJobs(
                service_pb2.ListJobsRequest(page_token=token), timeout=10)
            self.assertLess(page.ByteSize(), 1.1 * 2**20)
            seen += [job.id for job in page.jobs]
            token = page.next_page_token
            if not token:
                break
        self.assertEqual(sorted(seen), sorted(ids))

    def test_a_damaged_page(self):
        job_id, = self.ended_jobs(1)
        self.daemon.terminate()
        with open(self.store(), "r+b") as file:
            content = file.read()
            for page in range(4096, len(content), 4096):
                # "corner", the monitor, stands in the two cases of the job only.
                if b"\x0a\x06corner" in content[page:page + 4096]:
                    file.seek(page)
                    file.write(b"\xff" * 64)
        self.restart()
        self.assertIn("built again from the folders", self.daemon.said())
        answer = self.client.stub.QueryResult(service_pb2.QueryResultRequest(id=job_id), timeout=10)
        self.assertEqual(answer.case.monitor[0].name, "corner")


class CommandLine(ServiceTest):
    def run_daemon(self, *words):
        return subprocess.run([os.path.join(BIN, "dccastd"), *words], capture_output=True, text=True,
                              timeout=20, check=False, cwd=self.folder)

    def test_a_port_for_local_users_is_refused_with_the_remedy(self):
        for address in ("0.0.0.0:0", "127.0.0.1:7117"):
            ended = self.run_daemon("--set", f"listen.socket={address}", "--set", "data_directory=other")
            self.assertEqual(ended.returncode, 2)
            for text in (f"listen.socket = {address}", "unix:PATH", "listen.tls", "TLS and a token"):
                self.assertIn(text, ended.stderr)

    def test_a_path_that_is_too_long(self):
        ended = self.run_daemon("--set", "listen.socket=unix:/tmp/" + "x" * 103, "--set",
                                "data_directory=other", "--set",
                                f"workers.program={self.daemon.settings['workers__program']}")
        self.assertEqual(ended.returncode, 4)
        self.assertIn("1 to 107 bytes", ended.stderr)

    def test_an_address_in_use(self):
        ended = self.run_daemon("--set", f"listen.socket={self.daemon.address}", "--set",
                                "data_directory=other", "--set",
                                f"workers.program={self.daemon.settings['workers__program']}")
        self.assertEqual(ended.returncode, 4)
        self.assertIn("cannot listen on " + self.daemon.address, ended.stderr)
        self.assertIn("in use", ended.stderr)
        self.assertEqual(len(ended.stderr.splitlines()), 1, ended.stderr)

    def test_a_port_that_is_none(self):
        for port in ("65536", "99999", "-1", "", "7117x"):
            ended = self.run_daemon("--set", f"listen.tls=127.0.0.1:{port}")
            self.assertEqual(ended.returncode, 2)
            self.assertIn(f"listen.tls = 127.0.0.1:{port}", ended.stderr)
            self.assertIn("0 to 65535", ended.stderr)

    def test_settings_with_faults(self):
        ended = self.run_daemon("--set", "workers.count=-1", "--set", "wrokers=2")
        self.assertEqual(ended.returncode, 2)
        self.assertIn("workers.count = -1: out of range; permitted: 0 to 4096", ended.stderr)
        self.assertIn("wrokers = 2: unknown key; did you mean 'workers'?", ended.stderr)
        self.assertEqual(self.run_daemon("--nonsense").returncode, 2)
        self.assertEqual(self.run_daemon("--help").returncode, 0)
        self.assertIn("dccastd 1.", self.run_daemon("--version").stdout)


if __name__ == "__main__":
    main()
