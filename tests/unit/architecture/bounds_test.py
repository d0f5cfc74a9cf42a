#!/usr/bin/python3
"""The table of bounds of docs/operations.md is complete: each row is in the sources, each bound has a row.

A row names what one peer or one job decides. What holds it are texts of the sources, which must be there;
a number that stands in the row and in the source alike is changed in both. A new constant of a room in which
peers decide is a row, or is named below with the reason why it is none.
"""
import re
import unittest

from sources_test import ROOT

PAGE = "docs/operations.md"
RELAY, JOBS = "server/relay/", "server/jobs/"
# First cell of the row, what is in the sources, and what of it the row says.
ROWS = [
    ("work of one turn of the relay: reads, writes, handshakes", RELAY + "turn_budget.hpp",
     ["most_bytes = 512 * 1024", "most_transfers = 128", "most_time{1000}"], ["512 kB", "128 transfers", "1 ms"]),
    ("records of TLS without content: renewed keys, alerts, empty ones", RELAY + "byte_stream.cpp",
     ["empty_{1.0, 32.0}"], ["32, then one a second"]),
    ("records of a TLS handshake", RELAY + "byte_stream.cpp", ["most_of_handshake = 128"], ["128"]),
    ("pings, settings, priorities, empty frames of HTTP/2", RELAY + "frame_guard.hpp",
     ["others_{200.0, 1000.0}"], ["1,000, then 200 a second"]),
    ("updates of windows", RELAY + "frame_guard.hpp", ["updates_{20000.0, 40000.0}"],
     ["40,000, then 20,000 a second"]),
    ("calls begun", RELAY + "frame_guard.hpp", ["begun_{2000.0, 10000.0}"], ["10,000, then 2,000 a second"]),
    ("calls begun before the bound on them is acknowledged", RELAY + "frame_guard.cpp",
     ["most_begun_before_acknowledgement = 100"], ["100"]),
    ("headers of one call", RELAY + "frame_guard.cpp", ["most_of_a_header_block = 64 * 1024"], ["64 KiB"]),
    ("calls taken back on one connection", RELAY + "frame_guard.hpp", ["resets_{1000.0, 2000.0}"],
     ["2,000, then 1,000 a second"]),
    ("calls taken back", RELAY + "reset_toll.hpp", ["of_each{4}", "free_at_once = 200", "longest_wait{5}"],
     ["200, then 250 a second", "5 s"]),
    ("connections", RELAY + "acceptor.cpp", ["kept_for_root = 16", "bounds_.per_peer"],
     ["limits.maximum_connections_per_peer", "16"]),
    ("TLS handshakes at once", RELAY + "acceptor.cpp", ["most_in_handshake = 64"], ["64"]),
    ("returns after such an end", RELAY + "acceptor.cpp", ["delay_per_hostile{25}", "longest_delay{5000}"],
     ["25 ms", "5 s"]),
    ("memory of unfinished requests", "server/service/server.cpp", ["all = 96'000'000", "of_user = 80'000'000",
     "of_strangers = 16'000'000", "of_machine = 8'000'000"], ["96 MB; 80 MB", "16 MB", "8 MB"]),
    ("calls", "server/service/gate.cpp", ["per_user.maximum_calls_per_s"], ["per_user.maximum_calls_per_s"]),
    ("streams that are open", "server/access/limits.cpp", ["per_user.maximum_{}"],
     ["limits.maximum_streams", "per_user.maximum_streams"]),
    ("tokens of a user", "server/access/users.cpp", ["largest_number_of_credentials = 100"], ["100"]),
    ("refusals in the audit log", "server/service/gate.cpp", ["recorded_refusals_per_s = 10.0"], ["10 a second"]),
    ("a field of the audit log", "server/access/audit.cpp", ["longest_text = 300"], ["300 bytes"]),
    ("precedence over other runs", JOBS + "executors/precedence.hpp", ["longest_hold{30}"], ["30 s", "twice"]),
    ("damage of a job's own files, or one that is missing", JOBS + "queue/attempts.cpp", ["find_damage"],
     ["STORAGE"]),
    ("EIO from the files of one job, while the folder of all jobs can be written", JOBS + "queue/queue_loop.cpp",
     ["most_in_a_row = 3"], ["three times"]),
    ("castings that are followed at once", JOBS + "queue/queue_state.cpp",
     ["per_user.maximum_followed", "limits.maximum_followed"],
     ["per_user.maximum_followed", "limits.maximum_followed", "per_user.maximum_running"]),
    ("connections of the metrics port or the dashboard", "proto/http/server.hpp",
     ["connections = 256", "connections_of_address = 32"], ["256", "32"]),
    ("connections of the metrics port or the dashboard", "client/web/web_server.cpp", ["connections = 1024"],
     ["1,024"]),
    ("connections of the metrics port or the dashboard", "proto/http/server.cpp", ["longest_wait_for_room{1}"],
     ["1 s"]),
    ("attempts to sign in at `dccast-web`", "client/web/session_entrance.hpp",
     ["most_of_address = 10, most = 100"], ["10", "100"]),
    ("requests of a session at `dccast-web`", "client/web/session_entrance.hpp", ["most_under_way = 32"], ["32"]),
    ("work of one HTTP request", "proto/http/server.hpp", ["header_bytes = 8192", "time{5000}"], ["8 kB", "5 s"]),
    ("bodies of HTTP requests", "client/web/web_server.cpp", ["body_bytes = 2'200'000"], ["2.2 MB"]),
    ("bodies of HTTP requests", "proto/http/connection.cpp", ["least_bytes_per_s = 64 * 1024"], ["64 KiB/s"]),
    ("bodies of HTTP requests", "proto/http/server.hpp", ["all_bodies_bytes = 64 << 20"], ["64 MiB"]),
    ("processes of a worker", "server/worker/sandbox.cpp", ["permit_threads_alone"], ["threads alone"]),
    ("locks on files", "server/worker/sandbox.cpp", ["lock_filter"], ["none after its claim"]),
    ("wait of a running daemon for a lock of another process, on its users or its store",
     "core/storage/file_lock.hpp", ["longest_lock_wait{1000}"], ["1 s"]),
    ("wait of a running daemon for a lock of another process, on its users or its store",
     JOBS + "store/sqlite.hpp", ["storage::longest_lock_wait"], ["1 s"]),
    ("gauges of a casting", JOBS + "logs/readings_log.hpp", ["fits_record"], ["64 KiB"]),
    ("a reading", JOBS + "logs/readings_log.hpp", ["longest_entry = 64 * 1024"], ["64 KiB"]),
    ("a reading", "server/service/readings.cpp", ["most = 1000"], ["1,000 in a call"]),
    ("readings of a casting", JOBS + "logs/readings_log.hpp",
     ["most_readings = 100'000", "longest_record = 32'000'000", "least_spacing_s = 0.01"],
     ["100,000", "32 MB", "0.01 s"]),
    ("rate of readings", JOBS + "logs/readings_log.hpp",
     ["readings_per_s = 1000.0", "readings_at_once = 30'000.0"], ["30,000, then 1,000 a second"]),
    ("lines", "server/studies/lines.hpp", ["most_lines_of_user = 100"], ["100"]),
    ("castings of a line", "server/studies/lines.hpp", ["most_castings = 10'000", "most_casting_bytes = 8 << 20"],
     ["10,000", "8 MB"]),
    ("a message of Slurm", JOBS + "executors/slurm_commands.cpp", ["longest_message = 300"], ["300 bytes"]),
    ("a message of a topic", "client/session/mqtt.cpp", ["largest_packet = 1 << 24"], ["16 MB"]),
    ("time without a reading", JOBS + "queue/attempts.hpp", ["6 * stall"], ["six times"]),
    ("labels of a job or study", "server/service/refusals.cpp", ["most_labels = 20", "longest_label = 64"],
     ["20", "64 bytes"]),
    ("a page of a list", "server/service/refusals.cpp", ["largest_page = 1000"], ["1,000"]),
    ("an event of a worker", JOBS + "logs/event_log_scan.hpp", ["largest_event = 1u << 24"], ["16 MB"]),
]
# Rooms in which a peer or a job decides how much there is.
ROOMS = ["server/relay", "server/access", "server/jobs/logs", "server/jobs/queue", "proto/http"]
FILES = ["server/studies/lines.hpp", "server/studies/lines.cpp", "server/service/gate.cpp",
         "server/service/refusals.cpp", "server/service/readings.cpp"]
# Constants of these that bound nothing which a peer or a job decides, or part of a row.
NO_ROWS = {
    "largest_backlog": "ended jobs that wait for the hook: what a user starts is bounded by the queue",
    "longest_span": "of arithmetic",
    "shortest_interval": "between looks at a disk", "longest_interval": "between looks at a disk",
    "largest_storage_failures": "of the daemon's disk", "longest_simulated": "of arithmetic",
    "smallest_record": "a format", "longest_name": "refused where users are made, by an admin",
    "longest_machine": "shortened", "most_kept": "uses of tokens: the oldest is dropped",
    "largest_number_of_buckets": "full ones are dropped", "ns_per_s": "a unit",
    "largest_change": "a record of the file of a line; a request is within its row",
    "largest_file": "the file of a line, which is written anew; its castings are within its row",
    "most_bytes_of_changes": "of a request, which is bounded as a whole",
    "largest_details": "of an answer", "longest_report": "of a bug",
    "longest_time": "a value, not a number of them", "largest_curl": "a value, not a number of them",
    "longest": "a local wait",
}
CONSTANT = re.compile(r"constexpr [^=;(]*?\b((?:most|longest|largest|maximum|shortest|least|smallest)\w*|"
                      r"\w+_(?:at_once|per_s|bound|limit))\s*[={]")
ALLOWANCE = re.compile(r"(\w+_)\{[\d.']+, [\d.']+\}")


def rows_of_page():
    text = (ROOT / PAGE).read_text("utf-8").split("## Bounds\n", 1)[1].split("\n## ", 1)[0]
    rows = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in text.splitlines()
            if line.startswith("|")][2:]
    return {row[0]: " | ".join(row[1:]) for row in rows}


class Bounds(unittest.TestCase):
    def test_each_row_is_in_the_sources_with_its_figures(self):
        page = rows_of_page()
        self.assertEqual(sorted(page), sorted({row[0] for row in ROWS}))
        for name, file, in_source, in_row in ROWS:
            source = (ROOT / file).read_text("utf-8")
            with self.subTest(row=name):
                self.assertEqual([text for text in in_source if text not in source], [], file)
                self.assertEqual([text for text in in_row if text not in page[name]], [], PAGE)

    def test_each_bound_of_these_rooms_is_a_row(self):
        shown = " ".join(text for row in ROWS for text in row[2])
        paths = [path for room in ROOMS for path in sorted((ROOT / room).glob("*.?pp"))]
        lost = []
        for path in [*paths, *map(ROOT.joinpath, FILES)]:
            text = path.read_text("utf-8")
            lost += [f"{path.relative_to(ROOT)}: {name}"
                     for name in [*CONSTANT.findall(text), *ALLOWANCE.findall(text)]
                     if name not in NO_ROWS and not re.search(rf"\b{name}\b", shown)]
        self.assertEqual(lost, [], "neither a row of the table nor named here as none")

    def test_what_is_named_as_no_row_is_there(self):
        texts = "".join(path.read_text("utf-8") for room in ROOMS for path in (ROOT / room).glob("*.?pp"))
        texts += "".join((ROOT / file).read_text("utf-8") for file in FILES)
        self.assertEqual([name for name in NO_ROWS if not re.search(rf"\b{name}\b", texts)], [])


if __name__ == "__main__":
    unittest.main()
