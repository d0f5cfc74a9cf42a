#pragma once

#include <filesystem>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "dccast/v1/line.pb.h"

namespace dccast::studies {

/// See jobs::file_header().
inline constexpr const char* line_file_kind = "DCCASTLN";

/// The file of a line cannot be read.
class DamagedLine : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Whether a text may name a line, so that a path made of it stays in its folder.
bool is_line_name(const std::string& text);

/// The lines: castings that share mould, water and metal, with the curls observed in each.
///
/// A line is a file `lines/NAME.bin`, replaced as a whole: a change survives a crash of the machine
/// once its call has returned. Format: the header "DCCASTLN" (jobs/folder/format.hpp),
/// then a frame with the serialised Line. A text that is no name names no line. Safe to use from
/// several threads. All calls throw DamagedLine and std::system_error.
class Lines {
public:
  explicit Lines(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// By name; a damaged one by its name alone.
  v1::ListLinesResponse list() const;
  /// Empty if there is no such line.
  std::optional<v1::Line> find(const std::string& name) const;

  /// The line, which is made for this owner where there is none.
  v1::Line begin(const std::string& name, const std::string& owner);
  /// Adds a casting; nothing if the line has that job already, or is not there any more.
  void add(const std::string& name, const v1::LineCasting& casting);
  /// Keeps the curls observed in an ended casting; nothing if the line does not have it any more.
  void end_casting(const std::string& name, const std::string& job,
                   const std::vector<v1::ObservedCurl>& curls);
  /// Takes all castings off the line. @return empty if there is no such line
  std::optional<v1::Line> restart(const std::string& name);
  /// @return false if there is no such line
  bool remove(const std::string& name);

private:
  std::optional<v1::Line> read(const std::string& name) const;
  void write(const v1::Line& line) const;

  std::filesystem::path directory_;
  mutable std::mutex mutex_;
};

}  // namespace dccast::studies
