#!/usr/bin/python3
"""Whatever becomes of the store, no job is lost: the daemon refuses or keeps aside, `dccastd check`
says what is wrong and puts it right, a backup of a working daemon can be restored."""
import contextlib
import os
import shutil
import sqlite3
import subprocess
import threading

import grpc
import h5py

from dccast.v1 import job_pb2, service_pb2, study_pb2
from support import BIN, Daemon, ServiceTest, fake_case, main

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
SUCCEEDED, PAUSED = job_pb2.SUCCEEDED, job_pb2.PAUSED
CANCELLED, QUEUED = job_pb2.CANCELLED, job_pb2.QUEUED


def flip_bit(path, offset, bit=3):
    with open(path, "r+b") as file:
        file.seek(offset)
        byte = file.read(1)[0]
        file.seek(offset)
        file.write(bytes([byte ^ (1 << bit)]))


def all_datasets(file):
    names = []
    file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return names


class StateTest(ServiceTest):
    settings = {"workers__count": 1}

    def setUp(self):
        super().setUp()
        self.data = self.in_folder("data")
        self.store = os.path.join(self.data, "jobs.sqlite")

    def command(self, *words, data=None):
        """Runs a subcommand of dccastd. Returns its exit code and what it printed."""
        ended = subprocess.run(
            [os.path.join(BIN, "dccastd"), *words, "--set", f"data_directory={data or self.data}"],
            capture_output=True, text=True, timeout=60, check=False)
        return ended.returncode, ended.stdout + ended.stderr

    def folders(self):
        return sorted(os.listdir(os.path.join(self.data, "jobs")))

    def jobs_in_every_state(self):
        """What each must be in the end; the daemon is killed with one of them running."""
        done = self.client.submit(fake_case("steps=30"), request_id="done")
        self.client.until_state(done.id, SUCCEEDED)
        paused = self.client.submit(fake_case("steps=2000 sleep_ms=5 checkpoint=5"))
        self.client.until_step(paused.id, 7)
        self.client.ask("PauseJob", id=paused.id)
        self.client.until_state(paused.id, PAUSED)
        running = self.client.submit(fake_case("steps=60 sleep_ms=20 checkpoint=7"))
        self.client.until_step(running.id, 9)
        cancelled = self.client.submit(fake_case("steps=3"))
        self.client.cancel(cancelled.id)
        waiting = [self.client.submit(fake_case("steps=4"), priority=job_pb2.LOW) for _ in range(3)]
        self.daemon.kill_with_workers()
        return {done.id: SUCCEEDED, paused.id: PAUSED, cancelled.id: CANCELLED,
                running.id: SUCCEEDED, **{job.id: SUCCEEDED for job in waiting}}

    def check_jobs(self, expected):
        for job_id, state in expected.items():
            self.client.until_state(job_id, state)
            if state == PAUSED:
                continue
            events = self.sound_events(list(self.client.watch(job_id)))
            self.assertEqual(events[-1].state_change.state, state)
            if state == SUCCEEDED:
                self.assertTrue(self.client.fetch(job_id))
        listed = self.client.ask("ListJobs", page_size=100).jobs
        self.assertEqual({job.id for job in listed}, set(expected))


class LostStore(StateTest):
    """Every way to lose the store: the daemon makes it again from the folders, without a loss."""

    def lose_and_repair(self, lose):
        expected = self.jobs_in_every_state()
        lose()
        before = self.folders()
        code, said = self.command("check")
        self.assertEqual(code, 3, said)
        self.assertEqual(self.folders(), before)
        self.restart()
        self.assertIn("built again from the folders", self.daemon.said())
        self.check_jobs(expected)  # a kill while jobs begin would leave the index behind them
        self.daemon.kill_with_workers()
        self.assertEqual(self.folders(), before)
        code, found = self.command("check", "--deep")
        self.assertEqual(code, 0, found)
        self.restart()
        self.check_jobs(expected)
        again = self.client.submit(fake_case("steps=30"), request_id="done")
        self.assertIn(again.id, expected)

    def test_removed(self):
        def remove():
            for end in ("", "-wal", "-shm"):
                os.remove(self.store + end)
        self.lose_and_repair(remove)

    def test_empty(self):
        def empty():
            for end in ("-wal", "-shm"):
                os.remove(self.store + end)
            os.truncate(self.store, 0)
        self.lose_and_repair(empty)

    def test_one_flipped_bit_in_the_header_of_the_wal(self):
        self.lose_and_repair(lambda: flip_bit(self.store + "-wal", 17))

    def test_restored_without_its_wal(self):
        self.lose_and_repair(lambda: os.remove(self.store + "-wal"))

    def test_not_a_database(self):
        def overwrite():
            os.remove(self.store + "-wal")
            with open(self.store, "wb") as file:
                file.write(b"This was a job store once." * 400)
        self.lose_and_repair(overwrite)

    def test_an_older_copy(self):
        first = self.client.submit(fake_case("steps=2"))
        self.client.until_state(first.id, SUCCEEDED)
        copy = self.in_folder("copy.sqlite")
        with contextlib.closing(sqlite3.connect(self.store)) as store, \
             contextlib.closing(sqlite3.connect(copy)) as target:
            store.backup(target)
        def restore():
            os.remove(self.store + "-wal")
            shutil.copy(copy, self.store)
        jobs = self.jobs_in_every_state
        self.jobs_in_every_state = lambda: {**jobs(), first.id: SUCCEEDED}
        self.lose_and_repair(restore)

    def test_one_flipped_bit_in_a_record_of_the_wal(self):
        """SQLite drops what follows: jobs are missing."""
        self.lose_and_repair(lambda: flip_bit(self.store + "-wal", 32 + 24 + 4096 + 40))

    def test_a_job_without_a_description_is_kept_aside_with_the_reason(self):
        expected = self.jobs_in_every_state()
        old = next(iter(expected))
        os.remove(os.path.join(self.data, "jobs", old, "description.bin"))
        for end in ("", "-wal", "-shm"):
            os.remove(self.store + end)
        code, said = self.command("check", "--repair")
        self.assertEqual(code, 3, said)
        self.assertIn("no description.bin", said)
        self.restart()
        quarantine = os.path.join(self.data, "quarantine")
        kept = [name for name in os.listdir(quarantine) if name.startswith(old)]
        self.assertTrue(os.path.exists(os.path.join(quarantine, kept[0], "results.h5")))


class OtherFormat(StateTest):
    """A data directory of another format is refused as a whole, with the remedy, and left alone."""
    settings = StateTest.settings | {"workers__other_version": "fail"}

    def other(self, path):
        """Writes format 2 into the header of a file."""
        with open(path, "r+b") as file:
            file.seek(8)
            file.write(b"\2\0\0\0\2\0\0\0")

    def refused(self, subject):
        with self.assertRaises(RuntimeError) as start:
            self.daemon.start()
        for said in (str(start.exception), self.command("check", "--repair")[1]):
            for part in (subject, "has data format 2", "reads format 4", "move it away",
                         "another data_directory"):
                self.assertIn(part, said)

    def test_of_a_job(self):
        job = self.client.submit(fake_case("steps=2"))
        self.client.until_state(job.id, SUCCEEDED)
        self.daemon.terminate()
        folder = os.path.join(self.data, "jobs", job.id)
        self.other(os.path.join(folder, "description.bin"))
        self.refused(folder)
        os.rename(folder, self.in_folder("away"))
        self.restart()
        self.client.until_state(self.client.submit(fake_case("steps=2")).id, SUCCEEDED)

    def test_of_a_study(self):
        study = self.client.ask("CreateStudy",
                                case=fake_case("steps=2"), refinement=study_pb2.RefinementPlan(levels=2))
        self.daemon.terminate()
        file = os.path.join(self.data, "studies", f"{study.id}.bin")
        self.other(file)
        self.refused(file)

    def test_of_a_line(self):
        self.daemon.terminate()
        os.makedirs(os.path.join(self.data, "lines"), exist_ok=True)
        file = os.path.join(self.data, "lines", "pit-3.bin")
        with open(file, "wb") as line:
            line.write(b"DCCASTLN" + bytes(8))
        self.other(file)
        self.refused(file)


class Folders(StateTest):
    def test_a_folder_without_a_job_goes_to_quarantine_and_comes_back(self):
        job = self.client.submit(fake_case("steps=3"))
        self.client.until_state(job.id, SUCCEEDED)
        self.daemon.terminate()
        with sqlite3.connect(self.store) as store:
            store.execute("PRAGMA foreign_keys = ON")
            store.execute("DELETE FROM job")
        store.close()
        # Make it look submitted and never acknowledged: its log ends after the first event.
        folder = os.path.join(self.data, "jobs", job.id)
        os.remove(os.path.join(folder, "accepted"))
        with open(os.path.join(folder, "events.log"), "r+b") as log:
            log.seek(16)
            log.truncate(16 + 8 + int.from_bytes(log.read(4), "little"))
        self.daemon.start()
        self.assertEqual(self.folders(), [])

        self.daemon.terminate()
        code, said = self.command("check")
        self.assertEqual(code, 0, said)
        self.assertIn(f"--adopt {job.id}", said)

        code, said = self.command("check", "--adopt", job.id)
        self.assertEqual(code, 0, said)

        self.restart()
        self.client.until_state(job.id, SUCCEEDED)

    def test_check_refuses_while_a_daemon_works(self):
        code, said = self.command("check", "--repair")
        self.assertEqual(code, 4)
        self.assertIn("another dccastd", said)

    def test_one_flipped_bit_in_the_events_costs_one_event(self):
        job = self.client.submit(fake_case("steps=50"))
        self.client.until_state(job.id, SUCCEEDED)
        before = list(self.client.watch(job.id))
        self.daemon.terminate()
        log = os.path.join(self.data, "jobs", job.id, "events.log")
        flip_bit(log, os.path.getsize(log) // 2)
        code, said = self.command("check")

        self.assertEqual(code, 0, said)
        self.assertIn("is lost", said)

        self.restart()
        after = self.sound_events(list(self.client.watch(job.id)))
        changed = [(old, new) for old, new in zip(before, after) if old != new]
        self.assertEqual(len(after), len(before))
        self.assertEqual(len(changed), 1)
        self.assertEqual(changed[0][1].message.level, job_pb2.JobEvent.Message.WARNING)

    def test_damaged_and_missing_results_are_told(self):
        ids = []
        for number in range(2):
            job = self.client.submit(fake_case(f"steps=3 n={number}"))
            self.client.until_state(job.id, SUCCEEDED)
            ids.append(os.path.join(self.data, "jobs", job.id))
        self.daemon.terminate()
        flip_bit(os.path.join(ids[0], "results.h5"), 5)
        self.assertEqual(self.command("check")[0], 0)
        self.assertEqual(self.command("check", "--deep")[0], 3)
        os.remove(os.path.join(ids[1], "results.h5"))
        code, said = self.command("check", "--repair")
        self.assertEqual(code, 3)
        self.assertIn("results.h5 is missing", said)

    def test_a_lost_event_log_and_a_lost_folder(self):
        kept = self.client.submit(fake_case("steps=3"))
        gone = self.client.submit(fake_case("steps=3 n=2"))
        for job in (kept, gone):
            self.client.until_state(job.id, SUCCEEDED)
        self.daemon.terminate()
        os.remove(os.path.join(self.data, "jobs", kept.id, "events.log"))
        shutil.rmtree(os.path.join(self.data, "jobs", gone.id))
        code, said = self.command("check", "--repair")

        self.assertEqual(code, 3)
        self.assertIn(f"job {gone.id}: its folder is missing", said)

        self.restart()
        self.assertEqual(list(self.client.watch(kept.id))[-1].state_change.state, SUCCEEDED)

        self.client.ask("DeleteJob", id=gone.id)
        self.daemon.terminate()
        self.assertEqual(self.command("check")[0], 0)


def a_link(path):
    os.symlink(os.path.join(os.path.dirname(path), "elsewhere"), path)


ENTRIES = {"folder": os.mkdir, "named pipe": os.mkfifo, "symbolic link": a_link}


class UnreadableFiles(StateTest):
    """A file of a job that cannot be read costs its calls an answer with a remedy, and no path."""

    def test_of_a_job(self):
        job = self.client.submit(fake_case("steps=5")).id
        self.client.until_state(job, SUCCEEDED)
        folder = os.path.join(self.data, "jobs", job)
        query = service_pb2.QueryResultRequest(id=job, frame=True)
        calls = {"results.h5": [lambda: self.client.fetch(job),
                                lambda: self.client.stub.QueryResult(query, timeout=20)],
                 "worker.log": [lambda: self.client.fetch(job, "worker.log")],
                 "case.toml": [lambda: self.client.fetch(job, "case.toml")]}
        for name, asked in calls.items():
            path = os.path.join(folder, name)
            for kind, make in {**ENTRIES, "nothing": None}.items():
                if os.path.lexists(path):
                    os.rename(path, path + ".kept")
                if make:
                    make(path)
                elif name != "results.h5":
                    continue  # they need not be there
                for call in asked:
                    with self.subTest(name=name, kind=kind):
                        error = self.refused(grpc.StatusCode.DATA_LOSS, call)
                        self.assertNotIn(self.data, error.details())
                        self.assertRegex(error.details(), "dccastd check|run the job again")
                if make:
                    shutil.rmtree(path) if kind == "folder" else os.remove(path)
                if os.path.exists(path + ".kept"):
                    os.rename(path + ".kept", path)
        self.client.fetch(job)


class ReplacedFiles(StateTest):
    """Something else than a file in the place of one of the daemon's own."""

    def test_the_store_is_made_again_and_what_was_there_kept(self):
        job = self.client.submit(fake_case("steps=5")).id
        self.client.until_state(job, SUCCEEDED)
        self.daemon.terminate()
        for kind, make in ENTRIES.items():
            with self.subTest(kind=kind):
                os.remove(self.store)
                make(self.store)
                code, said = self.command("check")
                self.assertEqual(code, 3)
                self.assertIn(f"is a {kind}, not a regular file", said)
                self.assertIn("--repair", said)
                code, said = self.command("backup", "--to", self.in_folder("copy"))
                self.assertIn("dccastd check --repair", said)
                if kind == "folder":  # the others by the daemon itself
                    self.assertEqual(self.command("check", "--repair")[0], 0)
                self.restart()
                self.assertEqual(self.client.job(job).state, SUCCEEDED)
                self.daemon.terminate()
                self.assertTrue(os.path.isfile(self.store) and not os.path.islink(self.store))
        self.assertFalse(os.path.exists(os.path.join(self.data, "elsewhere")))

    def test_in_one_job_others_go_on_and_a_check_comes_to_its_end(self):
        replaced = self.client.submit(fake_case("steps=5")).id
        other = self.client.submit(fake_case("steps=5")).id
        for job in (replaced, other):
            self.client.until_state(job, SUCCEEDED)
        self.daemon.terminate()
        saved = self.in_folder("saved")
        shutil.copytree(self.data, saved)
        for name in ("events.log", "description.bin", "marks", "request", "accepted"):
            for kind, make in ENTRIES.items():
                with self.subTest(name=name, kind=kind):
                    shutil.rmtree(self.data)
                    shutil.copytree(saved, self.data)
                    path = os.path.join(self.data, "jobs", replaced, name)
                    if os.path.exists(path):
                        os.remove(path)
                    make(path)
                    code, said = self.command("check", "--deep")
                    self.assertIn(code, (0, 3), said)
                    self.restart()
                    self.assertEqual(self.client.job(other).state, SUCCEEDED)
                    self.client.fetch(other)
                    again = self.client.submit(fake_case("steps=3")).id
                    self.client.until_state(again, SUCCEEDED)
                    self.daemon.terminate()
                    code, said = self.command("check", "--repair")
                    self.assertIn(code, (0, 3), said)
                    self.assertEqual(code, 3 if name == "description.bin" else 0, said)

    def test_of_others_the_refusal_says_what_to_do(self):
        self.daemon.terminate()
        for name in ("audit.log", "lock"):
            path = os.path.join(self.data, name)
            for kind, make in ENTRIES.items():
                with self.subTest(name=name, kind=kind):
                    if os.path.lexists(path):
                        os.remove(path)
                    make(path)
                    if name == "audit.log":
                        self.assertNotEqual(self.command("audit")[0], 0)  # and it does not wait
                    with self.assertRaises(RuntimeError) as refused:
                        self.daemon.start()
                    self.assertIn(f"is a {kind}, not a regular file (move it away)",
                                  str(refused.exception))
                    shutil.rmtree(path) if kind == "folder" else os.remove(path)
        self.restart()


class ChangedResults(StateTest):
    """What was changed after the run is shown by no call."""
    worker = "dccast-worker"

    def test_frames_and_reports(self):
        path = os.path.join(ROOT, "cases", "start-2d-thickness.toml")
        job = self.dccast("submit", path, "--set", "quality=draft", "--set", "time.end=20 s").strip()
        self.client.until_state(job, SUCCEEDED, seconds=60)
        query = service_pb2.QueryResultRequest(id=job, frame=True)
        self.assertTrue(self.client.stub.QueryResult(query, timeout=20).HasField("frame"))

        results = os.path.join(self.data, "jobs", job, "results.h5")
        # A value of a dataset, which HDF5 reads as any other.
        with h5py.File(results, "r+") as file:
            name = next(name for name in all_datasets(file) if name.endswith("displacement_m"))
            file[name][...] = 2.0
        error = self.refused(grpc.StatusCode.DATA_LOSS, self.client.stub.QueryResult, query,
                             timeout=20)
        self.assertRegex(error.details(), "size|SHA-256")

        report = self.in_folder("report.html")
        shown = self.dccast("report", job, "-o", report, code=4)
        self.assertIn("without a picture of the slab", shown)
        self.assertTrue(os.path.exists(report))

        self.dccast("fetch", job, "-o", report + ".h5", code=4)
        # Histories are those of the event log.
        self.assertGreater(len(self.client.steps(job)), 5)


class Backup(StateTest):
    settings = {"workers__count": 2}

    def submit_until(self, stop, ids):
        client = self.new_client()
        while not stop.is_set():
            ids.append(client.submit(fake_case(f"steps=40 sleep_ms=2 checkpoint=3 n={len(ids)}")).id)

    def test_of_a_daemon_under_load(self):
        stop, ids = threading.Event(), []
        load = threading.Thread(target=self.submit_until, args=(stop, ids))
        load.start()
        try:
            while len(ids) < 15:
                stop.wait(0.05)
            acknowledged = list(ids)
            deleted = self.client.until_state(ids[0], SUCCEEDED)
            backup = self.in_folder("backup")
            code, said = self.command("backup", "--to", backup)
            self.assertEqual(code, 0, said)
        finally:
            stop.set()
            load.join()
        self.assertEqual(self.client.job(deleted.id).state, SUCCEEDED)  # the daemon goes on

        self.daemon.kill_with_workers()
        self.assertEqual(subprocess.run(["sha256sum", "--quiet", "-c", "MANIFEST.sha256"],
                                        cwd=backup, check=False).returncode, 0)

        self.restore(backup, acknowledged)

    def restore(self, backup, acknowledged):
        restored = self.in_folder("restored")
        code, said = self.command("restore", "--from", backup, data=restored)
        self.assertEqual(code, 0, said)
        self.assertEqual(self.command("check", "--deep", data=restored)[0], 0)
        other = self.in_folder("other")
        os.mkdir(other)
        self.daemon = Daemon(other, workers__count=4, data_directory=restored).start()
        self.client = self.new_client()
        for job_id in acknowledged:
            self.client.until_state(job_id, SUCCEEDED)
            self.sound_events(list(self.client.watch(job_id)))
            self.assertEqual([step.step for step in self.client.steps(job_id)],
                             list(range(1, 41)))

    def test_a_backup_after_another_takes_room_for_what_is_new_alone(self):
        jobs = []
        backups = [self.in_folder(name) for name in ("monday", "tuesday")]
        for backup, words in zip(backups, ([], ["--earlier", backups[0]])):
            jobs.append(self.client.submit(fake_case("steps=3")).id)
            self.client.until_state(jobs[-1], SUCCEEDED)
            code, said = self.command("backup", "--to", backup, *words)
            self.assertEqual(code, 0, said)
        self.assertRegex(said, r"2 jobs copied to \S+tuesday, \d+ of its files linked to those of \S+monday")
        linked = [os.stat(os.path.join(backups[1], "jobs", job, "results.h5")).st_nlink for job in jobs]
        self.assertEqual(linked, [2, 1])

        # Each is whole without the other.
        shutil.rmtree(backups[0])
        code, said = self.command("restore", "--from", backups[1], data=self.in_folder("restored"))
        self.assertEqual(code, 0, said)
        code, said = self.command("backup", "--to", self.in_folder("next"), "--earlier", backups[0])
        self.assertEqual(code, 4)
        self.assertIn("not a backup, or an incomplete one", said)

    def test_a_damaged_or_unfinished_backup_is_refused(self):
        job = self.client.submit(fake_case("steps=3"))
        self.client.until_state(job.id, SUCCEEDED)
        backup = self.in_folder("backup")
        self.assertEqual(self.command("backup", "--to", backup)[0], 0)

        code, said = self.command("backup", "--to", backup)
        self.assertEqual(code, 4)
        self.assertIn("not empty", said)

        code, said = self.command("restore", "--from", backup)
        self.assertEqual(code, 4)  # a daemon has this data directory

        flip_bit(os.path.join(backup, "jobs", job.id, "results.h5"), 2)
        fresh = self.in_folder("fresh")
        code, said = self.command("restore", "--from", backup, data=fresh)
        self.assertEqual(code, 4)
        self.assertIn("results.h5 is damaged", said)

        os.remove(os.path.join(backup, "MANIFEST.sha256"))
        code, said = self.command("restore", "--from", backup, data=fresh + "2")
        self.assertIn("not a backup, or an incomplete one", said)


if __name__ == "__main__":
    main()
