#!/usr/bin/python3
"""The shipped start-up case on the real solver, submitted by the real command line client."""
import hashlib
import json
import os
import signal
import subprocess

import grpc
import h5py
import numpy

from dccast.v1 import job_pb2
from support import ServiceTest, main
from waiting import WAIT_FACTOR

CASE = os.path.join(os.path.dirname(__file__), "..", "..", "cases", "start-2d-thickness.toml")
CHECK = os.path.join(os.path.dirname(__file__), "..", "unit", "results", "check_results_file.py")


def physics(steps):
    """The reports without what the clock says; serialised, so that every bit counts."""
    for step in steps:
        step.ClearField("solver_s")
        step.ClearField("process_s")
    return [step.SerializeToString(deterministic=True) for step in steps]


class RealRunTest(ServiceTest):
    """The real worker, and the real client that gives it the shipped case."""
    worker = "dccast-worker"

    def submit_case(self, *changes, path=CASE):
        words = [word for change in changes for word in ("--set", change)]
        return json.loads(self.run_dccast("submit", "--json", *words, path).stdout)["id"]

    def finished_steps(self, job_id):
        events = self.sound_events(list(self.client.watch(job_id, timeout=120 * WAIT_FACTOR)))
        self.assertEqual(events[-1].state_change.state, job_pb2.SUCCEEDED, events[-1])
        return events, self.client.steps(job_id)


class RealRun(RealRunTest):
    def test_runs_interrupted_in_every_way_give_the_same_bits(self):
        undisturbed = self.submit_case()
        events, steps = self.finished_steps(undisturbed)
        expected = physics(steps)
        seconds = [e.time.seconds + e.time.nanos * 1e-9 for e in events if e.HasField("step")]
        computed = [e.step.solver_s for e in events if e.HasField("step")]
        print(f"\n{len(steps)} steps in {seconds[-1] - seconds[0]:.2f} s, "
              f"of which the solver says {computed[-1] - computed[0]:.2f} s")

        killed = self.submit_case()
        self.client.until_step(killed, 120, seconds=60)
        os.kill(self.daemon.worker_processes()[0], signal.SIGKILL)
        self.assertEqual(physics(self.finished_steps(killed)[1]), expected)
        self.assertEqual(self.client.job(killed).attempts, 2)

        for stop in (self.daemon.terminate, self.daemon.kill_with_workers):
            job_id = self.submit_case()
            self.client.until_step(job_id, 100, seconds=60)
            stop()
            self.restart()
            events, steps = self.finished_steps(job_id)
            self.assertEqual(physics(steps), expected)
            self.assertEqual([event.HasField("resumed") for event in events].count(True), 1)

    def test_fetched_files_can_move_together(self):
        job_id = self.submit_case()
        self.finished_steps(job_id)
        here, there = self.in_folder("here"), self.in_folder("there")
        os.mkdir(here)
        self.run_dccast("fetch", job_id, "-o", os.path.join(here, "run.h5"))
        os.rename(here, there)
        checked = subprocess.run(["/usr/bin/python3", CHECK, os.path.join(there, "run.h5")],
                                 capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)

    def test_one_answer_names_every_fault_that_can_be_judged(self):
        with open(CASE, encoding="utf-8") as shipped:
            text = shipped.read()
        for right, wrong in (('half_width = "0.28 m"', "half_width = 0.28"),  # unit missing
                             ('card = "paper"', 'card = "paper"\ncoherency = "700 degC"'),
                             ('name = "mid"', 'name = "corner"'),
                             ('\nend = "145 s"', '\nend = "9e5 s"')):
            self.assertEqual(text.count(right), 1, right)
            text = text.replace(right, wrong)

        path = self.write_file("faulty.toml", text)
        answer = json.loads(self.run_dccast("validate", "--json", path, code=2).stdout)
        self.assertEqual([fault["field"] for fault in answer["faults"]],
                         ["section.half_width", "alloy.coherency", "time.step", "monitor[1].name"])

        waits = {warning["field"]: warning["line"] for warning in answer["warnings"]
                 if "wait until this is fixed" in warning["message"]}
        self.assertEqual(set(waits), {"section.half_width", "time.step"})
        self.assertTrue(all(line > 0 for line in waits.values()))

    def test_results_and_the_last_frame(self):
        job_id = self.submit_case()
        self.finished_steps(job_id)
        artifact = self.client.job(job_id).artifacts[0]
        content = b"".join(chunk.data for chunk in self.client.fetch(job_id))

        self.assertEqual(hashlib.sha256(content).hexdigest(), artifact.sha256)
        self.assertEqual(content[:8], b"\x89HDF\r\n\x1a\n")

        frame = self.client.ask("QueryResult", id=job_id, frame=True).frame
        self.assertAlmostEqual(frame.time_s, 145)

        nodes = len(frame.temperature_c)
        self.assertEqual(len(frame.node_m), 2 * nodes)
        self.assertEqual(len(frame.displacement_m), 2 * nodes)
        self.assertLess(max(frame.element_node), nodes)
        self.assertGreater(frame.liquidus_c, frame.solidus_c)

    def test_results_name_their_origin_and_differ_in_nothing_else(self):
        folders = []
        for number in range(2):
            job_id = self.submit_case("quality=draft")
            self.finished_steps(job_id)
            folder = self.in_folder(str(number))
            os.mkdir(folder)
            self.dccast("fetch", job_id, "-o", folder)
            folders.append((job_id, folder))
        contents = []
        for job_id, folder in folders:
            with open(os.path.join(folder, "results.h5"), "rb") as file:
                contents.append(file.read())
            with open(os.path.join(folder, "results-run.json"), encoding="utf-8") as file:
                facts = json.load(file)
            self.assertEqual(facts["case_sha256"], self.client.job(job_id).case_sha256)
            self.assertEqual(facts["job"], job_id)
            self.assertGreater(facts["wall_s"], 0)
            for name in ("processor", "system", "begin", "end", "commit", "program_version"):
                self.assertTrue(facts[name], name)
            self.assertIn(facts["case_sha256"].encode(), contents[-1])
            self.assertIn(facts["commit"].encode(), contents[-1])
        self.assertEqual(contents[0], contents[1])

    def page(self, job_id, number, **rest):
        return self.client.ask("QueryResult", id=job_id, frame=True, frame_number=number, **rest)

    def test_every_stored_frame_can_be_asked_for(self):
        job_id = self.submit_case("quality=draft")
        self.finished_steps(job_id)
        last = self.page(job_id, 0)
        times = list(last.frame_time_s)

        self.assertEqual(times, [-60 + 10 * i for i in range(21)] + [145])
        self.assertEqual(last.frame.time_s, 145)
        self.assertEqual(self.page(job_id, len(times)).frame, last.frame)

        first = self.page(job_id, 1, page_size=1)
        self.assertEqual((first.frame.time_s, len(first.steps)), (-60, 1))
        self.assertLess(len(first.frame.temperature_c), len(last.frame.temperature_c))
        self.assertEqual(self.page(job_id, 10).frame.time_s, times[9])

        error = self.refused(grpc.StatusCode.OUT_OF_RANGE, self.page, job_id, len(times) + 1)
        self.assertIn(f"has {len(times)} frames", error.details())

        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.page, job_id, -1)

    def test_every_field_of_a_frame_can_be_asked_for(self):
        job_id = self.submit_case("quality=draft", "time.end=20 s")
        self.finished_steps(job_id)
        self.assertEqual(self.client.job(job_id).quality, "draft")
        path = self.in_folder("results.h5")
        with open(path, "wb") as file:
            for chunk in self.client.fetch(job_id):
                file.write(chunk.data)
        mesh = self.page(job_id, 0).frame
        names = [field.name for field in mesh.fields]
        for name in ("solid_fraction", "von_mises_pa", "principal_stress_pa", "tear_pressure_pa",
                     "equivalent_viscoplastic_strain", "gap_m"):
            self.assertIn(name, names)
        with h5py.File(path) as results:
            stored = results["frames"][sorted(results["frames"])[-1]]
            for name in names:
                asked = self.page(job_id, 0, field=name).frame
                self.assertEqual((len(asked.node_m), asked.time_s), (0, 20))
                expected = stored[name][:]
                if expected.ndim == 2:  # the largest
                    expected = expected[:, 0]
                numpy.testing.assert_allclose(asked.field.values, expected, rtol=1e-6)
                count = (len(mesh.temperature_c) if asked.field.on_nodes
                         else len(mesh.element_node) // mesh.nodes_per_element)
                self.assertEqual(len(asked.field.values), count, name)
        error = self.refused(grpc.StatusCode.NOT_FOUND, self.page, job_id, 0, field="colour")
        self.assertIn("colour", error.details())

    def test_frames_of_a_running_job(self):
        job_id = self.submit_case("quality=fine", "output.frame_interval=1 s")
        self.client.until_step(job_id, 40, seconds=60)
        running = self.page(job_id, 0)
        self.assertGreater(len(running.frame_time_s), 1)
        self.assertEqual(running.frame.time_s, running.frame_time_s[-1])
        self.assertEqual(self.page(job_id, 1).frame.time_s, running.frame_time_s[0])
        self.assertTrue(self.page(job_id, 0, field="solid_fraction").frame.field.values)
        self.assertEqual(self.client.job(job_id).state, job_pb2.RUNNING)
        self.client.cancel(job_id)

    def test_an_answer_stays_below_4_mib_however_large_frame_and_steps_are(self):
        """gRPC's own bound on a message; the client of these tests takes no more."""
        with open(CASE, encoding="utf-8") as shipped:
            text = shipped.read()
        monitors = "".join(f'[[monitor]]\nname = "{number} {"x" * 58}"\nx = "0 m"\ny = "0 m"\n'
                           for number in range(990))
        path = self.write_file("large.toml", text + monitors)
        changes = ("mesh.columns=400", "mesh.rows=187", "mesh.growth_cell=1 mm",
                   "mechanics.enabled=false", "schedule.hold=0 s", "time.end=2 s",
                   "time.step=0.2 s", "schedule.casting_speed=50 mm/s")
        job_id = self.submit_case(*changes, path=path)
        self.client.until_state(job_id, job_pb2.SUCCEEDED, job_pb2.FAILED, seconds=120)
        page = self.page(job_id, 1)

        self.assertGreater(page.frame.ByteSize(), 3 << 20)
        self.assertLess(page.ByteSize(), 4 << 20)
        self.assertTrue(page.next_page_token)  # fewer steps, as the frame is large
        self.assertEqual([step.step for step in self.client.steps(job_id)], list(range(1, 11)))

        error = self.refused(grpc.StatusCode.RESOURCE_EXHAUSTED, self.page, job_id, 0)
        self.assertIn("fetch results.h5", error.details())
        self.assertLess(max(chunk.ByteSize() for chunk in self.client.fetch(job_id)), 1 << 20)


if __name__ == "__main__":
    main()
