#!/usr/bin/python3
"""Where local clients find a daemon without being told: its Unix socket; and the file that names its address."""
import os
import subprocess
import unittest.mock

from support import BIN, Daemon, ServiceTest, fake_case, main

CASE_TITLE = "steps=1"


class LocalSocket(ServiceTest):
    def setUp(self):
        environment = unittest.mock.patch.dict(os.environ)
        environment.start()
        self.addCleanup(environment.stop)
        for name in ("XDG_RUNTIME_DIR", "RUNTIME_DIRECTORY", "DCCAST_SERVER", "DCCAST_CONFIG"):
            os.environ.pop(name, None)
        super().setUp()

    def in_runtime_directory(self):
        """Starts the daemon again as one of a user with a runtime directory. Returns its socket."""
        os.environ["XDG_RUNTIME_DIR"] = os.path.join(self.folder, "run")
        os.mkdir(os.environ["XDG_RUNTIME_DIR"], 0o700)
        self.daemon.terminate()
        self.restart()
        return os.path.join(os.environ["XDG_RUNTIME_DIR"], "dccastd.sock")

    def dccast(self, *words):
        environment = {"HOME": self.folder, "PATH": os.environ["PATH"],
                       "XDG_RUNTIME_DIR": os.environ["XDG_RUNTIME_DIR"]}
        return subprocess.run([os.path.join(BIN, "dccast"), *words], capture_output=True, text=True,
                              timeout=60, check=False, env=environment)

    def test_local_clients_use_the_socket_of_their_user(self):
        path = self.in_runtime_directory()
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
        self.in_runtime_directory()
        job = self.client.submit(fake_case(CASE_TITLE))
        folder = os.path.join(self.folder, "second")
        os.mkdir(folder)
        second = Daemon(folder).start()
        try:
            self.assertIn("another program listens", second.said())
            self.assertIn(job.id, self.dccast("list", "--json").stdout)
        finally:
            second.terminate()
        self.assertIn(job.id, self.dccast("list", "--json").stdout)  # it is still there

    def test_doctor_says_why_a_socket_does_not_answer(self):
        path = self.in_runtime_directory()
        self.daemon.kill()
        left = self.dccast("doctor", f"unix:{path}")
        self.assertEqual(left.returncode, 4)
        self.assertIn("no program listens at the socket", left.stdout)
        self.assertIn("start dccastd again", left.stdout)
        self.assertIn("there is no socket at", self.dccast("doctor", f"unix:{path}.no").stdout)

        self.restart()  # takes the place of the socket that was left
        self.assertEqual(self.dccast("doctor").returncode, 0)

    def test_without_a_runtime_directory_there_is_no_socket_and_a_long_one_does_no_harm(self):
        self.assertNotIn("unix:", self.daemon.said())
        os.environ["XDG_RUNTIME_DIR"] = os.path.join(self.folder, "x" * 120)
        os.mkdir(os.environ["XDG_RUNTIME_DIR"])
        self.daemon.terminate()
        self.restart()
        self.assertEqual(os.listdir(os.environ["XDG_RUNTIME_DIR"]), [])


class PortFile(ServiceTest):
    def test_it_names_the_address_and_goes_with_the_daemon(self):
        with open(self.daemon.port_file, encoding="ascii") as file:
            self.assertEqual(file.read().splitlines(), [self.daemon.address])
        self.daemon.terminate()
        self.assertFalse(os.path.exists(self.daemon.port_file))

    def test_a_link_at_its_temporary_name_is_not_followed(self):
        self.daemon.terminate()
        victim = os.path.join(self.folder, "victim")
        with open(victim, "w", encoding="ascii") as file:
            file.write("as before")
        os.symlink(victim, self.daemon.port_file + ".tmp")
        self.restart()
        with open(victim, encoding="ascii") as file:
            self.assertEqual(file.read(), "as before")
        self.client.submit(fake_case(CASE_TITLE))


if __name__ == "__main__":
    main()
