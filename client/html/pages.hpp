#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "client/model/answer.hpp"
#include "client/model/study.hpp"
#include "client/session/connection.hpp"
#include "client/session/plan_requests.hpp"
#include "client/session/queries.hpp"
#include "dccast/v1/service.pb.h"

/// What the client writes to be opened in a browser. Every page is one file that loads nothing.
namespace dccast::client::render {

/// A page about a job, see docs/report.md. The first sheet is one page of A4 for the plant: the
/// curl, its error and cause, findings, recipe, the last frame. The next ones have the histories
/// and the basis of the figures. The page states which parts are missing in the result, such as
/// frames. With a study of at least two successful runs, curls have their error, and charts show
/// the limit with its interval; otherwise the page names the command that computes them.
/// @param series  frames for the slider; the last one is that of the result
std::string report_page(const v1::Job& job, const v1::QueryResultResponse& result,
                        const Study& study = {}, const FrameSeries& series = {});

/// That page with all that the server has for the job: result, study, frames. Throws CommandFailed.
/// @param notes  receives what the page lacks, a line each
/// @param frame_status  set to why there is no picture of the slab; OK where there is one
std::string report_of(Connection& connection, const v1::Job& job, std::ostream& notes,
                      grpc::Status& frame_status);

/// A comparison with charts of the differences and of what caused them.
std::string comparison_page(const v1::Comparison& comparison);

/// A sweep: the final curl against each numeric key and against pairs of such keys, with the table
/// of all runs.
std::string sweep_page(const v1::StudyResult& result);

/// A mould design: mould and cold slab of every run, their deviation from flatness, and the tables
/// shown in the terminal.
std::string mould_page(const MouldDesign& design);

/// What the server concludes from a study: its sentences, then the tables and charts they rest on.
std::string judgement_page(const v1::StudyJudgement& study);

/// A calibration: what was measured over what is computed, with the bands of the data before and
/// after and that of mesh and time steps, keys and curves as tables, and the runs that do not
/// count.
std::string calibration_page(const v1::StudyResult& result);

/// The page of any study. @param kind  "Study"  @param note  text below its title  @param body HTML
std::string study_page(const v1::Study& study, const std::string& kind, const std::string& note,
                       const std::string& body);

/// The start of a case as an SVG file: the section through the middle of the wide face, to scale,
/// with metal, mould, zones, water line and block, beside the ramps of speed and water.
/// @param complete  case with its defaults
std::string casting_drawing(const v1::Case& complete);

}  // namespace dccast::client::render
