"""Peers of the metrics port and of the dashboard that send without end, or hardly anything."""
import contextlib
import http.client
import os
import re
import socket
import subprocess
import threading
import time
import urllib.parse

from cases import fake
from clients import ANSWER, memory_of
from fault import Fault
from scene import TIED
from support import BIN
from waiting import turns, until

MOST_MEMORY = 150e6


class WebPeers(Fault):
    """Peers of one kind at the metrics port, then at the dashboard, before they have shown a key."""
    short = long = at_once = 2
    settings = {"listen__metrics": "127.0.0.1:0"}
    connections, lasts = 8, 5.0
    begins = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n"
    goes_on = b""
    pause = 0.0

    def begin(self, scene):
        scene.submit(fake("steps=20"))

    def disturb(self, scene, count):
        with contextlib.ExitStack() as until_end:
            if count.tried % 2 == 1:
                process, port = scene.daemon.process.pid, self.metrics_port(scene)
                ask, name = self.page(port, "/metrics"), "metrics"
            else:
                dashboard = until_end.enter_context(subprocess.Popen(
                    [*TIED, os.path.join(BIN, "dccast"), "--server", scene.daemon.address,
                     "dashboard"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True))
                until_end.callback(dashboard.terminate)
                address = urllib.parse.urlsplit(dashboard.stdout.readline().strip())
                process, port, name = dashboard.pid, address.port, "dashboard"
                ask = self.page(port, "/app.js", self.session(address))
            slowest = self.assault(port, ask, count, name)
            peak = memory_of(process, "VmHWM")
        if peak > MOST_MEMORY:
            count.found("wrong", f"{name}: {peak / 1e6:.0f} MB")
        if slowest > ANSWER:
            count.found("wrong", f"{name}: a page took {slowest:.1f} s")
        count.measured("MB", peak / 1e6)
        count.measured("s", slowest)

    @staticmethod
    def metrics_port(scene):
        until(lambda: "metrics on" in scene.daemon.said(), 10)
        return int(re.findall(r"metrics on http://[^:]+:(\d+)", scene.daemon.said())[-1])

    @staticmethod
    def session(address):
        connection = http.client.HTTPConnection("127.0.0.1", address.port, timeout=10)
        connection.request("GET", f"/?{address.query}")
        return connection.getresponse().getheader("Set-Cookie").split(";")[0]

    @staticmethod
    def page(port, path, cookie=""):
        def ask():
            with contextlib.closing(http.client.HTTPConnection("127.0.0.1", port,
                                                               timeout=20)) as connection:
                connection.request("GET", path, headers={"Cookie": cookie})
                answer = connection.getresponse()
                return answer.status == 200 and answer.read()
        return ask

    def assault(self, port, ask, count, name):
        """Returns the slowest page of an honest peer meanwhile [s]."""
        peers = [threading.Thread(target=self.keep_on, args=(port,), daemon=True)
                 for _ in range(self.connections)]
        for peer in peers:
            peer.start()
        slowest = 0.0
        for _ in turns(self.lasts, 0.1):
            begin = time.monotonic()
            try:
                if not ask():
                    count.found("wrong", f"{name}: another page than asked for")
            except OSError as error:
                count.found("wrong", f"{name}: no page: {error!r}")
            slowest = max(slowest, time.monotonic() - begin)
        for peer in peers:
            peer.join(10)
        return slowest

    def keep_on(self, port):
        end = time.monotonic() + self.lasts
        for _ in turns(self.lasts, 0.2):
            with contextlib.suppress(OSError):
                with socket.create_connection(("127.0.0.1", port), 2) as peer:
                    peer.sendall(self.begins)
                    for _ in turns(end - time.monotonic(), self.pause):
                        peer.sendall(self.goes_on)


class EndlessHeaderLines(WebPeers):
    """Metrics and dashboard: header lines without end"""
    goes_on = b"X-Filling: " + 100 * b"y" + b"\r\n"
    goes_on *= 10000


class EndlessHeaderLine(WebPeers):
    """Metrics and dashboard: one header line without end"""
    begins = WebPeers.begins + b"X-Filling: "
    goes_on = 1_000_000 * b"y"


class EndlessRequestLine(WebPeers):
    """Metrics and dashboard: a request line without end"""
    begins = b"GET /"
    goes_on = 1_000_000 * b"y"


class ChunkExtensions(WebPeers):
    """Metrics and dashboard: bodies in chunks of one byte, each with an extension of 1 kB"""
    begins = b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\n"
    goes_on = (b"1;" + 1000 * b"x" + b"\r\ny\r\n") * 1000


class SlowRequests(WebPeers):
    """Metrics and dashboard: 100 connections whose headers come byte by byte"""
    connections = 100
    goes_on, pause = b"y", 0.2
