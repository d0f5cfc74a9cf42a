"""Pages of the contract: services, messages and enumerations of the .proto files, with our options."""
import html
import importlib
import pathlib
import subprocess
import sys

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
