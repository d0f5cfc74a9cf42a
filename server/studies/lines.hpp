#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "dccast/v1/line.pb.h"

namespace dccast::studies {

/// See jobs::file_header().
inline constexpr const char* line_file_kind = "DCCASTLN";

/// The file of a line cannot be read.
class DamagedLine : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Lines that one user may own. All are listed at once.
inline constexpr int most_lines_of_user = 100;
/// What a line keeps, its newest castings. Forecasts use the last 30 of them.
inline constexpr int most_castings = 100;
inline constexpr std::size_t most_casting_bytes = 1 << 20;

/// The lines in a folder by name, castings without what they have told; a damaged one by its name
/// alone.
v1::ListLinesResponse list_lines(const std::filesystem::path& directory);

/// Whether a text may name a line, so that a path made of it stays in its folder.
bool is_line_name(const std::string& text);

/// A job as a casting of its line, before it has told anything.
v1::LineCasting make_line_casting(const v1::Job& job, const v1::Following& following);

/// The lines: castings that share mould, water and metal, with the curls observed in each.
///
/// A line is a file `lines/NAME.bin`, replaced as a whole: a change survives a crash of the machine
/// once its call has returned. Format: the header "DCCASTLN" (jobs/folder/format.hpp),
/// then a frame with the serialised Line. A text that is no name names no line. Safe to use from
/// several threads. All calls throw DamagedLine and std::system_error.
class Lines {
public:
  /// A casting that is about to be submitted on a line. While it lasts, no other user begins a line
  /// of this name; a line that is new is written by add() alone.
  class Reservation {
  public:
    Reservation(Lines& lines, std::string name) : lines_(lines), name_(std::move(name)) {}
    Reservation(const Reservation&) = delete;
    ~Reservation() { lines_.release(name_); }

    /// Adds the casting, unless the line has its job already.
    void add(const v1::LineCasting& casting) const { lines_.add(name_, casting); }

  private:
    Lines& lines_;
    const std::string name_;
  };

  explicit Lines(std::filesystem::path directory);

  v1::ListLinesResponse list() const;  ///< see list_lines()
  /// Empty if there is no such line.
  std::optional<v1::Line> find(const std::string& name) const;
  /// The owner of the line, or of its name while it is reserved; "" of a damaged line. Empty if
  /// there is neither.
  std::optional<std::string> owner(const std::string& name) const;

  /// Keeps the name of a new line for this owner. @throws refusal::LimitReached
  Reservation reserve(const std::string& name, const std::string& owner);
  /// Adds a casting of a job that a crash of the daemon kept from its line. Nothing if the line has
  /// it, or was begun afresh since.
  void add_lost(const std::string& name, const std::string& owner, const v1::LineCasting& casting);
  /// Keeps the curls observed in an ended casting; nothing if the line does not have it any more.
  void end_casting(const std::string& name, const std::string& job,
                   const std::vector<v1::ObservedCurl>& curls);
  /// Takes all castings off the line. @return empty if there is no such line
  std::optional<v1::Line> restart(const std::string& name);
  /// @return false if there is no such line
  bool remove(const std::string& name);

private:
  /// The owner of a name for which castings are being submitted.
  struct Reserved {
    std::string owner;
    int castings = 0;
  };

  void add(const std::string& name, const v1::LineCasting& casting);
  /// Writes a line with one more casting. @param line  empty: it begins with it
  void write_with(std::optional<v1::Line> line, const std::string& name, const std::string& owner,
                  const v1::LineCasting& casting);
  void release(const std::string& name);
  void write(v1::Line line);

  const std::filesystem::path directory_;
  mutable std::mutex mutex_;
  std::map<std::string, std::string> owners_;  ///< of the files, by name of the line
  std::map<std::string, Reserved> reserved_;   ///< by name of the line
};

}  // namespace dccast::studies
