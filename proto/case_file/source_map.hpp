#pragma once

#include <map>
#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::case_file {

/// Where something stands in a file; 1 is the first line and column, 0 means unknown.
struct Position {
  int line = 0;
  int column = 0;
};

/// Where each key of a file stands, by its path ("schedule.casting_speed", "monitor[1].x").
class SourceMap {
public:
  SourceMap() = default;
  explicit SourceMap(std::string file) : file_(std::move(file)) {}

  void set(const std::string& path, Position position) { positions_[path] = position; }

  /// Position of `path`, or of its nearest parent that stands in the file; 0:0 if there is none.
  /// A fault found by the server in a key that was left out is so shown at its table.
  Position find(std::string path) const;

  const std::string& file() const { return file_; }

private:
  std::string file_;
  std::map<std::string, Position> positions_;
};

/// One line for people: `file:line:column: key = value: message; permitted; remedy`.
/// Parts that the fault leaves empty are left out.
std::string describe(const v1::Fault& fault, const SourceMap& source);

}  // namespace dccast::case_file
