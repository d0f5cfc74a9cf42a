#!/usr/bin/python3
"""The entry for programs: Connect on the dashboard's server answers as gRPC does."""
import base64
import getpass
import http.client
import json
import os
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import tomllib
import urllib.parse

import grpc
from google.protobuf import json_format

from dccast.v1 import job_pb2, refusal_pb2, service_pb2, service_pb2_grpc
from doctor_test import ClientTest
from support import BIN, fake_case, main
from waiting import until

SERVICE = "dccast.v1.SimulationService"
METHODS = service_pb2.DESCRIPTOR.services_by_name["SimulationService"].methods
ROLES = ("viewer", "submitter", "admin")
NOTHING = "00000000-0000-4000-8000-000000000000"
HTTP_STATUS = {"invalid_argument": 400, "not_found": 404, "permission_denied": 403,
               "unauthenticated": 401, "failed_precondition": 400, "resource_exhausted": 429}
END = 2  # flag of the last message of a stream


def messages_of(body):
    """(flags, message) of each message of a stream."""
    while body:
        flags, size = struct.unpack(">BI", body[:5])
        yield flags, body[5:5 + size]
        body = body[5 + size:]


class Entry:
    """The server of a dashboard of one user, as a program uses it."""

    def __init__(self, environment):
        self.process = subprocess.Popen([os.path.join(BIN, "dccast"), "dashboard"],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                        text=True, env={**os.environ, **environment})
        url = urllib.parse.urlsplit(self.process.stdout.readline().strip())
        self.base = f"http://127.0.0.1:{url.port}"
        self.port = url.port
        self.headers = {}
        entered = self.ask("GET", f"/?{url.query}")[0]
        self.headers = {"Cookie": entered.getheader("Set-Cookie").split(";")[0],
                        "Origin": self.base}

    def close(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=5)
        self.process.stdout.close()

    def ask(self, method, path, body=None, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.request(method, path, body, {**self.headers, **headers})
        response = connection.getresponse()
        text = response.read()
        connection.close()
        return response, text

    def post(self, name, body, kind, **headers):
        headers = {key.replace("_", "-"): value for key, value in headers.items()}
        return self.ask("POST", f"/{SERVICE}/{name}", body,
                        **{"Content-Type": f"application/{kind}", **headers})

    def unary(self, method, request, is_json=True):
        """@return the response, or the error"""
        body = json_format.MessageToJson(request) if is_json else request.SerializeToString()
        response, text = self.post(method.name, body, "json" if is_json else "proto")
        answer = CLASSES[method.output_type.full_name]()
        if response.status != 200:
            error = json.loads(text)
            return {**error, "status": response.status}
        return json_format.Parse(text, answer) if is_json else answer.FromString(text)

    def stream(self, method, request, is_json=True):
        """@return responses, and the error at the end: None where there is none"""
        body = (json_format.MessageToJson(request).encode() if is_json
                else request.SerializeToString())
        response, text = self.post(method.name, struct.pack(">BI", 0, len(body)) + body,
                                   "connect+" + ("json" if is_json else "proto"))
        assert response.status == 200, (response.status, text)
        *messages, (flags, end) = messages_of(text)
        assert flags == END, text
        kind = CLASSES[method.output_type.full_name]
        return [json_format.Parse(each, kind()) if is_json else kind.FromString(each)
                for _, each in messages], json.loads(end).get("error")


CLASSES = {each.full_name: getattr(module, name)
           for module in (service_pb2, job_pb2, __import__("dccast.v1.study_pb2", fromlist=["x"]),
                          __import__("dccast.v1.judgement_pb2", fromlist=["x"]),
                          __import__("dccast.v1.follow_pb2", fromlist=["x"]),
                          __import__("dccast.v1.line_pb2", fromlist=["x"]))
           for name, each in module.DESCRIPTOR.message_types_by_name.items()}


class WebEntry(Entry):
    """dccast-web behind a proxy, as a program with a token uses it."""

    def __init__(self, daemon, folder, token):
        self.process = subprocess.Popen(
            [os.path.join(BIN, "dccast-web"), "serve", "--listen", "127.0.0.1:0", "--behind",
             "https://dccast.test", "--socket", daemon.address, "--state", os.path.join(folder, "web")],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.port = int(self.process.stderr.readline().split()[-1])
        self.headers = {"Authorization": "Bearer " + token}

    def close(self):
        super().close()
        self.process.stderr.close()


class ConnectTest(ClientTest):
    def setUp(self):
        super().setUp()
        self.start()

    def entry(self, token):
        """Where the user who has logged in last asks by JSON."""
        entry = Entry({"XDG_CONFIG_HOME": self.in_folder("settings")})
        self.addCleanup(entry.close)
        return entry

    def entry_of(self, name, role="submitter"):
        """The entry of a new user, and a gRPC client with the same token."""
        self.log_in(name, role, "--name", name, "--default")
        with open(self.servers_file(), "rb") as file:
            token = {server["name"]: server["token"]
                     for server in tomllib.load(file)["server"]}[name]
        entry = self.entry(token)
        with open(os.path.join(self.daemon.settings["data_directory"], "pki", "ca.pem"), "rb") as file:
            credentials = grpc.composite_channel_credentials(
                grpc.ssl_channel_credentials(file.read()),
                grpc.access_token_call_credentials(token))
        channel = grpc.secure_channel(self.daemon.tls_address, credentials)
        self.addCleanup(channel.close)
        return entry, service_pb2_grpc.SimulationServiceStub(channel)


def readable(kind, value):
    """A detail of a status; the entries of a map have no order."""
    message = refusal_pb2.ErrorInfo if kind == "google.rpc.ErrorInfo" else CLASSES[kind]
    return kind, message.FromString(value)


class LikeGrpc(ConnectTest):
    def requests_of(self, method):
        kind = CLASSES[method.input_type.full_name]
        yield kind()
        if "id" in method.input_type.fields_by_name:
            yield kind(id=NOTHING)

    def by_grpc(self, stub, method, request):
        """@return responses, and the error: None where there is none"""
        given = iter([request]) if method.client_streaming else request
        try:
            answer = getattr(stub, method.name)(given, timeout=60)
            return (list(answer) if method.server_streaming else [answer]), None
        except grpc.RpcError as error:
            details = refusal_pb2.StatusDetails.FromString(
                dict(error.trailing_metadata()).get("grpc-status-details-bin", b""))
            return [], {"code": error.code().value[1].replace(" ", "_"), "message": error.details(),
                        "details": [readable(each.type_url.split("/")[-1], each.value)
                                    for each in details.details]}

    def by_connect(self, entry, method, request, is_json):
        if method.client_streaming or method.server_streaming:
            responses, error = entry.stream(method, request, is_json)
        else:
            answer = entry.unary(method, request, is_json)
            error = answer if isinstance(answer, dict) else None
            responses = [] if error else [answer]
            if error:
                self.assertEqual(error.pop("status"), HTTP_STATUS[error["code"]], error)
        if error:
            error["details"] = [readable(each["type"], base64.b64decode(each["value"] + "=="))
                                for each in error["details"]]
        return responses, error

    def test_each_method_for_each_role(self):
        """Revoking a token ends what the other calls need: it comes last."""
        # Each answer is another one: memory in use, a secret, times.
        once = {"GetServerInfo": service_pb2.GetServerInfoRequest,
                "IssueSignIn": service_pb2.IssueSignInRequest,
                "ListTokens": service_pb2.ListTokensRequest,
                "RevokeToken": service_pb2.RevokeTokenRequest}
        refused = set()
        for role in ROLES:
            entry, stub = self.entry_of("with-" + role, role)
            for method in METHODS:
                for request in self.requests_of(method) if method.name not in once else ():
                    for is_json in (True, False):
                        with self.subTest(role=role, method=method.name, json=is_json):
                            expected = self.by_grpc(stub, method, request)
                            self.assertEqual(
                                self.by_connect(entry, method, request, is_json), expected)
                            if expected[1]:
                                refused.add((role, expected[1]["code"]))
            by_name = {method.name: method for method in METHODS}
            for name, kind in once.items():
                self.assertNotIsInstance(entry.unary(by_name[name], kind()), dict)
            gone = entry.unary(by_name["WhoAmI"], service_pb2.WhoAmIRequest())
            self.assertEqual((gone["code"], gone["status"]), ("unauthenticated", 401))
        self.assertLessEqual({("viewer", "permission_denied"), ("submitter", "invalid_argument"),
                              ("admin", "not_found")}, refused)


class LikeGrpcThroughTheWebServer(LikeGrpc):
    """The same table for dccast-web, which has no rights of its own."""

    def start(self, **settings):  # the user of this test is the one of dccast-web, too
        super().start(access__web_user=getpass.getuser(), **settings)

    def entry(self, token):
        entry = WebEntry(self.daemon, self.folder, token)
        self.addCleanup(entry.close)
        return entry


class Protocol(ConnectTest):
    """What the headers and bodies of requests may be."""

    def setUp(self):
        super().setUp()
        self.addCleanup(self.daemon.stop)
        self.entry, self.stub = self.entry_of("anna")

    def error(self, name, body, kind="json", **headers):
        response, text = self.entry.post(name, body, kind, **headers)
        self.assertNotEqual(response.status, 200, text)
        return response.status, json.loads(text)

    def test_faults_of_a_case_are_structured(self):
        status, error = self.error("SubmitJob", json.dumps({
            "request_id": "1", "case": {"section": {"half_width_m": -1}}}))
        self.assertEqual((status, error["code"]), (400, "invalid_argument"))
        kinds = {detail["type"]: detail["debug"] for detail in error["details"]}
        self.assertEqual(kinds["google.rpc.ErrorInfo"]["reason"], "INVALID_CASE")
        fields = [fault["field"] for fault in kinds["dccast.v1.ValidateCaseResponse"]["faults"]]
        self.assertIn("section.half_width", fields)

    def test_requests_that_are_none(self):
        self.assertEqual(self.error("Nonsense", "{}")[0], 501)
        self.assertEqual(self.error("ListJobs", "{")[1]["code"], "invalid_argument")
        self.assertIn("no_such", self.error("ListJobs", '{"no_such": 1}')[1]["message"])
        deep = '{"case":' + 10_000 * '{"mesh":' + 10_000 * "}" + "}"
        self.assertEqual(self.error("ValidateCase", deep)[0], 400)
        self.assertEqual(self.error("ListJobs", b"\xff\xff", "proto")[0], 400)
        self.assertIn("not 1", self.error("ListJobs", "{}", Connect_Protocol_Version="2")[1]["message"])
        for timeout in ("x", "-1", "12345678901"):
            self.assertEqual(self.error("ListJobs", "{}", Connect_Timeout_Ms=timeout)[0], 400)
        self.assertEqual(self.error("ListJobs", "{}", Content_Encoding="br")[0], 400)

        for name, kind in (("ListJobs", "connect+json"), ("WatchJob", "json"), ("ListJobs", "xml")):
            self.assertEqual(self.entry.post(name, "{}", kind)[0].status, 415, (name, kind))
        self.assertEqual(self.entry.post("ListJobs", "x" * 3_000_000, "json")[0].status, 413)
        for body in (b"", b"\0\0\0\0\x09{}", b"\1\0\0\0\2{}", b"\0\0", 2 * b"\0\0\0\0\2{}"):
            response, text = self.entry.post("WatchJob", body, "connect+json")
            error = json.loads(list(messages_of(text))[0][1])["error"]
            self.assertEqual((response.status, error["code"]), (200, "invalid_argument"), body)

    def test_a_deadline_ends_a_stream(self):
        job = self.stub.SubmitJob(service_pb2.SubmitJobRequest(
            request_id="2", case=fake_case("steps=100000 sleep_ms=5")))
        body = json.dumps({"id": job.id}).encode()
        begin = time.monotonic()
        _, text = self.entry.post("WatchJob", struct.pack(">BI", 0, len(body)) + body,
                                  "connect+json", Connect_Timeout_Ms="1500")
        self.assertLess(time.monotonic() - begin, 10)
        *events, (flags, end) = messages_of(text)
        self.assertGreater(len(events), 2)
        self.assertEqual(flags, END)
        self.assertEqual(json.loads(end)["error"]["code"], "deadline_exceeded")
        self.stub.CancelJob(service_pb2.CancelJobRequest(id=job.id))

    def test_curl(self):
        command = ["curl", "--silent", "--show-error", "--fail-with-body", "--json", "{}",
                   *(word for name, value in self.entry.headers.items()
                     for word in ("--header", f"{name}: {value}")),
                   f"{self.entry.base}/{SERVICE}/WhoAmI"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
        self.assertEqual(json.loads(done.stdout)["name"], "anna", done.stderr)

    def test_a_watch_holds_no_thread_and_ends_when_its_client_leaves(self):
        job = self.stub.SubmitJob(service_pb2.SubmitJobRequest(
            request_id="3", case=fake_case("steps=100000 sleep_ms=5")))
        threads = lambda: len(os.listdir(f"/proc/{self.entry.process.pid}/task"))
        files = lambda: len(os.listdir(f"/proc/{self.entry.process.pid}/fd"))
        body = json.dumps({"id": job.id}).encode()
        before, open_before = threads(), files()
        watching = []
        for _ in range(20):
            connection = http.client.HTTPConnection("127.0.0.1", self.entry.port, timeout=30)
            connection.request("POST", f"/{SERVICE}/WatchJob",
                               struct.pack(">BI", 0, len(body)) + body,
                               {**self.entry.headers, "Content-Type": "application/connect+json"})
            self.assertEqual(connection.getresponse().read(1), b"\0")
            watching.append(connection)
        self.assertLessEqual(threads(), before + 4)  # those of gRPC itself
        for connection in watching:
            connection.close()
        until(lambda: files() <= open_before + 2, 20)
        self.stub.CancelJob(service_pb2.CancelJobRequest(id=job.id))


PROGRAM = """
import {readFileSync} from 'node:fs';
import {createPromiseClient} from '@connectrpc/connect';
import {createConnectTransport} from '@connectrpc/connect-node';
import {createRegistryFromDescriptors} from '@bufbuild/protobuf';

const [, , base, cookie, schema, useBinaryFormat] = process.argv;
const registry = createRegistryFromDescriptors(readFileSync(schema));
const session = next => request => {
  request.header.set('cookie', cookie);
  request.header.set('origin', base);
  return next(request);
};
const client = createPromiseClient(
  registry.findService('dccast.v1.SimulationService'),
  createConnectTransport({
    baseUrl: base, httpVersion: '1.1', useBinaryFormat: useBinaryFormat === 'binary',
    interceptors: [session], jsonOptions: {typeRegistry: registry}
  }));

const read = await client.readCase({source: {case: 'shipped', value: 'start-2d-thickness'}});
read.case.title = 'steps=20';
const job = await client.submitJob({requestId: `node ${useBinaryFormat}`, case: read.case});
let steps = 0;
for await (const event of client.watchJob({id: job.id})) steps += event.what?.case === 'step';
const parts = [];
for await (const part of client.fetchResult({id: job.id, artifact: 'case.toml'})) parts.push(part.data);
const refused = await client.getJob({id: '%s'}).catch(error => error);
const {state} = await client.getJob({id: job.id});
console.log(JSON.stringify({
  id: job.id, steps, state, bytes: parts.reduce((sum, part) => sum + part.length, 0),
  refused: [refused.code, refused.rawMessage], details: refused.details?.length
}));
""" % NOTHING
PACKAGES = ("@connectrpc/connect@1.6.1", "@connectrpc/connect-node@1.6.1", "@bufbuild/protobuf@1.10.0")


def with_npm(test, *packages):
    """A folder in which these packages are installed; without them the test is skipped."""
    if not shutil.which("npm"):
        test.skipTest("npm is not installed")
    folder = tempfile.mkdtemp(prefix="dccast-npm-")
    test.addCleanup(shutil.rmtree, folder)
    installed = subprocess.run(["npm", "install", "--no-audit", "--no-fund", *packages], cwd=folder,
                               capture_output=True, text=True, timeout=120, check=False)
    if installed.returncode != 0:
        test.skipTest("the registry of npm cannot be reached: " + installed.stderr[-300:])
    return folder


class ConnectNode(ConnectTest):
    """A client that nobody here wrote."""

    def test_it_submits_watches_and_fetches(self):
        folder = with_npm(self, *PACKAGES)
        proto = os.path.join(os.path.dirname(__file__), "..", "..", "proto")
        subprocess.run(["protoc", "-I", proto, "--include_imports", "--descriptor_set_out",
                        os.path.join(folder, "schema.bin"), "dccast/v1/service.proto"], check=True)
        with open(os.path.join(folder, "program.mjs"), "w", encoding="utf-8") as file:
            file.write(PROGRAM)

        entry, stub = self.entry_of("anna")
        for form in ("json", "binary"):
            done = subprocess.run(
                ["node", "program.mjs", entry.base, entry.headers["Cookie"], "schema.bin", form],
                cwd=folder, capture_output=True, text=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            seen = json.loads(done.stdout)
            self.assertEqual((seen["steps"], seen["state"]), (20, job_pb2.SUCCEEDED), seen)
            self.assertGreater(seen["bytes"], 100)
            self.assertEqual(seen["refused"][0], 5)  # not_found
            self.assertIn(NOTHING, seen["refused"][1])
            self.assertGreater(seen["details"], 0)
            self.assertEqual(stub.GetJob(service_pb2.GetJobRequest(id=seen["id"])).owner, "anna")


VALIDATOR = """
import {Validator} from '@seriousme/openapi-schema-validator';

const seen = await new Validator().validate(process.argv[2]);
console.log(JSON.stringify(seen));
"""


class OpenApi(ConnectTest):
    """The description of calls and resources."""

    def test_it_is_valid_and_names_every_call(self):
        entry, _ = self.entry_of("anna")
        response, text = entry.ask("GET", "/openapi.json")
        self.assertEqual(response.getheader("Content-Type"), "application/json")
        described = json.loads(text)
        paths = described["paths"]
        for method in METHODS:
            streams = method.client_streaming or method.server_streaming
            self.assertEqual(f"/{SERVICE}/{method.name}" in paths, not streams, method.name)
        self.assertIn("half_width_m", described["components"]["schemas"]["dccast.v1.Section"]
                      ["properties"])
        self.assertEqual(paths["/jobs.csv"]["get"]["security"][-1], {"userAndToken": []})
        self.assertEqual(paths[f"/{SERVICE}/Enrol"]["post"]["security"], [])
        for path in paths:  # a name that is none is no such page
            if "get" in paths[path]:
                asked = entry.ask("GET", path.replace("{id}", NOTHING))
                self.assertNotIn(b"no such page", asked[1], path)

        folder = with_npm(self, "@seriousme/openapi-schema-validator@2.2.5")
        for name, content in (("openapi.json", text.decode()), ("program.mjs", VALIDATOR)):
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(content)
        done = subprocess.run(["node", "program.mjs", "openapi.json"], cwd=folder, text=True,
                              capture_output=True, timeout=60, check=False)
        seen = json.loads(done.stdout)
        self.assertEqual((seen["valid"], seen.get("errors")), (True, None), seen)


if __name__ == "__main__":
    main()
