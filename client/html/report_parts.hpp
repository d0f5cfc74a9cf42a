#pragma once

#include <optional>
#include <string>

#include "client/model/answer.hpp"
#include "client/session/queries.hpp"
#include "dccast/v1/judgement.pb.h"
#include "dccast/v1/service.pb.h"

/// The parts of report_page().
namespace dccast::client::render {

/// The run that a report is about.
struct ReportedRun {
  /// The job of the report, and its history with case and last frame.
  const v1::Job& job;
  const v1::QueryResultResponse& result;
  const v1::StudyJudgement& study;  ///< of the refinement study it belongs to, or empty
  CurlHistory history;
};

/// One sentence about the largest curl at the end: place, value, uncertainty, and whether it is
/// within the plant's range. Empty before the first step.
std::string curl_sentence(const ReportedRun& run);

/// When half of the largest curl came, and through which faces the heat left meanwhile. Empty where
/// nothing has curled.
std::string cause_sentence(const ReportedRun& run);

/// The figures of the last step in boxes, curls with their error if known.
std::string headline(const ReportedRun& run);

/// The chart of the curl against time or cast length, with the plant's range.
std::string curl_figure(const ReportedRun& run, bool against_length);

/// The remark beside a figure of the last step; empty while the model is valid.
std::string last_step_mark(const CurlHistory& history);

/// Charts against time of the quantities that decide whether a casting succeeds: shell, sump,
/// temperatures, heat through each face, and the contact of the bottom with the block. Empty with
/// fewer than two steps.
std::string history_part(const v1::QueryResultResponse& result);

/// The stored frames, which a script of the page draws. A line reports that there is none.
std::string frame_part(const v1::QueryResultResponse& result, const CurlHistory& history,
                       const FrameSeries& series);

/// Of the last stored frame, gap and pressure along the bottom of a 2D section; of a quarter slab
/// the gap map and the pull-in of the wide face. Empty without a frame.
std::string bottom_part(const v1::QueryResultResponse& result, const CurlHistory& history);

/// Error of the curl of one run according to a study.
struct CurlError {
  double this_run_m = 0.0;  ///< distance to the limit plus the uncertainty of the limit [m]
  double limit_m = 0.0;
  double uncertainty_m = 0.0;  ///< of the limit [m]
  bool extrapolated = false;   ///< else the limit is the curl of the finest run
};

/// @return empty if the study has no result for this monitor at this time
std::optional<CurlError> curl_error(const v1::StudyResult& study, const std::string& monitor,
                                    double time_s, double curl_m);

/// Adds the limit of each monitor with its interval, against time or cast length.
void add_limits(v1::Chart& chart, const v1::StudyResult& study, bool against_length);

/// The card "How much of it is discretisation", or a line with the command that computes it where
/// no error is known.
std::string study_part(const v1::StudyJudgement& study, const v1::Job& job);

}  // namespace dccast::client::render
