"""Users of other machines whose token or certificate ends, and silent ones: jobs and other users go on."""
import contextlib
import os
import re
import resource
import subprocess
import threading
import time

import grpc

from cases import fake
from certificates import TestCa, openssl_time
from dccast.v1 import service_pb2, service_pb2_grpc
from fault import Fault
from oracle import must
from scene import Scene, limit
from support import BIN, connected, setting_options
from waiting import pause, until

LONG = "steps=400 sleep_ms=10"


def admin(scene, *words):
    """A command of dccastd on the scene's settings, beside the daemon."""
    command = [os.path.join(BIN, "dccastd"), *words, *setting_options(scene.daemon.settings)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=True)
    return done.stdout


def over_tls(scene, ca, token="", certificate=None):
    """A stub for calls over TLS. @param certificate  key and chain of the client, as files"""
    def read(path):
        with open(path, "rb") as file:
            return file.read()
    key, chain = map(read, certificate) if certificate else (None, None)
    credentials = grpc.ssl_channel_credentials(read(ca), key, chain)
    if token:
        credentials = grpc.composite_channel_credentials(credentials,
                                                         grpc.access_token_call_credentials(token))
    channel = grpc.secure_channel(scene.daemon.tls_address, credentials,
                                  [("grpc.use_local_subchannel_pool", 1)])
    scene.clients.append(channel)
    return service_pb2_grpc.SimulationServiceStub(channel)


class Watch(threading.Thread):
    """Follows a job until the stream ends."""

    def __init__(self, stub, job_id):
        super().__init__(daemon=True)
        self.call = stub.WatchJob(service_pb2.WatchJobRequest(id=job_id), timeout=60)
        self.events, self.code = 0, None
        self.start()
        until(lambda: self.events > 0 or self.code, 20)

    def run(self):
        try:
            for _ in self.call:
                self.events += 1
            self.code = grpc.StatusCode.OK
        except grpc.RpcError as error:
            self.code = error.code()

    def ended_with(self, code, count, seconds):
        with contextlib.suppress(AssertionError):
            until(lambda: self.code is not None, seconds)
        if self.code != code:
            count.found("wrong", f"the watch ended with {self.code}, not {code}")


class RemoteFault(Fault):
    """A daemon that listens over TLS, with a submitter named anna."""
    short, long = 1, 10

    def scene(self, chance):
        return Scene(chance, self.worker, prepare=self.prepare, options=self.options,
                     listen__tls="127.0.0.2:0", listen__public_address="127.0.0.2:7118", **self.settings)

    def prepare(self, scene):
        """Before the daemon starts."""

    def ca(self, scene):
        return scene.data("pki", "ca.pem")

    def enrol(self, scene, name):
        line = admin(scene, "user", "add", name, "--role", "submitter")
        request = service_pb2.EnrolRequest(secret=re.search(r"dccast-enrol-\w+-\w+", line)[0])
        return over_tls(scene, self.ca(scene)).Enrol(request, timeout=10).token


class TokenRevokedUnderWatch(RemoteFault):
    """A token is revoked: its watches end within 2 s, job and other watches go on"""

    def disturb(self, scene, count):
        stubs = [over_tls(scene, self.ca(scene), self.enrol(scene, name))
                 for name in ("anna", "bert")]
        job_id = scene.submit(fake(LONG))
        anna, bert = (Watch(stub, job_id) for stub in stubs)
        pause(scene.chance, 1.0)
        admin(scene, "user", scene.chance.choice(("rotate", "disable", "remove")), "anna")
        anna.ended_with(grpc.StatusCode.UNAUTHENTICATED, count, 2)
        bert.ended_with(grpc.StatusCode.OK, count, 30)


class TokenOverTheSocket(RemoteFault):
    """A false token, or one of another user, over the Unix socket: no call runs as the user of the socket"""
    short = long = 1

    def disturb(self, scene, count):
        scene.submit(fake("steps=20"))
        for token in ("dccast-token-0000-0000", "no token", self.enrol(scene, "anna")):
            metadata = [("authorization", f"Bearer {token}")]
            try:
                answer = scene.client.stub.WhoAmI(service_pb2.WhoAmIRequest(), timeout=10,
                                                  metadata=metadata)
                count.found("wrong", f"a call with a token of another runs as {answer.name}")
            except grpc.RpcError as error:
                if error.code() is not grpc.StatusCode.UNAUTHENTICATED:
                    count.found("wrong", f"{error.code().name}: {error.details()}")


class ClientCertificateExpiresUnderWatch(RemoteFault):
    """A client's certificate expires: its watch ends, the job goes on"""

    def prepare(self, scene):
        self.own = TestCa(scene.folder)
        scene.daemon.settings["tls__client_ca"] = self.own.certificate

    def disturb(self, scene, count):
        admin(scene, "user", "add", "anna", "--role", "viewer")
        ends = 4
        chain = self.own.issue("anna.pem", subject="anna", ends=openssl_time(ends))
        job_id = scene.submit(fake(LONG + "0"))
        watch = Watch(over_tls(scene, self.ca(scene), certificate=(self.own.key, chain)), job_id)
        watch.ended_with(grpc.StatusCode.UNAUTHENTICATED, count, ends + 3)
        scene.client.cancel(job_id)
        scene.acknowledged.pop(job_id)  # that it goes on until then is seen by its state
        until(lambda: scene.ended(job_id), 20)
        scene.client.ask("DeleteJob", id=job_id)


class ServerCertificateExpiresUnderWatch(RemoteFault):
    """The server's certificate expires and is replaced: a watch goes on, new calls are served"""

    def prepare(self, scene):
        self.own = TestCa(scene.folder)
        self.issue(5)
        scene.daemon.settings.update(tls__certificate=os.path.join(scene.folder, "server.pem"),
                                     tls__key=self.own.key,
                                     tls__ca=self.own.certificate)

    def issue(self, ends):
        self.own.issue("server.pem", name="IP:127.0.0.2", ends=openssl_time(ends))

    def ca(self, scene):
        return self.own.certificate

    def disturb(self, scene, count):
        token = self.enrol(scene, "anna")
        job_id = scene.submit(fake("steps=1200 sleep_ms=10"))
        watch = Watch(over_tls(scene, self.ca(scene), token), job_id)
        time.sleep(6)  # the certificate has expired by then
        with contextlib.suppress(grpc.RpcError):
            over_tls(scene, self.ca(scene), token).WhoAmI(service_pb2.WhoAmIRequest(), timeout=2)
            count.found("wrong", "an expired certificate was taken")
        self.issue(3600)
        renewed = over_tls(scene, self.ca(scene), token)
        must(count, lambda: renewed.WhoAmI(service_pb2.WhoAmIRequest(), timeout=5,
                                           wait_for_ready=True).name,
             "no new connection with the new certificate", 10)
        watch.ended_with(grpc.StatusCode.OK, count, 40)


class RefusedEnrolments(RemoteFault):
    """Enrolments without a secret, as fast as possible: at most 200 lines in the audit log"""
    short, long = 1, 5
    calls, most_lines = 3000, 200

    def disturb(self, scene, count):
        job_id = scene.submit(fake("steps=20"))
        stub = over_tls(scene, self.ca(scene))
        before = self.lines(scene)
        calls = [stub.Enrol.future(service_pb2.EnrolRequest(secret="dccast-enrol-x-y"), timeout=60)
                 for _ in range(self.calls)]
        refused = sum(call.code() is not grpc.StatusCode.OK for call in calls)
        grown = self.lines(scene) - before
        if refused != self.calls:
            count.found("wrong", f"{self.calls - refused} enrolments were not refused")
        if not 0 < grown <= self.most_lines:
            count.found("wrong", f"the audit log has {grown} more lines")
        count.measured("lines", grown)
        must(count, lambda: scene.ended(job_id), "the job did not end", 30)

    @staticmethod
    def lines(scene):
        with open(scene.data("audit.log"), "rb") as file:
            return file.read().count(b"\n")


class SilentConnections(RemoteFault):
    """1,200 silent connections on both listeners"""
    short, long = 1, 5
    connections = 1200
    greeting = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0])

    def begin(self, scene):
        limit(os.getpid(), resource.RLIMIT_NOFILE, 8192)

    def disturb(self, scene, count):
        token = self.enrol(scene, "anna")
        job_id = scene.submit(fake(LONG))
        with contextlib.ExitStack() as silent:
            for address in (scene.daemon.address, scene.daemon.tls_address):
                for number in range(self.connections):
                    with contextlib.suppress(OSError):
                        one = silent.enter_context(connected(address, timeout=2))
                        if number % 2:
                            one.sendall(self.greeting)
            time.sleep(1.0)  # a stranger's silence: nothing says that all of them count
            must(count, lambda: scene.connected().stub.WhoAmI(
                service_pb2.WhoAmIRequest(), timeout=2).name, "a local user was shut out", 2)
            must(count, lambda: over_tls(scene, self.ca(scene), token).WhoAmI(
                service_pb2.WhoAmIRequest(), timeout=2).name, "a user over TLS was shut out", 2)
        must(count, lambda: scene.ended(job_id), "the job did not end", 30)
