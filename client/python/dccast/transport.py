"""The connection to a server, and where its address comes from."""
from __future__ import annotations

import os
import pathlib
import time
import tomllib
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import grpc

from dccast import errors
from dccast.v1 import service_pb2_grpc

PORT = 7117
ATTEMPTS = 4  # of a call that may be repeated
FIRST_PAUSE_S = 0.2  # doubled after every attempt
DEADLINE_S = 60.0
STREAM_ATTEMPTS = 12  # without progress, before a stream is given up
LONGEST_PAUSE_S = 5.0
PASSING = {"OK", "UNAVAILABLE", "DEADLINE_EXCEEDED", "CANCELLED", "UNKNOWN", "INTERNAL",
           "RESOURCE_EXHAUSTED"}  # a stream that ended so is taken up again

Message = TypeVar("Message")


def configuration_file() -> pathlib.Path | None:
    """The settings file of the command line client: $DCCAST_CONFIG, else dccast/client.toml in
    $XDG_CONFIG_HOME or ~/.config."""
    if named := os.environ.get("DCCAST_CONFIG"):
        if not os.path.exists(named):
            raise errors.DccastError("INVALID_ARGUMENT",
                                     f"DCCAST_CONFIG names {named}, and there is no such file")
        return pathlib.Path(named)
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    root = pathlib.Path(folder) if folder.startswith("/") else pathlib.Path.home() / ".config"
    file = root / "dccast" / "client.toml"
    return file if file.exists() else None


def address(server: str | None) -> str:
    """The address with its port: the argument, else $DCCAST_SERVER, else `server` of the settings
    file, else this machine.

    >>> from dccast import transport
    >>> transport.address("caster.example")
    'caster.example:7117'
    """
    named = server or os.environ.get("DCCAST_SERVER")
    if not named and (file := configuration_file()):
        try:
            named = tomllib.loads(file.read_text("utf-8")).get("server")
        except tomllib.TOMLDecodeError as error:
            raise errors.DccastError("INVALID_ARGUMENT", f"{file}: not valid TOML: {error}") from None
    named = named or "127.0.0.1"
    if named.startswith("unix:"):
        return named
    if "://" in named:
        raise errors.DccastError("INVALID_ARGUMENT", f"server {named}: write HOST:PORT")
    has_port = ":" in named.rsplit("]", 1)[-1]
    return named if has_port else f"{named}:{PORT}"


class Transport:
    """Calls of one server. Those that may be repeated are, while the server does not answer."""

    def __init__(self, server: str) -> None:
        self.server = server
        options = [("grpc.max_receive_message_length", -1), ("grpc.enable_http_proxy", 0),
                   ("grpc.keepalive_time_ms", 30000), ("grpc.keepalive_timeout_ms", 10000),
                   ("grpc.initial_reconnect_backoff_ms", 200), ("grpc.max_reconnect_backoff_ms", 2000)]
        self.channel = grpc.insecure_channel(server, options=options)
        make_stub: Any = service_pb2_grpc.SimulationServiceStub
        self.stub = make_stub(self.channel)

    def call(self, method: str, request: Any, repeat: bool = True) -> Any:
        """A unary call. @raises DccastError"""
        pause = FIRST_PAUSE_S
        for attempt in range(1, ATTEMPTS + 1):
            try:
                return getattr(self.stub, method)(request, timeout=DEADLINE_S)
            except grpc.RpcError as error:
                if not repeat or attempt == ATTEMPTS or error.code().name != "UNAVAILABLE":
                    raise errors.of_call(error, self.server) from None
            time.sleep(pause)
            pause *= 2
        raise AssertionError("not reached")

    def stream(self, method: str, request: Any) -> Any:
        """A stream, which is iterated and cancelled. It raises grpc.RpcError."""
        return getattr(self.stub, method)(request)

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
