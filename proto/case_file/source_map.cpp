#include "proto/case_file/source_map.hpp"

namespace dccast::case_file {
namespace {

/// "monitor[1].x" -> "monitor[1]" -> "monitor" -> "".
std::string parent_path(const std::string& path) {
  const auto end = path.find_last_of(".[");
  return end == std::string::npos ? std::string() : path.substr(0, end);
}

}  // namespace

Position SourceMap::find(std::string path) const {
  while (true) {
    if (const auto found = positions_.find(path); found != positions_.end()) return found->second;
    if (path.empty()) return {};
    path = parent_path(path);
  }
}

std::string describe(const v1::Fault& fault, const SourceMap& source) {
  std::string text = source.file();
  if (const Position at = source.find(fault.field()); at.line > 0)
    text += ":" + std::to_string(at.line) + ":" + std::to_string(at.column);
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
