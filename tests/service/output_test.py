#!/usr/bin/python3
"""Where a command of the client writes, and what it says: a full disk, a folder, a device, a link in
the way, a formula in a name, a server given without its port."""
import concurrent.futures
import contextlib
import csv
import io
import json
import os
import pty
import re
import shutil
import subprocess
import threading

import grpc

from dccast.v1 import job_pb2, service_pb2
from support import BIN, TERMINAL, ServiceTest, fake_case, main

CASES = os.path.join(os.path.dirname(__file__), "..", "..", "cases")
CONFIG = os.path.join(os.path.dirname(__file__), "..", "..", "deploy", "config", "dccastd.toml")


class Commands(ServiceTest):
    def dccast(self, *words, code=0, address=None, environment=None, **rest):
        process = subprocess.run(
            [os.path.join(BIN, "dccast"), "--server", address or self.daemon.address, *words],
            stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=self.folder,
            timeout=120, check=False, env={**os.environ, **(environment or {})},
            **{"stdout": subprocess.PIPE, **rest})
        self.assertEqual(process.returncode, code, process.stderr)
        return process

    def finished_job(self, title="steps=20", **rest):
        job = self.client.submit(fake_case(title, **rest))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        return job.id

    def here(self, name):
        return self.in_folder(name)

    def write_case(self, name, **changes):
        with open(os.path.join(CASES, "start-2d-thickness.toml"), encoding="utf-8") as file:
            text = file.read()
        for key, value in changes.items():
            text = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
        with open(self.here(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.here(name)


OVERWRITES = "\x1b]0;owned\x07\x1b[2J\x1b[1Aforged\r\x9b2J\u202e"


class HostileServer(grpc.GenericRpcHandler):
    """A server whose texts act on a terminal that is given them."""

    def service(self, handler_call_details):
        if handler_call_details.method.endswith("/GetServerInfo"):
            info = service_pb2.GetServerInfoResponse(version=OVERWRITES, build="build")
            return grpc.unary_unary_rpc_method_handler(lambda *_: info.SerializeToString())
        return grpc.unary_unary_rpc_method_handler(
            lambda _, context: context.abort(grpc.StatusCode.NOT_FOUND, "none " + OVERWRITES))


class Terminals(Commands):
    """What reaches a screen acts on it only where the client itself wants so."""

    def on_screen(self, *words, address=None):
        screen, terminal = pty.openpty()
        process = subprocess.Popen(
            [os.path.join(BIN, "dccast"), "--server", address or self.daemon.address, *words],
            stdin=subprocess.DEVNULL, stdout=terminal, stderr=terminal, cwd=self.folder)
        os.close(terminal)
        shown = b""
        with contextlib.suppress(OSError):  # at the end of the other side
            while part := os.read(screen, 65536):
                shown += part
        os.close(screen)
        process.wait(20)
        return shown.decode()

    def is_harmless(self, shown):
        self.assertEqual(re.findall(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", shown.replace("\r\n", "\n")),
                         [], shown)

    def test_a_case_file(self):
        path = self.write_case("case.toml")
        with open(path, encoding="utf-8") as file:
            text = file.read()
        # A comment may hold what TOML permits in none.
        hostile = ("# \x1b]0;owned\x07 is no TOML\n" + text).encode()
        with open(self.here("hostile.toml"), "wb") as file:
            file.write(hostile)
        self.is_harmless(self.on_screen("validate", "--local", "hostile.toml"))
        hostile = ("# \u202e turns what follows, \u2028 ends a line\n" + text).encode()
        with open(path, "wb") as file:
            file.write(hostile)
        job = self.dccast("submit", path).stdout.strip()
        self.client.until_state(job, *TERMINAL)
        shown = self.on_screen("case", job)
        self.is_harmless(shown)
        self.assertIn("\\u{202E} turns", shown)

        with open(self.here("same.toml"), "wb") as file:
            self.dccast("case", job, stdout=file)
        with open(self.here("same.toml"), "rb") as file:
            self.assertEqual(file.read(), hostile)

    def test_texts_of_a_server(self):
        server = grpc.server(concurrent.futures.ThreadPoolExecutor(2))
        server.add_generic_rpc_handlers((HostileServer(),))
        address = f"unix:{self.folder}/hostile"
        server.add_insecure_port(address)
        server.start()
        try:
            shown = self.on_screen("info", address=address)
            self.is_harmless(shown)
            self.assertIn("\\u{1B}]0;owned", shown)
            shown = self.on_screen("show", "00000000-0000-4000-8000-000000000000",
                                   address=address)
            self.is_harmless(shown)
            self.assertIn("forged", shown)
        finally:
            server.stop(None).wait(5)


class Output(Commands):
    # -- what cannot be written

    def test_output_that_does_not_fit_is_an_error_of_every_command(self):
        job = self.finished_job()
        for words in (["curl", "--csv", job], ["curl", job], ["curl", "--json", job],
                      ["list"], ["list", "--json"], ["show", job],
                      ["schema"], ["completion", "bash"], ["info"], ["new"], ["--help"]):
            with self.subTest(words=words), open("/dev/full", "w", encoding="ascii") as full:
                error = self.dccast(*words, code=7, stdout=full).stderr
                self.assertIn("standard output cannot be written: No space left", error)

    def test_output_into_a_closed_pipe_is_no_success(self):
        reading, writing = os.pipe()
        os.close(reading)
        command = subprocess.run([os.path.join(BIN, "dccast"), "schema"], stdout=writing, timeout=60,
                                 stderr=subprocess.PIPE, check=False, restore_signals=True)
        os.close(writing)
        # Like other programs of a pipeline: the signal ends it, and the shell shows 141.
        self.assertEqual(command.returncode, -13, command.stderr)

    def test_a_watch_ends_when_its_output_has_no_place(self):
        job = self.client.submit(fake_case("steps=100000 sleep_ms=5"))
        with open("/dev/full", "w", encoding="ascii") as full:
            self.dccast("watch", "--json", job.id, code=7, stdout=full)
        self.client.cancel(job.id)

    # -- fetch

    def test_fetch_refuses_what_is_no_file(self):
        job = self.finished_job()
        for place, word in (("", "a file or a folder"), ("-", "two files"),
                            ("/dev/null", "not a regular file"), ("x.xdmf", "HDF5"),
                            ("a:b.h5", "colon"), ("sub/c:.h5", "colon"), ("x\t.h5", "control"),
                            (" x.h5", "blank")):
            with self.subTest(place=place):
                self.assertIn(word, self.dccast("fetch", "-o", place, job, code=2).stderr)
        os.mkfifo(self.here("pipe"))
        self.dccast("fetch", "-f", "-o", "pipe", job, code=2)
        with open("/dev/null", encoding="ascii") as null:
            self.assertFalse(os.path.isfile("/dev/null"))
            self.assertEqual(null.read(), "")

    def test_fetch_does_not_write_through_a_link(self):
        job = self.finished_job()
        with open(self.here("victim"), "w", encoding="ascii") as file:
            file.write("mine")
        os.symlink(self.here("victim"), self.here("r.h5.part"))
        self.assertIn("symbolic link", self.dccast("fetch", "-o", "r.h5", job, code=5).stderr)
        with open(self.here("victim"), encoding="ascii") as file:
            self.assertEqual(file.read(), "mine")
        self.assertFalse(os.path.exists(self.here("r.h5")))

    # -- formats

    def test_a_name_in_a_csv_is_no_formula(self):
        case = fake_case("steps=5")
        case.monitor.add(name="=1+2", x_m=0.0, y_m=0.0)
        job = self.client.submit(case)
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        table = self.dccast("curl", "--csv", job.id).stdout
        for cell in next(csv.reader(io.StringIO(table))):
            self.assertNotRegex(cell, "^[=+@]")

    def test_the_number_of_a_swept_key_says_its_unit(self):
        case = self.write_case("case.toml", title='"steps=3"')
        table = self.dccast("sweep", case, "--grid",
                            "schedule.casting_speed=50 mm/min,60 mm/min", "--grid",
                            "schedule.water_flow.scale=1", "--csv", "-").stdout
        head = next(csv.reader(io.StringIO(table)))
        self.assertIn("schedule.casting_speed_m_per_s", head)
        self.assertIn("schedule.water_flow.scale_factor", head)

    # -- states, ids, addresses

    def test_pause_and_cancel_print_the_state_they_reach(self):
        job = self.client.submit(fake_case("steps=100000 sleep_ms=5"))
        self.client.until_step(job.id, 3)
        self.assertEqual(self.dccast("pause", job.id).stdout, f"{job.id} paused\n")
        self.dccast("resume", job.id)
        self.client.until_step(job.id, 6)
        self.assertEqual(self.dccast("cancel", job.id).stdout, f"{job.id} cancelled\n")

    def test_why_a_job_was_cancelled_is_shown(self):
        for reason, cause in (("wrong alloy", "cancelled: wrong alloy"), ("", "cancelled by request")):
            job = self.client.submit(fake_case("steps=100000 sleep_ms=5"))
            self.client.until_step(job.id, 3)
            self.client.ask("CancelJob", id=job.id, reason=reason)
            self.dccast("wait", job.id, code=3)
            self.assertRegex(self.dccast("show", job.id).stdout, f"cause +{cause}\n")
            self.assertEqual(json.loads(self.dccast("show", "--json", job.id).stdout)["cause"], cause)

    def test_states_of_studies_and_jobs_are_spelt_alike(self):
        case = self.write_case("case.toml", title='"steps=3"')
        self.dccast("sweep", case, "--grid", "schedule.casting_speed=50 mm/min,60 mm/min")
        for words in (("studies", "--json"), ("list", "--json")):
            for entry in json.loads(self.dccast(*words).stdout):
                self.assertEqual(entry["state"], "SUCCEEDED")

    def test_a_list_folds_the_runs_of_a_study(self):
        case = self.write_case("case.toml", title='"steps=3"')
        alone = self.client.submit(fake_case("steps=3"))
        self.dccast("sweep", case, "--grid", "schedule.casting_speed=50 mm/min,60 mm/min",
                    "--grid", "schedule.hold=10 s,20 s")
        self.client.until_state(alone.id, job_pb2.SUCCEEDED)
        study = json.loads(self.dccast("studies", "--json").stdout)[0]["id"]
        runs = self.dccast("list", "--study", "last", "--ids").stdout.split()

        lines = self.dccast("list").stdout.splitlines()[1:]
        self.assertEqual(len(lines), 2, lines)
        self.assertTrue(study.startswith(lines[0].split()[0]))
        self.assertRegex(lines[0], r"answered +100 % .*\(study, 4 of 4 runs\)$")
        self.assertTrue(alone.id.startswith(lines[1].split()[0]))
        self.assertEqual(len(self.dccast("list", "--limit", "1").stdout.splitlines()), 2)

        lines = self.dccast("list", "--all").stdout.splitlines()[1:]
        self.assertTrue(study.startswith(lines[0].split()[0]))
        for run, line in zip(runs, lines[1:5], strict=True):
            self.assertRegex(line, "^  [0-9a-f]")
            self.assertTrue(run.startswith(line.split()[0]))
        self.assertFalse(lines[5].startswith(" "))

        # Who asks for certain jobs gets jobs.
        for words in (("--state", "succeeded"), ("--json",), ("--ids",)):
            self.assertNotIn("(study", self.dccast("list", *words).stdout)
        self.assertEqual(len(json.loads(self.dccast("list", "--json").stdout)), 5)

    # -- cases

    def test_a_slab_becomes_a_case(self):
        path = self.in_folder("slab.toml")
        made = self.dccast("new", "--slab", "1320x570mm", "--alloy", "aa5182", "--speed",
                           "45..55mm/min", "--water", "25..45m3/h", "--out", path)
        self.assertIn("25 -> 45 m3/h = 110.2 -> 198.4 l/min/m", made.stderr)

        said = self.dccast("validate", "--local", path, "--drawing",
                           self.in_folder("slab.html"))
        words = ("slab 1320 x 570 mm of aa5182, speed 45 -> 55 mm/min from 51 s to 174 s (over "
                 "102.5 mm), water 110.2 -> 198.4 l/min/m = 25 -> 45 m3/h")
        self.assertEqual(said.stdout.splitlines()[0], words)
        self.assertEqual(json.loads(self.dccast("validate", "--local", "--json", path).stdout)["casting"],
                         words)

        with open(self.in_folder("slab.html"), encoding="utf-8") as file:
            self.assertIn("data-kind='casting'", file.read())
        self.assertIn("exists already", self.dccast("new", "--slab", "1320x570mm", "-o", path,
                                                    code=2).stderr)
        self.assertIn("not both", self.dccast("new", "start-3d", "--slab", "1320x570mm", code=2).stderr)
        self.assertIn("belong to --slab", self.dccast("new", "--speed", "45mm/min", code=2).stderr)

    def test_a_new_case_is_checked_by_a_draft(self):
        path = self.in_folder("slab.toml")
        recipe = ("new", "--slab", "1860x510mm", "--alloy", "aa1050", "--check")
        self.assertIn("give --out FILE", self.dccast(*recipe, code=2).stderr)

        checked = self.dccast(*recipe, "--out", path)
        self.assertIn("curls at the end", checked.stdout)
        self.assertIn("changed: quality = draft", checked.stdout + checked.stderr)
        with open(path, encoding="utf-8") as file:
            self.assertIn('quality = "engineering"', file.read())

    def test_new_asks_on_a_terminal(self):
        # Only what is at fault is asked for again.
        answers = b"1320\n1500x600mm\naa3104\n50mm\n50mm/min\n30m3/h\nasked.toml\n"
        main_end, terminal = pty.openpty()
        asking = subprocess.Popen([os.path.join(BIN, "dccast"), "new"], stdin=terminal,
                                  stdout=terminal, stderr=terminal, cwd=self.folder)
        os.close(terminal)
        os.write(main_end, answers)
        self.assertEqual(asking.wait(20), 0)

        screen = os.read(main_end, 65536).decode()
        os.close(main_end)
        self.assertIn("width x thickness with a unit is expected", screen)
        self.assertIn("a speed is expected", screen)
        self.assertEqual([screen.count(word) for word in ("Slab, width", "Alloy, a card", "Casting speed, ")],
                         [2, 1, 2])
        with open(self.in_folder("asked.toml"), encoding="utf-8") as file:
            self.assertIn('card = "aa3104" # [G]', file.read())

    def test_a_study_has_short_names(self):
        case = self.write_case("case.toml", title='"steps=3"')
        self.dccast("sweep", case, "--grid", "schedule.casting_speed=50 mm/min,60 mm/min",
                    "--grid", "schedule.hold=10 s,20 s")
        study = json.loads(self.dccast("studies", "--json").stdout)[0]["id"]
        for name in ("last", study[:8], study):
            with self.subTest(name=name):
                self.assertIn(study, self.dccast("studies", "show", name).stdout)
        self.assertIn("no study", self.dccast("studies", "show", "0", code=5).stderr
                      if study[0] != "0" else "no study")
        self.assertEqual(len(self.dccast("list", "--study", "last", "--ids").stdout.split()), 4)
        self.assertIn("a study does: see dccast studies --help",
                      self.dccast("cancel", study[:8], code=5).stderr)

        error = self.dccast("predict", "last", "--set", "schedule.casting_sped=55 mm/min",
                            code=2).stderr
        self.assertIn("schedule.casting_sped was not swept; did you mean schedule.casting_speed?",
                      error)

    def test_a_fault_of_a_plan_points_at_the_plan(self):
        case = self.write_case("case.toml")
        error = self.dccast("sweep", case, "--grid", "schedule.casting_speed=50 mm/min,-3 mm/min",
                            code=2).stderr
        self.assertIn("--grid schedule.casting_speed: ", error)
        self.assertNotIn("case.toml:", error)

    def test_an_address_without_port_and_one_of_the_web(self):
        error = self.dccast("info", address="127.0.0.77", code=4).stderr
        self.assertIn("there is no login for 127.0.0.77:7118", error)
        self.assertIn("Local users give no --server", error)
        self.assertIn("write HOST:PORT, without https://",
                      self.dccast("info", address="https://localhost:1", code=2).stderr)

    def test_settings_that_are_named_must_exist(self):
        error = self.dccast("info", code=2, environment={"DCCAST_CONFIG": "/nowhere.toml"}).stderr
        self.assertIn("DCCAST_CONFIG names /nowhere.toml", error)

    # -- words

    def test_a_quality_that_changes_nothing_is_said(self):
        case = self.write_case("case.toml")
        self.assertNotIn("quality: changes nothing", self.dccast("validate", case).stdout)
        text = self.dccast("validate", case, "--set", 'quality="fine"', "--set", "mesh.columns=20",
                           "--set", "mesh.rows=20", "--set", 'mesh.bottom_cell="3 mm"',
                           "--set", 'mesh.growth_cell="5 mm"', "--set", 'time.step="1 s"').stdout
        self.assertIn("quality: changes nothing", text)

    def test_whether_curls_will_have_an_error_bar_is_said_before_the_run(self):
        start = self.dccast("validate", "--local", os.path.join(CASES, "start-3d.toml")).stdout
        self.assertIn("an error bar of ± 5 % for mesh and steps", start)
        wide = self.dccast("validate", "--local", os.path.join(CASES, "start-3d.toml"), "--set",
                           'section.half_width="1.2 m"').stdout
        self.assertIn("no error bar: none was measured for such a casting or mesh", wide)

    def test_the_sample_settings_have_every_key(self):
        keys = json.loads(self.dccast("schema", "--daemon", "--json", "").stdout)
        shown, table = set(), ""
        with open(CONFIG, encoding="utf-8") as file:
            for line in file:
                if heading := re.match(r"\[(\w+)\]", line):
                    table = heading[1] + "."
                elif key := re.match(r"(?:# )?(\w+) = ", line):
                    shown.add(table + key[1])
        self.assertEqual(shown, {key["path"] for key in keys if key["type"] != "table"})


class Results(Commands):
    """With results that the real solver has written."""
    worker = "dccast-worker"

    def cast_job(self):
        job = self.dccast("submit", os.path.join(CASES, "start-2d-thickness.toml"), "--set",
                          'quality="draft"', "--set", 'time.end="5 s"').stdout.strip()
        self.client.until_state(job, job_pb2.SUCCEEDED, seconds=60)
        return job

    def test_a_file_that_does_not_fit_is_an_error_and_is_not_left(self):
        job = self.cast_job()
        error = self.dccast("report", "-o", "/dev/full", job, code=7).stderr
        self.assertIn("cannot write /dev/full: No space left", error)
        with open("/dev/full", "w", encoding="ascii") as full:
            self.dccast("report", "-o", "-", job, code=7, stdout=full)
        self.assertIn("cannot write nowhere/r.html: No such file",
                      self.dccast("report", "-o", "nowhere/r.html", job, code=7).stderr)

    def test_a_curl_has_its_error_in_csv_and_json(self):
        job = self.cast_job()
        rows = list(csv.DictReader(io.StringIO(self.dccast("curl", "--csv", job).stdout)))
        shown = json.loads(self.dccast("curl", "--json", job).stdout)["monitors"][0]
        self.assertGreater(float(rows[-1]["corner_curl_m"]), 0.0)
        for side in ("lower_error_m", "upper_error_m"):
            for row, error in zip(rows, shown[side]):
                self.assertAlmostEqual(float(row[f"corner_{side}"]),
                                       0.05 * abs(float(row["corner_curl_m"])), delta=1e-12)
                self.assertAlmostEqual(float(row[f"corner_{side}"]), error, delta=1e-12)
        printed = " ".join(self.dccast("curl", job).stderr.split())  # it may be cut at any blank
        self.assertIn("Mesh and time steps leave ± ", printed)

    def test_fetch_into_a_folder(self):
        job = self.cast_job()
        os.mkdir(self.here("results"))
        self.dccast("fetch", "-o", "results", job)
        self.assertEqual(sorted(os.listdir(self.here("results"))),
                         ["results-end.xdmf", "results-run.json"] +
                         ["results.h5", "results.xdmf"])

    def test_fetch_survives_a_daemon_that_is_away_for_five_seconds(self):
        job = self.cast_job()
        # The job is named by its whole id, so that the stream is the first call.
        self.daemon.terminate()
        again = threading.Timer(5, self.daemon.start)
        again.start()
        try:
            error = self.dccast("fetch", "-o", "late.h5", job).stderr
        finally:
            again.join()
        self.assertIn("going on", error)
        self.assertTrue(os.path.isfile(self.here("late.h5")))

    def test_report_as_pdf(self):
        job = self.cast_job()
        if shutil.which("chromium") is None:
            self.assertIn("Chromium",
                          self.dccast("report", "-o", "r.pdf", job, code=2).stderr)
            return
        self.dccast("report", "-o", "r.pdf", job)
        with open(self.here("r.pdf"), "rb") as file:
            self.assertEqual(file.read(4), b"%PDF")
        error = self.dccast("report", "-f", "-o", "r2.pdf", job, code=2,
                            environment={"PATH": self.folder}).stderr
        self.assertIn("Chromium, which is not installed", error)


if __name__ == "__main__":
    main()
