#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/study.pb.h"

/// What a plant changes against a finding: the levers, their direction and the steps that are
/// tried. docs/findings.md explains how `dccast remedy` uses them.
namespace dccast::case_file {

/// Which way a lever is moved.
enum class Direction { less, more };

/// A lever of a plant with its words: "hold", "longer".
struct PlantLever {
  const char* key;   ///< as in levers() of study_keys.hpp
  const char* verb;  ///< "hold"
  const char* less;  ///< "shorter"
  const char* more;  ///< "longer"
  double step;       ///< of the key's number in SI; of a factor its distance from 1
};

/// A lever that influences a finding.
struct Advice {
  const PlantLever* lever;
  Direction direction;  ///< that acts against the finding
};

/// The levers that influence a finding, the most effective first. Empty: no lever of a plant does.
std::vector<Advice> advice_against(const v1::Finding& finding);

/// Whether the table of levers has this code of a finding, with levers or without.
bool has_advice_row(std::string_view code);

/// What is sure to help against a finding, "Pour hotter."; empty where it has to be computed.
std::string remedy_text(const v1::Finding& finding);

/// The levers that influence some findings, each once; the direction is that of the first finding.
std::vector<Advice> advice_against(const google::protobuf::RepeatedPtrField<v1::Finding>& findings);

/// A case with one lever moved.
struct LeverDraft {
  v1::LeverStep step;
  std::vector<v1::CaseChange> changes;  ///< the lever, and time.end where the length needs it
};

/// Three drafts for a lever around a case: a step and two steps in its direction, a step against
/// it. All cast the length that the case casts. Those that the case cannot have are left out.
/// @param description  case as submitted
std::vector<LeverDraft> lever_drafts(const Advice& advice, const v1::Case& description);

}  // namespace dccast::case_file
