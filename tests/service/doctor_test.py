"""dccast login, logout, whoami and doctor: each cause has its sentence and its remedy."""
import contextlib
import os
import re
import shutil
import socket
import ssl
import stat
import subprocess
import tempfile
import threading
import unittest

from certificates import TestCa
from support import BIN, Daemon, ServiceTest
from waiting import until


class ClientTest(ServiceTest):
    """The command `dccast` with settings of its own, and a daemon where one is needed."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="dccast-service-")
        self.daemon = Daemon(self.folder, listen__tls="127.0.0.2:0")
        self.clients = []

    def start(self, **settings):
        self.daemon.settings.update(settings)
        self.daemon.start()

    def dccast(self, *words, given="", **environment):
        return subprocess.run(
            [os.path.join(BIN, "dccast"), *words], input=given, capture_output=True, text=True,
            timeout=60, check=False,
            env={"XDG_CONFIG_HOME": self.in_folder("settings"), "PATH": os.environ["PATH"],
                 **environment})

    def admin(self, *words):
        command = [os.path.join(BIN, "dccastd"), *words, "--set",
                   f"data_directory={self.daemon.settings['data_directory']}", "--set",
                   f"listen.public_address={self.daemon.tls_address}", "--set", "listen.tls=127.0.0.2:1"]
        return subprocess.run(command, capture_output=True, text=True, timeout=30, check=True).stdout

    def line_for(self, name, role="submitter"):
        return re.search(r"dccast login (\S+)", self.admin("user", "add", name, "--role", role))[1]

    def log_in(self, name, role="submitter", *words):
        done = self.dccast("login", *words, given=self.line_for(name, role) + "\n")
        self.assertEqual(done.returncode, 0, done.stderr)

    def servers_file(self):
        return self.in_folder("settings", "dccast", "servers.toml")

    def doctor(self, *words, cause, remedy, **environment):
        """The one sentence about the cause and the one remedy hold these texts."""
        done = self.dccast("doctor", *words, **environment)
        self.assertEqual(done.returncode, 4, done.stdout + done.stderr)
        lines = [line for line in done.stdout.splitlines() if not line.startswith("ok ")]
        self.assertEqual([line.split()[0] for line in lines], ["cause", "remedy"], done.stdout)
        self.assertIn(cause, lines[0])
        self.assertIn(remedy, lines[1])


class Login(ClientTest):
    def test_two_commands(self):
        self.start()
        self.log_in("anna")
        self.assertEqual(stat.S_IMODE(os.stat(self.servers_file()).st_mode), 0o600)
        who = self.dccast("whoami")
        self.assertIn(f"anna on {self.daemon.tls_address}, submitter, by token until", who.stdout)
        self.assertEqual(self.dccast("list").returncode, 0)
        self.assertEqual(self.dccast("--server", "127.0.0.2", "list").returncode, 0)
        self.assertEqual(self.dccast("doctor").returncode, 0)
        self.assertEqual(self.dccast("logout").returncode, 0)
        self.assertNotIn("token", self.admin("user", "list"))
        self.assertEqual(self.dccast("--server", self.daemon.tls_address, "list").returncode, 4)

    def test_queries_side_by_side_go_by_the_login(self):
        self.start()
        self.log_in("anna")
        for name, speed in (("a", "50"), ("b", "60")):
            case = self.dccast("new", "start-2d-thickness").stdout
            case = re.sub(r"(?m)^title = .*$", f'title = "steps=3 {name}"', case)
            self.write_file(name + ".toml", re.sub(r"(?m)^casting_speed = .*$",
                            f'casting_speed = "{speed} mm/min"', case))
        done = self.dccast("compare", *(self.in_folder(name + ".toml") for name in "ab"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("corner", done.stdout)

    def test_several_servers_have_names_and_one_is_the_default(self):
        self.start()
        self.log_in("anna")
        self.log_in("bert", "viewer", "--name", "north")
        self.assertTrue(self.dccast("whoami").stdout.startswith("anna on"))
        self.assertTrue(self.dccast("--server", "north", "whoami").stdout.startswith("bert on"))
        self.log_in("carl", "viewer", "--name", "south", "--default")
        self.assertTrue(self.dccast("whoami").stdout.startswith("carl on"))
        self.assertEqual(self.dccast("--server", "north", "logout").returncode, 0)
        self.assertTrue(self.dccast("whoami").stdout.startswith("carl on"))

    def test_a_wrong_fingerprint_ends_it_before_the_secret_is_sent(self):
        self.start()
        line = self.line_for("anna")
        wrong = re.sub(r"sha256:\w{4}", "sha256:0000", line)
        done = self.dccast("login", wrong)
        self.assertEqual(done.returncode, 4)
        self.assertIn("does not show the CA with the fingerprint", done.stderr)
        self.assertFalse(os.path.exists(self.servers_file()))
        self.assertEqual(self.dccast("login", line).returncode, 0)  # the secret is still good

    def test_a_line_is_good_once(self):
        self.start()
        line = self.line_for("anna")
        self.assertEqual(self.dccast("login", line).returncode, 0)
        again = self.dccast("login", line)
        self.assertEqual(again.returncode, 5)
        self.assertIn("used before", again.stderr)

    def test_what_is_no_line_is_refused(self):
        for text in ("", "casthouse:7118", "casthouse/sha256:12/x", "\x1b[2J" * 20):
            done = self.dccast("login", given=text)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertNotIn("\x1b", done.stderr)

    def test_a_file_that_others_may_read_is_not_used(self):
        self.start()
        self.log_in("anna")
        os.chmod(self.servers_file(), 0o644)
        done = self.dccast("list")
        self.assertEqual(done.returncode, 2)
        self.assertIn("chmod 600", done.stderr)

    def test_no_case_goes_beyond_loopback_without_tls(self):
        done = self.dccast("--server", "192.0.2.1:7117", "list")
        self.assertEqual(done.returncode, 4)
        self.assertIn("there is no login for 192.0.2.1:7117", done.stderr)


class Doctor(ClientTest):
    def test_addresses(self):
        self.doctor("https://casthouse:7118", cause="https://", remedy="casthouse:7118")
        self.doctor("casthouse", cause="no port", remedy="casthouse:7118")
        self.doctor("no-such-host.invalid:7118", cause="cannot be resolved", remedy="spelling")

    def test_a_port_where_no_program_listens(self):
        with self.listening() as closed:
            address = "127.0.0.1:%d" % closed.getsockname()[1]
        self.doctor(address, cause="no program listens", remedy="start dccastd")
        self.doctor(address, cause="https_proxy=http://proxy:3128", remedy="--server ssh://127.0.0.1",
                    https_proxy="http://proxy:3128")

    def test_a_firewall_that_drops(self):
        # A full backlog drops what comes, as a firewall does.
        with self.listening(0) as full, contextlib.ExitStack() as filled:
            for _ in range(4):
                one = filled.enter_context(socket.socket())
                one.setblocking(False)
                one.connect_ex(full.getsockname())
            self.doctor("127.0.0.1:%d" % full.getsockname()[1], "--timeout", "1",
                        cause="a firewall drops", remedy="to be opened")

    def test_tls_on_one_side_alone(self):
        self.start()
        self.doctor(self.daemon.tls_address, cause="no login", remedy="dccast login")
        # gRPC sees no more than a reset: the message leads to what finds the cause.
        self.assertIn(f"dccast doctor {self.daemon.tls_address}",
                      self.dccast("--server", self.daemon.tls_address, "list").stderr)
        self.log_in("anna")

        def answer(connection):
            with contextlib.suppress(ConnectionResetError):
                connection.recv(1000)
            connection.sendall(bytes([0, 0, 0, 4, 0, 0, 0, 0, 0]))  # settings of HTTP/2
        with self.serving(answer) as address:
            self.edit("address", address)
            self.doctor(cause="speaks no TLS", remedy="listen.tls")

    def test_a_web_server(self):
        def answer(connection):
            connection.recv(1000)
            connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")
        with self.serving(answer) as address:
            self.doctor(address, cause="a web server", remedy="port of listen.tls")

    def test_a_server_that_says_nothing(self):
        with self.serving(lambda connection: None) as address:
            self.doctor(address, cause="without an answer", remedy="try again later")

    def test_what_holds_the_workers(self):
        """A kernel without Landlock is named there, with what the workers can reach then."""
        self.start()
        self.log_in("anna")
        ended = self.dccast("doctor")
        self.assertEqual(ended.returncode, 0, ended.stdout)
        self.assertIn("its workers are held by: no network", ended.stdout)
        self.assertIn("(Landlock", ended.stdout)

    def test_tokens_and_roles(self):
        self.start()
        self.log_in("anna", "viewer")
        self.doctor("--role", "submitter", cause="the role of anna is viewer",
                    remedy="dccastd user role anna submitter")
        self.admin("user", "disable", "anna")
        self.doctor(cause="anna is disabled; an admin can undo it: dccastd user enable anna",
                    remedy="do as the cause says")
        self.admin("user", "enable", "anna")
        self.admin("user", "rotate", "anna")
        self.doctor(cause="token is unknown", remedy="log in again")

    def test_a_token_that_has_expired(self):
        self.start(access__token_lifetime="1 s")
        self.log_in("anna")
        until(lambda: "expired" in self.dccast("doctor").stdout, 10)
        self.doctor(cause="has expired", remedy="log in again")

    def test_an_unknown_ca(self):
        self.start()
        self.log_in("anna")
        self.daemon.terminate()
        shutil.rmtree(os.path.join(self.daemon.settings["data_directory"], "pki"))
        self.daemon.settings["listen__tls"] = self.daemon.tls_address
        self.start()
        self.doctor(cause="CA that is unknown", remedy="new line")

    def test_names_and_dates_of_certificates(self):
        self.ca = TestCa(self.folder)
        self.write_login("127.0.0.1:1")
        for what, cause, remedy in (
                (dict(name="DNS:casthouse"), "not for 127.0.0.1, but for casthouse", "renew --name"),
                (dict(begins="20200101000000Z", ends="20200201000000Z"), "has expired on 2020-02-01",
                 "renew"),
                (dict(begins="20700101000000Z", ends="20710101000000Z"), "not yet valid", "clock"),
                ({}, "not HTTP/2", "listen.tls")):
            with self.subTest(cause=cause), self.serving_tls(self.ca.issue(**what)) as address:
                self.edit("address", address)
                self.doctor(cause=cause, remedy=remedy)

    # A server of this test's own.

    @contextlib.contextmanager
    def listening(self, backlog=8):
        with socket.socket() as listener:
            listener.bind(("127.0.0.1", 0))
            listener.listen(backlog)
            yield listener

    @contextlib.contextmanager
    def serving(self, answer):
        with self.listening() as listener:
            def serve():
                while True:
                    try:
                        connection, _ = listener.accept()
                    except OSError:
                        return
                    with connection, contextlib.suppress(OSError):
                        connection.settimeout(5)
                        answer(connection)
            thread = threading.Thread(target=serve)
            thread.start()
            try:
                yield "127.0.0.1:%d" % listener.getsockname()[1]
            finally:
                listener.shutdown(socket.SHUT_RDWR)
                thread.join()

    def serving_tls(self, certificate):
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, self.ca.key)

        def answer(connection):
            with context.wrap_socket(connection, server_side=True) as session:
                session.recv(1)
        return self.serving(answer)

    def write_login(self, address):
        os.makedirs(os.path.dirname(self.servers_file()))
        with open(self.ca.certificate, encoding="ascii") as file:
            ca = file.read()
        descriptor = os.open(self.servers_file(), os.O_WRONLY | os.O_CREAT, 0o600)
        with open(descriptor, "w", encoding="ascii") as file:
            file.write(f"[[server]]\nname='x'\naddress='{address}'\ntoken='x'\nca='''{ca}'''\n")

    def edit(self, key, value):
        with open(self.servers_file(), encoding="utf-8") as file:
            text = file.read()
        with open(self.servers_file(), "w", encoding="utf-8") as file:
            file.write(re.sub(rf"(?m)^{key} ?= ?'.*'$", f"{key} = '{value}'", text))


if __name__ == "__main__":
    unittest.main()
