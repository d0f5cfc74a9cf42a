#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/session/readings_columns.hpp"
#include "client/session/source_clock.hpp"
#include "dccast/v1/follow.pb.h"

namespace dccast::client {

/// A reading, and the line of the source that held it.
struct ReadingOfLine {
  v1::Reading reading;
  int line = 0;  ///< from 1
};

/// Reads what a plant measures, line by line: rows of a table whose first line names the columns
/// with their units,
///
///     time [s], speed [mm/min], water [l/min/m], narrow water [l/min/m], metal [degC], curl corner
///     [mm]
///
/// or JSON objects with such names, {"time [s]": 12, "speed [mm/min]": 40}. With a file of columns
/// the names are those of the plant. Other columns are left out.
class ReadingsTable {
public:
  /// Longest line that is read [bytes].
  static constexpr std::size_t longest_line = 65536;

  /// A line as it was understood.
  struct Line {
    /// Known from now on, without numbers: that of this line, with those that waited for the time
    /// zero.
    std::vector<ReadingOfLine> readings;
    std::vector<std::string> remarks;  ///< what is wrong with it, or was left out
    std::optional<double> time_s;      ///< of the line, on the clock of the source
    bool has_values = false;           ///< a lever or a curl could be read
    std::string fault;                 ///< the first thing that could not be read; empty: nothing
  };

  /// @param map  the plant's names; empty: those above
  explicit ReadingsTable(std::optional<ColumnMap> map = {}, SourceClock clock = SourceClock());

  /// Takes the next line. Blank lines and comments ("#") hold nothing.
  /// @param arrival_s  when it came, on a steady clock [s]; empty: it is read at once
  /// @throws CommandFailed  the columns have no time, no lever, or a unit that does not fit; the
  /// bottom block moves before its start was seen
  Line take(const std::string& line, std::optional<double> arrival_s = {});

  bool has_header() const { return !header_.empty(); }
  const SourceClock& clock() const { return clock_; }
  /// How many cells of each column could not be read, and how many lines had each other fault,
  /// where that was more than one.
  std::vector<std::string> summary() const;
  /// Monitors whose curl has a column.
  std::vector<std::string> gauges() const;

private:
  /// A measured value that stays the same.
  struct Repetition {
    double value, since_s;
    bool reported = false;
  };

  std::string at_line(const std::string& text) const;
  /// Remarks the first line with a fault of a kind, and counts all of them.
  /// @param kind  for the summary, "lines without a time"
  void remark_first(const std::string& kind, const std::string& text, Line& line);
  /// The same of a line that is left out.
  void refuse(const std::string& kind, const std::string& text, Line& line);
  void refuse_cell(std::size_t column, const std::string& cell, Line& line);
  std::string clock_text(double seconds) const;
  void take_row(const std::string& text, Line& line);
  void take_object(const std::string& text, Line& line);
  void read_header(std::vector<std::string> names, Line& line);
  void read_columns_of_header();
  /// Takes a header that a logger writes again when it begins a new file.
  /// @return false: the row is none @throws CommandFailed  it lacks a column
  bool take_header_again(const std::vector<std::string>& row);
  void find_columns_of_map(Line& line);
  void report_new_names(const std::vector<std::string>& names, Line& line);
  /// @param cells  as many as columns; empty where there is no value
  void read_cells(const std::vector<std::string>& cells, Line& line);
  /// Gives a line the time of the clock without its jumps. @return whether it is later than the
  /// last
  bool follows_last(const std::vector<std::string>& cells, Line& line);
  void set_speed(double time_s, double length_m, v1::Reading& reading, Line& line);
  /// Goes on to a reading that may have no speed: the server keeps the last one for a while.
  void keep_speed(double time_s);
  /// Sends a speed that begins right after the last reading and holds up to a time.
  void hold_speed(double time_s, double speed_m_per_s, Line& line);
  bool is_odd(double time_s, double length_m, Line& line);
  void report_repetition(std::size_t column, double value, double time_s, Line& line);
  void place_in_time(v1::Reading reading, Line& line);
  void leave_out_oldest(Line& line);
  void find_zero(double time_s, Line& line);

  std::optional<ColumnMap> map_;
  SourceClock clock_;
  std::vector<Column> columns_;
  std::vector<std::string> header_;    ///< names in the first line, and in later objects
  char separator_ = 0;                 ///< of rows; 0: there are objects only
  int number_ = 0;                     ///< of the line, from 1
  std::optional<double> arrival_s_;    ///< of the line
  std::map<std::string, int> faulty_;  ///< lines with each kind of fault

  /// What the last reading leaves.
  std::optional<double> last_s_;                          ///< on the clock of the source
  std::optional<std::pair<double, double>> last_length_;  ///< its time [s], and [m]
  std::optional<std::pair<double, double>> odd_length_;   ///< no block moves to it from the last
  double first_length_s_ = 0.0;
  bool length_rises_ = false;
  /// A course of the block as the server integrates the speeds so far.
  struct Course {
    double time_s, length_m, speed_m_per_s;
    double measured_s;  ///< when a length was last there
  };
  std::optional<Course> course_;
  std::optional<double> before_s_;                      ///< time of the reading before this one
  double rise_s_ = 0.0;                                 ///< when the length last rose
  double due_s_ = 0.0;                                  ///< until when its last rise is spread
  std::vector<std::optional<Repetition>> repetitions_;  ///< (column)
  std::vector<int> unreadable_;                         ///< (column) cells

  /// The time zero on the clock of the source; empty: the block has not moved.
  std::optional<double> zero_s_ = 0.0;
  std::optional<double> still_s_;      ///< when it was last seen to stand
  std::deque<ReadingOfLine> waiting_;  ///< for the time zero; times of the source
  bool leaves_out_oldest_ = false;     ///< of those that wait
};

}  // namespace dccast::client
