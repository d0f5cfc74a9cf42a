#include "core/results/journal.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/storage/record_log.hpp"

namespace dccast::results {

namespace {

constexpr std::string_view magic = "DCJRNL1\n";

/// The record at `offset`; nothing at the end and where a record is damaged.
std::optional<Record> record_at(storage::FileWindow& file, std::int64_t offset) {
  const auto found = storage::long_records.at(file, offset);
  if (!found) return std::nullopt;
  auto content = decode(found->payload);
  if (!content) return std::nullopt;
  return Record{static_cast<RecordKind>(found->kind), std::move(*content), offset + found->size};
}

}  // namespace

Journal::Journal(storage::File file)
    : log_(std::make_unique<storage::RecordLog>(std::move(file))) {}

Journal Journal::create(const std::filesystem::path& path) {
  Journal journal(storage::File(path, O_WRONLY | O_CREAT | O_TRUNC, storage::readable_by_all));
  journal.pending_ = magic;
  return journal;
}

Journal Journal::reopen(const std::filesystem::path& path, std::int64_t size) {
  Journal journal(storage::File(path, O_WRONLY));
  journal.log_->cut(size);
  return journal;
}

void Journal::append(RecordKind kind, const Sections& content) {
  pending_ += storage::long_records.framed(encode(content), static_cast<std::uint8_t>(kind));
}

void Journal::write() {
  if (pending_.empty()) return;
  log_->append(pending_);
  pending_.clear();
}

bool visit_journal(const std::filesystem::path& path,
                   const std::function<bool(const Record&)>& visit, std::int64_t after) {
  const storage::File file(path, O_RDONLY);
  storage::FileWindow window(file);
  if (window.at(0, magic.size()) != magic) return false;
  std::int64_t end = std::max<std::int64_t>(after, magic.size());
  while (const auto record = record_at(window, end)) {
    if (!visit(*record)) break;
    end = record->end;
  }
  return true;
}

namespace {

using Points = std::vector<std::vector<double>>;

Sections::Reals flat(const Points& points) {
  Sections::Reals values;
  for (const auto& point : points) values.insert(values.end(), point.begin(), point.end());
  return values;
}

/// @throws std::out_of_range  the values are not whole points
Points points_of(const Sections::Reals& values, std::size_t count) {
  if (count == 0 ? !values.empty() : values.size() % count != 0)
    throw std::out_of_range("incomplete coordinates of a point");
  Points points(count);
  auto from = values.begin();
  for (auto& point : points) {
    point.assign(from, from + static_cast<std::ptrdiff_t>(values.size() / count));
    from += static_cast<std::ptrdiff_t>(values.size() / count);
  }
  return points;
}

std::vector<std::int32_t> narrow(const Sections::Integers& values) {
  std::vector<std::int32_t> narrowed(values.size());
  std::transform(values.begin(), values.end(), narrowed.begin(),
                 [](std::int64_t value) { return static_cast<std::int32_t>(value); });
  return narrowed;
}

Sections::Integers wide(const std::vector<std::int32_t>& values) {
  return {values.begin(), values.end()};
}

/// Calls visit(name, member of Frame) for every array of doubles of a frame.
template <class Visit>
void for_real_arrays(Visit&& visit) {
  visit("node", &Frame::node);
  visit("temperature", &Frame::temperature);
  visit("liquid_fraction", &Frame::liquid_fraction);
  visit("displacement", &Frame::displacement);
  visit("stress", &Frame::stress);
  visit("viscoplastic_strain", &Frame::viscoplastic_strain);
  visit("thermal_strain", &Frame::thermal_strain);
  visit("bottom_gap", &Frame::bottom_gap);
  visit("bottom_pressure", &Frame::bottom_pressure);
}

}  // namespace

Sections to_sections(const RunHeader& header) {
  Sections content;
  content.set("program_version", header.program_version);
  content.set("build", header.build);
  content.set("title", header.title);
  content.set("case_json", header.case_json);
  content.set("section", header.section);
  content.set_real("liquidus", header.liquidus);
  content.set_real("solidus", header.solidus);
  content.set_real("shell", header.shell);
  if (header.relative_curl_error)
    content.set_real("relative_curl_error", *header.relative_curl_error);
  content.set_integer("monitors", static_cast<std::int64_t>(header.monitor_name.size()));
  for (std::size_t i = 0; i < header.monitor_name.size(); ++i)
    content.set("monitor_name." + std::to_string(i), header.monitor_name[i]);
  content.set_integer("dimension", header.dimension);
  content.set("monitor_position", flat(header.monitor_position));
  return content;
}

RunHeader header_of(const Sections& content) {
  RunHeader header;
  header.program_version = content.text("program_version");
  header.build = content.text("build");
  header.title = content.text("title");
  header.case_json = content.text("case_json");
  header.section = content.text("section");
  header.liquidus = content.real("liquidus");
  header.solidus = content.real("solidus");
  header.shell = content.has("shell") ? content.real("shell") : header.solidus;
  if (content.has("relative_curl_error"))
    header.relative_curl_error = content.real("relative_curl_error");
  for (std::int64_t i = 0; i < content.integer("monitors"); ++i)
    header.monitor_name.push_back(content.text("monitor_name." + std::to_string(i)));
  header.dimension = static_cast<int>(content.integer("dimension"));
  header.monitor_position =
      points_of(content.reals("monitor_position"), header.monitor_name.size());
  return header;
}

Sections to_sections(const Frame& frame) {
  Sections content;
  content.set_integer("step", frame.step);
  content.set("instant", Sections::Reals{frame.time, frame.cast_length, frame.metal_level});
  content.set("shape", Sections::Integers{frame.dimension, frame.nodes_per_element});
  for_real_arrays([&](const char* name, auto member) { content.set(name, frame.*member); });
  content.set("element_node", wide(frame.element_node));
  content.set("bottom_node", wide(frame.bottom_node));
  return content;
}

Frame frame_of(const Sections& content) {
  Frame frame;
  frame.step = content.integer("step");
  const auto& instant = content.reals("instant");
  frame.time = instant.at(0);
  frame.cast_length = instant.at(1);
  frame.metal_level = instant.at(2);
  frame.dimension = static_cast<int>(content.integers("shape").at(0));
  frame.nodes_per_element = static_cast<int>(content.integers("shape").at(1));
  for_real_arrays([&](const char* name, auto member) {
    if (content.has(name)) frame.*member = content.reals(name);
  });
  frame.element_node = narrow(content.integers("element_node"));
  frame.bottom_node = narrow(content.integers("bottom_node"));
  return frame;
}

}  // namespace dccast::results
