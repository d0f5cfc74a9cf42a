"""What the service tests share: a daemon of their own in a fresh folder, and a client for it.

Everything is started at a Unix socket of its own and stopped by its process id.
"""
import contextlib
import hashlib
import http.client
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

import grpc
from google.protobuf import symbol_database

from dccast.v1 import case_pb2, job_pb2, refusal_pb2, service_pb2, service_pb2_grpc

sys.path.append(os.path.join(os.path.dirname(__file__), os.pardir, "support"))
from waiting import WAIT_FACTOR, until

BIN = os.environ["DCCAST_BIN"]
SANITIZED = "DCCAST_SANITIZER_REPORTS" in os.environ
METHODS = service_pb2.DESCRIPTOR.services_by_name["SimulationService"].methods_by_name
TERMINAL = (job_pb2.SUCCEEDED, job_pb2.FAILED, job_pb2.CANCELLED)


class Daemon:
    """One dccastd; its folder outlives it, so that it can be started again on it."""

    def __init__(self, folder, worker="dccast-worker-fake", before_exec=None, options=(),
                 **settings):
        self.folder = folder
        self.options = options
        self.before_exec = before_exec  # called in its process, e.g. to limit it
        self.port_file = os.path.join(folder, "port")
        self.settings = {"listen__socket": socket_in(folder), "listen__port_file": self.port_file,
                         "data_directory": os.path.join(folder, "data"),
                         "workers__program": os.path.join(BIN, worker), "workers__count": 2, **settings}
        self.process = None

    def command(self):
        return [os.path.join(BIN, "dccastd"), *self.options, *setting_options(self.settings)]

    def start(self):
        if os.path.exists(self.port_file):
            os.remove(self.port_file)
        self.log = open(os.path.join(self.folder, "daemon.log"), "ab")
        self.process = subprocess.Popen(self.command(), stderr=self.log,
                                        preexec_fn=self.before_exec)
        until(lambda: os.path.exists(self.port_file) or self.process.poll() is not None, 15)
        if self.process.poll() is not None:
            raise RuntimeError(f"dccastd ended with {self.process.returncode}:\n{self.said()}")
        with open(self.port_file, encoding="ascii") as file:
            self.address, *over_tls = file.read().split()
            self.tls_address = over_tls[0] if over_tls else None
        return self

    def said(self):
        with open(os.path.join(self.folder, "daemon.log"), encoding="utf-8") as file:
            return file.read()

    def terminate(self):
        """SIGTERM. Returns the exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.wait()

    def kill(self):
        """SIGKILL. Its workers run on, until it is started again."""
        self.process.send_signal(signal.SIGKILL)
        self.wait()

    def stop(self):
        """After a test. A sanitizer looks for leaks at an end of its own only."""
        if self.running() and SANITIZED:
            self.process.send_signal(signal.SIGCONT)
            self.terminate()
        elif self.running():
            self.kill()

    def kill_with_workers(self):
        """What the end of a machine leaves: nothing runs on."""
        self.kill()
        self.end_workers()

    def end_workers(self):
        """Ends the workers of a daemon that has gone, and waits until they have released their files:
        a process that ends loses its descriptors in /proc before the locks that it holds."""
        killed = set()

        def ended():
            for process in self.worker_processes():
                killed.add((process, start_ticks(process)))
                with contextlib.suppress(ProcessLookupError):
                    os.kill(process, signal.SIGKILL)
            return not self.worker_processes() and not any(
                ticks and start_ticks(process) == ticks for process, ticks in killed)
        until(ended, 10)

    def wait(self):
        code = self.process.wait(timeout=30 * WAIT_FACTOR)
        self.log.close()
        return code

    def running(self):
        return self.process is not None and self.process.poll() is None

    def worker_processes(self):
        """Process ids of workers that run jobs of this data directory, whoever started them."""
        jobs = os.path.join(os.path.realpath(self.settings["data_directory"]), "jobs", "")
        return [process for process in processes() if job_log(process).startswith(jobs)]

    def answering_processes(self):
        """Process ids of this daemon's workers without a job: they answer, or wait."""
        return [process for process in self.children() if not job_log(process)]

    def children(self):
        found = []
        for process in processes():
            try:
                with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
                    fields = file.read().rsplit(")", 1)[1].split()
                if fields[1] == str(self.process.pid) and fields[0] != "Z":
                    found.append(process)
            except OSError:
                pass  # it ended while we looked
        return found


def setting_options(settings):
    """Options of dccastd for settings whose names have two underscores for the dot: listen__tls."""
    return [word for key, value in settings.items()
            for word in ("--set", f"{key.replace('__', '.')}={value}")]


def socket_in(folder):
    """Where a daemon of this folder listens. A path of a socket has at most 107 bytes."""
    path = os.path.join(folder, "socket")
    if len(path) > 107:
        path = os.path.join(tempfile.mkdtemp(prefix="dccast-", dir="/tmp"), "socket")
    return "unix:" + path


def connected(address, timeout=5, source=None):
    """A socket without gRPC. @param source  address of ours, of TCP"""
    if address.startswith("unix:"):
        peer = socket.socket(socket.AF_UNIX)
        peer.settimeout(timeout)
        peer.connect(address.removeprefix("unix:"))
        return peer
    host, port = address.rsplit(":", 1)
    return socket.create_connection((host, int(port)), timeout, source)


def processes():
    return [int(name) for name in os.listdir("/proc") if name.isdigit()]


def start_ticks(process):
    """Tells a process from a later one with the same number; 0 when there is none."""
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
            fields = file.read().rsplit(")", 1)[1].split()
            return 0 if fields[0] == "Z" else int(fields[19])
    except OSError:
        return 0


def job_log(process):
    """A worker speaks into the log of its job once it has one. Returns the path of that log, or ""."""
    try:
        log = os.readlink(f"/proc/{process}/fd/2")
    except OSError:
        return ""  # it has ended, or is not ours
    return log if "/worker.log" in log else ""


def work_of(process):
    """What a worker is at: "dccast-check", "dccast-query", "dccast-job"; "" when it has ended."""
    try:
        with open(f"/proc/{process}/comm", encoding="utf-8") as file:
            return file.read().strip()
    except OSError:
        return ""


class SocketConnection(http.client.HTTPConnection):
    """HTTP to a Unix socket, as a proxy has it. The server's name is dccast.test."""

    def __init__(self, path, timeout=60):
        super().__init__("dccast.test", timeout=timeout)
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self.path)


class Client:
    """A Python client made from the .proto files alone."""

    def __init__(self, address):
        self.channel = grpc.insecure_channel(address, options=[("grpc.use_local_subchannel_pool", 1)])
        self.stub = service_pb2_grpc.SimulationServiceStub(self.channel)

    def close(self):
        self.channel.close()

    def ask(self, method, timeout=60, **fields):
        """Calls a method with a request of these fields. Returns its response, or the stream of them."""
        request = symbol_database.Default().GetPrototype(METHODS[method].input_type)
        return getattr(self.stub, method)(request(**fields), timeout=timeout)

    def upload(self, name, content, chunk=256_000):
        """Uploads a file. Returns what a case names it by."""
        named = job_pb2.Attachment(name=name, sha256=hashlib.sha256(content).hexdigest(),
                                   size_bytes=len(content))
        self.upload_as(named, content, chunk)
        return named

    def upload_as(self, named, content, chunk=256_000):
        """Uploads what may be another file than it is said to be. Returns the response."""
        def messages():
            yield service_pb2.UploadAttachmentRequest(attachment=named)
            for begin in range(0, len(content), chunk):
                yield service_pb2.UploadAttachmentRequest(chunk=content[begin:begin + chunk])
        return self.stub.UploadAttachment(messages(), timeout=60)

    def submit(self, case, **rest):
        return self.ask("SubmitJob", case=case, **rest)

    def job(self, job_id):
        return self.ask("GetJob", id=job_id)

    def watch(self, job_id, start=1, timeout=60):
        return self.ask("WatchJob", timeout, id=job_id, from_sequence=start)

    def cancel(self, job_id, reason=""):
        return self.ask("CancelJob", id=job_id, reason=reason)

    def pages(self, job_id, page_size=0):
        """All pages of a job's history."""
        pages, token = [], ""
        while True:
            pages.append(self.ask("QueryResult", id=job_id, page_size=page_size, page_token=token))
            token = pages[-1].next_page_token
            if not token:
                return pages

    def steps(self, job_id):
        return [step for page in self.pages(job_id) for step in page.steps]

    def fetch(self, job_id, artifact="", offset=0):
        return list(self.ask("FetchResult", id=job_id, artifact=artifact, offset=offset))

    def until_state(self, job_id, *states, seconds=60):
        until(lambda: self.job(job_id).state in states, seconds)
        return self.job(job_id)

    def until_step(self, job_id, step, seconds=60):
        until(lambda: self.job(job_id).last_step.step >= step, seconds)


def fake_case(title="", **rest):
    """A sound case; what dccast-worker-fake does with it stands in its title."""
    case = case_pb2.Case(title=title, **rest)
    case.section.half_width_m = 0.25
    case.section.initial_depth_m = 0.05
    case.time.end_s = 145
    monitor = case.monitor.add()
    monitor.name, monitor.x_m, monitor.y_m = "corner", 0.25, 0.0
    return case


def curve(steps):
    return [(step.step, step.monitors[0].displacement_m[1]) for step in steps]


class ServiceTest(unittest.TestCase):
    """A test with a daemon and a client; both are gone after it."""
    settings = {}
    worker = "dccast-worker-fake"
    before_exec = None
    options = ()  # of the daemon's command line, beside its settings

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="dccast-service-")
        self.daemon = Daemon(self.folder, self.worker, type(self).before_exec, self.options,
                             **self.settings).start()
        self.clients = []
        self.client = self.new_client()

    def new_client(self):
        self.clients.append(Client(self.daemon.address))
        return self.clients[-1]

    def restart(self):
        """Starts the daemon again, on its folder, and connects to it anew."""
        self.daemon.start()
        self.client = self.new_client()

    def in_folder(self, *names):
        return os.path.join(self.folder, *names)

    def write_file(self, name, text):
        """Writes a file into the folder of the test. Returns its path."""
        path = self.in_folder(name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def client_command(self, *words):
        return [os.path.join(BIN, "dccast"), "--server", self.daemon.address, *words]

    def run_dccast(self, *words, code=0):
        """Runs the command to its end, in the folder of the test."""
        ended = subprocess.run(self.client_command(*words), capture_output=True, text=True,
                               timeout=300 * WAIT_FACTOR, check=False, cwd=self.folder)
        self.assertEqual(ended.returncode, code, ended.stderr)
        return ended

    def dccast(self, *words, code=0):
        """The same. Returns what it printed, or why it failed."""
        ended = self.run_dccast(*words, code=code)
        return ended.stderr if code else ended.stdout

    def tearDown(self):
        for client in self.clients:
            client.close()
        self.daemon.stop()
        self.daemon.end_workers()
        if not self._outcome.success:
            sys.stderr.write(self.daemon.said())
        shutil.rmtree(self.folder)

    def refused(self, code, call, *arguments, **rest):
        """Calls, expects this status, returns the error."""
        with self.assertRaises(grpc.RpcError) as caught:
            result = call(*arguments, **rest)
            if hasattr(result, "__next__"):
                list(result)
        self.assertEqual(caught.exception.code(), code, caught.exception.details())
        if code not in (grpc.StatusCode.UNIMPLEMENTED, grpc.StatusCode.UNAVAILABLE):
            self.assertTrue(caught.exception.details())  # those two may be gRPC's own
        return caught.exception

    def details(self, error):
        """Why a call was refused, for programs: the ErrorInfo, and the faults of a case."""
        status = refusal_pb2.StatusDetails.FromString(
            dict(error.trailing_metadata())["grpc-status-details-bin"])
        self.assertEqual((status.code, status.message), (error.code().value[0], error.details()))
        info = refusal_pb2.ErrorInfo.FromString(status.details[0].value)
        self.assertEqual(status.details[0].type_url, "type.googleapis.com/google.rpc.ErrorInfo")
        verdict = service_pb2.ValidateCaseResponse()
        for detail in status.details[1:]:
            self.assertTrue(detail.Unpack(verdict))
        return info, verdict

    def sound_events(self, events):
        """Sequence numbers without a hole, one terminal event, at the end."""
        first = events[0].sequence
        self.assertEqual([event.sequence for event in events],
                         list(range(first, first + len(events))))
        self.assertEqual([event.sequence for event in events if event.state_change.terminal],
                         [events[-1].sequence])
        return events


def main():
    unittest.main()
