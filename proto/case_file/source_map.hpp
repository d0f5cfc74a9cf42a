#pragma once

#include <map>
#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::case_file {

/// Position in a file; 1 is the first line and column, 0 means unknown.
struct Position {
  /// Counted from 1; 0 if the place is not known.
  int line = 0;
  int column = 0;
};

/// Positions of the keys of a case by path ("schedule.casting_speed", "monitor[1].x"): in its file,
/// or in a change given in addition.
class SourceMap {
public:
  SourceMap() = default;
  explicit SourceMap(std::string file) : file_(std::move(file)) {}

  /// Records the position of a key in the file.
  void set(const std::string& path, Position position) { places_[path] = {position, {}}; }

  /// Records a key whose value comes from `origin` ("--set mesh.rows") instead of the file; the
  /// line is 0.
  void set(const std::string& path, Position position, const std::string& origin) {
    places_[path] = {position, origin};
  }

  /// Forgets a key and everything below it.
  void erase(const std::string& path);

  /// Position of `path`, or of its nearest parent in the file; 0:0 if there is none. A fault
  /// reported by the server for a missing key is thus shown at its table.
  Position find(const std::string& path) const { return find_place(path).position; }

  /// The file, or the change that gave the key.
  std::string origin_of(const std::string& path) const;

  /// Name of the file for messages.
  const std::string& file() const { return file_; }

private:
  /// Where a key was written, and in which file.
  struct Place {
    Position position;
    std::string origin;  ///< empty: the file
  };

  /// Place of a path, or of the nearest one above it.
  Place find_place(std::string path) const;

  std::string file_;
  std::map<std::string, Place> places_;
};

/// Whether `path` contains `other`: "schedule.casting_speed" covers itself,
/// "schedule.casting_speed[1]" and keys below it.
bool covers(const std::string& path, const std::string& other);

/// The fault as one line of text: `file:line:column: key = value: message; permitted; remedy`; for
/// a change it begins with `--set KEY, column N`. Empty parts are omitted.
std::string describe(const v1::Fault& fault, const SourceMap& source);

}  // namespace dccast::case_file
