#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/line.pb.h"
#include "server/studies/line_log.pb.h"

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
/// What a line keeps, its newest records. Forecasts use the last 30 followed castings.
inline constexpr int most_castings = 10'000;
inline constexpr std::size_t most_casting_bytes = 8 << 20;  ///< of these records

/// The lines in a folder by name, without their castings; a damaged one by its name alone.
v1::ListLinesResponse list_lines(const std::filesystem::path& directory);

/// Whether a text may name a line, so that a path made of it stays in its folder.
bool is_line_name(const std::string& text);

/// A job as a casting of its line, before it has told anything.
/// @param complete  its case
v1::LineCasting make_line_casting(const v1::Job& job, const v1::Following& following,
                                  const v1::Case& complete);
/// Names title, recipe and its end in a record. @param complete  the case that was cast
void set_recipe(const v1::Case& complete, v1::LineCasting& casting);
/// Writes what somebody has typed of a casting into its record; a followed one keeps its begin.
/// @param user  who has typed it
void set_typed(const v1::LineCasting& typed, const std::string& user, v1::LineCasting& casting);
/// What the castings of a case have in common: LineCasting.recipe.
std::string recipe_name(const v1::Case& complete);

class StoredLine;  // in lines.cpp

/// What became of typed castings.
struct AddedCastings {
  std::vector<std::string> ids;  ///< of the records, in their order
  bool repeated = false;         ///< the request had added them before
  bool other_request = false;    ///< its id was used for other castings: nothing was added
};

/// The lines: castings that share mould, water and metal, followed ones with the curls observed in
/// each, and those that somebody has typed.
///
/// A line is a file `lines/NAME.bin` to which changes are appended: a change survives a crash of
/// the machine once its call has returned. Format: the header "DCCASTLN" (jobs/folder/format.hpp),
/// then frames with serialised LineChanges (line_log.proto). Bytes of an append that was cut short
/// are dropped; anything else that is no frame is damage. A text that is no name names no line.
/// Safe to use from several threads. All calls throw DamagedLine and std::system_error.
class Lines {
public:
  /// A casting that is about to be submitted on a line. While it lasts, no other user begins a line
  /// of this name; a line that is new is written by add() alone.
  class Reservation {
  public:
    /// Made by reserve().
    Reservation(Lines& lines, std::string name) : lines_(lines), name_(std::move(name)) {}
    Reservation(const Reservation&) = delete;
    ~Reservation() { lines_.release(name_); }

    /// Adds the casting, unless the line has its job already.
    void add(const v1::LineCasting& casting) const { lines_.add(name_, casting); }
    /// Adds typed records in one write, which get ids; the same request once.
    /// @param request  what was asked for, as SHA-256
    AddedCastings add_typed(std::vector<v1::LineCasting> castings, const std::string& request_id,
                            const std::string& request) const {
      return lines_.add_typed(name_, std::move(castings), request_id, request);
    }

  private:
    Lines& lines_;
    const std::string name_;
  };

  /// Reads whose lines there are. @param directory  need not be there
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
  /// Replaces what was typed of a record, by set_typed(). @return empty if there is no such line or
  /// record
  std::optional<v1::LineCasting> edit(const std::string& name, const std::string& id,
                                      const v1::LineCasting& typed, const std::string& user);
  /// Takes records off the line, all or none.
  /// @return the first id that the line does not have; empty: all were taken off
  std::optional<std::string> forget(const std::string& name, const std::vector<std::string>& ids);
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
  AddedCastings add_typed(const std::string& name, std::vector<v1::LineCasting> castings,
                          const std::string& request_id, const std::string& request);
  void release(const std::string& name);
  /// Appends a change to the file of a line. @param stored  what the file has; empty: there is none
  /// @param owner  of a line that begins with it
  void append(const std::optional<StoredLine>& stored, const std::string& name,
              const std::string& owner, LineChange change);

  const std::filesystem::path directory_;
  mutable std::mutex mutex_;
  std::map<std::string, std::string> owners_;  ///< of the files, by name of the line
  std::map<std::string, Reserved> reserved_;   ///< by name of the line
};

}  // namespace dccast::studies
