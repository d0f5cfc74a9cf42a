#pragma once

#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// The answer of a recipe study, in at most 120 columns.
std::string recipe_text(const v1::StudyResult& result);

/// Headings and rows of its front, a row each, then that of the case itself; for screen and page.
std::vector<std::string> recipe_headings(const v1::RecipePlan& plan);
std::vector<std::vector<std::string>> recipe_rows(const v1::StudyResult& result);

/// What came out: the recipe of the case, the one that is chosen and how sure that is, what the
/// figures rest on.
std::vector<std::string> recipe_sentences(const v1::StudyResult& result);

}  // namespace dccast::client::render
