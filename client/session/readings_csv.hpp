#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/follow.pb.h"

namespace dccast::client {

/// Reads what a plant measures, one line of a table at a time. The first line names the columns with
/// their units:
///
///     time [s], speed [mm/min], water [l/min/m], narrow water [l/min/m], metal [degC], curl corner [mm]
///
/// "casting speed" and "casting temperature" are taken as well; "curl" stands before the monitor of
/// a gauge. Other columns are left out. Times are those of the case: zero is when the bottom block
/// starts to move.
class ReadingsTable {
public:
  /// A line as it was understood.
  struct Line {
    std::optional<v1::Reading> reading;  ///< without number; empty: the line holds none
    std::vector<std::string> remarks;    ///< what is wrong with it, or was left out
  };

  /// Takes the next line. Blank lines and comments ("#") hold nothing.
  /// @throws CommandFailed  the header has no time, no lever, or a unit that does not fit
  Line take(const std::string& line);

  bool has_header() const { return separator_ != 0; }
  /// Monitors whose curl has a column.
  const std::vector<std::string>& gauges() const { return gauges_; }

private:
  struct Quantity;
  /// A column that is read.
  struct Column {
    std::size_t cell;
    std::string name, unit;
    const Quantity* quantity;  ///< null: the curl of `monitor`
    std::string monitor;
  };

  static const std::vector<Quantity>& quantities();
  static const Quantity* quantity_of(const std::string& name);
  void read_header(const std::vector<std::string>& cells, Line& line);
  void read_cells(const std::vector<std::string>& cells, Line& line);

  int number_ = 0;       ///< of the line, from 1
  char separator_ = 0;   ///< 0: no header yet
  std::size_t cells_ = 0;
  std::vector<Column> columns_;
  std::vector<std::string> gauges_;
  std::optional<double> last_s_;
};

}  // namespace dccast::client
