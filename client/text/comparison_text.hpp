#pragma once

#include <string>
#include <vector>

#include "client/html/svg_chart.hpp"
#include "client/model/comparison.hpp"
#include "client/model/json.hpp"
#include "client/text/terminal.hpp"

namespace dccast::client::render {

/// The differing keys of the cases, the curls in one chart, and the significance of their
/// differences.
std::string comparison_text(const std::vector<Answer>& answers, const Terminal& terminal);

Json comparison_json(const std::vector<Answer>& answers);

/// The same as a self-contained HTML page.
std::string comparison_page(const std::vector<Answer>& answers);

/// Names of all monitors, in order of first appearance.
std::vector<std::string> monitors_of(const std::vector<Answer>& answers);

/// A value of a case without quotes, with numbers rounded to six digits and speeds in mm/min.
std::string shown_value(const std::string& value);

/// The curl of one monitor in all answers.
Chart comparison_chart(const std::vector<Answer>& answers, const std::string& monitor);

/// A chart as a separate SVG file that includes the colours of the page.
std::string svg_file(const Chart& chart);

}  // namespace dccast::client::render
