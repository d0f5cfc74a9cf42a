#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/case_file/toml_walker.hpp"
#include "proto/values/printable.hpp"

namespace dccast::case_file {
namespace {

std::string against_text(const FieldDescriptor& field) {
  std::vector<std::string> abscissae;
  for (const v1::Abscissa abscissa : abscissae_of(field)) {
    const std::string unit = abscissa_unit(abscissa);
    abscissae.push_back(unit == "1" ? abscissa_name(abscissa)
                                    : fmt::format("{} [{}]", abscissa_name(abscissa), unit));
  }
  return fmt::format("against {}", joined(abscissae));
}

std::string abscissa_example(v1::Abscissa abscissa) {
  switch (abscissa) {
    case v1::TEMPERATURE:
      return "\"500 degC\"";
    case v1::LIQUID_FRACTION:
      return "0.5";
    case v1::TIME:
      return "\"60 s\"";
    default:
      return "\"30 mm\"";
  }
}

std::string pair_example(const FieldDescriptor& field) {
  return fmt::format("[{}, {}]", abscissa_example(abscissae_of(field).front()),
                     example_text(field));
}

/// The abscissa of a table, by the unit of its first point; unspecified, with a fault, if none
/// fits.
v1::Abscissa find_abscissa(const Entry& first) {
  const auto choices = abscissae_of(first.field);
  const bool is_number = first.node.is_number();
  const auto text = first.node.value<std::string>();
  for (const v1::Abscissa choice : choices)
    if ((is_number && abscissa_unit(choice) == "1") ||
        (text && parse_quantity(*text, abscissa_unit(choice)).value))
      return choice;

  std::string fault = "first number of a point: the unit is missing";
  if (text)
    fault = fmt::format("first number of a point: {}",
                        parse_quantity(*text, abscissa_unit(choices.front())).message);
  else if (!is_number)
    fault = fmt::format("{} where a quantity is expected", type_name(first.node));
  first.refuse(fault, against_text(first.field), fmt::format("e.g. {}", pair_example(first.field)));
  return v1::ABSCISSA_UNSPECIFIED;
}

/// Reads a point of a table. @return false, with a fault, if it is not valid
bool read_point(const Entry& point, v1::Curve& curve) {
  const auto& [walk, node, field, path] = point;
  const toml::array* const pair = node.as_array();
  if (pair == nullptr || pair->size() != 2) {
    point.refuse("a point must be a pair [abscissa, value]", against_text(field),
                 fmt::format("e.g. {}", pair_example(field)));
    return false;
  }

  const Entry first{walk, *pair->get(0), field, path}, second{walk, *pair->get(1), field, path};
  if (curve.abscissa() == v1::ABSCISSA_UNSPECIFIED) curve.set_abscissa(find_abscissa(first));
  if (curve.abscissa() == v1::ABSCISSA_UNSPECIFIED) return false;

  const auto at = read_number(walk, first.node, abscissa_unit(curve.abscissa()),
                              abscissa_example(curve.abscissa()), nullptr, path);
  const auto value = read_number(second);
  if (!at || !value) return false;
  if (curve.at_size() > 0 && *at <= curve.at(curve.at_size() - 1)) {
    walk.add(
        make_fault(path, written(first.node), "must be larger than that of the point before it",
                   fmt::format("strictly increasing {}", abscissa_name(curve.abscissa()))),
        node);
    return false;
  }

  curve.add_at(*at);
  curve.add_value(*value);
  return true;
}

constexpr std::size_t longest_reason = 200;  // of the parser, which repeats parts of the file

/// The outcome of a file that cannot be read at all: one fault.
ReadOutcome refused(const std::string& name, Position position, const std::string& message,
                    const std::string& remedy = {}) {
  ReadOutcome outcome;
  outcome.source = SourceMap(name);
  outcome.source.set("", position);
  outcome.faults.push_back(make_fault("", "", message, "", remedy));
  return outcome;
}

/// Reads a stream to its end, or to a little more than is accepted: enough to recognise a file that
/// is too large, or a device without an end.
std::string read_limited(std::istream& stream) {
  std::array<char, 65536> part;
  std::string text;
  while (text.size() <= maximum_file_bytes) {
    stream.read(part.data(), part.size());
    if (stream.gcount() == 0) break;
    text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
  }
  return text;
}

/// Orders faults by their position in the file; the parser returns keys in alphabetical order.
void sort_by_position(ReadOutcome& outcome) {
  std::stable_sort(outcome.faults.begin(), outcome.faults.end(),
                   [&](const v1::Fault& a, const v1::Fault& b) {
                     const Position left = outcome.source.find(a.field());
                     const Position right = outcome.source.find(b.field());
                     return std::pair(left.line, left.column) < std::pair(right.line, right.column);
                   });
}

/// Tells those who give the water of all faces what it is per metre of their perimeter.
void explain_flows_in_all(const Message& message, ReadOutcome& outcome) {
  const auto* const read = dynamic_cast<const v1::Case*>(&message);
  if (read == nullptr) return;
  for (v1::Fault& fault : outcome.faults) {
    if (fault.field().find("water_flow") == std::string::npos) continue;
    std::string flow = fault.value();
    std::erase(flow, '"');
    const std::string hint = flow_per_metre_hint(read->section(), flow);
    if (!hint.empty()) fault.set_remedy(hint);
  }
}

/// Reads a text. @param folder  of attachments; null: they are listed, not read
ReadOutcome read(std::string_view text, const std::string& name, Message& message,
                 const std::filesystem::path* folder) {
  if (const auto fault = check_text(text))
    return refused(name, fault->position, fault->message, fault->remedy);

  toml::table table;
  try {
    table = toml::parse(text, std::string_view(name));
  } catch (const toml::parse_error& error) {
    const auto begin = error.source().begin;
    return refused(
        name, {static_cast<int>(begin.line), static_cast<int>(begin.column)},
        fmt::format("not valid TOML: {}", values::shortened(error.description(), longest_reason)));
  }

  ReadOutcome outcome;
  outcome.source = SourceMap(name);
  outcome.source.set("", {1, 1});
  Walk walk{folder, outcome};
  if (table.empty())
    outcome.faults.push_back(make_fault("", "", "the file contains no key", "",
                                        "see `dccast new --list` for cases to begin with"));
  read_table(walk, table, message, "");
  if (outcome.ok()) outcome.faults = check_ranges(message);  // keys that do not go together
  explain_flows_in_all(message, outcome);
  sort_by_position(outcome);
  return outcome;
}

ReadOutcome too_large(const std::string& name) {
  return refused(name, {1, 1}, fmt::format("larger than {} MiB", maximum_file_bytes >> 20),
                 "a case file is a page or two; is this the right file?");
}

}  // namespace

v1::Curve read_curve(const Entry& entry) {
  v1::Curve curve;

  // A single quantity is a table of one point.
  const toml::array* const points = entry.node.as_array();
  if (points == nullptr) {
    if (const auto value = read_number(entry)) {
      curve.add_at(0.0);
      curve.add_value(*value);
    }
    return curve;
  }

  if (points->empty())
    entry.walk.add(make_fault(entry.path, "[]", "an empty table", "at least one point",
                              fmt::format("e.g. [{}]", pair_example(entry.field))),
                   entry.node);
  if (!entry.passes(count_fault(entry.field, points->size(), entry.path))) return curve;

  bool valid = true;
  for (std::size_t i = 0; i < points->size(); ++i)
    valid &=
        read_point({entry.walk, *points->get(i), entry.field, element_path(entry.path, i)}, curve);
  return valid ? curve : v1::Curve();
}

ReadOutcome read_text(std::string_view text, const std::string& name, Message& message,
                      const std::filesystem::path& folder) {
  return read(text, name, message, &folder);
}

ReadOutcome read_elsewhere(std::string_view text, const std::string& name, Message& message) {
  if (text.size() > maximum_file_bytes) return too_large(name);
  return read(text, name, message, nullptr);
}

ReadOutcome read_file(const std::filesystem::path& file, Message& message) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return refused(file.string(), {}, "no such file");
  if (std::filesystem::is_directory(file, error)) return refused(file.string(), {}, "is a folder");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return refused(file.string(), {}, "cannot be read");
  const std::string text = read_limited(stream);
  if (text.size() > maximum_file_bytes) return too_large(file.string());
  return read_text(text, file.string(), message, file.parent_path());
}

}  // namespace dccast::case_file
