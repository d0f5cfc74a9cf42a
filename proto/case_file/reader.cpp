#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/case_file/toml_walker.hpp"
#include "proto/values/shortened.hpp"

namespace dccast::case_file {
namespace {

constexpr std::size_t longest_reason = 200;  // of the parser, which repeats parts of the file

ReadOutcome refused(const std::string& name, Position position, const std::string& message,
                    const std::string& remedy = {}) {
  ReadOutcome outcome;
  outcome.source = SourceMap(name);
  outcome.source.set("", position);
  outcome.faults.push_back(make_fault("", "", message, "", remedy));
  return outcome;
}

/// The stream up to its end, or to a little more than is accepted: that tells a file that is too
/// large, whatever its size (or a device).
std::string beginning_of(std::istream& stream) {
  std::array<char, 65536> part;
  std::string text;
  while (text.size() <= maximum_file_bytes) {
    stream.read(part.data(), part.size());
    if (stream.gcount() == 0) break;
    text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
  }
  return text;
}

/// The parser hands keys over in alphabetical order; people read a file from its top.
void sort_by_place(ReadOutcome& outcome) {
  std::stable_sort(outcome.faults.begin(), outcome.faults.end(),
                   [&](const v1::Fault& a, const v1::Fault& b) {
                     const Position left = outcome.source.find(a.field());
                     const Position right = outcome.source.find(b.field());
                     return std::pair(left.line, left.column) < std::pair(right.line, right.column);
                   });
}

}  // namespace

ReadOutcome read_text(std::string_view text, const std::string& name, Message& message,
                      const std::filesystem::path& folder) {
  if (const auto fault = check_text(text))
    return refused(name, fault->position, fault->message, fault->remedy);
  toml::table table;
  try {
    table = toml::parse(text, std::string_view(name));
  } catch (const toml::parse_error& error) {
    const auto begin = error.source().begin;
    return refused(name, {static_cast<int>(begin.line), static_cast<int>(begin.column)},
                   std::string("not valid TOML: ")
                       .append(values::shortened(error.description(), longest_reason)));
  }
  ReadOutcome outcome;
  outcome.source = SourceMap(name);
  outcome.source.set("", {1, 1});
  Walk walk{folder, outcome};
  if (table.empty()) {
    outcome.faults.push_back(make_fault("", "", "the file holds no key", "",
                                        "see `dccast new --list` for cases to begin with"));
  }
  read_table(walk, table, message, "");
  sort_by_place(outcome);
  return outcome;
}

ReadOutcome read_file(const std::filesystem::path& file, Message& message) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return refused(file.string(), {}, "no such file");
  if (std::filesystem::is_directory(file, error)) return refused(file.string(), {}, "is a folder");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return refused(file.string(), {}, "cannot be read");
  const std::string text = beginning_of(stream);
  if (text.size() > maximum_file_bytes)
    return refused(file.string(), {1, 1},
                   "larger than " + std::to_string(maximum_file_bytes >> 20) + " MiB",
                   "a case file is a page or two; is this the right file?");
  return read_text(text, file.string(), message, file.parent_path());
}

}  // namespace dccast::case_file
