#include "core/results/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/storage/record_log.hpp"

namespace dccast::results {

namespace {

constexpr std::string_view magic = "DCJRNL1\n";

/// Arrays of node numbers of a frame: name of the section and member.
constexpr std::pair<const char*, std::vector<std::int32_t> Frame::*> node_numbers[] = {
    {"element_node", &Frame::element_node}, {"bottom_node", &Frame::bottom_node}};

/// The record at `offset`; nothing at the end, or if the record is damaged.
std::optional<Record> read_record(storage::FileWindow& file, std::int64_t offset) {
  const auto found = storage::long_records.at(file, offset);
  if (!found) return std::nullopt;
  auto content = decode(found->payload);
  if (!content) return std::nullopt;
  return Record{static_cast<RecordKind>(found->kind), std::move(*content), offset + found->size};
}

}  // namespace

Journal::Journal(const std::filesystem::path& path)
    : log_(storage::File(path, O_WRONLY | O_CREAT | O_TRUNC, storage::readable_by_all)),
      pending_(magic) {}

Journal::Journal(const std::filesystem::path& path, std::int64_t size)
    : log_(storage::File(path, O_WRONLY)) {
  log_.cut(size);
}

void Journal::append(RecordKind kind, const Sections& content) {
  pending_ += storage::long_records.framed(encode(content), static_cast<std::uint8_t>(kind));
}

void Journal::write() {
  if (pending_.empty()) return;
  log_.append(pending_);
  pending_.clear();
}

bool visit_journal(const std::filesystem::path& path,
                   const std::function<bool(const Record&)>& visit, std::int64_t after) {
  const storage::File file(path, O_RDONLY);
  storage::FileWindow window(file);
  if (window.at(0, magic.size()) != magic) return false;

  std::int64_t end = std::max<std::int64_t>(after, magic.size());
  while (const auto record = read_record(window, end)) {
    if (!visit(*record)) break;
    end = record->end;
  }
  return true;
}

Sections to_sections(const RunHeader& header) {
  Sections content;
  content.set("program_version", header.program_version);
  content.set("build", header.build);
  content.set("commit", header.commit);
  content.set("title", header.title);
  content.set("case_sha256", header.case_sha256);
  content.set("case_json", header.case_json);
  content.set("section", header.section);

  content.set_real("liquidus", header.liquidus);
  content.set_real("solidus", header.solidus);
  content.set_real("shell", header.shell);
  if (header.relative_curl_error)
    content.set_real("relative_curl_error", *header.relative_curl_error);

  // Texts have sections of their own, because a section holds one text.
  content.set_integer("monitors", static_cast<std::int64_t>(header.monitor_name.size()));
  for (std::size_t i = 0; i < header.monitor_name.size(); ++i)
    content.set(fmt::format("monitor_name.{}", i), header.monitor_name[i]);

  content.set_integer("dimension", header.dimension);
  content.set("monitor_position", flat(header.monitor_position));
  return content;
}

RunHeader read_header(const Sections& content) {
  RunHeader header;
  header.program_version = content.text("program_version");
  header.build = content.text("build");
  header.commit = content.text("commit");
  header.title = content.text("title");
  header.case_sha256 = content.text("case_sha256");
  header.case_json = content.text("case_json");
  header.section = content.text("section");

  header.liquidus = content.real("liquidus");
  header.solidus = content.real("solidus");
  header.shell = content.real("shell");
  if (content.has("relative_curl_error"))
    header.relative_curl_error = content.real("relative_curl_error");

  for (std::int64_t i = 0; i < content.integer("monitors"); ++i)
    header.monitor_name.push_back(content.text(fmt::format("monitor_name.{}", i)));
  header.dimension = static_cast<int>(content.integer("dimension"));
  header.monitor_position =
      split_points(content.reals("monitor_position"), header.monitor_name.size());
  return header;
}

Sections to_sections(const Frame& frame) {
  Sections content;
  content.set_integer("step", frame.step);
  content.set("instant", Sections::Reals{frame.time, frame.cast_length, frame.metal_level});
  content.set("shape", Sections::Integers{frame.dimension, frame.nodes_per_element});

  content.set("node", frame.node);
  for (const FrameArray& array : frame_arrays()) content.set(array.name, frame.*array.values);
  for (const auto& [name, nodes] : node_numbers)
    content.set(name, Sections::Integers{(frame.*nodes).begin(), (frame.*nodes).end()});
  return content;
}

Frame read_frame(const Sections& content) {
  Frame frame;
  frame.step = content.integer("step");

  const auto& instant = content.reals("instant");
  frame.time = instant.at(0);
  frame.cast_length = instant.at(1);
  frame.metal_level = instant.at(2);

  frame.dimension = static_cast<int>(content.integers("shape").at(0));
  frame.nodes_per_element = static_cast<int>(content.integers("shape").at(1));

  frame.node = content.reals("node");
  // A run without an array writes no section for it.
  for (const FrameArray& array : frame_arrays())
    if (content.has(array.name)) frame.*array.values = content.reals(array.name);
  for (const auto& [name, nodes] : node_numbers) {
    const auto& values = content.integers(name);
    (frame.*nodes).assign(values.begin(), values.end());
  }
  return frame;
}

}  // namespace dccast::results
