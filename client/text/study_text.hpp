#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "client/model/study.hpp"
#include "client/session/plan_requests.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// "running", "succeeded", ...
std::string state_text(v1::StudyState state);

/// "refinement", "sweep of 2 keys", "mould".
std::string plan_text(const v1::Study& study);

/// "120 of 200 runs, 2 running, 3 failed, 61 %".
std::string progress_text(const v1::Study& study);

/// All details of one study, one per line.
std::string study_sheet(const v1::Study& study);

/// Shows the progress of a study: on a terminal in one line that is updated, otherwise one line per
/// tenth of the runs.
class StudyProgress {
public:
  StudyProgress(std::ostream& stream, Terminal terminal) : stream_(stream), terminal_(terminal) {}
  StudyProgress(const StudyProgress&) = delete;
  ~StudyProgress();
  void show(const v1::Study& study);

private:
  std::ostream& stream_;
  Terminal terminal_;
  bool line_open_ = false;
  int shown_tenth_ = -1;
};

/// A study as a text table: one row per level with the curl at the end; then observed order, limit
/// and uncertainty at the end, and the largest uncertainty of the whole history with its time.
std::string study_table(const Study& study);

/// The note below a table whose figures are marked with "!"; empty if all levels are valid.
std::string validity_note(const Study& study);

/// Monitors of the levels that succeeded.
std::vector<std::string> monitor_names(const Study& study);

/// The cells of that table, for other kinds of tables: refinement, nodes, solver seconds and state,
/// then one cell per monitor. limit_rows() is empty while there is no result.
Rows level_rows(const Study& study);
Rows limit_rows(const Study& study);

/// A sweep as a text table: one row per run with its values, the final curl of every monitor and
/// its outcome.
std::string sweep_table(const v1::StudyResult& result);

/// The same as CSV, in metres; missing numbers are empty.
std::string sweep_csv(const v1::StudyResult& result);

/// Outcome of a run: "failed: solve failed", "succeeded, beyond validity".
std::string run_text(const v1::StudyRun& run);

/// State, break points, half-openings and deviation from flatness of each run.
std::string mould_runs_table(const MouldDesign& design);

/// The opening that was found: break points and half-openings. Empty if there is none yet.
std::string mould_opening_table(const MouldDesign& design);

/// The resulting cold slab along the wide face.
std::string mould_profile_table(const MouldDesign& design);

/// Summary in plain words, with caveats.
std::string mould_sentence(const MouldDesign& design);

/// All of this as terminal output.
std::string mould_text(const MouldDesign& design);

}  // namespace dccast::client::render
