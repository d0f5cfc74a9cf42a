#!/usr/bin/python3
"""The Python package on the real solver: its examples, and what a script relies on."""
import asyncio
import contextlib
import datetime
import doctest
import importlib
import inspect
import io
import json
import math
import os
import pathlib
import re
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
import textwrap
import types
import unittest
import unittest.mock
import zipfile

import numpy as np

import dccast
import dccast.v1.service_pb2
import dccast.v1.study_pb2
from dccast.text import millimetres
from doctor_test import ClientTest
from support import BIN, ServiceTest, main
from waiting import until

CASE = "start-2d-thickness"
QUICK = {"quality": "draft", "time.end": "20 s"}
MODULES = ("", ".cases", ".castings", ".errors", ".frames", ".jobs", ".judgements", ".logins", ".plots", ".runs", ".service", ".studies",
           ".text", ".transport")
PACKAGE = os.path.dirname(dccast.__file__)
os.environ["MPLBACKEND"] = "agg"


class PackageTest(ServiceTest):
    worker = "dccast-worker"

    def setUp(self):
        super().setUp()
        os.environ["DCCAST_SERVER"] = self.daemon.address
        self.service = dccast.connect()

    def ended(self, **changes):
        return self.service.submit(CASE, {**QUICK, **changes}).wait()

    def command(self, *words):
        return self.ended_command(*words).stdout

    def ended_command(self, *words):
        ended = subprocess.run([os.path.join(BIN, "dccast"), *words], capture_output=True, text=True,
                               timeout=60, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return ended


class Figures(unittest.TestCase):
    def test_curls_are_rounded_as_in_the_examples_of_all_renderers(self):
        file = pathlib.Path(__file__).resolve().parents[1] / "support" / "figures.json"
        for curl in json.loads(file.read_text("utf-8"))["curls"]:
            given = [curl.get(name, math.nan) for name in ("curl_m", "lower_m", "upper_m")]
            self.assertEqual(millimetres(*given), curl["text"])


class Examples(PackageTest):
    def test_every_example_of_the_package_runs(self):
        tried = 0
        for name in MODULES:
            module = importlib.import_module("dccast" + name)
            result = doctest.testmod(module, extraglobs={"dccast": dccast},
                                     verbose=False, optionflags=doctest.ELLIPSIS)
            self.assertEqual(result.failed, 0, module.__name__)
            tried += result.attempted
        self.assertGreater(tried, 15)


    def test_the_page_about_python_prints_what_it_says(self):
        """Code blocks of docs/python.md in turn; a block after one that prints is its output."""
        page = pathlib.Path(__file__).resolve().parents[2] / "docs" / "python.md"
        blocks = [textwrap.dedent(block).strip() for block in
                  re.findall(r"(?m)(?:^ {4}.*\n(?:\n(?= {4}))?)+", page.read_text("utf-8"))]
        names, printed, tried = {}, "", 0
        with contextlib.chdir(self.folder):
            for block in (part for whole in blocks for part in whole.split("\n\n")):
                if printed:
                    self.assertEqual(printed.strip(), block)
                    printed = ""
                elif not re.match(r"dccast |cmake |export |ninja ", block):
                    with contextlib.redirect_stdout(io.StringIO()) as output:
                        exec(block, names)  # pylint: disable=exec-used
                    printed, tried = output.getvalue(), tried + 1
        self.assertGreaterEqual(tried, 6)


class Figures(PackageTest):
    def test_a_curl_and_its_error_are_those_of_the_command_line(self):
        job = self.ended(**{"section.half_width": "0.3 m"})
        lines = self.command("curl", "--csv", job.id).splitlines()
        self.assertEqual(tuple(lines[0].split(",")), job.curl.dtype.names)
        printed = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
        for column, name in enumerate(job.curl.dtype.names):
            np.testing.assert_allclose(job.curl[name].astype(float), printed[:, column], rtol=1e-5,
                                       atol=1e-9, err_msg=name)
        self.assertGreater(job.band().upper_error_m[-1], 0)
        self.assertEqual(list(job.curl_frame().columns), list(job.curl.dtype.names[1:]))

    def test_without_a_measured_error_it_is_not_zero(self):
        job = self.ended(**{"mesh.columns": 10})
        self.assertTrue(np.isnan(job.band().upper_error_m).all())

    def test_a_query_gives_the_bits_of_a_job(self):
        seen = []
        answer = self.service.query(CASE, QUICK, on_step=seen.append)
        self.assertEqual(len(seen), len(answer.steps))
        self.assertEqual(self.service.jobs(), [])
        np.testing.assert_array_equal(answer.curl, self.ended().curl)

    def test_the_history_has_every_figure_of_a_step(self):
        job = self.ended()
        self.assertEqual(job.history["step"].tolist(), list(range(1, len(job.steps) + 1)))
        self.assertAlmostEqual(job.history["progress"][-1], 1.0)
        self.assertGreater(job.history["sump_depth_m"][-1], 0)

    def test_frames_are_those_of_the_results(self):
        job = self.ended()
        last = job.frames[-1]
        self.assertEqual([frame.time_s for frame in job.frames], job.frames.times_s)
        self.assertEqual(last.points_m.shape, last.displacement_m.shape)
        self.assertLess(last.cells.max(), len(last.temperature_c))

        file = self.in_folder("end.vtu")
        last.to_meshio().write(file)
        import meshio
        np.testing.assert_allclose(meshio.read(file).point_data["temperature_c"], last.temperature_c)

        # The results themselves, by the last frame beside them.
        folder = os.path.dirname(file)
        job.fetch(folder)
        mesh = meshio.read(job.fetch(folder, "results-end.xdmf"))
        np.testing.assert_allclose(mesh.point_data["temperature_c"], last.temperature_c)
        np.testing.assert_allclose(mesh.points[:, :2], last.points_m[:, :2])

        # Debian 12 has no PyVista: what it would be given.
        stand_in = types.SimpleNamespace(from_meshio=lambda mesh: mesh)
        with unittest.mock.patch.dict(sys.modules, {"pyvista": stand_in}):
            np.testing.assert_array_equal(last.to_pyvista().cells[0].data, last.cells)
        with self.assertRaises(IndexError):
            job.frames[len(job.frames)]

        import h5py
        with h5py.File(job.fetch(self.folder, overwrite=True)) as results:
            self.assertGreater(len(results), 0)
        self.assertNotIn("results.h5.part", os.listdir(self.folder))

    def test_compare_has_the_judgement_of_the_command_line(self):
        slow, fast = self.ended(), self.ended(**{"schedule.casting_speed": "80 mm/min"})
        with unittest.mock.patch.dict(os.environ, {"PATH": ""}):
            found = self.service.compare(slow, fast)
        self.assertEqual([run.job for run in found.runs], [slow.id, fast.id])
        printed = json.loads(self.command("compare", "--json", slow.id, fast.id))
        self.assertEqual(found.sentences, printed["sentences"])
        self.assertIn(found.sentences[0], repr(found))
        difference = found.differences[0]
        row = [row for row in printed["differences"] if "verdict" in row][0]
        self.assertEqual((difference.monitor, difference.difference_m, difference.verdict),
                         (row["monitor"], row["difference_m"], row["verdict"]))
        self.assertEqual(list(found.tables["keys"]["key"]), [row["key"] for row in printed["keys"]])

    def test_a_run_is_judged_as_the_command_line_prints(self):
        job = self.ended()
        found = self.service.judge(job)
        printed = self.ended_command("curl", job.id).stderr
        self.assertIn(" ".join(found.sentences[0].split()), " ".join(printed.split()))
        self.assertAlmostEqual(found.tables["end"]["time_s"][0], job.curl["time_s"][-1])
        self.assertEqual(found.charts[0].key, "curl")
        self.assertTrue(all(chart.note for chart in found.charts))
        self.assertIn("Casting speed", found.tables["recipe"]["name"])
        self.assertIn("curls at the end", self.command("show", job.id))

        self.assertNotIn("bottom_gap", [chart.key for chart in found.charts])
        with_frame = self.service.judge(job, with_frame=True)
        self.assertIn("bottom_gap", [chart.key for chart in with_frame.charts])

    def test_answers_and_cases_are_compared_without_jobs(self):
        answer = self.service.query(CASE, QUICK)
        found = self.service.compare(answer, self.service.read(CASE, QUICK))
        self.assertEqual(found.differences[0].verdict, "no_difference")
        self.assertEqual(self.service.jobs(), [])


    def test_a_package_that_is_absent_is_named_as_debian_does(self):
        job = self.ended()
        absent = dict.fromkeys(("pandas", "meshio", "matplotlib", "pyvista"))
        with unittest.mock.patch.dict(sys.modules, absent):
            for use, package in ((job.curl_frame, "python3-pandas"), (job.plot, "python3-matplotlib"),
                                 (job.frames[0].to_meshio, "python3-meshio"),
                                 (job.frames[0].to_pyvista, "not in Debian 12")):
                with self.assertRaises(dccast.DccastError) as caught:
                    use()
                self.assertIn(package, str(caught.exception))


class Cases(PackageTest):
    def test_a_file_a_text_and_a_name_are_one_case(self):
        text = self.command("new", CASE)
        path = pathlib.Path(self.folder) / "my.toml"
        path.write_text(text)
        named, of_text, of_file = (self.service.read(case) for case in (CASE, text, path))
        self.assertEqual(named.message, of_text.message)
        self.assertEqual(named.message, of_file.message)

    def test_what_the_server_took_has_the_changes(self):
        job = self.service.submit(CASE, {"schedule.casting_speed": "55 mm/min"}, mesh__refinement=1,
                                  time__end="1 s").wait()
        self.assertEqual([(c.key, c.value) for c in job.message.changes],
                         [("schedule.casting_speed", "55 mm/min"), ("mesh.refinement", "1"),
                          ("time.end", "1 s")])
        self.assertAlmostEqual(job.case.schedule.casting_speed_m_per_s.value[0], 0.055 / 60)

    def test_all_faults_come_at_once_with_lines_and_remedies(self):
        with self.assertRaises(dccast.DccastError) as caught:
            self.service.submit('title = "x"\n[schedule]\ncasting_speed = "55 mm"\nspede = 1\n')
        error = caught.exception
        self.assertEqual(error.code, "INVALID_ARGUMENT")
        self.assertIn(("schedule.casting_speed", 3), [(f.field, f.line) for f in error.faults])
        self.assertIn(("schedule.spede", 4), [(f.field, f.line) for f in error.faults])

    def test_faults_that_only_the_whole_case_shows_have_their_key(self):
        with self.assertRaises(dccast.DccastError) as caught:
            self.service.submit(CASE, {"time.end": "-70 s"})
        self.assertEqual(caught.exception.field, "time.end")

    def test_no_file_of_the_server_is_read(self):
        secret = pathlib.Path(self.folder) / "secret.msh"
        secret.write_text("secret")
        read = self.service.read
        text = self.command("new", CASE)

        def with_mesh(file):
            return text.replace('\nelement', f'\nfile = "{file}"\nelement', 1)
        with self.assertRaises(FileNotFoundError):
            read(with_mesh(f"{secret}x"))
        case = read(with_mesh(secret))
        self.assertEqual(case.message.mesh.file, "secret.msh")
        self.assertEqual([(f.name, f.path.read_bytes()) for f in case.files],
                         [("secret.msh", b"secret")])
        with self.assertRaises(dccast.DccastError) as caught:
            read(CASE, {"mesh.file": str(secret)})
        self.assertEqual(caught.exception.field, "mesh.file")

    def test_names_that_are_not_there(self):
        for case, code in (("start-4d", "NOT_FOUND"), ("folder/no.toml", "NOT_FOUND")):
            with self.assertRaises(dccast.DccastError) as caught:
                self.service.read(case)
            self.assertEqual(caught.exception.code, code)
        for job in ("last", "ffffffff", "0" * 36):
            with self.assertRaises(dccast.DccastError):
                self.service.job(job)


class Steering(PackageTest):
    def long_job(self):
        job = self.service.submit(CASE, quality="fine")
        until(lambda: job.refresh().state == "RUNNING", 30)
        return job

    def test_pause_resume_cancel_and_delete(self):
        job = self.long_job().pause()
        until(lambda: job.refresh().state == "PAUSED", 30)
        job.resume().cancel("enough")
        with self.assertRaises(dccast.DccastError) as caught:
            job.wait()
        self.assertEqual(caught.exception.code, "CANCELLED")
        with self.assertRaises(dccast.DccastError) as caught:
            job.resume()
        self.assertEqual(caught.exception.code, "FAILED_PRECONDITION")
        job.delete()
        self.assertEqual(self.service.jobs(), [])

    def test_a_watch_goes_on_when_the_server_comes_back(self):
        self.daemon.settings["listen__socket"] = self.daemon.address
        job = self.long_job()
        numbers = []
        for event in job.watch():
            numbers.append(event.sequence)
            if len(numbers) == 8:
                self.daemon.terminate()
                self.daemon.start()
            if len(numbers) == 20:
                break
        self.assertEqual(numbers, list(range(1, 21)))
        job.cancel()

    def test_a_job_has_its_state_while_and_after_it_is_watched(self):
        job = self.service.submit(CASE, QUICK)
        seen = [(event.state, job.state) for event in job.watch() if event.state]
        self.assertEqual(seen[-1], ("SUCCEEDED", "SUCCEEDED"))
        self.assertTrue(all(of_event == of_job for of_event, of_job in seen), seen)
        self.assertTrue(job.ended)
        self.assertGreater(len(job.message.artifacts), 0)

    def test_what_is_printed_has_units(self):
        job = self.ended()
        self.assertRegex(repr(job), r"SUCCEEDED 'Start.*: corner [-\d.]+ ± [\d.]+ mm, .* at 20 s>")
        self.assertRegex(repr(job.band("corner")), r"'corner' [\d.]+ ± [\d.]+ mm at the end; \d+ steps,"
                                                   r" .* to 20 s>")
        self.assertRegex(repr(job.frames), r"<dccast.Frames \d+, .* to 20 s>")
        self.assertRegex(repr(job.frames[-1]), r"at 20 s, [\d.]+ mm cast, \d+ nodes>")
        answer = self.service.query(CASE, QUICK)
        self.assertRegex(repr(answer), r"SUCCEEDED 'Start.*: corner [\d.]+ ± [\d.]+ mm")

    def test_the_legend_covers_no_curve(self):
        band = self.ended().band()
        axes = dccast.plot_curl({"one label that is long": band, "another one": band})
        axes.figure.canvas.draw()
        legend, inside = axes.get_legend().get_window_extent(), axes.get_window_extent()
        self.assertGreaterEqual(legend.y0, inside.y1 - 1.0)
        self.assertLessEqual(legend.y1, axes.figure.bbox.y1 + 1.0)

    def test_a_chart_of_a_judgement_is_drawn_in_millimetres(self):
        chart = self.service.compare(self.ended(), self.ended()).charts[0]
        axes = dccast.plot_chart(chart)
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("time [s]", "curl [mm]"))
        self.assertEqual(len(axes.lines), len(chart.lines))
        for drawn, line in zip(axes.lines, chart.lines):
            self.assertAlmostEqual(drawn.get_ydata()[-1], 1e3 * line.y[-1])
        self.assertEqual(len(axes.collections), sum(1 for line in chart.lines if line.low))

    def test_a_probe_follows_a_point_and_a_line(self):
        job = self.ended()
        table = job.probe((0.28, 0.0))
        self.assertEqual(len(table), len(job.frames))
        last = job.frames[-1]
        corner = np.argmin(np.linalg.norm(last.points_m - (0.28, 0.0, 0.0), axis=1))
        self.assertAlmostEqual(table["temperature_c"][-1], last.temperature_c[corner], places=6)
        self.assertAlmostEqual(table["displacement_y_m"][-1], last.displacement_m[corner][1], places=9)

        line = job.probe((0.0, 0.02), to_m=(0.28, 0.02), points=11, time_s=20.0)
        self.assertEqual(len(line), 11)
        self.assertFalse(np.isnan(line["temperature_c"]).any())
        self.assertTrue(np.isnan(job.probe((0.0, 9.0))["temperature_c"]).all())

        printed = json.loads(self.command("probe", job.id, "--at", "0,20mm", "--to", "280mm,20mm",
                                          "--points", "11", "--json"))["samples"]
        np.testing.assert_allclose([sample["temperature_c"] for sample in printed],
                                   job.probe((0.0, 0.02), to_m=(0.28, 0.02), points=11)["temperature_c"],
                                   rtol=1e-9)
        self.assertIn("temperature_c", self.command("probe", job.id, "--at", "280,0 mm", "--csv"))

        # Inside the metal a stress is known once something is solid, and the command has the same.
        stress = job.probe((0.27, 0.005), fields=["von_mises_pa"])["von_mises_pa"]
        self.assertGreater(stress[-1], 0.0)
        lines = self.command("probe", job.id, "--at", "270,5 mm", "--field", "von_mises_pa", "--csv")
        self.assertAlmostEqual(float(lines.splitlines()[-1].split(",")[-1]) / stress[-1], 1.0, places=7)

    def test_a_probe_that_does_not_suit_the_job_is_refused(self):
        job = self.ended()
        for arguments, part in (({"at_m": (0.1, 0.1, 0.1)}, "a point has 3 coordinates"),
                                ({"at_m": (0.1, float("nan"))}, "not a finite number"),
                                ({"at_m": (0.1, 0.1), "fields": ["colour"]}, 'no field "colour"')):
            with self.assertRaisesRegex(dccast.errors.DccastError, part):
                job.probe(**arguments)

    def test_two_jobs_are_watched_in_one_loop(self):
        async def last_state(job):
            return [event.state async for event in job.watch() if event.state][-1]

        async def both():
            jobs = [self.service.submit(CASE, QUICK, title=str(i)) for i in range(2)]
            return await asyncio.gather(*(last_state(job) for job in jobs))
        self.assertEqual(asyncio.run(both()), ["SUCCEEDED", "SUCCEEDED"])

    def test_an_async_watch_that_is_given_up_leaves_no_thread(self):
        async def given_up(job):
            async def watch():
                async for _ in job.watch():
                    pass
            with self.assertRaises(asyncio.TimeoutError):
                await asyncio.wait_for(watch(), 1.0)
        job = self.long_job()
        asyncio.run(given_up(job))  # waits for its threads
        job.cancel()

    def test_a_sweep_is_watched_fetched_and_deleted(self):
        study = self.service.sweep(CASE, {"schedule.casting_speed": ["50 mm/min", "60 mm/min"],
                                          "schedule.casting_temperature": ["680 degC", "690 degC"]},
                                   changes=QUICK)
        self.assertEqual([seen.message.runs for seen in study.watch()][-1], 4)
        self.assertEqual(study.wait().state, "SUCCEEDED")
        self.assertEqual(len(set(study.table["corner_end_curl_m"])), 4)
        self.assertTrue(study.fetch(self.folder).exists())
        with self.assertRaises(dccast.DccastError) as caught:
            study.predict(schedule__casting_sped="57 mm/min")
        self.assertEqual(caught.exception.code, "INVALID_ARGUMENT")
        self.assertEqual(self.service.studies()[0].id, study.id)
        study.delete()
        self.assertEqual(self.service.studies(), [])

    def test_studies_of_data_are_begun_from_python(self):
        block = "cooling.bottom_block.temperature"
        study = self.service.uncertainty(CASE, only={block: ["60 degC", "100 degC"]}, runs=8,
                                         changes=QUICK).wait()
        self.assertIn("8 runs: 8 valid", study.judgement().message.heading)
        self.assertTrue(any(block in line for line in study.judgement().sentences))

        # The server knows the range of a datum that is only named.
        study = self.service.sensitivity(CASE, only=[block], changes=QUICK).wait()
        axis = study.evaluate().study.sweep.axes[0]
        self.assertEqual((axis.key, list(axis.values)), (block, ["60 degC", "150 degC"]))
        with self.assertRaises(dccast.DccastError) as caught:
            self.service.sensitivity(CASE, only=["time.end"], changes=QUICK)
        self.assertIn("has no range", str(caught.exception))

    def test_a_calibration_is_begun_from_python(self):
        curl = self.service.query(CASE, QUICK, cooling__bottom_block__temperature="95 degC").curl
        late = curl[curl["time_s"] > 5.0]
        study = self.service.calibrate(
            CASE, {"corner": {"time_s": late["time_s"], "curl_m": late["corner_curl_m"]}},
            free=["cooling.bottom_block.temperature"], runs=8, changes=QUICK).wait()
        self.assertTrue(study.judgement().sentences)
        self.assertEqual(study.evaluate().study.sweep.measured[0].monitor, "corner")


    def test_a_job_gets_what_the_command_gives_it(self):
        first = self.service.submit(CASE, QUICK)
        second = self.service.submit(CASE, QUICK, after=[first], time_limit_s=600.0, mail="anna@example.org",
                                     title="second")
        self.assertEqual(list(second.message.after), [first.id])
        self.assertEqual((second.message.time_limit_s, second.message.mail), (600.0, "anna@example.org"))
        self.assertEqual(second.wait().state, "SUCCEEDED")
        self.assertEqual([job.id for job in self.service.jobs(title="sec*")], [second.id])
        self.assertIn("[schedule]", second.fetch(self.folder, "case.toml").read_text())

        overdue = self.service.submit(CASE, quality="fine", time_limit_s=1.0)
        with self.assertRaises(dccast.DccastError) as caught:
            overdue.wait()
        self.assertEqual(caught.exception.code, "TIME_LIMIT")

        rescue = self.service.submit(CASE, QUICK, after=[overdue], after_end="failure", title="rescue")
        self.assertEqual(rescue.wait().state, "SUCCEEDED")

    def test_a_job_waits_for_its_time_and_changes_its_place(self):
        tonight = datetime.datetime.now() + datetime.timedelta(hours=1)
        job = self.service.submit(CASE, QUICK, begin=tonight, priority="low")
        self.assertEqual(job.prioritize("high").message.priority, dccast.v1.job_pb2.HIGH)
        self.assertEqual(job.refresh().state, "QUEUED")
        self.assertAlmostEqual(job.message.begin_time.seconds, tonight.timestamp(), delta=1.0)
        job.cancel()

    def test_labels_pin_and_logs(self):
        job = self.ended()
        job.label("pit=3", "trial").label("pit=4", remove=["trial"]).pin()
        self.assertEqual((list(job.message.labels), job.message.pinned), (["pit=4"], True))
        self.assertFalse(job.pin(False).message.pinned)
        self.assertTrue(
            self.command("logs", job.id).endswith("\nwritten by its workers:\n" + job.logs))

    def test_nothing_is_overwritten_unasked(self):
        job = self.ended()
        target = job.fetch(self.folder)
        with self.assertRaises(dccast.DccastError) as caught:
            job.fetch(self.folder)
        self.assertEqual(caught.exception.code, "ALREADY_EXISTS")
        target.write_bytes(b"of yesterday")
        self.assertGreater(job.fetch(target, overwrite=True).stat().st_size, 100)

    def test_a_wait_has_an_end(self):
        job = self.long_job()
        for wait in (job.wait, self.service.prepare(CASE, QUICK).wait):
            with self.assertRaises(dccast.DccastError) as caught:
                wait(timeout_s=0.5)
            self.assertEqual(caught.exception.code, "DEADLINE_EXCEEDED")
        self.assertEqual(job.refresh().state, "RUNNING")
        job.cancel()

        with socket.socket(socket.AF_UNIX) as mute:
            mute.bind(self.in_folder("mute"))
            mute.listen()
            with self.assertRaises(dccast.DccastError) as caught:
                dccast.connect(f"unix:{self.folder}/mute", timeout_s=0.5).info()
        self.assertEqual(caught.exception.code, "DEADLINE_EXCEEDED")

    def test_a_wait_shows_how_far_it_is(self):
        shown = io.StringIO()
        with contextlib.redirect_stderr(shown):
            self.service.submit(CASE, QUICK).wait(progress=True)
            self.service.sweep(CASE, {"schedule.hold": ["60 s", "70 s"]}, quality="draft",
                               time__end="20 s").wait(progress=True)
        bars = shown.getvalue()
        self.assertRegex(bars, r"\r\[#+\.+\] \d+ s, corner \d\.\d\d ± ")
        self.assertRegex(bars, r"\r\[#{30}\] SUCCEEDED +\n")
        self.assertRegex(bars, r"\r\[#{30}\] of 2 runs +\n$")

    def test_a_list_has_all_pages_and_an_unknown_state_is_an_error(self):
        ids = {self.service.submit(CASE, QUICK, title=str(number)).cancel().id for number in range(5)}
        # Each page of the server has two.
        class Pages:
            def __init__(self, transport):
                self.transport = transport

            def call(self, method, request):
                request.page_size = 2
                return self.transport.call(method, request)
        service = dccast.Service(Pages(self.service._transport))  # pylint: disable=protected-access
        self.assertEqual({job.id for job in service.jobs()}, ids)
        self.assertEqual(len(service.jobs(limit=3)), 3)
        with self.assertRaisesRegex(dccast.UnknownState, "SLEEPING"):
            self.service.jobs(states=["SLEEPING"])
        job = self.service.jobs()[0]
        job.message.state = 99
        with self.assertRaises(dccast.UnknownState):
            repr(job)


class Castings(PackageTest):
    def test_a_casting_is_followed_and_forecast(self):
        job = self.service.follow(CASE, QUICK, noise_m={"corner": 1e-3}, labels=["pit=3"])
        times = np.arange(-60.0, 11.0)
        table = {"time_s": times, "casting_speed_m_per_s": np.where(times < 0, 0.0, 9e-4),
                 "corner_curl_m": np.maximum(times, 0.0) * 1e-4}
        self.assertEqual(job.append(table).number, 71)
        self.assertEqual(job.append(table).number, 71, "readings that are there count once")
        frame = job.append(reading for reading in [{"time_s": 11.0, "corner_curl_m": float("nan")}])
        self.assertEqual((frame.number, frame.time_s), (72, 11.0))

        # A broken sensor costs its own value; the first one of each is told.
        with self.assertWarnsRegex(UserWarning, r"reading 73, 11.5 s: the casting speed is .* permitted"):
            kept = job.append([{"time_s": 11.5, "casting_speed_m_per_s": -9999.0, "corner_curl_m": 1.1e-3},
                               {"time_s": 11.6, "casting_speed_m_per_s": 32767.0}])
        self.assertEqual([(each.number, each.name) for each in kept.left_out],
                         [(73, "casting_speed_m_per_s"), (74, "casting_speed_m_per_s")])

        # The plan is not prepared: its forecast rests on the run that `follow` has begun.
        plan, = (self.service.job(listed.id) for listed in self.service.jobs() if listed.id != job.id)
        plan.wait()
        forecast = job.forecast()
        self.assertEqual(forecast.time_s, 11.6)
        band = forecast.bands["corner"]
        self.assertGreater(band.upper_error_m[-1], 0.0)
        self.assertAlmostEqual(band.time_s[-1], 20.0)
        printed = self.command("forecast", job.id)
        self.assertIn(f"{1e3 * band.curl_m[-1]:.1f}", printed)

        with self.assertRaises(dccast.DccastError) as caught:
            job.append([{"time_s": 12.0, "sped": 1.0}])
        self.assertEqual(caught.exception.field, "sped")
        self.assertTrue(job.append(close=True).closed)
        self.assertEqual(job.wait().state, "SUCCEEDED")

    def test_a_preparation_is_found_again_whatever_title_and_quality(self):
        first = self.service.prepare(CASE, QUICK, labels=["hall=3"])
        ensemble = first.studies["ensemble"]
        self.assertEqual((first.ready, list(first.studies), ensemble.message.runs), (False, ["ensemble"], 64))
        self.assertIn("hall=3", ensemble.message.labels)
        again = self.service.prepare(CASE, {**QUICK, "quality": "fine"}, title="another")
        self.assertEqual(again.studies["ensemble"].id, ensemble.id)
        self.assertNotEqual(again.plan_job, first.plan_job)
        self.assertEqual(self.service.prepare(CASE, QUICK, title="another").plan_job, first.plan_job)
        faster = self.service.prepare(CASE, QUICK, schedule__casting_speed="60 mm/min")
        other = faster.studies["ensemble"]
        self.assertNotEqual(other.id, ensemble.id)

        # Behind the first ensemble, it has hardly begun.
        self.assertEqual(other.cancel().wait(check=False).state, "CANCELLED")
        self.assertNotEqual(faster.refresh().studies["ensemble"].id, other.id)

    def test_a_line_is_listed_and_removed(self):
        job = self.service.follow(CASE, QUICK, noise_m={"corner": 1e-3}, line="pit-3")
        self.assertEqual([line.name for line in self.service.lines()], ["pit-3"])
        self.assertEqual([casting.job for casting in self.service.line("pit-3").castings], [job.id])
        self.assertEqual(self.service.restart_line("pit-3").name, "pit-3")
        self.service.delete_line("pit-3")
        self.assertEqual(self.service.lines(), [])
        job.cancel()

    def test_a_report_has_the_charts_of_the_page(self):
        job = self.ended()
        page = self.command("report", job.id, "-o", "-")
        report = job.report()
        self.assertIn("bottom_gap", [chart.key for chart in report.charts])
        for chart in report.charts:
            self.assertIn(chart.heading[0].upper() + chart.heading[1:], page)


class Parity(unittest.TestCase):
    """Command and package reach all that the contract has."""

    NOT_BY_COMMAND = {"ReadCase": "the command reads case files itself"}
    REQUESTS = ("SubmitJobRequest", "PrepareCastingRequest", "CreateStudyRequest", "UpdateJobRequest",
                "AddCastingsRequest", "EditCastingRequest", "ForgetCastingsRequest")

    def setUp(self):
        client = pathlib.Path(__file__).resolve().parents[2] / "client"

        def texts(pattern):
            return "\n".join(path.read_text("utf-8") for path in sorted(client.rglob(pattern)))
        self.command, self.package = texts("*.cpp") + texts("*.hpp"), texts("*.py")

    def test_every_call_is_made_by_both(self):
        service = dccast.v1.service_pb2.DESCRIPTOR.services_by_name["SimulationService"]
        calls = {method.name for method in service.methods}
        self.assertGreater(len(calls), 30)
        by_command = set(re.findall(r"(?:Stub::|stub\(\)\.)(\w+)", self.command))
        by_package = set(re.findall(r'"(\w+)"|stub\.(\w+)', self.package))
        by_package = {name for found in by_package for name in found}
        self.assertEqual(calls - by_command, set(self.NOT_BY_COMMAND))
        self.assertEqual(calls - by_package, set())

    def test_every_field_of_what_is_queued_is_set_by_both(self):
        modules = (dccast.v1.service_pb2, dccast.v1.study_pb2, dccast.v1.line_pb2)
        for name in self.REQUESTS:
            message, = (module.DESCRIPTOR.message_types_by_name[name] for module in modules
                        if name in module.DESCRIPTOR.message_types_by_name)
            for field in message.fields:
                if field.name == "levers":
                    continue  # PrepareCasting begins such studies
                with self.subTest(message=name, field=field.name):
                    self.assertTrue(re.search(rf"(set|mutable|add)_{field.name}_?\(", self.command))
                    self.assertTrue(re.search(rf"\b{field.name}=|request\.{field.name}\b", self.package))


class Remote(ClientTest):
    """A daemon in another building: what `dccast login` stored serves the package."""

    def connect(self, role):
        self.start()
        self.log_in("anna", role)
        self.from_here()
        return dccast.connect()

    def test_a_login_makes_the_owner(self):
        service = self.connect("submitter")
        self.assertEqual(service.server, self.daemon.tls_address)
        job = service.submit(CASE, QUICK, title="steps=3").wait()
        self.assertEqual(job.message.owner, "anna")
        self.assertEqual(service.job("last").id, job.id)

    def from_here(self):
        """The settings of this test, as those of this process."""
        variables = {"XDG_CONFIG_HOME": self.in_folder("settings")}
        self.enterContext(unittest.mock.patch.dict(os.environ, variables))
        for name in ("DCCAST_SERVER", "DCCAST_CONFIG"):
            os.environ.pop(name, None)

    def test_a_login_by_the_line_serves_package_and_command(self):
        self.start()
        self.from_here()
        line = self.line_for("anna")
        self.assertEqual(dccast.login(f"dccast login {line}\n").server, self.daemon.tls_address)
        self.assertEqual(stat.S_IMODE(os.stat(self.servers_file()).st_mode), 0o600)
        self.assertEqual(dccast.connect().submit(CASE, QUICK, title="steps=3").message.owner, "anna")
        self.assertIn("anna on", self.dccast("whoami").stdout)
        with self.assertRaises(dccast.DccastError) as caught:
            dccast.login(line)
        self.assertEqual(caught.exception.code, "UNAUTHENTICATED")

        dccast.login(self.line_for("bert"), "north")
        self.assertIn("anna on", self.dccast("whoami").stdout)
        self.assertIn("bert on", self.dccast("--server", "north", "whoami").stdout)
        dccast.login(self.line_for("carl"), "south", default=True)
        self.assertIn("carl on", self.dccast("whoami").stdout)
        dccast.connect("north").revoke_token()
        self.assertEqual(self.dccast("--server", "north", "whoami").returncode, 5)

    def test_another_server_gets_no_secret(self):
        self.start()
        self.from_here()
        line = self.line_for("anna")
        address, fingerprint, secret = line.split("/")
        other = fingerprint[:-1] + ("0" if fingerprint[-1] != "0" else "1")
        with self.assertRaises(dccast.DccastError) as caught:
            dccast.login("/".join((address, other, secret)))
        self.assertEqual(caught.exception.code, "UNAUTHENTICATED")
        self.assertIn("another server", str(caught.exception))
        self.assertFalse(os.path.exists(self.servers_file()))
        for text in ("", "nonsense", address, f"{address}/{fingerprint}", f"/{fingerprint}/{secret}"):
            with self.assertRaises(dccast.DccastError) as caught:
                dccast.login(text)
            self.assertEqual(caught.exception.code, "INVALID_ARGUMENT", text)
        with socket.socket() as silent:
            silent.bind(("127.0.0.1", 0))
            with self.assertRaises(dccast.DccastError) as caught:
                dccast.login(f"127.0.0.1:{silent.getsockname()[1]}/{fingerprint}/{secret}")
        self.assertEqual(caught.exception.code, "UNAVAILABLE")
        dccast.login(line)  # the secret is still good

    def test_tokens_are_listed_and_ended(self):
        self.start(access__web_address="https://dccast.test")
        self.from_here()
        service = dccast.login(self.line_for("anna"))
        other = dccast.login(self.admin("user", "line", "anna").split("dccast login ")[1].split()[0], "other")
        self.assertRegex(service.web_line(), r"^https://dccast\.test/sign-in\.html#dccast-enrol-\w+-\w+$")
        first, second, line = service.tokens()
        self.assertEqual([first.is_of_this_call, second.is_of_this_call, line.is_secret], [True, False, True])
        self.assertEqual(first.last_use_address, "127.0.0.1")
        self.assertIn("(this login)", self.dccast("tokens").stdout)
        self.assertIn("line, not used yet", self.dccast("tokens").stdout)
        self.assertTrue(json.loads(self.dccast("tokens", "--json").stdout)[0]["is_this_login"])
        self.assertIn("/sign-in.html#dccast-enrol-", self.dccast("web-line").stdout)
        self.assertIn("/sign-in.html#", json.loads(self.dccast("web-line", "--json").stdout)["link"])

        service.revoke_token(second.id)
        with self.assertRaises(dccast.DccastError) as caught:
            other.tokens()
        self.assertEqual(caught.exception.code, "UNAUTHENTICATED")
        self.assertEqual(self.dccast("tokens", "--end", line.id).returncode, 0)
        self.assertEqual(self.dccast("tokens", "--end", line.id).returncode, 5)

    def test_without_unix_sockets_as_on_windows(self):
        self.start()
        self.from_here()
        dccast.login(self.line_for("anna"))
        script = textwrap.dedent("""
            import socket
            del socket.AF_UNIX
            import importlib, pkgutil
            import dccast
            for module in pkgutil.walk_packages(dccast.__path__, "dccast."):
                importlib.import_module(module.name)
            print(dccast.connect().info().workers > 0)
            """)

        def said(**more):
            return subprocess.run([sys.executable, "-c", script], env={**os.environ, **more},
                                  capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual(said().stdout, "True\n", said().stderr)
        self.assertIn("no server is named", said(XDG_CONFIG_HOME=self.folder).stderr)

    def test_a_viewer_reads_cases_and_submits_none(self):
        service = self.connect("viewer")
        service.validate(CASE, QUICK)
        with self.assertRaises(dccast.DccastError) as caught:
            service.submit(CASE, QUICK)
        self.assertEqual(caught.exception.code, "PERMISSION_DENIED")


class Packaging(unittest.TestCase):
    def test_the_version_is_that_of_the_command(self):
        printed = subprocess.run([os.path.join(BIN, "dccast"), "--version"], capture_output=True, text=True,
                                 check=True).stdout
        self.assertIn(f" {dccast.__version__} ", printed.replace("\n", " "))

    def test_types_are_complete(self):
        ended = subprocess.run(["mypy", "--config-file", "pyproject.toml", "--cache-dir",
                                os.devnull], cwd=os.path.dirname(PACKAGE), capture_output=True,
                               text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)

    def test_everything_public_has_a_text(self):
        silent = []
        for name in MODULES:
            module = importlib.import_module("dccast" + name)
            for kind in (k for k in vars(module).values() if inspect.isclass(k)):
                if kind.__module__ == module.__name__ and not kind.__name__.startswith("_"):
                    silent += [f"{kind.__name__}.{member}" for member in list(vars(kind))
                               if not member.startswith("_") and member not in kind.__annotations__
                               and not inspect.getdoc(getattr(kind, member))]
        self.assertEqual(silent, [])

    def test_a_wheel_has_the_package_with_its_types(self):
        script = "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"
        with tempfile.TemporaryDirectory() as folder:
            copy = os.path.join(folder, "source")
            shutil.copytree(os.path.dirname(PACKAGE), copy)
            subprocess.run([sys.executable, "-c", script, folder], cwd=copy, check=True,
                           capture_output=True)
            wheel, = pathlib.Path(folder).glob("dccast-*-py3-none-any.whl")
            names = zipfile.ZipFile(wheel).namelist()
        for name in ("dccast/__init__.py", "dccast/py.typed", "dccast/v1/service_pb2_grpc.py",
                     "dccast/v1/case_pb2.pyi", "dccast/logins.py"):
            self.assertIn(name, names)

    def test_the_settings_file_names_the_server(self):
        script = "from dccast.transport import endpoint; print(endpoint(None).address)"
        environment = {"PATH": os.environ["PATH"], "PYTHONPATH": os.environ["PYTHONPATH"]}
        file = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "client.toml"
        file.write_text('server = "caster"\n[submit]\npriority = "low"\n')

        def said(**more):
            return subprocess.run([sys.executable, "-c", script], env={**environment, **more},
                                  capture_output=True, text=True, check=False)
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(file.with_name("dccastd.sock")))
            listener.listen()
            self.assertEqual(said(HOME="/nonexistent", XDG_RUNTIME_DIR=str(file.parent)).stdout,
                             f"unix:{listener.getsockname()}\n")
        self.assertIn("there is no login for caster:7118", said(DCCAST_CONFIG=str(file)).stderr)
        logins = file.with_name("servers.toml")
        logins.write_text('[[server]]\nname = "plant"\naddress = "caster:7118"\nca = "x"\n')
        logins.chmod(0o644)
        self.assertIn("other users may read", said(DCCAST_CONFIG=str(file)).stderr)
        logins.chmod(0o600)
        for named in ("plant", "caster", "caster:7118"):
            self.assertEqual(said(DCCAST_CONFIG=str(file), DCCAST_SERVER=named).stdout, "caster:7118\n")
        self.assertIn("there is no login for [::1]:7118",
                      said(DCCAST_CONFIG=str(file), DCCAST_SERVER="[::1]").stderr)
        self.assertIn("there is no such file", said(DCCAST_CONFIG=str(file) + "x").stderr)


if __name__ == "__main__":
    main()
