"""The contract for its readers: pages of services, messages and enumerations with our options, and a
description in OpenAPI 3.1 of what programs ask by HTTP (docs/programs.md).

    contract.py --openapi FILE --version VERSION    writes the latter
"""
import argparse
import html
import importlib
import json
import pathlib
import subprocess
import sys
import tempfile

from google.protobuf import descriptor_pb2

STYLE = """<style>body{font:15px/1.5 sans-serif;max-width:75em;margin:2em auto;padding:0 1em}
table{border-collapse:collapse;width:100%}td,th{border:1px solid #bbb;padding:.2em .5em;text-align:left;vertical-align:top}
code{white-space:nowrap}h3{margin-top:2em}p.note{white-space:pre-line}</style>"""
F = descriptor_pb2.FieldDescriptorProto
SCALARS = {number: name[5:].lower() for name, number in F.Type.items()}


def described(sources, folder):
    """The files of the contract with their comments, and the modules that know our options."""
    names = [str(path.relative_to(sources)) for path in sorted((sources / "dccast/v1").glob("*.proto"))]
    stored = folder / "contract.bin"
    subprocess.run(["protoc", f"-I{sources}", f"--descriptor_set_out={stored}", "--include_source_info",
                    f"--python_out={folder}", *names], check=True)
    sys.path.insert(0, str(folder))
    options = importlib.import_module("dccast.v1.options_pb2")
    access = importlib.import_module("dccast.v1.access_pb2")
    return descriptor_pb2.FileDescriptorSet.FromString(stored.read_bytes()).file, options, access


class Comments:
    """Comments of a file by the path of what they stand beside."""

    def __init__(self, file):
        self.of = {tuple(place.path): (place.leading_comments.strip() + "\n"
                                       + place.trailing_comments.strip()).strip()
                   for place in file.source_code_info.location}

    def __call__(self, *path):
        return self.of.get(path, "")

    def lines(self, *path):
        """The same without the spaces that begin the lines."""
        return "\n".join(line.strip() for line in self(*path).splitlines())


def note(text):
    return f"<p class='note'>{html.escape(text)}</p>" if text else ""


def table(head, rows):
    cells = "".join(f"<th>{title}</th>" for title in head)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{cells}</tr>{body}</table>"


def link(name, home):
    """A type as a link to its place; `home` has the page of each message and enumeration."""
    short = name.lstrip(".").removeprefix("dccast.v1.")
    page = home.get(name.lstrip("."))
    return f"<a href='{page}#{short}'>{html.escape(short)}</a>" if page else html.escape(short)


def type_of(field, home):
    kind = link(field.type_name, home) if field.type_name else SCALARS[field.type]
    return ("repeated " if field.label == F.LABEL_REPEATED else "") + kind


def bounds(key):
    """The permitted range, as "0 < x <= 1"."""
    low = f"{key.minimum:g} {'<' if key.minimum_excluded else '<='} " if key.HasField("minimum") else ""
    high = f" {'<' if key.maximum_excluded else '<='} {key.maximum:g}" if key.HasField("maximum") else ""
    return f"{low}x{high}" if low or high else ""


def message_part(message, prefix, path, comment, home, options):
    name = prefix + message.name
    parts = [f"<h3 id='{name}'>{name}</h3>", note(comment(*path))]
    rows = []
    for index, field in enumerate(message.field):
        key = field.options.Extensions[options.key]
        said = " ".join(text for text in (key.doc, comment(*path, 2, index)) if text)
        rows.append([f"<code>{field.name}</code>", field.number, type_of(field, home), html.escape(key.unit),
                     html.escape(bounds(key)), html.escape("required" if key.required else key.default_text),
                     html.escape(key.uncertainty), html.escape(said)])
    if rows:
        parts.append(table(["field", "number", "type", "unit", "range", "default", "uncertain", "meaning"], rows))
    for index, inner in enumerate(message.nested_type):
        if not inner.options.map_entry:
            parts.append(message_part(inner, name + ".", (*path, 3, index), comment, home, options))
    for index, inner in enumerate(message.enum_type):
        parts.append(enumeration_part(inner, name + ".", (*path, 4, index), comment))
    return "".join(parts)


def enumeration_part(enumeration, prefix, path, comment):
    name = prefix + enumeration.name
    rows = [[f"<code>{value.name}</code>", value.number, html.escape(comment(*path, 2, index))]
            for index, value in enumerate(enumeration.value)]
    return f"<h3 id='{name}'>{name}</h3>" + note(comment(*path)) + table(["value", "number", "meaning"], rows)


def service_part(service, path, comment, home, access):
    rows = []
    for index, call in enumerate(service.method):
        may = call.options.Extensions[access.access]
        allowed = ", ".join(f"{field.name}: {field.enum_type.values_by_number[value].name}" if field.enum_type
                            else f"{field.name}: {value}" for field, value in may.ListFields())
        answer = ("stream " if call.server_streaming else "") + link(call.output_type, home)
        request = ("stream " if call.client_streaming else "") + link(call.input_type, home)
        rows.append([f"<code>{call.name}</code>", request, answer, html.escape(allowed),
                     note(comment(*path, 2, index))])
    return (f"<h3 id='{service.name}'>{service.name}</h3>" + note(comment(*path))
            + table(["call", "request", "answer", "access", "meaning and status codes"], rows))


def types_of(messages, prefix):
    for message in messages:
        yield prefix + message.name
        yield from (f"{prefix}{message.name}.{kind.name}" for kind in message.enum_type)
        yield from types_of(message.nested_type, f"{prefix}{message.name}.")


def write_contract(sources, folder, scratch):
    """Writes a page for each file. @return  names of the pages, and of calls, messages and enumerations
    without a comment of their own"""
    files, options, access = described(sources, scratch)
    page_of = {file.name: pathlib.PurePath(file.name).stem + ".html" for file in files}
    home = {}
    for file in files:
        for name in types_of(file.message_type, file.package + "."):
            home[name] = page_of[file.name]
        home.update({f"{file.package}.{kind.name}": page_of[file.name] for kind in file.enum_type})

    silent = []
    for file in files:
        comment = Comments(file)
        parts = [service_part(service, (6, i), comment, home, access) for i, service in enumerate(file.service)]
        parts += [message_part(message, "", (4, i), comment, home, options)
                  for i, message in enumerate(file.message_type)]
        parts += [enumeration_part(kind, "", (5, i), comment) for i, kind in enumerate(file.enum_type)]
        silent += [f"{file.name}: {call.name}" for s, service in enumerate(file.service)
                   for i, call in enumerate(service.method) if not comment(6, s, 2, i)]
        silent += [f"{file.name}: {message.name}" for i, message in enumerate(file.message_type)
                   if not comment(4, i)]
        silent += [f"{file.name}: {kind.name}" for i, kind in enumerate(file.enum_type) if not comment(5, i)]
        title = html.escape(file.name)
        (folder / page_of[file.name]).write_text(
            f"<!doctype html><meta charset='utf-8'><title>{title}</title>{STYLE}"
            f"<p><a href='../index.html'>API</a></p><h1>{title}</h1>{''.join(parts)}", encoding="utf-8")
    return sorted(page_of.values()), silent


# ---- OpenAPI

NUMBER = {"oneOf": [{"type": "number"}, {"enum": ["NaN", "Infinity", "-Infinity"]}]}
WHOLE_64 = {"type": ["string", "integer"], "format": "int64"}  # written as a text
JSON_OF = {F.TYPE_DOUBLE: NUMBER, F.TYPE_FLOAT: NUMBER, F.TYPE_BOOL: {"type": "boolean"},
           F.TYPE_STRING: {"type": "string"}, F.TYPE_BYTES: {"type": "string", "contentEncoding": "base64"},
           **dict.fromkeys((F.TYPE_INT32, F.TYPE_SINT32, F.TYPE_SFIXED32), {"type": "integer", "format": "int32"}),
           **dict.fromkeys((F.TYPE_UINT32, F.TYPE_FIXED32), {"type": "integer", "minimum": 0}),
           **dict.fromkeys((F.TYPE_INT64, F.TYPE_SINT64, F.TYPE_SFIXED64, F.TYPE_UINT64, F.TYPE_FIXED64), WHOLE_64)}
JSON_OF_GOOGLE = {".google.protobuf.Timestamp": {"type": "string", "format": "date-time"},
                  ".google.protobuf.Any": {"type": "object"}}
CODES = ("canceled unknown invalid_argument deadline_exceeded not_found already_exists permission_denied "
         "resource_exhausted failed_precondition aborted out_of_range unimplemented internal unavailable data_loss "
         "unauthenticated").split()
SERVICE = "/dccast.v1.SimulationService/"
ERROR = {
    "type": "object", "required": ["code", "message", "details"],
    "properties": {
        "code": {"enum": CODES}, "message": {"type": "string", "description": "For people"},
        "details": {"type": "array", "description": "A google.rpc.ErrorInfo; of a case with faults also a "
                    "dccast.v1.ValidateCaseResponse, which names their fields", "items": {
                        "type": "object", "required": ["type", "value"],
                        "properties": {"type": {"type": "string"},
                                       "value": {"type": "string", "contentEncoding": "base64"},
                                       "debug": {"type": "object", "description": "The same in JSON"}}}}}}
SECURITY = {
    "token": {"type": "http", "scheme": "bearer", "description": "Of a user, see dccast login"},
    "session": {"type": "apiKey", "in": "cookie", "name": "__Host-dccast",
                "description": "Of a browser that has signed in; changes need the Origin of the server"},
    "userAndToken": {"type": "http", "scheme": "basic", "description": "For spreadsheets: user and token"}}
JOB = {"name": "id", "in": "path", "required": True, "schema": {"type": "string"},
       "description": "Id of a job, the beginning of one, or last"}


def reference(name):
    return {"$ref": f"#/components/schemas/{name.lstrip('.')}"}


def refusal():
    return {"default": {"description": "A refusal", "content": {"application/json": {"schema": reference("Error")}}}}


def field_schema(field, comment, key, maps):
    if field.type_name in maps:
        schema = {"type": "object", "additionalProperties": maps[field.type_name]}
    else:
        schema = JSON_OF_GOOGLE.get(field.type_name) or (reference(field.type_name) if field.type_name
                                                         else dict(JSON_OF[field.type]))
        if field.label == F.LABEL_REPEATED:
            schema = {"type": "array", "items": schema}
    bound = bounds(key)
    text = " ".join(part for part in (key.doc, comment, key.unit and f"[{key.unit}]", bound and f"({bound})") if part)
    return {**schema, "description": text} if text else schema


def message_schemas(message, name, path, comment, options, schemas):
    maps = {f".{name}.{inner.name}": JSON_OF[inner.field[1].type]
            for inner in message.nested_type if inner.options.map_entry}
    properties = {field.name: field_schema(field, comment.lines(*path, 2, index),
                                           field.options.Extensions[options.key], maps)
                  for index, field in enumerate(message.field)}
    schemas[name] = {"type": "object", "properties": properties, "additionalProperties": False}
    if comment(*path):
        schemas[name]["description"] = comment.lines(*path)
    for index, inner in enumerate(message.nested_type):
        if not inner.options.map_entry:
            message_schemas(inner, f"{name}.{inner.name}", (*path, 3, index), comment, options, schemas)
    for kind in message.enum_type:
        schemas[f"{name}.{kind.name}"] = {"enum": [value.name for value in kind.value]}


def method_path(method, comment, access):
    may = method.options.Extensions[access.access]
    role = may.DESCRIPTOR.fields_by_name["role"].enum_type.values_by_number[may.role].name.lower()
    operation = {
        "operationId": method.name, "tags": ["calls"], "description": f"{comment}\nRole: {role}.".strip(),
        "requestBody": {"required": True,
                        "content": {"application/json": {"schema": reference(method.input_type)}}},
        "responses": {"200": {"description": "The answer",
                              "content": {"application/json": {"schema": reference(method.output_type)}}},
                      **refusal()}}
    if method.name == "Enrol":
        operation["security"] = []
    return {"post": operation}


def query(name, text, kind="string", repeated=False):
    schema = {"type": "array", "items": {"type": kind}} if repeated else {"type": kind}
    return {"name": name, "in": "query", "description": text, "schema": schema}


def resource(name, text, kind, parameters=(), method="get", **more):
    operation = {"operationId": name, "tags": ["resources"], "description": text, "parameters": list(parameters),
                 "responses": {"200": {"description": "The resource", "content": {kind: {}}}, **refusal()}, **more}
    if kind == "text/csv":
        operation["security"] = [{scheme: []} for scheme in SECURITY]
    return {method: operation}


def resources():
    """What client/web/resources.cpp answers."""
    whole = resource("GetResults", "The result file; its ETag is its SHA-256", "application/x-hdf5", [
        JOB, {"name": "Range", "in": "header", "schema": {"type": "string"}, "description": "bytes=N-"},
        {"name": "If-None-Match", "in": "header", "schema": {"type": "string"}}])
    whole["get"]["responses"] |= {"206": {"description": "From the byte that was asked for", "content": {
        "application/x-hdf5": {}}}, "304": {"description": "It has not changed"}}
    sha256 = {"name": "sha256", "in": "path", "required": True,
              "schema": {"type": "string", "pattern": "^[0-9a-f]{64}$"}}
    return {
        "/jobs.csv": resource("GetJobsTable", "The newest jobs, a line each", "text/csv", [
            query("state", "Only these states", repeated=True), query("label", "Only jobs with all of these labels",
                                                                      repeated=True),
            query("owner", "Only jobs of this user"), query("study", "Only jobs of this study"),
            query("title", "Only jobs with this title, with * and ?"),
            query("limit", "Most lines; 1,000", "integer")]),
        "/jobs/{id}/report": resource("GetReport", "The report of a job", "text/html", [JOB]),
        "/jobs/{id}/curl.csv": resource("GetCurlTable", "The curl of every monitor, step by step", "text/csv", [JOB]),
        "/jobs/{id}/results.h5": whole,
        "/jobs/{id}/frame": resource("GetFrame", "A stored frame, or one field of it", "application/octet-stream", [
            JOB, query("number", "From 1; 0 is the last one", "integer"), query("field", "Name of a field")]),
        "/attachments/{sha256}": resource(
            "PutAttachment", "Sends a file that a case names; Content-Length is required", "application/json",
            [sha256, query("name", "Of the file in the case; else its SHA-256")], "put",
            requestBody={"required": True, "content": {"application/octet-stream": {}}})}


def openapi(files, options, access, version):
    """The description of all unary calls and resources, as JSON can write it."""
    schemas, paths = {"Error": ERROR}, {}
    for file in files:
        comment = Comments(file)
        for index, message in enumerate(file.message_type):
            message_schemas(message, f"{file.package}.{message.name}", (4, index), comment, options, schemas)
        for kind in file.enum_type:
            schemas[f"{file.package}.{kind.name}"] = {"enum": [value.name for value in kind.value]}
        for place, service in enumerate(file.service):
            paths |= {SERVICE + method.name: method_path(method, comment.lines(6, place, 2, index), access)
                      for index, method in enumerate(service.method)
                      if not method.client_streaming and not method.server_streaming}
    return {"openapi": "3.1.0",
            "info": {"title": "dccast", "version": version,
                     "description": "Calls by the Connect protocol (https://connectrpc.com/docs/protocol), which also "
                     "has the streams, and resources by plain HTTP."},
            "security": [{"token": []}, {"session": []}], "paths": {**paths, **resources()},
            "components": {"securitySchemes": SECURITY, "schemas": used(schemas, paths)}}


def used(schemas, paths):
    """The schemas that paths name, directly or not."""
    found, left = {}, [json.dumps(paths)]
    while left:
        text = left.pop()
        for name, schema in schemas.items():
            if name not in found and f'schemas/{name}"' in text:
                found[name] = schema
                left.append(json.dumps(schema))
    return dict(sorted(found.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--openapi", required=True, type=pathlib.Path)
    parser.add_argument("--version", required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        sources = pathlib.Path(__file__).resolve().parents[2] / "proto"
        described_all = openapi(*described(sources, pathlib.Path(scratch)), arguments.version)
    arguments.openapi.write_text(json.dumps(described_all, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
