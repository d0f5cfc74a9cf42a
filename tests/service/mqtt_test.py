#!/usr/bin/python3
"""A casting whose readings come from a topic of a real broker, and whose alarms go to one."""
import json
import os
import socket
import subprocess

import numpy

from dccast.v1 import study_pb2
from certificates import TestCa
from follow_test import END, FollowTest, levers, table
from mqtt_client import MqttClient
from real_run_test import physics
from support import main
from waiting import WAIT_FACTOR, until

USER, PASSWORD = "logger", "a secret"


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Broker:
    """A mosquitto on loopback that admits one user."""

    def __init__(self, folder, *settings):
        self.port = free_port()
        self.settings = os.path.join(folder, "mosquitto.conf")
        passwords = os.path.join(folder, "passwords")
        with open(passwords, "w", encoding="ascii"):
            os.chmod(passwords, 0o600)
        subprocess.run(["mosquitto_passwd", "-b", passwords, USER, PASSWORD], check=True, timeout=20)
        owner = "root" if os.geteuid() == 0 else ""
        with open(self.settings, "w", encoding="utf-8") as file:
            lines = [f"listener {self.port} 127.0.0.1", "allow_anonymous false",
                     f"password_file {passwords}", *settings]
            lines += [f"user {owner}"] if owner else []
            file.write("\n".join(lines) + "\n")
        self.start()

    def start(self):
        self.process = subprocess.Popen(["mosquitto", "-c", self.settings], stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        until(self.answers, 10)

    def answers(self):
        with socket.socket() as one:
            return one.connect_ex(("127.0.0.1", self.port)) == 0

    def stop(self):
        self.process.kill()
        self.process.wait()

    def client(self, ca=None):
        return MqttClient(self.port, USER, PASSWORD, ca)

    def publish(self, topic, lines, retain=False, ca=None):
        """One message for each line."""
        with self.client(ca) as client:
            for line in lines:
                client.publish(topic, line, retain)


def objects(begin=-60, end=END):
    lines = []
    for t in range(begin, end + 1):
        speed, water, metal = levers(t)
        lines.append(json.dumps({"time [s]": t, "speed [mm/min]": speed * 6e4,
                                 "water [l/min/m]": water * 6e4, "metal [degC]": metal}))
    return lines


class MqttTest(FollowTest):
    def setUp(self):
        super().setUp()
        self.broker = Broker(self.folder)

    def tearDown(self):
        self.broker.stop()
        super().tearDown()

    def login(self, mode=0o600, **texts):
        texts = texts or {"user": USER, "password": PASSWORD}
        path = self.in_folder("broker.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.writelines(f"{key} = {json.dumps(text)}\n" for key, text in texts.items())
        os.chmod(path, mode)
        return path

    def start(self, *words, topic="pit3/readings", scheme="mqtt"):
        """`dccast follow` of the topic, which waits for the first reading."""
        with open(self.in_folder("said"), "w", encoding="utf-8") as err:
            process = subprocess.Popen(
                [*self.dccast_words("follow", self.case_file(), "--set", "quality=draft", "--readings",
                                    f"{scheme}://127.0.0.1:{self.broker.port}/{topic}"), *words],
                stdout=subprocess.DEVNULL, stderr=err)
        until(lambda: "waiting for those of" in self.said() or process.poll() is not None, 20)
        return process

    def said(self):
        with open(self.in_folder("said"), encoding="utf-8") as file:
            return file.read()

    def dccast_words(self, *words):
        return [os.path.join(os.environ["DCCAST_BIN"], "dccast"), "--server", self.daemon.address, *words]

    def ends(self, process, code=0):
        self.assertEqual(process.wait(timeout=60 * WAIT_FACTOR), code, self.said())

    def newest_job(self):
        return self.client.ask("ListJobs").jobs[0].id


class Readings(MqttTest):
    def test_a_topic_gives_what_a_table_gives(self):
        path = self.write_file("table.csv", table())
        self.ended(self.dccast("follow", self.case_file(), "--set", "quality=draft", "--readings", path))
        expected = physics(self.steps_at_end(self.newest_job()))

        # What the broker kept of the last casting is none of this one.
        self.broker.publish("pit3/readings", ['{"time [s]": 500, "speed [mm/min]": 1}'], retain=True)
        process = self.start("--broker", self.login())
        self.broker.publish("pit3/other", ['{"time [s]": 600, "speed [mm/min]": 1}'])
        self.broker.publish("pit3/readings", ["x" * 3_000_000])
        self.broker.publish("pit3/readings", objects())
        self.ends(process)
        self.assertIn("left out: longer than 65536 bytes", self.said())
        self.assertEqual(physics(self.steps_at_end(self.newest_job())), expected)

    def test_a_broker_that_comes_back_is_read_again(self):
        process = self.start("--broker", self.login())
        self.broker.publish("pit3/readings", objects(end=-20))
        until(lambda: "follows the casting" in self.said(), 20)
        job_id = self.newest_job()
        self.until_time(job_id, -25)

        self.broker.stop()
        until(lambda: "is away" in self.said(), 20)
        self.broker.start()
        until(lambda: "is there again" in self.said(), 30)
        self.broker.publish("pit3/readings", objects(begin=-19))
        self.ends(process)
        self.assertEqual(self.append(job_id).number, len(objects()))

    def test_what_is_wrong_with_topic_and_login_is_said_before_a_job_is_made(self):
        process = self.start("--broker", self.login(user=USER, password="wrong"))
        self.ends(process, code=4)
        self.assertRegex(self.said(), "refuses: Not authorized; see the login in the file of --broker")
        self.ends(self.start("--broker", self.login(mode=0o644)), code=2)
        self.assertIn("chmod 600", self.said())
        self.ends(self.start("--broker", self.login(passwort="x")), code=2)
        self.assertIn("passwort: permitted: texts with the keys user, password", self.said())
        self.ends(self.start(topic=""), code=2)
        self.assertIn("the topic is missing", self.said())

        self.broker.stop()
        self.ends(self.start("--broker", self.login()), code=4)
        self.assertIn("does not answer: Connection refused", self.said())
        self.assertFalse(self.client.ask("ListJobs").jobs)


class Tls(MqttTest):
    def setUp(self):
        FollowTest.setUp(self)
        self.ca = TestCa(self.folder)
        certificate = self.ca.issue()
        self.broker = Broker(self.folder, f"cafile {self.ca.certificate}", f"certfile {certificate}",
                             f"keyfile {self.ca.key}")

    def test_the_broker_is_known_by_its_certificate(self):
        own = self.login(user=USER, password=PASSWORD, ca=self.ca.certificate)
        process = self.start("--broker", own, scheme="mqtts")
        self.broker.publish("pit3/readings", objects(), ca=self.ca.certificate)
        self.ends(process)

        # The authorities of the machine do not know it.
        self.ends(self.start("--broker", self.login(), scheme="mqtts"), code=4)
        self.assertIn("does not answer", self.said())


class Alarms(MqttTest):
    def test_a_gauge_that_slips_reaches_a_command_and_a_topic(self):
        ensemble = self.ensemble()
        request = study_pb2.EvaluateStudyRequest(id=ensemble, curves=True)
        curve = next(each for each in self.client.stub.EvaluateStudy(request, timeout=30).runs[0].curves
                     if each.monitor == "corner")

        path, told = (self.in_folder(name) for name in ("curls.csv", "told"))
        with open(path, "w", encoding="utf-8") as file:
            file.write("time [s], curl corner [mm]\n")
            for t in range(0, END):
                slip = 15 if t >= 25 else 0
                curl = 1e3 * numpy.interp(t, curve.time_s, numpy.nan_to_num(curve.curl_m)) + slip
                file.write(f"{t}, {curl}\n")
        with self.broker.client() as listener, self.broker.client() as display:
            listener.subscribe("pit3/alarms")
            display.subscribe("pit3/forecasts")
            _, err = self.ended(self.dccast(
                "follow", self.case_file(), "--set", "quality=draft", "--readings", path, "--ensemble",
                ensemble, "--noise", "0.5 mm", "--broker", self.login(), "--alarms",
                f"mqtt://127.0.0.1:{self.broker.port}/pit3/alarms", "--forecasts",
                f"mqtt://127.0.0.1:{self.broker.port}/pit3/forecasts", "--notify",
                f'echo "$DCCAST_JOB: $DCCAST_ALARM" >> {told}'))
            heard = {}
            while "warning" not in heard:  # a finding may come before it
                heard = json.loads(listener.receive())
            shown = json.loads(display.receive())

        job_id = self.newest_job()
        self.assertRegex(err, r"warning at 2\d s, corner: .*; likeliest: .*gauge")
        self.assertRegex(err, r"forecast at \d+ s: corner .* mm at the end \(")
        self.assertEqual(heard["job"], job_id)
        self.assertEqual(heard["warning"]["monitor"], "corner")
        self.assertEqual(shown["job"], job_id)
        corner = shown["corner"]
        for when in ("soon", "end"):
            self.assertLess(corner[f"{when}_lower_mm"], corner[f"{when}_mm"])
            self.assertLess(corner[f"{when}_mm"], corner[f"{when}_upper_mm"])
        self.assertLessEqual(corner["soon_s"], corner["end_s"])
        with open(told, encoding="utf-8") as file:
            lines = file.read().splitlines()
        self.assertIn(f"{job_id}: {heard['alarm']}", lines)
        self.assertEqual(len(lines), len(set(lines)), "each once")


if __name__ == "__main__":
    main()
