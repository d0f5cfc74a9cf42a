#pragma once

#include <string>
#include <vector>

#include "client/comparison.hpp"
#include "client/message_json.hpp"
#include "client/render/svg_chart.hpp"
#include "client/render/terminal.hpp"

namespace dccast::client::render {

/// What differs in the cases, the curls over each other, and what the differences weigh.
std::string comparison_text(const std::vector<Answer>& answers, const Terminal& terminal);

Json comparison_json(const std::vector<Answer>& answers);

/// The same as a page that stands for itself.
std::string comparison_page(const std::vector<Answer>& answers);

/// Names of all monitors, in the order in which they come first.
std::vector<std::string> monitors_of(const std::vector<Answer>& answers);

/// A value of a case with its numbers rounded to six digits, speeds in mm/min, without quotes.
std::string shown_value(const std::string& value);

/// The curl of one monitor in all answers.
Chart comparison_chart(const std::vector<Answer>& answers, const std::string& monitor);

/// A chart as a file of its own: with the colours of the page in it.
std::string svg_file(const Chart& chart);

}  // namespace dccast::client::render
