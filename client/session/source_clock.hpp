#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dccast::client {

/// The clock of a source of readings, freed from its jumps. What a jump adds to the stamps is taken
/// from all later ones.
///
/// A source in real time is one whose lines arrive as far apart as their stamps are. There a stamp
/// that is 5 s ahead of its arrival is a jump, however long the line before is ago: no line is
/// written in the future. So is one that is 5 s behind it although the line came in time.
///
/// Lines that are read at once have no arrivals. There a step of more than ten usual pauses and of
/// more than `jump_from` is a jump, a shorter one a gap.
///
/// A step back is a jump where the next line goes on from there. A line that fills a gap is late,
/// and one that repeats a line is doubled: both are left out.
class SourceClock {
public:
  /// A line that is known again: its stamp, and a hash of what it holds.
  struct Mark {
    double stamp_s = 0.0;
    std::size_t content = 0;
    bool operator==(const Mark&) const = default;
  };
  /// The jumps so far, for a program that goes on with the source.
  struct History {
    struct Jump {
      Mark at;                ///< the line at which it was found
      double offset_s = 0.0;  ///< added to the stamps from there on
    };
    Mark first;  ///< line of the source
    std::vector<Jump> jumps;
  };

  /// @param jump_from_s  steps of this length and more are jumps, of lines that are read at once;
  ///                     empty: 60 s
  explicit SourceClock(std::optional<double> jump_from_s = {}) : jump_from_s_(jump_from_s) {}
  /// @param before  jumps that an earlier program has found. A source that begins with the same
  ///                line meets them again, another one goes on behind them.
  SourceClock(std::optional<double> jump_from_s, History before)
      : jump_from_s_(jump_from_s), history_(std::move(before)) {}

  /// A stamp as it is understood.
  struct Placed {
    double time_s = 0.0;      ///< on the clock as it was at first
    bool is_earlier = false;  ///< not later than the last one: the line is left out
    bool is_jump = false;     ///< found at this line
    /// What it was taken for, and how to say otherwise; empty: the clock runs as usual. It follows
    /// "the clock " for a jump, and stands behind "no reading for 20 s" for a gap.
    std::string remark{};
  };

  /// Takes the next line. @param time_s  its stamp [s]  @param arrival_s  on a steady clock; empty:
  /// it is read at once  @param content  hash of what the line holds
  Placed place(double time_s, std::optional<double> arrival_s, std::size_t content);
  const History& history() const { return history_; }

private:
  struct Line {
    double time_s;
    Mark mark;
  };

  /// Usual step of the stamps or of the arrivals; empty: not known yet.
  static std::optional<double> usual(const std::deque<double>& steps);
  bool is_in_real_time() const;
  /// Whether a stamp that is not later tells a clock that was set back, with the one before it.
  bool is_set_back(const Line& line) const;
  Placed place_earlier(const Line& line, std::optional<double> elapsed_s);
  Placed place_later(const Line& line, std::optional<double> elapsed_s);
  Placed jump(double to_s, const Line& line, const std::string& reason);
  /// Finds the place of the first line among the jumps that are known.
  void begin(const Mark& first);
  /// Whether a known jump is at this line; the offset is then that behind it.
  bool meets_known_jump(const Mark& mark);
  void accept(const Line& line, std::optional<double> arrival_s);

  std::optional<double> jump_from_s_;
  History history_;
  std::size_t passed_ = 0;  ///< jumps of it that lie behind
  double offset_s_ = 0.0;   ///< added to stamps
  std::deque<Line> lines_;
  std::deque<double> steps_s_, pauses_s_;  ///< of stamps and arrivals that went on as usual
  std::optional<double> last_arrival_s_;
  std::optional<double> ahead_s_;  ///< largest lead of a stamp over its arrival
  std::optional<Line> back_;       ///< the last line, if it was not later
};

}  // namespace dccast::client
