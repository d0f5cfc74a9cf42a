#include "proto/case_file/source_map.hpp"

#include <fmt/format.h>

namespace dccast::case_file {
namespace {

/// Path of the table that contains a key: "monitor[1].x" -> "monitor[1]" -> "monitor" -> "".
std::string parent_path(const std::string& path) {
  const auto end = path.find_last_of(".[");
  return end == std::string::npos ? std::string() : path.substr(0, end);
}

std::string format_position(const std::string& origin, Position position) {
  if (position.line > 0) return fmt::format("{}:{}:{}", origin, position.line, position.column);
  return position.column > 0 ? fmt::format("{}, column {}", origin, position.column) : origin;
}

}  // namespace

bool covers(const std::string& path, const std::string& other) {
  if (path.empty() || !other.starts_with(path)) return false;
  return other.size() == path.size() || other[path.size()] == '.' || other[path.size()] == '[';
}

void SourceMap::erase(const std::string& path) {
  std::erase_if(places_, [&](const auto& entry) { return covers(path, entry.first); });
}

std::string SourceMap::origin_of(const std::string& path) const {
  const std::string origin = find_place(path).origin;
  return origin.empty() ? file_ : origin;
}

SourceMap::Place SourceMap::find_place(std::string path) const {
  while (true) {
    if (const auto found = places_.find(path); found != places_.end()) return found->second;
    if (path.empty()) return {};
    path = parent_path(path);
  }
}

std::string describe(const v1::Fault& fault, const SourceMap& source) {
  std::string text = format_position(source.origin_of(fault.field()), source.find(fault.field()));
  if (!text.empty()) text += ": ";

  if (!fault.field().empty()) {
    text += fault.field();
    if (!fault.value().empty()) text += " = " + fault.value();
    text += ": ";
  }

  text += fault.message();
  if (!fault.permitted().empty()) text += "; permitted: " + fault.permitted();
  if (!fault.remedy().empty()) text += "; " + fault.remedy();
  return text;
}

}  // namespace dccast::case_file
