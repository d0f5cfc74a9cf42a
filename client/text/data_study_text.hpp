#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/model/effects.hpp"
#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// What a study is and how its runs ended, in two lines.
std::string head_of(const v1::StudyResult& result);

/// Half the band of mesh and steps at the end of an uncertainty study [m].
/// @param mesh_error  the same relative to the curl; empty: not known
std::optional<double> mesh_error_at_end_m(const v1::Spread& spread,
                                          std::optional<double> mesh_error);

/// The answer of an uncertainty study, on one screen of 100 columns; `mesh_error` as above.
std::string uncertainty_text(const v1::StudyResult& result, std::optional<double> mesh_error);

/// The answer of a sensitivity study for one monitor, on one screen of 100 columns.
/// @param of_curl  as for effects_of()
std::string sensitivity_text(const v1::StudyResult& result, int monitor,
                             std::optional<double> of_curl);

/// The sentences of an uncertainty study, for screen and page: what the curl will be, how sure that
/// is, and what to measure first; `mesh_error` as above.
std::vector<std::string> uncertainty_sentences(const v1::StudyResult& result,
                                               std::optional<double> mesh_error);

/// A row of the table of shares, largest total first: datum, range, "42 ± 3 %" alone, in all.
std::vector<std::vector<std::string>> share_rows(const v1::StudyResult& result);

/// Effects as rows: key, range, low mm, high mm, bar; and the keys to which the curl does not
/// respond.
struct EffectRows {
  std::vector<std::vector<std::string>> levers, data;
  std::string rest;
};
EffectRows effect_rows(const v1::StudyResult& result, const Effects& effects);

}  // namespace dccast::client::render
