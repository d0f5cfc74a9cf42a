"""Hostile peers: memory of the daemon, and how long another client waits, during and after each kind."""
import contextlib
import os
import signal
import subprocess
import sys
import time

import grpc

from access import RemoteFault, over_tls
from cases import fake
from clients import ANSWER, memory_of
from dccast.v1 import service_pb2
from hostile_peers import KINDS
from http2 import DATA, END_HEADERS, END_STREAM, HEADERS, Peer, frame, text, upload_of, whole
from oracle import must
from waiting import turns

MOST_MEMORY = 300e6
WAYS = ("local", "over TLS without a token", "over TLS with a token")


def environment():
    """For another Python, which is to find the same modules."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


class HostilePeers(RemoteFault):
    """Peers of one kind: local ones, then others over TLS before and after they have shown a token."""
    short = long = at_once = len(WAYS)
    lasts, after = 8.0, 2.0

    def prepare(self, scene):
        os.chmod(scene.folder, 0o711)  # of the socket, for the other user of this machine

    def begin(self, scene):
        self.long_job = scene.submit(fake("steps=4000 sleep_ms=10"))
        self.tokens = {name: self.enrol(scene, name) for name in ("anna", "mallory")}

    def disturb(self, scene, count):
        way = WAYS[count.tried % len(WAYS)]
        # A local one is another user, by its system.
        user = ["--reuid=65534", "--regid=65534", "--clear-groups"] if way == "local" else []
        where = ([scene.daemon.address] if way == "local" else
                 [scene.daemon.tls_address, self.ca(scene)])
        if way.endswith("with a token"):
            where.append(self.tokens["mallory"])
        with open(f"/proc/{scene.daemon.process.pid}/clear_refs", "w", encoding="ascii") as file:
            file.write("5")  # VmHWM begins anew
        peers = subprocess.Popen(
            ["setpriv", "--pdeathsig", "KILL", *user, sys.executable,
             os.path.join(os.path.dirname(__file__), "hostile_peers.py"), type(self).__name__,
             str(self.lasts), *where], env={**environment(), "HOSTILE_JOB": self.long_job})
        try:
            slowest = self.watch_others(scene, self.lasts + self.after, count, way)
        finally:
            peers.kill()
            peers.wait(10)
        peak = memory_of(scene.daemon.process.pid, "VmHWM")
        if os.environ.get("HOSTILE_FIGURES"):
            print(f"    {type(self).__name__} {way}: {peak / 1e6:.0f} MB at most, now "
                  f"{memory_of(scene.daemon.process.pid, 'VmRSS') / 1e6:.0f}, slowest {slowest:.2f} s",
                  flush=True)
        if peak > MOST_MEMORY:
            count.found("wrong", f"{way}: the daemon took {peak / 1e6:.0f} MB")
        if slowest > ANSWER:
            count.found("wrong", f"{way}: a status took {slowest:.1f} s")
        count.measured("MB", peak / 1e6)
        count.measured("s", slowest)

    def look(self, scene, count):
        scene.client.cancel(self.long_job)
        scene.acknowledged.pop(self.long_job)
        must(count, lambda: scene.ended(self.long_job), "the job did not end", 30)
        scene.client.ask("DeleteJob", id=self.long_job)

    def watch_others(self, scene, seconds, count, way):
        """Asks on both listeners, over an old and a new connection. Returns the slowest answer [s]."""
        before = [scene.client.stub, over_tls(scene, self.ca(scene), self.tokens["anna"])]
        slowest = 0.0
        for _ in turns(seconds, 0.1):
            new = [scene.connected().stub, over_tls(scene, self.ca(scene), self.tokens["anna"])]
            for stub in before + new:
                begin = time.monotonic()
                try:
                    stub.GetServerInfo(service_pb2.GetServerInfoRequest(), timeout=20,
                                       wait_for_ready=True)
                except grpc.RpcError as error:
                    count.found("wrong", f"{way}: a status was refused: {error.code().name}")
                slowest = max(slowest, time.monotonic() - begin)
            for _ in new:
                scene.clients.pop().close()
        return slowest


class UploadBesideStrangers(RemoteFault):
    """Peers without a token hold requests: an upload of 40 MB by another user is taken"""
    kinds = ("UnbegunCalls", "UnfinishedEnrolments", "UnfinishedUploads", "SlowBodies")
    short = long = at_once = len(kinds)
    lasts, before = 8.0, 1.0
    size = 40_000_000
    machine = "127.0.0.5"

    def begin(self, scene):
        scene.submit(fake("steps=20"))
        self.token = self.enrol(scene, "anna")

    def disturb(self, scene, count):
        kind = self.kinds[count.tried % len(self.kinds)]
        strangers = subprocess.Popen(
            [sys.executable, os.path.join(os.path.dirname(__file__), "hostile_peers.py"), kind,
             str(self.before + self.lasts + 1.0), scene.daemon.tls_address, self.ca(scene)],
            env=environment())
        try:
            time.sleep(self.before)  # the strangers hold their requests by then
            self.upload(scene, count.tried)
        except OSError as error:
            count.found("wrong", f"{kind}: the upload was ended: {type(error).__name__}")
        finally:
            strangers.kill()
            strangers.wait(10)

    def upload(self, scene, number):
        with contextlib.closing(Peer(scene.daemon.tls_address, self.ca(scene), self.token,
                                     machine=self.machine)) as peer:
            stream = peer.begin("UploadAttachment")
            peer.send_slowly(stream, upload_of(self.size, number), self.lasts)
            end = time.monotonic() + 5.0
            while stream not in peer.messages:
                if time.monotonic() > end:
                    raise TimeoutError
                peer.receive(0.1)


class StopUnderAttack(RemoteFault):
    """SIGTERM while hostile peers send all they can: the daemon ends in order within seconds"""
    kinds = ("KeyUpdates", "HandshakesInPieces", "RapidResetOfLists", "PriorityFlood", "UnfinishedUploads",
             "PingFlood")
    short = long = at_once = len(kinds)
    lasts, before, longest = 20.0, 1.5, 6.0
    settings = {**RemoteFault.settings, "workers__stop_grace": "2 s"}

    def begin(self, scene):
        self.token = self.enrol(scene, "mallory")

    def disturb(self, scene, count):
        kind = self.kinds[count.tried % len(self.kinds)]
        scene.submit(fake("steps=400 sleep_ms=5"))
        peers = subprocess.Popen(
            ["setpriv", "--pdeathsig", "KILL", sys.executable,
             os.path.join(os.path.dirname(__file__), "hostile_peers.py"), kind, str(self.lasts),
             scene.daemon.tls_address, self.ca(scene), self.token], env=environment())
        try:
            time.sleep(self.before)  # so long the peers send before it is to end
            begin = time.monotonic()
            code = scene.tell_daemon(signal.SIGTERM)
            taken = time.monotonic() - begin
        finally:
            peers.kill()
            peers.wait(10)
        count.measured("s", taken)
        if code != 0 or taken > self.longest:
            count.found("wrong", f"{kind}: it ended with {code} after {taken:.1f} s")
        scene.come_back()


class BorrowedConnections(RemoteFault):
    """A peer without a token names connections of others in its calls: none is answered"""
    short = long = at_once = 1
    header = "dccast-connection"

    def begin(self, scene):
        scene.submit(fake("steps=20"))

    def disturb(self, scene, count):
        for number in [str(number) for number in range(1, 6)] + ["0" * 32]:
            for swallows in (False, True):
                if self.is_answered(scene, number, swallows):
                    count.found("wrong", f"a stranger called as connection {number}")

    def is_answered(self, scene, number, swallows):
        with contextlib.closing(Peer(scene.daemon.tls_address, self.ca(scene))) as peer:
            block = peer.headers("WhoAmI", (self.header, number))
            if swallows:  # a value that ends where the header of the relay does
                block += b"\x00" + text("x") + whole(4 + len(self.header) + len(number) - 1, 7)
            stream = peer.new_stream()
            peer.send(frame(HEADERS, END_HEADERS, stream, block) +
                      frame(DATA, END_STREAM, stream, bytes(5)))
            end = time.monotonic() + 5.0
            with contextlib.suppress(OSError):
                while stream not in peer.answered and time.monotonic() < end:
                    peer.receive(0.1)
            return stream in peer.messages


for NAME, KIND in KINDS.items():
    globals()[NAME] = type(NAME, (HostilePeers,), {
        "__doc__": f"Hostile peers: {KIND.says}"})
