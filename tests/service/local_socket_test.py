#!/usr/bin/python3
"""Where local clients find a daemon without being told: its Unix socket; and the file that names its address."""
import ctypes
import os
import platform
import pwd
import shutil
import socket
import struct
import subprocess
import tempfile
import unittest
import unittest.mock

from support import BIN, Daemon, ServiceTest, connected, fake_case, main

CASE_TITLE = "steps=1"
USER = 61000 + os.getpid() % 4000  # that no one has


def forget_places(test):
    """Takes out of the environment, for this test, what says where sockets and servers are."""
    environment = unittest.mock.patch.dict(os.environ)
    environment.start()
    test.addCleanup(environment.stop)
    for name in ("XDG_RUNTIME_DIR", "RUNTIME_DIRECTORY", "DCCAST_SERVER", "DCCAST_CONFIG"):
        os.environ.pop(name, None)


class LocalSocket(ServiceTest):
    """A daemon whose settings name no address."""
    settings = {"listen__socket": ""}

    def setUp(self):
        forget_places(self)
        runtime = tempfile.mkdtemp(prefix="dccast-", dir="/tmp")
        self.addCleanup(shutil.rmtree, runtime)
        os.environ["XDG_RUNTIME_DIR"] = runtime
        self.path = os.path.join(runtime, "dccastd.sock")
        super().setUp()

    def dccast(self, *words):
        environment = {"HOME": self.folder, "PATH": os.environ["PATH"],
                       "XDG_RUNTIME_DIR": os.environ["XDG_RUNTIME_DIR"]}
        return subprocess.run([os.path.join(BIN, "dccast"), *words], capture_output=True, text=True,
                              timeout=60, check=False, env=environment)

    def test_local_clients_use_the_socket_of_their_user(self):
        path = self.path
        self.assertEqual(self.daemon.address, f"unix:{path}")
        job = self.client.submit(fake_case(CASE_TITLE))
        listed = self.dccast("list", "--json")
        self.assertIn(job.id, listed.stdout, listed.stderr)
        examined = self.dccast("doctor")
        self.assertEqual(examined.returncode, 0, examined.stdout)
        self.assertIn(f"unix:{path}", examined.stdout)
        python = subprocess.run(
            ["/usr/bin/python3", "-c", "import dccast; print(dccast.connect().server)"],
            capture_output=True, text=True, timeout=30, check=True,
            env={**os.environ, "HOME": self.folder})
        self.assertEqual(python.stdout.strip(), f"unix:{path}")

        self.assertEqual(self.daemon.terminate(), 0)
        self.assertFalse(os.path.exists(path))

    def test_a_second_daemon_leaves_the_socket_to_the_first(self):
        job = self.client.submit(fake_case(CASE_TITLE))
        folder = self.in_folder("second")
        os.mkdir(folder)
        with self.assertRaises(RuntimeError) as refused:
            Daemon(folder, listen__socket="").start()
        self.assertIn(f"cannot listen on unix:{self.path}", str(refused.exception))
        self.assertIn("is another dccastd there?", str(refused.exception))
        self.assertIn(job.id, self.dccast("list", "--json").stdout)  # it is still there

    def test_doctor_says_why_a_socket_does_not_answer(self):
        self.daemon.kill()
        left = self.dccast("doctor", f"unix:{self.path}")
        self.assertEqual(left.returncode, 4)
        self.assertIn("no program listens at the socket", left.stdout)
        self.assertIn("start dccastd again", left.stdout)
        self.assertIn("there is no socket at", self.dccast("doctor", f"unix:{self.path}.no").stdout)

        self.restart()  # takes the place of the socket that was left
        self.assertEqual(self.dccast("doctor").returncode, 0)

    def test_a_path_that_is_too_long_is_refused_with_the_remedy(self):
        self.daemon.terminate()
        os.environ["XDG_RUNTIME_DIR"] = self.in_folder("x" * 120)
        with self.assertRaises(RuntimeError) as refused:
            self.daemon.start()
        self.assertIn("1 to 107 bytes", str(refused.exception))
        self.assertIn("listen.socket", str(refused.exception))

    def test_an_address_of_earlier_versions_is_answered_with_the_remedy(self):
        said = self.dccast("--server", "127.0.0.1:7117", "list")
        self.assertEqual(said.returncode, 4)
        self.assertIn("there is no login for 127.0.0.1:7117", said.stderr)
        self.assertIn("Local users give no --server", said.stderr)


def without_netlink():
    """Kills this process with its first netlink socket: a filter as seccomp(2) takes it."""
    load, is_equal, ret = 0x20, 0x15, 0x06
    kill_process, allow = 0x80000000, 0x7FFF0000
    socket_call, af_netlink = 41, 16  # of x86-64
    program = b"".join(struct.pack("HBBI", *line) for line in (
        (load, 0, 0, 0), (is_equal, 0, 3, socket_call),
        (load, 0, 0, 16), (is_equal, 0, 1, af_netlink),
        (ret, 0, 0, kill_process), (ret, 0, 0, allow)))
    content = ctypes.create_string_buffer(program, len(program))
    pr_set_no_new_privs, pr_set_seccomp, filter_mode = 38, 22, 2
    described = ctypes.create_string_buffer(
        struct.pack("HxxxxxxP", len(program) // 8, ctypes.addressof(content)))
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(pr_set_no_new_privs, 1, 0, 0, 0) != 0 or \
            libc.prctl(pr_set_seccomp, filter_mode, described, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "seccomp")


@unittest.skipUnless(platform.machine() == "x86_64", "the numbers of calls are those of x86-64")
class NoNetlink(ServiceTest):
    settings = {"listen__tls": "127.0.0.1:0"}
    before_exec = staticmethod(without_netlink)

    def test_no_netlink_socket_is_opened(self):
        who = self.client.ask("WhoAmI")
        self.assertEqual(who.name, pwd.getpwuid(os.getuid()).pw_name)
        with connected(self.daemon.tls_address):
            pass
        self.client.ask("WhoAmI")
        self.assertTrue(self.daemon.running())


@unittest.skipUnless(os.getuid() == 0, "root alone starts programs of other users")
class WithoutRuntimeDirectory(ServiceTest):
    """A daemon of another user, who has no runtime directory and sets nothing."""
    settings = {"listen__socket": ""}

    @staticmethod
    def before_exec():
        os.setgroups([])
        os.setgid(USER)
        os.setuid(USER)

    def setUp(self):
        forget_places(self)
        self.place = f"/tmp/dccast-{USER}"
        shutil.rmtree(self.place, ignore_errors=True)
        self.addCleanup(shutil.rmtree, self.place, ignore_errors=True)
        self.folder = tempfile.mkdtemp(prefix="dccast-service-", dir="/tmp")
        os.chown(self.folder, USER, USER)
        self.daemon = Daemon(self.folder, before_exec=self.before_exec, **self.settings)
        self.clients = []

    def dccast(self, *words, user=USER):
        return subprocess.run(
            ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups",
             os.path.join(BIN, "dccast"), *words], capture_output=True, text=True, timeout=60,
            check=False, env={"HOME": "/nonexistent", "PATH": os.environ["PATH"]})

    def test_the_users_client_finds_it_and_others_are_refused(self):
        self.daemon.start()
        self.assertEqual(self.daemon.address, f"unix:{self.place}/dccastd.sock")
        who = self.dccast("whoami")
        self.assertEqual(who.returncode, 0, who.stderr)
        self.assertIn(str(USER), who.stdout)
        stranger = self.dccast("--server", self.daemon.address, "whoami", user=USER + 1)
        self.assertEqual(stranger.returncode, 4, stranger.stdout)
        self.assertEqual(self.daemon.terminate(), 0)

    def test_a_folder_that_another_user_has_made_is_not_used(self):
        os.mkdir(self.place, 0o777)  # of root
        with self.assertRaises(RuntimeError) as refused:
            self.daemon.start()
        self.assertIn(f"{self.place} is not a folder that this user alone may write to",
                      str(refused.exception))
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(os.path.join(self.place, "dccastd.sock"))
            os.chmod(listener.getsockname(), 0o777)
            listener.listen()
            self.assertNotIn(self.place, self.dccast("info").stderr)


class PortFile(ServiceTest):
    def test_it_names_the_address_and_goes_with_the_daemon(self):
        with open(self.daemon.port_file, encoding="ascii") as file:
            self.assertEqual(file.read().splitlines(), [self.daemon.address])
        self.daemon.terminate()
        self.assertFalse(os.path.exists(self.daemon.port_file))

    def test_a_link_at_its_temporary_name_is_not_followed(self):
        self.daemon.terminate()
        victim = self.write_file("victim", "as before")
        os.symlink(victim, self.daemon.port_file + ".tmp")
        self.restart()
        with open(victim, encoding="ascii") as file:
            self.assertEqual(file.read(), "as before")
        self.client.submit(fake_case(CASE_TITLE))


if __name__ == "__main__":
    main()
