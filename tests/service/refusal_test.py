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
from support import BIN, ServiceTest, connected, fake_case, main, work_of
from waiting import until


class Refusal(ServiceTest):
    def tearDown(self):
        self.assertTrue(self.daemon.running())
        job = self.client.submit(fake_case("steps=1"))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        super().tearDown()

    def test_a_text_that_acts_on_a_terminal_does_not_reach_the_log(self):
        text = "\x1b]0;owned\x07"
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit,
                     fake_case(f"steps=1 {text}"))
        sound = fake_case("steps=1")
        for rest in ({"request_id": text}, {"labels": [text]},
                     {"attachments": [self.client.upload(text, b"x")]}):
            self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.submit, sound, **rest)
        self.assertNotIn("\x1b]0;", self.daemon.said())

    def test_a_message_too_large(self):
        self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.client.submit, fake_case("steps=1"),
                     case_file=b"x" * 2_200_000)

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
        checked = self.client.ask("ValidateCase", case=case,
                                  attachments=[self.client.upload("slab.msh", mesh)])
        self.assertTrue(checked.faults)
        broken = b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$bott\xe9m\n"
        checked = self.client.ask("ValidateCase", case=case,
                                  attachments=[self.client.upload("slab.msh", broken)])
        self.assertTrue(checked.faults)

    def test_a_file_that_ends_its_worker_costs_one_answer(self):
        case = fake_case("temperatures")
        case.mesh.growth = False
        case.thermal.file = "temperatures.h5"
        attachment = self.client.upload("temperatures.h5", DAMAGED_HDF5)
        error = self.refused(grpc.StatusCode.INTERNAL, self.client.submit, case,
                             attachments=[attachment])
        self.assertIn("dccast-worker ended with signal 11", error.details())
        self.assertEqual(self.client.ask("ListJobs").jobs[:], [])
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
        with open(self.in_folder("data", "jobs", job.id, "worker.log"),
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
        self.client.ask("GetServerInfo")
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


class OldStore(ServiceTest):
    """A store that was filled, or damaged, by something else than this daemon."""

    def test_a_damaged_page(self):
        job_id = self.client.submit(fake_case("steps=1")).id
        self.client.until_state(job_id, job_pb2.SUCCEEDED)
        self.daemon.terminate()
        with open(self.in_folder("data", "jobs.sqlite"), "r+b") as file:
            content = file.read()
            for page in range(4096, len(content), 4096):
                # "corner", the monitor, stands in the two cases of the job only.
                if b"\x0a\x06corner" in content[page:page + 4096]:
                    file.seek(page)
                    file.write(b"\xff" * 64)
        self.restart()
        self.assertIn("built again from the folders", self.daemon.said())
        answer = self.client.ask("QueryResult", id=job_id)
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

    def test_an_address_of_pages_that_is_none(self):
        for address in ("dccast.plant.example", "http://x.test", "https://x.test/", "https://x.test:0x"):
            ended = self.run_daemon("--set", f"access.web_address={address}")
            self.assertEqual(ended.returncode, 2)
            for text in (f"access.web_address = {address}", "permitted: https://NAME", "write what"):
                self.assertIn(text, ended.stderr)

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
