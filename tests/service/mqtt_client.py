"""The little of MQTT 3.1.1 that a logger of a plant needs, for tests against a real broker."""
import socket
import ssl
import uuid

CONNECT, CONNACK, PUBLISH, PUBACK, SUBSCRIBE, SUBACK = 0x10, 0x20, 0x30, 0x40, 0x82, 0x90
AT_LEAST_ONCE, RETAIN = 0x02, 0x01
CLEAN_SESSION_WITH_LOGIN = 0xC2


def text(value):
    data = value.encode()
    return len(data).to_bytes(2, "big") + data


class MqttClient:
    """A connection to a broker on this machine, over TLS where a CA is given."""

    def __init__(self, port, user, password, ca=None):
        self.stream = socket.create_connection(("127.0.0.1", port), timeout=30)
        if ca:
            context = ssl.create_default_context(cafile=ca)
            self.stream = context.wrap_socket(self.stream, server_hostname="127.0.0.1")
        self.number = 0
        no_keep_alive = (0).to_bytes(2, "big")
        self.send(CONNECT, text("MQTT") + bytes([4, CLEAN_SESSION_WITH_LOGIN]) + no_keep_alive +
                  text(uuid.uuid4().hex) + text(user) + text(password))
        self.expect(CONNACK)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stream.close()

    def publish(self, topic, message, retain=False):
        self.send(PUBLISH | AT_LEAST_ONCE | (RETAIN if retain else 0),
                  text(topic) + self.next_number() + message.encode())
        self.expect(PUBACK)

    def subscribe(self, topic):
        """Returns when the broker has taken the subscription."""
        self.send(SUBSCRIBE, self.next_number() + text(topic) + b"\x01")
        self.expect(SUBACK)

    def receive(self):
        """The text of the next message."""
        kind, body = self.packet()
        assert kind & 0xF0 == PUBLISH, kind
        begin = 2 + int.from_bytes(body[:2], "big")
        if kind & 0x06:
            self.send(PUBACK, body[begin:begin + 2])
            begin += 2
        return body[begin:].decode()

    def next_number(self):
        self.number += 1
        return self.number.to_bytes(2, "big")

    def send(self, kind, body):
        length, rest = b"", len(body)
        while not length or rest:
            length += bytes([rest % 128 + (128 if rest >= 128 else 0)])
            rest //= 128
        self.stream.sendall(bytes([kind]) + length + body)

    def expect(self, kind):
        found, body = self.packet()
        assert found == kind and (kind != CONNACK or body[1] == 0), (found, body)

    def packet(self):
        """(kind with its flags, content)."""
        kind, length, shift = self.read(1)[0], 0, 0
        while True:
            byte = self.read(1)[0]
            length |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return kind, self.read(length)

    def read(self, size):
        data = b""
        while len(data) < size:
            more = self.stream.recv(size - len(data))
            assert more, "the broker has closed the connection"
            data += more
        return data
