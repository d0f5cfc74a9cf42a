#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "client/text/terminal.hpp"
#include "dccast/v1/study.pb.h"

namespace dccast::client {

/// "running", "answered", "no answer", "cancelled". A study has answered where a run has succeeded:
/// in a search for remedies most of the runs may fail.
std::string state_text(const v1::Study& study);

/// "refinement", "sweep of 2 keys", "mould".
std::string plan_text(const v1::Study& study);

/// "120 of 200 runs, 2 running, 3 failed".
std::string runs_text(const v1::Study& study);

/// "120 of 200 runs, 2 running, 3 failed, 61 %".
std::string progress_text(const v1::Study& study);

/// All details of one study, one per line.
std::string study_sheet(const v1::Study& study);

/// Shows the progress of a study: on a terminal in one line that is updated, otherwise one line per
/// tenth of the runs.
class StudyProgress {
public:
  /// @param stream  standard error
  StudyProgress(std::ostream& stream, Terminal terminal) : stream_(stream), terminal_(terminal) {}
  StudyProgress(const StudyProgress&) = delete;
  /// Ends the line of progress.
  ~StudyProgress();
  /// Shows the progress: on a terminal in one renewed line, else a line at every tenth.
  void show(const v1::Study& study);

private:
  std::ostream& stream_;
  Terminal terminal_;
  bool line_open_ = false;
  int shown_tenth_ = -1;
};

}  // namespace dccast::client
