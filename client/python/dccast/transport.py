"""The connection to a server, and where its address comes from."""
from __future__ import annotations

import os
import pathlib
import socket
import stat
import threading
import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import grpc

from dccast import errors
from dccast.v1 import service_pb2, service_pb2_grpc

PORT = 7118
SERVICE_SOCKET = "/run/dccast/dccastd.sock"
ATTEMPTS = 4  # of a call that may be repeated
FIRST_PAUSE_S = 0.2  # doubled after every attempt
DEADLINE_S = 60.0
CHUNK_BYTES = 256_000  # of an upload, service.proto
STREAM_ATTEMPTS = 12  # without progress, before a stream is given up
LONGEST_PAUSE_S = 5.0
PASSING = {"OK", "UNAVAILABLE", "DEADLINE_EXCEEDED", "CANCELLED", "UNKNOWN", "INTERNAL",
           "RESOURCE_EXHAUSTED"}  # a stream that ended so is taken up again

Message = TypeVar("Message")


@dataclass(frozen=True)
class Endpoint:
    """A server, and what a call to it carries. Certificates and key are PEM."""

    address: str  #: with its port
    ca: str = ""  #: of the server; empty: no TLS
    certificate: str = ""
    key: str = ""
    token: str = ""

    @property
    def is_local(self) -> bool:
        """Whether it is a socket of this machine."""
        return self.address.startswith("unix:")


def settings_folder() -> pathlib.Path:
    """Of the settings and logins of the command line client: beside $DCCAST_CONFIG, else dccast in
    $XDG_CONFIG_HOME or ~/.config."""
    if named := os.environ.get("DCCAST_CONFIG"):
        if not os.path.exists(named):
            raise errors.DccastError("INVALID_ARGUMENT",
                                     f"DCCAST_CONFIG names {named}, and there is no such file")
        return pathlib.Path(named).parent
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    root = pathlib.Path(folder) if folder.startswith("/") else pathlib.Path.home() / ".config"
    return root / "dccast"


def _read(file: pathlib.Path) -> dict[str, Any]:
    """A TOML file; empty where there is none."""
    try:
        return tomllib.loads(file.read_text("utf-8"))
    except FileNotFoundError:
        return {}
    except tomllib.TOMLDecodeError as error:
        raise errors.DccastError("INVALID_ARGUMENT", f"{file}: not valid TOML: {error}") from None


def stored_logins(folder: pathlib.Path) -> list[dict[str, str]]:
    """What `dccast login` has stored; the first is the default."""
    file = folder / "servers.toml"
    if file.exists() and os.name == "posix" and file.stat().st_mode & 0o077:
        raise errors.DccastError("PERMISSION_DENIED", f"other users may read the tokens in {file}",
                                 remedy=f"chmod 600 {file}")
    logins: list[dict[str, str]] = _read(file).get("server", [])
    return logins


def with_port(server: str) -> str:
    """The address with the port of dccastd where it has none.

    >>> from dccast import transport
    >>> transport.with_port("caster.example")
    'caster.example:7118'
    """
    if server.startswith("unix:"):
        return server
    if "://" in server:
        raise errors.DccastError("INVALID_ARGUMENT", f"server {server}: write HOST:PORT")
    return server if ":" in server.rsplit("]", 1)[-1] else f"{server}:{PORT}"


def host_and_port(address: str) -> tuple[str, str]:
    """The parts of an address with a port, such as "[::1]:7118"; the host without brackets.

    >>> from dccast import transport
    >>> transport.host_and_port("[::1]:7118")
    ('::1', '7118')
    """
    host, _, port = address.rpartition(":")
    return host.strip("[]"), port


def _listens(path: str) -> bool:
    with socket.socket(socket.AF_UNIX) as caller:
        caller.setblocking(False)
        try:
            caller.connect(path)
        except BlockingIOError:  # its queue is full
            return True
        except OSError:
            return False
    return True


def _belongs_to_this_user(folder: str) -> bool:
    """Anyone may make a folder in /tmp, and could serve there in place of this user's daemon."""
    try:
        status = os.lstat(folder)
    except OSError:
        return False
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid() and not status.st_mode & 0o022


def _local_server() -> str:
    """The socket of this user's daemon, else of this machine's, where one listens; else the place
    of this user's."""
    if not hasattr(socket, "AF_UNIX"):  # Windows: no daemon runs there
        raise errors.DccastError("INVALID_ARGUMENT", "no server is named",
                                 remedy="dccast.login(LINE), with the line that the administrator gives")
    own = os.environ.get("XDG_RUNTIME_DIR", "")
    folders = [own] if own.startswith("/") else []
    if os.name == "posix" and _belongs_to_this_user(folder := f"/tmp/dccast-{os.geteuid()}"):
        folders.append(folder)
    sockets = [*(f"{folder}/dccastd.sock" for folder in folders), SERVICE_SOCKET]
    return "unix:" + next(filter(_listens, sockets), sockets[0])


def endpoint(server: str | None) -> Endpoint:
    """The server that is meant: the argument, else $DCCAST_SERVER, else `server` of the settings file,
    else the first login, else the socket of this machine. One that `dccast login` has stored is found
    by its name or address."""
    folder = settings_folder()
    settings = pathlib.Path(os.environ.get("DCCAST_CONFIG") or folder / "client.toml")
    named = server or os.environ.get("DCCAST_SERVER") or _read(settings).get("server", "")
    for login in stored_logins(folder):
        address = login.get("address", "")
        if named in ("", login.get("name"), address, host_and_port(address)[0]):
            return Endpoint(address, *(login.get(key, "") for key in ("ca", "certificate", "key", "token")))
    found = Endpoint(with_port(named or _local_server()))
    if not found.is_local:
        raise errors.DccastError("UNAUTHENTICATED", f"there is no login for {found.address}",
                                 remedy="dccast login, with the line that the administrator gives; "
                                        "local users give no address: dccastd serves them at a Unix socket")
    return found


def channel_to(to: Endpoint) -> grpc.Channel:
    """A channel, which connects with its first call."""
    options = [("grpc.max_receive_message_length", -1), ("grpc.enable_http_proxy", 0),
               ("grpc.keepalive_time_ms", 30000), ("grpc.keepalive_timeout_ms", 10000),
               ("grpc.initial_reconnect_backoff_ms", 200), ("grpc.max_reconnect_backoff_ms", 2000)]
    if not to.ca:
        return grpc.insecure_channel(to.address, options=options)
    credentials = grpc.ssl_channel_credentials(
        to.ca.encode(), to.key.encode() or None, to.certificate.encode() or None)
    if to.token:
        credentials = grpc.composite_channel_credentials(
            credentials, grpc.access_token_call_credentials(to.token))
    return grpc.secure_channel(to.address, credentials, options=options)


class Deadline:
    """The end of a wait. @param timeout_s  from now; None: no end"""

    def __init__(self, timeout_s: float | None) -> None:
        self._end = None if timeout_s is None else time.monotonic() + timeout_s

    def left(self) -> float | None:
        """Seconds until then; None: no end. @raises DccastError  it is over"""
        if self._end is None:
            return None
        left = self._end - time.monotonic()
        if left <= 0.0:
            raise errors.DccastError("DEADLINE_EXCEEDED", "it has not ended within the given time",
                                     remedy="what runs on the server goes on; wait again")
        return left


class Transport:
    """Calls of one server. Those that may be repeated are, while the server does not answer."""

    def __init__(self, to: Endpoint, timeout_s: float = DEADLINE_S) -> None:
        self.server, self._timeout_s = to.address, timeout_s
        make_stub: Any = service_pb2_grpc.SimulationServiceStub
        self.stub = make_stub(channel_to(to))

    def call(self, method: str, request: Any, repeat: bool = True) -> Any:
        """A unary call. @raises DccastError"""
        pause = FIRST_PAUSE_S
        for attempt in range(1, ATTEMPTS + 1):
            try:
                return getattr(self.stub, method)(request, timeout=self._timeout_s)
            except grpc.RpcError as error:
                if not repeat or attempt == ATTEMPTS or error.code().name != "UNAVAILABLE":
                    raise errors.of_call(error, self.server) from None
            time.sleep(pause)
            pause *= 2
        raise AssertionError("not reached")

    def upload(self, named: Any, path: pathlib.Path) -> None:
        """Uploads a file, unless the server has it. @raises DccastError"""
        pause = FIRST_PAUSE_S
        for attempt in range(1, ATTEMPTS + 1):
            try:
                self._upload_once(named, path)
                return
            except grpc.RpcError as error:
                if attempt == ATTEMPTS or error.code().name != "UNAVAILABLE":
                    raise errors.of_call(error, self.server) from None
            time.sleep(pause)
            pause *= 2

    def _upload_once(self, named: Any, path: pathlib.Path) -> None:
        answered = threading.Event()  # the server takes the content, or has it

        def messages() -> Iterator[Any]:
            yield service_pb2.UploadAttachmentRequest(attachment=named)
            answered.wait()
            with path.open("rb") as file:
                while not call.done() and (chunk := file.read(CHUNK_BYTES)):
                    yield service_pb2.UploadAttachmentRequest(chunk=chunk)

        call = self.stub.UploadAttachment.future(messages())
        try:
            call.initial_metadata()
        finally:
            answered.set()
        call.result()

    def stream(self, method: str, request: Any, timeout_s: float | None = None) -> Any:
        """A stream, which is iterated and cancelled. It raises grpc.RpcError."""
        return getattr(self.stub, method)(request, timeout=timeout_s)

    def resumed(self, open_stream: Callable[[], Any], is_last: Callable[[Message], bool],
                on_stream: Callable[[Any], None] = lambda _: None) -> Iterator[Message]:
        """The messages of a stream that is taken up again where it was cut, up to the last one.

        @param open_stream  opens it behind what was received so far
        @param on_stream    receives every stream that is opened, to cancel it
        """
        failures, pause = 0, FIRST_PAUSE_S
        while True:
            reason = "the stream ended early"
            try:
                stream = open_stream()
                on_stream(stream)
                for message in stream:
                    failures, pause = 0, FIRST_PAUSE_S
                    yield message
                    if is_last(message):
                        stream.cancel()
                        return
            except grpc.RpcError as error:
                if error.code().name not in PASSING:
                    raise errors.of_call(error, self.server) from None
                reason = error.details()
            failures += 1
            if failures == STREAM_ATTEMPTS:
                raise errors.DccastError("UNAVAILABLE", f"lost the stream from {self.server}: {reason}",
                                         remedy="what runs there goes on; watch it again")
            time.sleep(pause)
            pause = min(2 * pause, LONGEST_PAUSE_S)
