#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "client/model/answer.hpp"
#include "client/model/json.hpp"
#include "client/session/connection.hpp"
#include "client/session/queries.hpp"
#include "dccast/v1/service.pb.h"

/// What the client writes to be opened in a browser. Every page is one file that loads nothing.
namespace dccast::client {

/// The run that a report is about.
struct ReportedRun {
  /// The job of the report, and its history with case and last frame.
  const v1::Job& job;
  const v1::QueryResultResponse& result;
  v1::Judgement judgement{};  ///< of the run alone; empty before its first step
  FrameSeries series{};       ///< frames to show; the last one is that of the result
};

/// A page about a job, see docs/report.md. The first sheet is one page of A4 for the plant: the
/// curl, its error and cause, findings, recipe, the last frame. The next ones have the histories
/// and the basis of the figures. The page states which parts are missing in the result, such as
/// frames.
std::string report_page(const ReportedRun& run);

/// That page with all that the server has for the job: result, study, frames. Throws CommandFailed.
/// @param notes  receives what the page lacks, a line each
/// @param frame_status  set to why there is no picture of the slab; OK where there is one
std::string report_of(Connection& connection, const v1::Job& job, std::ostream& notes,
                      grpc::Status& frame_status);

/// A comparison with charts of the differences and of what caused them.
std::string comparison_page(const v1::Comparison& comparison);

/// What the server concludes from a study: its sentences, then the tables and charts they rest on.
std::string judgement_page(const v1::StudyJudgement& study);

/// The start of a case: the section through the middle of the wide face, to scale, with metal,
/// mould, zones, water line and block, beside the ramps of speed and water.
/// @param complete  case with its defaults
std::string casting_page(const v1::Case& complete);

}  // namespace dccast::client
