"""Users of other machines: lines, tokens, roles, owners, TLS, certificates, limits, the audit log."""
import json
import os
import pwd
import re
import socket
import stat
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import grpc

from dccast.v1 import access_pb2, job_pb2, service_pb2, service_pb2_grpc, study_pb2
from certificates import TestCa
from support import BIN, Client, Daemon, ServiceTest, connected, fake_case as fake, setting_options
from waiting import until

NOBODY = 65534


class Remote(Client):
    """A client over TLS as python3-grpc makes one: with a token, a certificate, or neither."""

    def __init__(self, daemon, token="", certificate=None):
        own = os.path.join(daemon.settings["data_directory"], "pki", "ca.pem")
        with open(daemon.settings.get("tls__ca", own), "rb") as file:
            ca = file.read()
        key, chain = certificate or (None, None)
        credentials = grpc.ssl_channel_credentials(ca, key, chain)
        if token:
            credentials = grpc.composite_channel_credentials(
                credentials, grpc.access_token_call_credentials(token))
        self.channel = grpc.secure_channel(daemon.tls_address, credentials,
                                           [("grpc.enable_http_proxy", 0)])
        self.stub = service_pb2_grpc.SimulationServiceStub(self.channel)

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.channel.close()


class AccessTest(ServiceTest):
    """A daemon that listens over TLS, too."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="dccast-service-")
        self.daemon = Daemon(self.folder)
        self.clients = []

    def start(self, **settings):
        settings.setdefault("listen__tls", "127.0.0.2:0")
        settings.setdefault("listen__public_address", "127.0.0.2:7118")
        self.daemon = Daemon(self.folder, **settings).start()
        return self.daemon

    def admin(self, *words, code=0):
        command = [os.path.join(BIN, "dccastd"), *words, *setting_options(self.daemon.settings)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def secret_of(self, text):
        return re.search(r"dccast-enrol-\w+-\w+", text)[0]

    def token_of(self, name, role="submitter"):
        secret = self.secret_of(self.admin("user", "add", name, "--role", role))
        with Remote(self.daemon) as client:
            return client.ask("Enrol", secret=secret, machine="desk").token

    def remote(self, token="", certificate=None):
        client = Remote(self.daemon, token, certificate)
        self.addCleanup(client.channel.close)
        return client.stub

    def local(self):
        channel = grpc.insecure_channel(self.daemon.address, [("grpc.enable_http_proxy", 0)])
        self.addCleanup(channel.close)
        return service_pb2_grpc.SimulationServiceStub(channel)

    def refusal(self, code, call, request):
        return self.refused(code, call, request, timeout=10).details()

    def submit(self, stub, words="steps=3"):
        return stub.SubmitJob(service_pb2.SubmitJobRequest(case=fake(words)), timeout=20)

    def audit(self, *filters):
        return [json.loads(line) for line in self.admin("audit", *filters).splitlines()
                if line.startswith("{")]


class StudiesOfOthers(AccessTest):
    """A study holds jobs of its owner alone."""
    ID = "0f2b9a4e-0000-4000-8000-00000000000a"

    def study_of(self, stub, case="steps=3", request_id=ID):
        plan = study_pb2.SweepPlan(design=study_pb2.SweepPlan.GRID)
        plan.axes.add(key="time.end", values=["100 s", "101 s"])
        return stub.CreateStudy(study_pb2.CreateStudyRequest(
            request_id=request_id, case=fake(case), sweep=plan), timeout=20)

    def submit_into(self, stub, words):
        return stub.SubmitJob(service_pb2.SubmitJobRequest(case=fake(words), study=self.ID),
                              timeout=20).id

    def until_study_ended(self, stub):
        until(lambda: stub.GetStudy(study_pb2.GetStudyRequest(id=self.ID), timeout=10).state !=
              study_pb2.STUDY_RUNNING, 30)

    def paused(self, stub, job):
        stub.PauseJob(service_pb2.PauseJobRequest(id=job), timeout=10)
        until(lambda: self.state(stub, job) == job_pb2.PAUSED, 20)

    def state(self, stub, job):
        return stub.GetJob(service_pb2.GetJobRequest(id=job), timeout=10).state

    def test_a_job_that_was_there_before_is_no_part_of_the_study(self):
        self.start()
        anna, bert = (self.remote(self.token_of(name)) for name in ("anna", "bert"))
        foreign = self.submit_into(bert, "steps=20000 sleep_ms=5")
        until(lambda: self.state(bert, foreign) == job_pb2.RUNNING, 20)
        self.study_of(anna)
        self.until_study_ended(anna)
        anna.CancelStudy(study_pb2.CancelStudyRequest(id=self.ID), timeout=10)
        self.assertEqual(self.state(bert, foreign), job_pb2.RUNNING)
        self.paused(bert, foreign)
        anna.DeleteStudy(study_pb2.DeleteStudyRequest(id=self.ID), timeout=10)
        self.assertEqual(self.state(bert, foreign), job_pb2.PAUSED)
        left = bert.ListJobs(service_pb2.ListJobsRequest(study=self.ID), timeout=10).jobs
        self.assertEqual([job.id for job in left], [foreign])

    def test_what_has_not_ended_of_an_ended_study_is_named_and_can_be_cancelled(self):
        self.start()
        anna = self.remote(self.token_of("anna"))
        self.study_of(anna)
        beside = self.submit_into(anna, "steps=20000 sleep_ms=5")
        self.until_study_ended(anna)
        self.paused(anna, beside)
        delete = study_pb2.DeleteStudyRequest(id=self.ID)
        details = self.refusal(grpc.StatusCode.FAILED_PRECONDITION, anna.DeleteStudy, delete)

        self.assertIn(beside, details)
        self.assertIn("cancel it first", details)

        anna.CancelStudy(study_pb2.CancelStudyRequest(id=self.ID), timeout=10)
        until(lambda: self.state(anna, beside) == job_pb2.CANCELLED, 20)
        anna.DeleteStudy(delete, timeout=10)
        self.refusal(grpc.StatusCode.NOT_FOUND, anna.GetJob, service_pb2.GetJobRequest(id=beside))


class Tokens(AccessTest):
    def test_a_line_buys_one_token_and_the_token_makes_the_owner(self):
        self.start()
        secret = self.secret_of(self.admin("user", "add", "anna", "--role", "submitter"))
        enrol = service_pb2.EnrolRequest(secret=secret, machine="desk")
        answer = self.remote().Enrol(enrol, timeout=10)
        self.assertEqual(answer.user.name, "anna")
        self.assertEqual(answer.user.role, access_pb2.SUBMITTER)
        self.refusal(grpc.StatusCode.UNAUTHENTICATED, self.remote().Enrol, enrol)
        anna = self.remote(answer.token)
        self.assertEqual(anna.WhoAmI(service_pb2.WhoAmIRequest(), timeout=10).proof, "token")
        self.assertEqual(self.submit(anna).owner, "anna")
        self.assertIn("desk", self.admin("user", "list"))

    def test_the_list_of_processes_does_not_show_the_line_of_a_login(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            line = f"127.0.0.1:{silent.getsockname()[1]}/sha256:{'0' * 64}/dccast-enrol-anna-secret"
            login = subprocess.Popen([os.path.join(BIN, "dccast"), "login", line],
                                     stderr=subprocess.DEVNULL,
                                     env={**os.environ, "HOME": self.folder})
            try:
                silent.settimeout(20)
                silent.accept()[0].close()
                with open(f"/proc/{login.pid}/cmdline", "rb") as file:
                    words = file.read().split(b"\0")
            finally:
                login.kill()
                login.wait()
        self.assertEqual(words[1:3], [b"login", b"*" * len(line)])

    def test_no_one_borrows_the_connection_of_another(self):
        self.start()
        local = self.local()
        name = local.WhoAmI(service_pb2.WhoAmIRequest(), timeout=10).name
        forged = [("dccast-connection", str(number)) for number in range(1, 6)]
        stranger = self.remote()
        self.refused(grpc.StatusCode.UNAUTHENTICATED, stranger.WhoAmI, service_pb2.WhoAmIRequest(),
                     timeout=10, metadata=forged)
        token = self.token_of("anna")
        anna = self.remote(token).WhoAmI(service_pb2.WhoAmIRequest(), timeout=10, metadata=forged)
        self.assertEqual((anna.name, anna.proof), ("anna", "token"))
        again = local.WhoAmI(service_pb2.WhoAmIRequest(), timeout=10, metadata=forged)
        self.assertEqual((again.name, again.proof), (name, "local user"))

    def test_what_a_command_changes_holds_at_once(self):
        self.start()
        token = self.token_of("anna")
        anna = self.remote(token)
        self.submit(anna)
        self.admin("user", "role", "anna", "viewer")
        details = self.refusal(grpc.StatusCode.PERMISSION_DENIED, anna.SubmitJob,
                               service_pb2.SubmitJobRequest(case=fake("steps=3")))
        for part in ("anna has the role viewer", "SubmitJob needs submitter", "root"):
            self.assertIn(part, details)

        self.admin("user", "disable", "anna")
        self.assertIn("disabled", self.refusal(grpc.StatusCode.UNAUTHENTICATED, anna.ListJobs,
                                               service_pb2.ListJobsRequest()))

        self.admin("user", "enable", "anna")
        anna.ListJobs(service_pb2.ListJobsRequest(), timeout=10)
        self.admin("user", "rotate", "anna")
        self.refusal(grpc.StatusCode.UNAUTHENTICATED, anna.ListJobs, service_pb2.ListJobsRequest())

    def test_a_token_expires(self):
        self.start(access__token_lifetime="2 s")
        anna = self.remote(self.token_of("anna"))
        anna.ListJobs(service_pb2.ListJobsRequest(), timeout=10)
        until(lambda: self.is_refused(anna), 10)
        self.assertIn("expired", self.refusal(grpc.StatusCode.UNAUTHENTICATED, anna.ListJobs,
                                              service_pb2.ListJobsRequest()))

    def is_refused(self, stub):
        try:
            stub.ListJobs(service_pb2.ListJobsRequest(), timeout=10)
        except grpc.RpcError as error:
            return error.code() == grpc.StatusCode.UNAUTHENTICATED
        return False

class Lapses(AccessTest):
    """A watch ends when its caller is one no longer; the job goes on."""

    def watch(self, stub, job):
        ended = {}

        def follow():
            try:
                for event in stub.WatchJob(service_pb2.WatchJobRequest(id=job.id), timeout=60):
                    ended.setdefault("events", []).append(event)
            except grpc.RpcError as error:
                ended["code"], ended["details"] = error.code(), error.details()

        thread = threading.Thread(target=follow)
        thread.start()
        self.addCleanup(thread.join)
        until(lambda: ended.get("events"), 20)
        return ended

    def lapses(self, ended, job):
        until(lambda: "code" in ended, 15)
        self.assertEqual(ended["code"], grpc.StatusCode.UNAUTHENTICATED)
        found = self.local().GetJob(service_pb2.GetJobRequest(id=job.id), timeout=10)
        self.assertEqual(found.state, job_pb2.RUNNING)
        self.local().CancelJob(service_pb2.CancelJobRequest(id=job.id), timeout=10)
        return ended["details"]

    def test_a_revoked_token_ends_its_watch(self):
        self.start()
        anna, bert = self.remote(self.token_of("anna")), self.remote(self.token_of("bert"))
        job = self.submit(anna, "steps=100000 sleep_ms=20")
        of_anna, of_bert = self.watch(anna, job), self.watch(bert, job)
        self.admin("user", "rotate", "anna")
        self.assertIn("revoked", self.lapses(of_anna, job))
        until(lambda: of_bert["events"][-1].HasField("state_change") or "code" in of_bert, 20)
        self.assertNotEqual(of_bert.get("code"), grpc.StatusCode.UNAUTHENTICATED)

    def test_a_token_that_expires_ends_its_watch(self):
        self.start(access__token_lifetime="4 s")
        anna = self.remote(self.token_of("anna"))
        job = self.submit(anna, "steps=100000 sleep_ms=20")
        self.assertIn("expired", self.lapses(self.watch(anna, job), job))

    def test_a_removed_user_stops_a_query(self):
        self.start()
        anna = self.remote(self.token_of("anna"))
        call = anna.QueryButtCurl(
            service_pb2.QueryButtCurlRequest(case=fake("steps=100000 sleep_ms=20")), timeout=60)
        next(call)
        self.admin("user", "remove", "anna")
        with self.assertRaises(grpc.RpcError) as caught:
            list(call)
        self.assertEqual(caught.exception.code(), grpc.StatusCode.UNAUTHENTICATED)


class Owners(AccessTest):

    @unittest.skipUnless(os.geteuid() == 0, "takes another user's id")
    def test_another_local_user_does_not_delete_roots_job(self):
        os.chmod(self.folder, 0o755)
        self.start()
        job = self.submit(self.local())
        until(lambda: self.local().GetJob(service_pb2.GetJobRequest(id=job.id),
                                          timeout=10).HasField("end_time"), 20)
        done = subprocess.run(self.client_command("delete", job.id), capture_output=True, text=True,
                              timeout=30, check=False, user=NOBODY, env={"HOME": "/nonexistent"})
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertIn("of root", done.stderr)
        self.local().DeleteJob(service_pb2.DeleteJobRequest(id=job.id), timeout=10)


class Commands(AccessTest):
    """What an IT department types before and beside the daemon."""

    def test_what_reads_creates_nothing_and_names_the_folder(self):
        data = self.in_folder("absent")
        for words in (["user", "list"], ["pki", "show"], ["audit"], ["check"]):
            done = subprocess.run([os.path.join(BIN, "dccastd"), *words, "--set",
                                   f"data_directory={data}"],
                                  capture_output=True, text=True, timeout=30, check=False)
            self.assertNotEqual(done.returncode, 0, words)
            self.assertIn(data, done.stderr, words)
            self.assertFalse(os.path.exists(data), words)
        self.start()
        self.assertIn("data directory " + self.daemon.settings["data_directory"],
                      self.admin("user", "list"))

    def test_audit_since_takes_the_times_of_list(self):
        self.start()
        self.token_of("anna")
        for since in ("today", "3 h", "2020-01-01", "2020-01-01T08"):
            self.assertGreater(len(self.audit("--since", since)), 0, since)
        self.assertEqual(self.audit("--since", "2099-01-01"), [])
        self.assertIn("no time", self.admin("audit", "--since", "banana", code=2))

    def test_the_audit_log_can_be_moved_while_dccastd_runs(self):
        self.start()
        self.token_of("anna")
        log = os.path.join(self.daemon.settings["data_directory"], "audit.log")
        os.rename(log, log + ".1")
        self.remote(self.token_of("bert"))
        self.assertEqual([event["call"] for event in self.audit()], ["dccastd user add", "Enrol"])

    def test_check_config_prints_all_faults(self):
        self.start()
        self.assertIn("no faults", self.admin("check-config"))
        settings = self.write_file("wrong.toml", 'worker.count = 4\njob_end_hook = "/nowhere"\n'
                                   '[listen]\ntls = "casthouse"\n'
                                   '[slurm]\noptions = "--clusters=big"\n[workers]\ncount = -3\n')
        done = subprocess.run([os.path.join(BIN, "dccastd"), "check-config", "--config", settings],
                              capture_output=True, text=True, timeout=30, check=False)
        self.assertEqual(done.returncode, 2)
        for word in ("worker", "job_end_hook", "listen.tls", "--clusters", "workers.count"):
            self.assertIn(word, done.stderr)
        done = subprocess.run([os.path.join(BIN, "dccastd"), "check-config", "--set",
                               "workers.program=/nowhere", "--set", "alloy_directory=/nowhere/else"],
                              capture_output=True, text=True, timeout=30, check=False)
        self.assertEqual((done.returncode, done.stderr.count("nowhere")), (2, 2), done.stderr)

    def test_a_token_that_ends_soon_is_said_and_renewed(self):
        self.start(access__token_lifetime="10 days", listen__metrics="127.0.0.1:0")
        home = self.in_folder("home")

        def dccast(*words, given=""):
            return subprocess.run([os.path.join(BIN, "dccast"), *words], input=given, text=True,
                                  capture_output=True, timeout=30, check=True,
                                  env={"XDG_CONFIG_HOME": home, "PATH": os.environ["PATH"]}).stderr

        line = re.search(r"dccast login (\S+)", self.admin("user", "add", "anna"))[1]
        dccast("login", self.daemon.tls_address, line, "--name", "north")
        self.assertIn("your token for north ends on", dccast("--server", "north", "whoami"))
        before = re.findall(r"token (\w+) on", self.admin("user", "list"))
        self.assertIn("is good until", dccast("login", "--renew", "--server", "north"))
        after = re.findall(r"token (\w+) on", self.admin("user", "list"))
        self.assertEqual((len(before), len(after)), (1, 1))
        self.assertNotEqual(before, after)
        dccast("--server", "north", "whoami")
        self.daemon.terminate()
        self.start(listen__metrics="127.0.0.1:0")
        self.assertRegex(self.daemon.said(), rf"the token {after[0]} of anna on .* ends in (9|10) days")

    def test_a_line_for_a_further_token_revokes_nothing(self):
        self.start()
        first = self.token_of("anna")
        secret = self.secret_of(self.admin("user", "line", "anna", "--for", "night script"))
        second = self.remote().Enrol(service_pb2.EnrolRequest(secret=secret, machine="desk"),
                                     timeout=10).token
        for token in (first, second):
            self.remote(token).WhoAmI(service_pb2.WhoAmIRequest(), timeout=10)
        token, = re.findall(r"token (\w+) on night script", self.admin("user", "list"))
        self.admin("user", "revoke", "anna", token)
        self.remote(first).WhoAmI(service_pb2.WhoAmIRequest(), timeout=10)
        self.refusal(grpc.StatusCode.UNAUTHENTICATED, self.remote(second).WhoAmI,
                     service_pb2.WhoAmIRequest())


class WrongCertificates(AccessTest):
    def test_one_of_another_ca_or_name_is_said_at_the_start(self):
        folders = [tempfile.mkdtemp(dir=self.folder) for _ in range(2)]
        own, other = TestCa(folders[0]), TestCa(folders[1])
        certificate = own.issue(name="DNS:casthouse")
        self.start(tls__certificate=certificate, tls__key=own.key, tls__ca=other.certificate)
        said = self.daemon.said()
        self.assertIn(f"{certificate} is not signed by the CA {other.certificate}", said)
        self.assertIn("is not for 127.0.0.2, by which clients call, but for casthouse", said)
        self.assertIn("not signed", self.admin("check-config", code=2))


class Certificates(AccessTest):
    def test_a_client_certificate_stands_for_a_token(self):
        self.start()
        self.admin("user", "add", "anna", "--role", "viewer")
        self.daemon.terminate()
        self.daemon.end_workers()
        ca = os.path.join(self.daemon.settings["data_directory"], "pki", "ca.pem")
        self.start(tls__client_ca=ca)
        self.admin("pki", "issue", "anna", "--to", self.folder)
        self.admin("pki", "issue", "carl", "--to", self.folder)
        anna = self.remote(certificate=self.pair("anna"))
        who = anna.WhoAmI(service_pb2.WhoAmIRequest(), timeout=10)

        self.assertEqual((who.name, who.proof), ("anna", "certificate"))
        self.assertIn("not listed", self.refusal(
            grpc.StatusCode.UNAUTHENTICATED, self.remote(certificate=self.pair("carl")).WhoAmI,
            service_pb2.WhoAmIRequest()))

        self.refusal(grpc.StatusCode.UNAUTHENTICATED, self.remote().WhoAmI,
                     service_pb2.WhoAmIRequest())

    def pair(self, name):
        def read(ending):
            with open(self.in_folder(name + ending), "rb") as file:
                return file.read()
        return read(".key"), read(".pem")

    def fingerprint(self):
        shown = subprocess.run(
            f"openssl s_client -connect {self.daemon.tls_address} -alpn h2 </dev/null 2>/dev/null |"
            " openssl x509 -noout -fingerprint -sha256", shell=True, capture_output=True, text=True,
            timeout=20, check=False)
        return shown.stdout

    def test_a_renewed_certificate_is_taken_up_and_a_watch_goes_on(self):
        self.start()
        anna = self.remote(self.token_of("anna"))
        job = self.submit(anna, "steps=100000 sleep_ms=20")
        watch = anna.WatchJob(service_pb2.WatchJobRequest(id=job.id), timeout=60)
        next(watch)
        before = self.fingerprint()
        self.admin("pki", "renew", "--name", "casthouse")
        until(lambda: self.fingerprint() not in ("", before), 15)
        self.assertIn("casthouse", self.admin("pki", "show"))
        for _ in range(20):
            next(watch)
        self.assertEqual(self.submit(anna).owner, "anna")  # nor does a new connection need more
        anna.CancelJob(service_pb2.CancelJobRequest(id=job.id), timeout=10)

    def test_without_tls_no_port_is_served(self):
        for address in ("0.0.0.0:0", "127.0.0.1:7117"):
            daemon = Daemon(self.folder, listen__socket=address)
            with self.assertRaises(RuntimeError) as caught:
                daemon.start()
            self.assertIn("listen.tls", str(caught.exception))


class Audit(AccessTest):
    def test_who_did_what_from_where(self):
        self.start()
        anna = self.remote(self.token_of("anna"))
        job = self.submit(anna)
        self.refusal(grpc.StatusCode.PERMISSION_DENIED,
                     self.remote(self.token_of("vera", "viewer")).DeleteJob,
                     service_pb2.DeleteJobRequest(id=job.id))
        anna.CancelJob(service_pb2.CancelJobRequest(id=job.id, reason="no\u2014need"), timeout=10)
        submitted, = self.audit("--call", "SubmitJob")

        self.assertEqual(submitted["user"], "anna")
        self.assertEqual(submitted["job"], job.id)
        self.assertEqual(submitted["case_sha256"], job.case_sha256)
        self.assertTrue(submitted["from"].startswith("ipv4:127.0.0."), submitted)
        self.assertEqual([event["outcome"] for event in self.audit("--job", job.id)],
                         ["OK", "PERMISSION_DENIED", "OK"])
        self.assertEqual(len(self.audit("--call", "Enrol")), 2)
        self.assertEqual(self.audit("--user", "vera")[-1]["role"], "viewer")

    def test_a_flood_of_wrong_tokens_does_not_fill_the_disk(self):
        self.start()
        stub = self.remote("wrong")
        for _ in range(300):
            self.refusal(grpc.StatusCode.UNAUTHENTICATED, stub.WhoAmI, service_pb2.WhoAmIRequest())
        self.assertLess(len(self.audit("--call", "WhoAmI")), 200)

    def test_the_data_directory_is_the_owners_alone(self):
        self.start()
        anna = self.remote(self.token_of("anna"))
        job = self.submit(anna)
        until(lambda: anna.GetJob(service_pb2.GetJobRequest(id=job.id),
                                  timeout=10).HasField("end_time"), 20)
        data = self.daemon.settings["data_directory"]
        self.assertEqual(stat.S_IMODE(os.stat(data).st_mode), 0o700)
        for folder, folders, files in os.walk(data):
            for name in folders + files:
                mode = os.stat(os.path.join(folder, name)).st_mode
                self.assertEqual(mode & 0o077, 0, os.path.join(folder, name))


class LocalSocket(AccessTest):
    def test_the_users_of_a_unix_socket_are_known(self):
        path = self.in_folder("socket")
        os.chmod(self.folder, 0o755)
        self.start(listen__socket="unix:" + path)
        self.assertEqual(self.daemon.address, "unix:" + path)

        own = self.local().WhoAmI(service_pb2.WhoAmIRequest(), timeout=10)
        self.assertEqual((own.name, own.proof), (pwd.getpwuid(os.getuid()).pw_name, "local user"))

        command = self.client_command("whoami")
        done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
        self.assertIn(own.name, done.stdout, done.stderr)

        if os.getuid() == 0:
            another = subprocess.run(["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}",
                                      "--clear-groups", *command], capture_output=True, text=True,
                                     timeout=20, check=False)
            self.assertIn("nobody", another.stdout, another.stderr)
        job = self.submit(self.local())
        self.assertEqual(self.audit("--job", job.id)[0]["from"], "unix:")

    def test_a_socket_of_a_killed_daemon_is_replaced(self):
        self.start(listen__socket="unix:" + self.in_folder("socket"))
        self.daemon.kill()
        self.daemon.end_workers()
        self.daemon.start()
        self.local().WhoAmI(service_pb2.WhoAmIRequest(), timeout=10)
        self.assertEqual(self.daemon.terminate(), 0)
        self.assertFalse(os.path.exists(self.in_folder("socket")))


CALLS_OF_WEB = """
import sys, grpc
from dccast.v1 import service_pb2, service_pb2_grpc
channel = grpc.insecure_channel(sys.argv[1], [("grpc.enable_http_proxy", 0)])
stub = service_pb2_grpc.SimulationServiceStub(channel)
from_desk = ("dccast-client-address", "ipv4:192.0.2.7:4000")
with_token = (from_desk, ("authorization", "Bearer " + sys.argv[2]))
try:
    stub.WhoAmI(service_pb2.WhoAmIRequest(), metadata=[from_desk], timeout=10)
except grpc.RpcError as error:
    print(error.code().name, error.details())
who = stub.WhoAmI(service_pb2.WhoAmIRequest(), metadata=with_token, timeout=10)
print(who.name, who.proof)
case = service_pb2.ReadCaseRequest(shipped="start-2d-thickness")
case = stub.ReadCase(case, metadata=with_token, timeout=10).case
case.title = "steps=3"
job = stub.SubmitJob(service_pb2.SubmitJobRequest(case=case), metadata=with_token, timeout=20)
print(job.owner, job.id)
enrolled = stub.Enrol(service_pb2.EnrolRequest(secret=sys.argv[3]), metadata=[from_desk], timeout=10)
print(enrolled.user.name)
"""


class Web(AccessTest):
    """access.web_user calls over the socket for the users whose tokens it carries."""

    @unittest.skipUnless(os.geteuid() == 0, "takes another user's id")
    def test_it_has_no_rights_of_its_own(self):
        os.chmod(self.folder, 0o755)
        self.start(access__web_user="nobody")
        secret = self.secret_of(self.admin("user", "add", "bert", "--role", "viewer"))
        done = subprocess.run(
            [sys.executable, "-c", CALLS_OF_WEB, self.daemon.address, self.token_of("anna"), secret],
            capture_output=True, text=True, timeout=60, check=False, user=NOBODY, group=NOBODY,
            env={"PYTHONPATH": os.environ["PYTHONPATH"]})
        self.assertEqual(done.returncode, 0, done.stderr)
        without, with_token, submitted, enrolled = done.stdout.splitlines()
        self.assertRegex(without, "^UNAUTHENTICATED this call has no token.*sign in on the pages of dccast-web")
        self.assertEqual((with_token, enrolled), ("anna token", "bert"))
        owner, job = submitted.split()
        self.assertEqual(owner, "anna")
        self.assertEqual(self.audit("--job", job)[0]["from"], "ipv4:192.0.2.7:4000")

    def test_others_cannot_state_an_address(self):
        self.start(access__web_user="nobody")
        stated = [("dccast-client-address", "ipv4:192.0.2.7:4000")]
        job = self.local().SubmitJob(service_pb2.SubmitJobRequest(case=fake("steps=3")),
                                     metadata=stated, timeout=20)
        self.assertEqual(self.audit("--job", job.id)[0]["from"], "unix:")

    def test_an_unknown_user_is_refused(self):
        with self.assertRaisesRegex(RuntimeError, "access.web_user = \"no-such-user\" is no user"):
            self.start(access__web_user="no-such-user")


class Silence(AccessTest):
    def test_silent_connections_give_way(self):
        self.start(limits__maximum_connections=50)
        silent = []
        self.addCleanup(lambda: [one.close() for one in silent])
        for number in range(200):
            one = connected(self.daemon.address)
            if number % 2:  # an HTTP/2 greeting, and then nothing
                one.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0]))
            silent.append(one)
        start = time.monotonic()
        until(lambda: self.answers(), 10)
        print(f"another client was served after {time.monotonic() - start:.1f} s")

    def answers(self):
        channel = grpc.insecure_channel(self.daemon.address, [("grpc.enable_http_proxy", 0)])
        try:
            stub = service_pb2_grpc.SimulationServiceStub(channel)
            stub.WhoAmI(service_pb2.WhoAmIRequest(), timeout=2)
            return True
        except grpc.RpcError:
            return False
        finally:
            channel.close()


if __name__ == "__main__":
    unittest.main()
