#pragma once

#include <string>
#include <vector>

#include "client/html/svg_chart.hpp"
#include "client/model/comparison.hpp"
#include "client/model/json.hpp"
#include "client/text/terminal.hpp"

namespace dccast::client::render {

/// Findings, the curl of every monitor with its uncertainty, and a loss of validity, one per line.
std::string answer_text(const Answer& answer);

/// What a query waits for and how long, in one line: "waiting for 2 queries, about 40 s".
std::string waiting_text(const v1::QueryButtCurlResponse::Waiting& waiting);

/// Origin of the answer and the time it took, in one line.
std::string origin_text(const Answer& answer);

/// The complete answer, in metres and seconds.
Json answer_json(const Answer& answer);

/// A difference in a sentence, and what differed before it.
struct Explained {
  const CurlDifference* difference;
  std::vector<Cause> causes;  ///< of the monitor that differs most between two runs
  std::string text;
};
std::vector<Explained> explanations(const std::vector<Answer>& answers,
                                    const std::vector<CurlDifference>& differences);

/// The differing keys of the cases, the curls in one chart, their differences, and sentences about
/// them, in at most 120 columns.
std::string comparison_text(const std::vector<Answer>& answers,
                            const std::vector<CurlDifference>& differences,
                            const Terminal& terminal);

Json comparison_json(const std::vector<Answer>& answers,
                     const std::vector<CurlDifference>& differences);

/// Names of all monitors, in order of first appearance.
std::vector<std::string> monitors_of(const std::vector<Answer>& answers);

/// A value of a case without quotes, with numbers rounded to six digits and speeds in mm/min.
std::string shown_value(const std::string& value);

/// The curl of one monitor in all answers.
Chart comparison_chart(const std::vector<Answer>& answers, const std::string& monitor);

/// Whether any line of a chart leaves zero.
bool has_curl(const Chart& chart);

/// A chart as a separate SVG file that includes the colours of the page.
std::string svg_file(const Chart& chart);

}  // namespace dccast::client::render
