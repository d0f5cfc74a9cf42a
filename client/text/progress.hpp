#pragma once

#include <chrono>
#include <optional>
#include <ostream>
#include <string>

#include "client/model/answer.hpp"
#include "client/text/terminal.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::client {

/// How fast a run goes. During the hold before t = 0 only heat is computed, which is quick: its
/// pace is none for what follows.
struct Pace {
  double expected_s = 0.0;  ///< of the whole run; 0: not known

  /// Counts a step for the estimate of the remaining time.
  void add(const v1::StepReport& step);
  /// Begins anew, after a resumption.
  void forget() { begin_.reset(); }
  /// Time left after the last step [s]; empty at the end, and where nothing is known.
  std::optional<double> left_s() const;

private:
  std::optional<v1::StepReport> begin_;  ///< first step that has the pace of the rest
  v1::StepReport last_;
};

/// Shows the events of a job: on a terminal in one line that is updated, otherwise one line per
/// event.
class Progress {
public:
  /// @param stream  standard error, so that results stay alone on standard output
  Progress(std::ostream& stream, Terminal terminal) : stream_(stream), terminal_(terminal) {}
  Progress(const Progress&) = delete;
  /// Ends the updated line, so that the next message starts on a new one.
  ~Progress() {
    if (stream_.good()) end_line();
  }

  /// Shows an event; the line of progress stays the last one.
  void show(const v1::JobEvent& event);
  /// What the whole run is expected to take [s]: for the time left while it has no pace of its own.
  void expect(double run_s) { pace_.expected_s = run_s; }
  /// Ends the updated line and draws the curl of the run, if there is one.
  void finish();

  /// The steps shown so far.
  const figures::RunHistory& history() const { return history_; }

private:
  /// Writes a line above the line of progress.
  void line(const std::string& text);
  /// Ends the line of progress, if there is one.
  void end_line();
  /// Writes the line of progress anew, at most 20 times a second unless forced.
  void renew(const std::string& text, bool force);

  std::ostream& stream_;
  Terminal terminal_;
  figures::RunHistory history_;
  Pace pace_;
  bool line_open_ = false;
  std::chrono::steady_clock::time_point renewed_{};
};

/// "step 120  t 45.2 s  cast 30.1 mm  corner +3.21 mm  2 it" (one step, no line end).
std::string step_line(const v1::StepReport& step);

/// "1 h 03 min", "4 min 10 s", "7 s".
std::string duration_text(double seconds);

}  // namespace dccast::client
