#!/usr/bin/python3
"""Pause, resume, cancel and delete by the command line client, on the real solver."""
import json
import os
import re

from dccast.v1 import job_pb2
from support import ServiceTest, main
from waiting import stays, until

CASE = os.path.join(os.path.dirname(__file__), "..", "..", "cases", "start-2d-thickness.toml")


class RealSteering(ServiceTest):
    worker = "dccast-worker"
    settings = {"workers__count": 1}

    def wrong_state(self, *words, state, remedy):
        """Refused with exit code 6, the state it is in, and what to do instead."""
        ended = self.run_dccast(*words, code=6)
        self.assertEqual(ended.stdout, "")
        self.assertRegex(ended.stderr, rf"^dccast: job {words[1]} is {state}; .*{remedy}")

    def submit(self, columns=8):
        """A coarse thickness section in small steps: 800 of them in a second or two."""
        path = self.in_folder(f"{columns}.toml")
        with open(CASE, encoding="utf-8") as shipped:
            text = shipped.read()
        mesh = (f'[mesh]\ncolumns = {columns}\nrows = 22\nside_cell = "10 mm"\n'
                'bottom_cell = "10 mm"\ngrowth_cell = "4.9 mm"\n\n')
        for pattern, coarse in ((r"(?s)^\[mesh\].*?(?=^\[)", mesh),
                                (r'(?s)^\[time\].*?(?=^\[)', '[time]\nend = "145 s"\nstep = "0.2 s"\n\n')):
            text, changes = re.subn(pattern, coarse, text, flags=re.M)
            self.assertGreater(changes, 0, pattern)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return self.dccast("submit", path).strip()

    def running_at_step(self, step):
        job_id = self.submit()
        self.client.until_step(job_id, step)
        self.assertEqual(self.client.job(job_id).state, job_pb2.RUNNING)
        return job_id

    def folder_of(self, job_id):
        return self.in_folder("data", "jobs", job_id)

    def results(self, job_id):
        """What a finished job leaves: every report bit by bit, and its files by their checksums."""
        self.client.until_state(job_id, job_pb2.SUCCEEDED, seconds=60)
        steps = self.client.steps(job_id)
        for step in steps:
            step.ClearField("solver_s")
            step.ClearField("process_s")
        files = {a.name: a.sha256 for a in self.client.job(job_id).artifacts}
        self.assertEqual(set(files), {"results.h5", "results.xdmf", "results-end.xdmf"})
        return [step.SerializeToString(deterministic=True) for step in steps], files

    def assert_stands_still(self, job_id):
        until(lambda: not self.daemon.worker_processes(), 10)
        step = self.client.job(job_id).last_step.step

        def stands():
            job = self.client.job(job_id)
            return (job.state, job.last_step.step) == (job_pb2.PAUSED, step)
        stays(stands, 0.3)
        return step

    def test_paused_at_a_checkpoint_and_resumed_to_the_same_bits(self):
        undisturbed = self.results(self.submit())
        job_id = self.running_at_step(60)
        self.dccast("pause", job_id)
        self.client.until_state(job_id, job_pb2.PAUSED)
        step = self.assert_stands_still(job_id)
        self.assertTrue(os.path.exists(os.path.join(self.folder_of(job_id), "checkpoint.bin")))
        self.assertEqual(self.dccast("pause", job_id), f"{job_id} paused\n")  # again: as it is

        self.daemon.terminate()  # a paused job stays so when the daemon starts again
        self.restart()
        self.assertEqual(self.assert_stands_still(job_id), step)
        self.dccast("resume", job_id)
        events = self.sound_events(list(self.client.watch(job_id)))
        # At the very step it was paused after: nothing is computed twice.
        self.assertEqual([e.resumed.step for e in events if e.HasField("resumed")], [step])
        self.assertEqual(self.results(job_id), undisturbed)
        self.assertEqual(self.client.job(job_id).attempts, 2)

    def test_a_queued_job_paused_stays_behind_and_is_resumed(self):
        undisturbed = self.results(self.submit())
        ahead = self.running_at_step(1)
        queued = self.submit()
        self.assertEqual(self.client.job(queued).queue_position, 1)
        self.assertEqual(self.dccast("pause", queued), f"{queued} paused\n")
        self.results(ahead)  # its worker is free from here on
        self.assert_stands_still(queued)
        self.assertEqual(self.client.job(queued).attempts, 0)
        self.dccast("resume", queued)
        self.assertEqual(self.results(queued), undisturbed)
        self.assertEqual(self.client.job(queued).attempts, 1)

    def test_cancelled_and_deleted_nothing_is_left(self):
        running = self.running_at_step(5)
        queued = self.submit()
        self.assertEqual(self.dccast("cancel", queued, "--reason", "wrong alloy"),
                         f"{queued} cancelled\n")

        self.dccast("cancel", running)
        self.client.until_state(running, job_pb2.CANCELLED)
        until(lambda: not self.daemon.worker_processes(), 10)
        last = list(self.client.watch(queued))[-1].state_change
        self.assertTrue(last.terminal)
        self.assertIn("wrong alloy", last.cause)

        succeeded = self.submit()
        self.results(succeeded)
        for job_id in (running, queued, succeeded):
            self.assertTrue(os.path.exists(self.folder_of(job_id)))
            self.assertEqual(json.loads(self.dccast("delete", "--json", job_id)),
                             {"id": job_id, "deleted": True})
            self.assertFalse(os.path.exists(self.folder_of(job_id)))
            for command in ("show", "watch", "fetch", "report", "delete", "resume"):
                self.assertIn(f"there is no job {job_id}", self.dccast(command, job_id, code=5))
        self.assertEqual(os.listdir(self.in_folder("data", "jobs")), [])

        self.daemon.terminate()
        self.restart()
        self.assertEqual(json.loads(self.dccast("list", "--json")), [])

    def test_a_paused_job_can_be_cancelled_and_then_deleted(self):
        job_id = self.running_at_step(5)
        self.dccast("pause", job_id)
        self.client.until_state(job_id, job_pb2.PAUSED)
        self.wrong_state("delete", job_id, state="PAUSED", remedy="cancel it first")
        self.assertEqual(self.dccast("cancel", job_id), f"{job_id} cancelled\n")
        self.dccast("delete", job_id)
        self.assertFalse(os.path.exists(self.folder_of(job_id)))

    def test_what_a_state_does_not_permit_is_refused_with_a_remedy(self):
        running = self.submit(columns=40)  # stays so for seconds
        self.client.until_step(running, 1)
        queued = self.submit()
        for job_id, state in ((running, "RUNNING"), (queued, "QUEUED")):
            self.wrong_state("resume", job_id, state=state, remedy="goes on by itself")
            self.wrong_state("delete", job_id, state=state, remedy="cancel it first")
            self.wrong_state("fetch", job_id, state=state, remedy="watch it until it has ended")
        self.dccast("cancel", running)
        self.client.until_state(running, job_pb2.CANCELLED)
        self.results(queued)
        for job_id, state in ((running, "CANCELLED"), (queued, "SUCCEEDED")):
            for command in ("pause", "resume"):
                self.wrong_state(command, job_id, state=state, remedy="submit its case again")
            before = self.client.job(job_id)
            self.assertEqual(self.dccast("cancel", job_id), f"{job_id} {state.lower()}\n")
            self.assertEqual(self.client.job(job_id), before)  # left as it is


if __name__ == "__main__":
    main()
