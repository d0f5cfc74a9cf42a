#pragma once

#include <string>

#include "tests/verification/program/paper_tables.hpp"

namespace dccast::verification {

/// Every table and figure of the paper: where this page has it, how it differs and why, or why it
/// is not here. HTML.
std::string contents_section();
/// Where the paper and the product differ, a sentence each. HTML.
std::string differences_section();
/// The paper's figure 13. HTML.
std::string deformed_square_section();

/// The paper's figures 6 and 16 to 21 and its check after Saint-Venant, of castings. HTML.
/// @throws std::logic_error without castings
std::string casting_figures(const TableOptions& options);

}  // namespace dccast::verification
