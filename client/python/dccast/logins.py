"""Logging in with the line of `dccastd user add`, as the command `dccast login` does."""
from __future__ import annotations

import hashlib
import json
import os
import pathlib
import socket
import ssl
from dataclasses import dataclass
from typing import Any

from dccast import errors
from dccast.service import Service
from dccast.transport import (DEADLINE_S, Endpoint, Transport, host_and_port, settings_folder,
                              stored_logins)
from dccast.v1 import service_pb2

FINGERPRINT = "sha256:"
KEYS = ("name", "address", "user", "token", "expires", "certificate", "key", "ca")


@dataclass(frozen=True)
class _Line:
    address: str
    fingerprint: str  # 64 hexadecimal digits
    secret: str


def _read_line(text: str) -> _Line:
    """HOST:PORT/sha256:FINGERPRINT/SECRET, also behind the words `dccast login`."""
    address, fingerprint, secret = ((text.split() or [""])[-1].split("/", 2) + ["", ""])[:3]
    if not (address and secret and fingerprint.startswith(FINGERPRINT)
            and len(fingerprint) == len(FINGERPRINT) + 64):
        raise errors.DccastError(
            "INVALID_ARGUMENT", "this is not the line of `dccastd user add`",
            remedy="give the whole of it: HOST:PORT/sha256:FINGERPRINT/SECRET")
    return _Line(address, fingerprint.removeprefix(FINGERPRINT), secret)


def _shown_certificates(address: str, timeout_s: float) -> list[str]:
    """All certificates that a server shows, as PEM. None is trusted yet."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    context.set_alpn_protocols(["h2"])
    host, port = host_and_port(address)
    try:
        with socket.create_connection((host, int(port)), timeout_s) as plain, \
                context.wrap_socket(plain, server_hostname=host) as wire:
            shown: Any = wire if hasattr(wire, "get_unverified_chain") else getattr(wire, "_sslobj")
            chain = shown.get_unverified_chain()  # public since Python 3.13
    except OSError as error:
        raise errors.DccastError("UNAVAILABLE", f"no answer from {address}: {error}",
                                 remedy="is the address right, and does dccastd run there?") from None
    return [ssl.DER_cert_to_PEM_cert(each) if isinstance(each, bytes) else each.public_bytes()
            for each in chain]


def _ca_with(fingerprint: str, address: str, timeout_s: float) -> str:
    """The certificate with this SHA-256 among those that the server shows, as PEM."""
    for pem in _shown_certificates(address, timeout_s):
        if hashlib.sha256(ssl.PEM_cert_to_DER_cert(pem)).hexdigest() == fingerprint:
            return pem
    raise errors.DccastError(
        "UNAUTHENTICATED", f"the server at {address} does not show the CA with the fingerprint of the "
        "line: it is another server, or some program in between",
        remedy="do not go on; ask the admin who gave you the line")


def _store(file: pathlib.Path, login: dict[str, str], default: bool) -> None:
    """Adds a login, or replaces the one of its name. The file is replaced as a whole, and others can
    never read it."""
    logins = stored_logins(file.parent)
    is_first = default or not logins or logins[0].get("name") == login["name"]
    others = [each for each in logins if each.get("name") != login["name"]]
    text = "# Written by dccast login; with its tokens anyone can call as you.\n"
    for each in [login, *others] if is_first else [*others, login]:
        # A JSON string without escapes beyond ASCII is one of TOML.
        text += "\n[[server]]\n" + "".join(f"{key} = {json.dumps(each[key], ensure_ascii=False)}\n"
                                           for key in KEYS if each.get(key))

    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(file.name + ".part")
    part.unlink(missing_ok=True)
    with os.fdopen(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as out:
        out.write(text.encode())
        out.flush()
        os.fsync(out.fileno())
    os.replace(part, file)


def login(line: str, name: str = "", *, default: bool = False, timeout_s: float = DEADLINE_S) -> Service:
    """Logs in to a server of another machine with the line of `dccastd user add`, and stores the login
    where `dccast login` does. The fingerprint of the line is compared before anything is sent.

    @param name  for connect(name); else that of the host
    @param default  make it the server of connect()
    @raises DccastError  UNAUTHENTICATED: another server, or a line that was used or is too old

    >>> dccast.login("casthouse:7118/sha256:...")
    Traceback (most recent call last):
    dccast.errors.DccastError: this is not the line of `dccastd user add`
    """
    read = _read_line(line)
    settings = settings_folder()
    stored_logins(settings)  # a file that cannot be read is found before the line is used up
    ca = _ca_with(read.fingerprint, read.address, timeout_s)

    # Not repeated: the secret is good once.
    request = service_pb2.EnrolRequest(secret=read.secret, machine=socket.gethostname())
    answer = Transport(Endpoint(read.address, ca=ca), timeout_s).call("Enrol", request, repeat=False)
    _store(settings / "servers.toml",
           {"name": name or host_and_port(read.address)[0], "address": read.address, "user": answer.user.name,
            "token": answer.token, "expires": str(answer.user.expire_time.seconds), "ca": ca}, default)
    return Service(Transport(Endpoint(read.address, ca=ca, token=answer.token), timeout_s))
