"""As much of HTTP/2 as a hostile peer needs: frames and headers by hand, over a Unix socket or TLS."""
import collections
import contextlib
import hashlib
import select
import ssl
import struct
import time

from dccast.v1 import job_pb2, service_pb2
from support import connected

DATA, HEADERS, PRIORITY, RST_STREAM, SETTINGS = range(5)
PING, GOAWAY, WINDOW_UPDATE, CONTINUATION = range(6, 10)
END_STREAM, END_HEADERS, ACK = 1, 4, 1
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
LARGEST_FRAME = 16384
FIRST_WINDOW = 65535
FIRST_DYNAMIC_INDEX = 62
INITIAL_WINDOW_SIZE = 4  # the setting


def frame(kind, flags, stream, payload=b""):
    return struct.pack(">I", len(payload))[1:] + struct.pack(">BBI", kind, flags, stream) + payload


def setting(name, value):
    return struct.pack(">HI", name, value)


def whole(value, bits, first=0):
    """An integer of HPACK (RFC 7541, 5.1) with a prefix of so many bits."""
    most = (1 << bits) - 1
    if value < most:
        return bytes([first | value])
    encoded, value = [first | most], value - most
    while value >= 128:
        encoded.append(value % 128 + 128)
        value //= 128
    return bytes([*encoded, value])


def text(value):
    value = value.encode("ascii") if isinstance(value, str) else value
    return whole(len(value), 7) + value


def framed(message):
    """A message as gRPC sends it."""
    content = message.SerializeToString()
    return struct.pack(">BI", 0, len(content)) + content


def upload_of(size, number=0):
    """All that a client sends of a file. @param number  of the file: the server takes none twice"""
    chunk = 256_000
    content = bytes([number]) * size
    named = job_pb2.Attachment(name="x.msh", sha256=hashlib.sha256(content).hexdigest(),
                               size_bytes=size)
    return framed(service_pb2.UploadAttachmentRequest(attachment=named)) + b"".join(
        framed(service_pb2.UploadAttachmentRequest(chunk=content[begin:begin + chunk]))
        for begin in range(0, size, chunk))


def is_ready(peer_socket, events, seconds):
    """Waits so long for one of the events; descriptors may be of any number."""
    look = select.poll()
    look.register(peer_socket, events)
    return bool(look.poll(1000 * seconds))


class Peer:
    """One connection, for one thread. What comes is read whenever something is sent."""

    def __init__(self, address, ca=None, token="", settings=b"", greets=True, acknowledges=True,
                 machine="127.0.0.9"):
        host = address.rsplit(":", 1)[0]
        # Over TLS as another machine, which has its own limits.
        self.socket = connected(address, source=(machine, 0) if host == "127.0.0.2" else None)
        if ca:
            context = ssl.create_default_context(cafile=ca)
            context.set_alpn_protocols(["h2"])
            self.socket = context.wrap_socket(self.socket, server_hostname=host)
        self.socket.setblocking(False)
        self.token = token
        self.acknowledges = acknowledges
        self.owed = b""  # goes before what is sent next
        self.incoming = bytearray()
        self.windows = collections.defaultdict(lambda: self.first_window)
        self.windows[0] = self.first_window = FIRST_WINDOW
        self.next_stream = 1
        self.answered = set()  # streams that the server has ended
        self.messages = set()  # streams with a message of the server
        self.indexed = []  # headers in the server's table, oldest first
        if greets:
            self.send(PREFACE + frame(SETTINGS, 0, 0, settings))

    def close(self):
        self.socket.close()

    def send(self, content):
        """Raises OSError once the connection has ended, or takes nothing for 10 s."""
        rest, self.owed = memoryview(self.owed + content), b""
        while rest:
            self.receive()
            try:
                rest = rest[self.socket.send(rest[:65536]):]
            except (BlockingIOError, ssl.SSLWantWriteError, ssl.SSLWantReadError):
                if not is_ready(self.socket, select.POLLIN | select.POLLOUT, 10):
                    raise TimeoutError from None

    def receive(self, seconds=0.0):
        """Takes what has come; waits so long for something."""
        if seconds and not self.pending():
            is_ready(self.socket, select.POLLIN, seconds)
        with contextlib.suppress(BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            while True:
                received = self.socket.recv(65536)
                if not received:
                    raise ConnectionError
                self.incoming += received
        while len(self.incoming) >= 9:
            end = 9 + int.from_bytes(self.incoming[:3], "big")
            if len(self.incoming) < end:
                break
            self.take(self.incoming[3], self.incoming[4],
                      int.from_bytes(self.incoming[5:9], "big"), bytes(self.incoming[9:end]))
            del self.incoming[:end]
        if seconds and self.owed:
            self.send(b"")

    def pending(self):
        return isinstance(self.socket, ssl.SSLSocket) and self.socket.pending() > 0

    def take(self, kind, flags, stream, payload):
        if kind == WINDOW_UPDATE:
            self.windows[stream] += int.from_bytes(payload, "big")
        if kind == SETTINGS and not flags & ACK:
            for at in range(0, len(payload), 6):
                name, value = struct.unpack(">HI", payload[at:at + 6])
                if name == INITIAL_WINDOW_SIZE:
                    for one in self.windows:
                        self.windows[one] += (value - self.first_window) if one else 0
                    self.first_window = value
            if self.acknowledges:
                self.owed += frame(SETTINGS, ACK, 0)
        if kind == PING and not flags & ACK:
            self.owed += frame(PING, ACK, 0, payload)
        if kind == DATA and payload:
            self.messages.add(stream)
        if kind == HEADERS and flags & END_STREAM:
            self.answered.add(stream)
        if kind == GOAWAY:
            raise ConnectionError

    def new_stream(self):
        stream, self.next_stream = self.next_stream, self.next_stream + 2
        if stream > 2**31 - 3:
            raise ConnectionError
        return stream

    def header(self, name, value):
        """As an index of the table, after the first time."""
        if (name, value) in self.indexed:
            back = len(self.indexed) - 1 - self.indexed.index((name, value))
            return whole(FIRST_DYNAMIC_INDEX + back, 7, 0x80)
        self.indexed.append((name, value))
        return b"\x40" + text(name) + text(value)

    def headers(self, method, *more):
        """The header block of a call."""
        all_of_them = [(":path", "/dccast.v1.SimulationService/" + method), (":authority", "x"),
                       ("content-type", "application/grpc"), ("te", "trailers"), *more]
        if self.token:
            all_of_them.append(("authorization", "Bearer " + self.token))
        return b"\x83\x86" + b"".join(self.header(*one) for one in all_of_them)

    def begin(self, method, *more):
        """Begins a call. Returns its stream."""
        stream = self.new_stream()
        self.send(frame(HEADERS, END_HEADERS, stream, self.headers(method, *more)))
        return stream

    def send_slowly(self, stream, content, seconds):
        """Messages as framed() gives them, over so many seconds, and the end of the call."""
        begin, sent = time.monotonic(), 0
        while sent < len(content):
            due = len(content) * (time.monotonic() - begin) / seconds
            room = min(self.windows[0], self.windows[stream], LARGEST_FRAME)
            if room <= 0 or sent > due:
                self.receive(0.01)
                continue
            sent += self.send_part(stream, content[sent:sent + room])
        self.send(frame(DATA, END_STREAM, stream))

    def send_part(self, stream, part):
        """One frame of a message, within the windows; returns its length."""
        self.send(frame(DATA, 0, stream, part))
        self.windows[0] -= len(part)
        self.windows[stream] -= len(part)
        return len(part)

    def send_most_of_a_message(self, stream, size, missing=1, compressed=0, content=None):
        """A message without its last bytes, as fast as the windows permit; for 5 s at most."""
        self.send_what_fits(stream, struct.pack(">BI", compressed, size) +
                            (content or bytes(size - missing)))

    def send_what_fits(self, stream, content):
        """As fast as the windows permit; for 5 s at most."""
        end, sent = time.monotonic() + 5, 0
        while sent < len(content) and time.monotonic() < end:
            room = min(self.windows[0], self.windows[stream], LARGEST_FRAME)
            if room <= 0:
                self.receive(0.5)
                continue
            sent += self.send_part(stream, content[sent:sent + room])
