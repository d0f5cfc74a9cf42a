#!/usr/bin/python3
"""Which part may see which: scans includes, target links, packages and paths of the project."""
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
SOURCE_SUFFIXES = {".cpp", ".hpp", ".h", ".cc", ".c"}

# client -> proto <- server -> core, and nothing else.
PARTS_SEEN = {
    "client": {"client", "proto"},
    "proto": {"proto"},
    "server": {"server", "proto", "core"},
    "core": {"core"},
}

# A core room sees the rooms before it. Those named here see less.
CORE_ROOMS = ["base", "statistics", "storage", "mesh", "fem", "linalg", "material", "thermal", "mechanics",
              "results", "casting"]
CORE_ROOMS_SEEN = {room: set(CORE_ROOMS[:i + 1]) for i, room in enumerate(CORE_ROOMS)}
CORE_ROOMS_SEEN["results"] = {"results", "storage", "base"}
for room in ("mesh", "fem", "linalg", "material", "thermal", "mechanics"):  # no files
    CORE_ROOMS_SEEN[room] -= {"storage"}
CORE_ROOMS_SEEN["mechanics"] -= {"thermal"}  # the two meet only in casting
# Parts of casting: the time loop, in the folder of casting itself, sees both.
CASTING_PARTS = {"case": {"case"}, "findings": {"case", "findings"}}

# The daemon never runs a solver: of the server only these rooms see core, the others only what knows
# no physics.
SERVER_ROOMS_THAT_SEE_CORE = {"translate", "worker"}
CORE_ROOMS_WITHOUT_PHYSICS = {"base", "storage", "statistics"}

# Rooms of jobs, each with those that it sees; log and processes stand in the folder of jobs itself.
JOBS_ROOMS = {"folder": {"folder"}, "logs": {"folder", "logs"}, "store": {"folder", "store"}}
JOBS_ROOMS["executors"] = JOBS_ROOMS["logs"] | {"executors"}
JOBS_ROOMS["queue"] = JOBS_ROOMS["executors"] | JOBS_ROOMS["store"] | {"queue"}

# The log of the program, which all rooms of the server write to; the shipped cases, a target of their own.
NAMESPACES_OF_THEIR_OWN = {"server/jobs/log.hpp", "server/jobs/log.cpp", "proto/case_file/shipped.hpp"}

# Rooms of the client, each with those that it sees.
CLIENT_ROOMS = {"model": {"model"}, "session": {"model", "session"}}
CLIENT_ROOMS["text"] = CLIENT_ROOMS["html"] = {"model", "session", "text", "html"}
CLIENT_ROOMS["web"] = CLIENT_ROOMS["text"] | {"web"}
CLIENT_ROOMS["cli"] = CLIENT_ROOMS["text"] | {"cli"}
CLIENT_ROOMS["commands"] = CLIENT_ROOMS["cli"] | {"web", "commands"}

# Headers that only one place may include; tests of that place may too, and others named below.
ONLY_IN = {
    "hdf5.h": "core/results",
    "cholmod.h": "core/linalg",
    "sqlite3.h": "server/jobs/store",
}
# Libraries whose headers take seconds to compile stay behind one source of the client.
CLIENT_LIBRARIES = {"CLI/CLI.hpp": "client/cli/options.cpp", "nlohmann/json.hpp": "client/model/json.cpp"}
TESTS_THAT_LOOK_INTO_FILES = {"tests/unit/results": "hdf5.h"}
# A text for people in which a program looks for something, and the files that look into texts of gRPC,
# ssh, Slurm and HDF5.
TEXTS_FOR_PEOPLE = r"\b(?:message|reason|why|what|cause|remedy|further|held|fault|refused|details)(?:\(\))?"
PARSED_TEXT = re.compile(
    TEXTS_FOR_PEOPLE + r"\.(?:find|rfind|starts_with|ends_with|contains|includes|startsWith|endsWith|match"
    r"|indexOf|startswith|endswith|split|partition)\("
    + "|" + TEXTS_FOR_PEOPLE + r" *[!=]=+ *[\"'](?!$|[\"']|[A-Z_]+[\"'])"
    + r"|regex_(?:search|match)\(" + TEXTS_FOR_PEOPLE + r"|\bin (?:error\.details\(\)|str\(error\))")
READS_TEXTS_OF_OTHERS = {
    "client/session/failure.cpp", "client/session/ssh_tunnel.cpp", "core/results/hdf5_file.cpp",
    "server/jobs/executors/slurm_commands.cpp", "server/jobs/executors/slurm_executor.cpp"}
NEVER_IN_CORE = re.compile(r"^(grpc|grpcpp|google/protobuf|toml\+\+|sqlite3|dccast/v1)(/|\.|$)")
NEVER_IN_JOBS = re.compile(r"^(grpc|grpcpp)(/|$)")

# Debian packages behind each find_package and each own Find module.
DEBIAN_PACKAGES = {
    "Threads": [],
    "OpenMP": ["g++"],
    "PkgConfig": ["pkg-config"],
    "Protobuf": ["libprotobuf-dev", "protobuf-compiler"],
    "gRPC": ["libgrpc++-dev", "protobuf-compiler-grpc"],
    "fmt": ["libfmt-dev"],
    "spdlog": ["libspdlog-dev"],
    "CLI11": ["libcli11-dev"],
    "SQLite3": ["libsqlite3-dev"],
    "tomlplusplus": ["libtomlplusplus-dev"],
    "nlohmann_json": ["nlohmann-json3-dev"],
    "HDF5": ["libhdf5-dev"],
    "Eigen3": ["libeigen3-dev"],
    "Boost": ["libboost-dev"],
    "OpenSSL": ["libssl-dev"],
    "Udunits2": ["libudunits2-dev"],
    "ZLIB": ["zlib1g-dev"],
    "Boost": ["libboost-dev"],
    "Cholmod": ["libsuitesparse-dev", "libopenblas-pthread-dev", "libmetis-dev"],
    "GTest": ["libgtest-dev", "libgmock-dev"],
    "benchmark": ["libbenchmark-dev"],
    "prometheus-cpp": ["prometheus-cpp-dev"],
    "Python3": ["python3"],
}


def tracked_files():
    """Files of the project, relative to its root; without git every file outside build trees."""
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "--cached"], capture_output=True,
                            text=True, check=False)
    if listed.returncode == 0:
        names = listed.stdout.splitlines()
    else:
        names = [str(path.relative_to(ROOT)) for path in ROOT.rglob("*") if path.is_file()]
        names = [name for name in names
                 if not name.startswith(("build/", ".git/", "dccast-quickstart/"))]
    return [pathlib.PurePosixPath(name) for name in names if (ROOT / name).is_file()]


def text_of(path):
    return (ROOT / path).read_text(encoding="utf-8", errors="replace")


def includes_of(path):
    return re.findall(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', text_of(path), re.MULTILINE)


FILES = tracked_files()
SOURCES = [path for path in FILES if path.suffix in SOURCE_SUFFIXES]
CMAKE_FILES = [path for path in FILES if path.name == "CMakeLists.txt" or path.suffix == ".cmake"]


def part_of(include):
    """The part of the project an include belongs to; None for the world outside."""
    if include.startswith("dccast/v1/"):
        return "proto"
    first = include.split("/")[0]
    return first if first in PARTS_SEEN and "/" in include else None


class Sources(unittest.TestCase):
    def assert_none(self, broken):
        self.assertFalse(broken, "\n" + "\n".join(broken))

    def test_sources_are_as_clang_format_writes_them(self):
        """The rules of .clang-format; `git ls-files '*.cpp' '*.hpp' '*.proto' | xargs clang-format-14 -i`."""
        formatted = [path for path in FILES if path.suffix in (".cpp", ".hpp", ".proto")]
        check = subprocess.run(["clang-format-14", "--dry-run", *formatted], cwd=ROOT,
                               capture_output=True, text=True, check=True)
        self.assert_none(sorted(set(re.findall(r"^(\S+?):\d+:", check.stderr, re.MULTILINE))))

    def test_lines_of_the_contract_have_at_most_100_columns(self):
        self.assert_none([f"{path}:{number}" for path in FILES if path.suffix == ".proto"
                          for number, line in enumerate(text_of(path).splitlines(), 1)
                          if len(line) > 100])

    def test_there_are_sources_to_scan(self):
        self.assertGreater(len(SOURCES), 20)
        self.assertIn("core/results/frame.hpp",
                      includes_of(pathlib.PurePosixPath("core/results/result_writer.hpp")))

    def test_parts_see_only_what_they_may(self):
        self.assert_none([
            f"{path} includes {include}"
            for path in SOURCES if path.parts[0] in PARTS_SEEN
            for include in includes_of(path)
            if part_of(include) not in PARTS_SEEN[path.parts[0]] | {None}])

    def test_core_rooms_see_only_rooms_above_them(self):
        broken = []
        for path in SOURCES:
            if path.parts[0] != "core":
                continue
            for include in includes_of(path):
                parts = include.split("/")
                if parts[0] == "core" and parts[1] not in CORE_ROOMS_SEEN[path.parts[1]]:
                    broken.append(f"{path} includes {include}")
        self.assert_none(broken)

    def test_parts_of_casting_see_only_parts_before_them(self):
        seen, broken = set(), []
        for path in SOURCES:
            if path.parts[:2] != ("core", "casting") or len(path.parts) < 4:
                continue
            seen.add(path.parts[2])
            for include in includes_of(path):
                parts = include.split("/")
                if parts[:2] == ["core", "casting"] and (
                        len(parts) < 4 or parts[2] not in CASTING_PARTS[path.parts[2]]):
                    broken.append(f"{path} includes {include}")
        self.assertEqual(seen, set(CASTING_PARTS))
        self.assert_none(broken)

    def test_every_core_room_is_known(self):
        self.assertEqual({path.parts[1] for path in SOURCES
                          if path.parts[0] == "core" and len(path.parts) > 2}, set(CORE_ROOMS))

    def test_core_targets_link_only_rooms_above_them(self):
        broken = []
        for room in CORE_ROOMS:
            path = pathlib.PurePosixPath(f"core/{room}/CMakeLists.txt")
            if not (ROOT / path).is_file():
                continue
            for linked in re.findall(r"\bdccast_(\w+)", text_of(path)):
                if linked in CORE_ROOMS and linked not in CORE_ROOMS_SEEN[room]:
                    broken.append(f"{path} links dccast_{linked}")
        self.assert_none(broken)

    def test_client_and_proto_link_nothing_of_core(self):
        core_targets = {f"dccast_{room}" for room in CORE_ROOMS}
        self.assert_none([
            f"{path} links {target}"
            for path in CMAKE_FILES if path.parts[0] in ("client", "proto")
            for target in re.findall(r"\bdccast_\w+", text_of(path)) if target in core_targets])

    def test_the_daemon_never_sees_the_solver(self):
        self.assert_none([
            f"{path} includes {include}"
            for path in SOURCES
            if path.parts[0] == "server" and path.parts[1] not in SERVER_ROOMS_THAT_SEE_CORE
            for include in includes_of(path)
            if include.startswith("core/")
            and include.split("/")[1] not in CORE_ROOMS_WITHOUT_PHYSICS])
        self.assert_none([
            f"{path} links dccast_{linked}"
            for path in CMAKE_FILES
            if path.parts[0] == "server" and path.parts[1] not in SERVER_ROOMS_THAT_SEE_CORE
            for linked in re.findall(r"\bdccast_(\w+)", text_of(path))
            if linked in CORE_ROOMS and linked not in CORE_ROOMS_WITHOUT_PHYSICS])

    def test_rooms_of_jobs_see_only_rooms_before_them(self):
        broken, seen = [], set()
        for path in SOURCES:
            if path.parts[:2] != ("server", "jobs"):
                continue
            room = path.parts[2] if len(path.parts) > 3 else None
            seen.add(room)
            for include in includes_of(path):
                parts = include.split("/")
                other = parts[2] if parts[:2] == ["server", "jobs"] and len(parts) > 3 else None
                if other and other not in JOBS_ROOMS.get(room, set()):
                    broken.append(f"{path} includes {include}")
        self.assertEqual(seen - {None}, set(JOBS_ROOMS))

        for room, visible in JOBS_ROOMS.items():
            path = pathlib.PurePosixPath(f"server/jobs/{room}/CMakeLists.txt")
            broken += [f"{path} links dccast_jobs_{linked}"
                       for linked in re.findall(r"\bdccast_jobs_(\w+)", text_of(path))
                       if linked not in visible | {"base"}]
        self.assert_none(broken)

    def test_rooms_name_their_namespaces_and_targets(self):
        """PART/ROOM of core, server and proto is namespace dccast::ROOM and target dccast_ROOM. A part of
        a room, a folder below it, shares the namespace, and is target dccast_ROOM_PART. The client is one
        program: its rooms share namespace dccast::client and one target."""
        broken = []
        for path in SOURCES:
            if path.parts[0] not in PARTS_SEEN or len(path.parts) < 3 or str(path) in NAMESPACES_OF_THEIR_OWN:
                continue
            room = "client" if path.parts[0] == "client" else path.parts[1]
            named = set(re.findall(r"^namespace (dccast[\w:]*) \{$", text_of(path), re.M)) - {"dccast"}
            if not all(f"{name}::".startswith(f"dccast::{room}::") for name in named):
                broken.append(f"{path} is in {sorted(named)}")
        for path in CMAKE_FILES:
            if path.parts[0] not in ("core", "server") or len(path.parts) < 3 or path.name != "CMakeLists.txt":
                continue
            expected = "_".join(("dccast", *path.parts[1:-1])).replace("dccast_daemon", "dccastd")
            targets = re.findall(r"add_(?:library|executable)\((\S+)", text_of(path))
            targets += [f"dccast_{name}" for name in re.findall(r"dccast_core_library\((\w+)", text_of(path))]
            if not any(target.startswith(expected) for target in targets):
                broken.append(f"{path} makes {targets}")
        self.assert_none(broken)

    def test_client_rooms_see_only_rooms_before_them(self):
        self.assert_none([
            f"{path} includes {include}"
            for path in SOURCES if path.parts[0] == "client" and len(path.parts) > 2
            for include in includes_of(path) if include.startswith("client/")
            and include.split("/")[1] not in CLIENT_ROOMS[path.parts[1]]])

    def test_slow_headers_stay_behind_one_source_of_the_client(self):
        self.assert_none([
            f"{path} includes {include}"
            for path in SOURCES if path.parts[0] == "client"
            for include in includes_of(path)
            if CLIENT_LIBRARIES.get(include, str(path)) != str(path)])

    def test_libraries_are_wrapped_once(self):
        broken = []
        for path in SOURCES:
            for include in includes_of(path):
                owner = ONLY_IN.get(include.split("/")[-1])
                folder = str(path.parent)
                mirror = folder.replace("tests/unit/", "core/", 1)
                if TESTS_THAT_LOOK_INTO_FILES.get(folder) == include:
                    continue
                if owner and not folder.startswith(owner) and not mirror.startswith(owner):
                    broken.append(f"{path} includes {include}, which belongs to {owner}")
        self.assert_none(broken)

    def test_no_text_that_we_write_for_people_is_parsed(self):
        """Programs read fields: refusal.proto, Finding.kind. Only texts of others are looked into."""
        self.assert_none([
            f"{path}:{number}: {line.strip()}"
            for path in FILES if path.parts[0] in PARTS_SEEN and path.suffix in {".cpp", ".hpp", ".py", ".js"}
            and str(path) not in READS_TEXTS_OF_OTHERS
            for number, line in enumerate(text_of(path).splitlines(), 1) if PARSED_TEXT.search(line)])

    def test_core_knows_no_wire_no_toml_and_no_database(self):
        self.assert_none([
            f"{path} includes {include}" for path in SOURCES if path.parts[0] == "core"
            for include in includes_of(path) if NEVER_IN_CORE.match(include)])

    def test_the_queue_knows_no_wire(self):
        self.assert_none([
            f"{path} includes {include}" for path in SOURCES if path.parts[:2] == ("server", "jobs")
            for include in includes_of(path) if NEVER_IN_JOBS.match(include)])

    def test_access_knows_no_other_room_of_the_server(self):
        self.assert_none([
            f"{path} includes {include}"
            for path in SOURCES if path.parts[:2] == ("server", "access")
            for include in includes_of(path)
            if NEVER_IN_JOBS.match(include)
            or (include.startswith("server/") and not include.startswith("server/access/"))])

    def test_no_file_names_a_place_of_one_machine(self):
        # Spelt so that this file does not find itself.
        machine_path = re.compile(r"(?<![A-Za-z0-9_.}~])/(?:work|farm|root|home/[a-z])\w*/")
        self.assert_none([
            f"{path}:{number}: {line.strip()[:120]}"
            for path in FILES if path.name != "LICENSE"
            for number, line in enumerate(text_of(path).splitlines(), 1)
            if machine_path.search(line) and path.name != pathlib.Path(__file__).name])

    def test_a_sleep_of_a_test_says_why_nothing_can_be_waited_for(self):
        sleep = re.compile(r"\b(time\.sleep|sleep_for|sleep_until|nanosleep|usleep)\(")
        helpers = {"waiting.py", "eventually.hpp", pathlib.Path(__file__).name}
        self.assert_none([
            f"{path}:{number}: {line.strip()}"
            for path in FILES if path.parts[0] == "tests" and path.suffix in (".py", ".cpp", ".hpp", ".js")
            and path.name not in helpers
            for number, line in enumerate(text_of(path).splitlines(), 1)
            if sleep.search(line) and not re.search("#|//", line)])

    def test_every_package_found_is_a_package_installed(self):
        entries = [line.split() for line in text_of("deploy/packages.txt").splitlines()
                   if line and not line.startswith("#")]
        listed = {package for _, package in entries}
        self.assertEqual(len(listed), len(entries), "a package is listed twice")
        self.assertTrue(all(group in ("build", "package", "test", "nightly") for group, _ in entries))
        broken = []
        for path in CMAKE_FILES:
            for name in re.findall(r"^\s*find_package\(\s*([\w-]+)", text_of(path), re.MULTILINE):
                if name not in DEBIAN_PACKAGES:
                    broken.append(f"{path}: find_package({name}) is unknown to {__file__}")
                broken += [f"{path}: find_package({name}) needs {package} in deploy/packages.txt"
                           for package in DEBIAN_PACKAGES.get(name, []) if package not in listed]
        self.assert_none(broken)


if __name__ == "__main__":
    unittest.main()
