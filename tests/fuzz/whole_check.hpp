#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "core/casting/case/case_check.hpp"
#include "core/casting/findings/judge.hpp"
#include "dccast/v1/service.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "server/translate/translate.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace dccast::fuzz {

/// Small enough that a check takes no more than some milliseconds.
inline void limit(casting::Case& c) {
  c.limits.maximum_nodes = std::min<std::int64_t>(c.limits.maximum_nodes, 2000);
  c.limits.maximum_steps = std::min<std::int64_t>(c.limits.maximum_steps, 2000);
}

inline v1::ValidateCaseResponse verdict_of_worker(const v1::Case& complete,
                                                  const std::vector<std::string>& faulty_keys,
                                                  const std::filesystem::path& attachments) {
  casting::Case c = translate::to_core(complete, attachments);
  limit(c);
  auto verdict = translate::to_proto(casting::check(c, faulty_keys));
  if (verdict.faults_size() > 0 || !faulty_keys.empty()) return verdict;
  for (const results::Finding& finding : casting::findings_of_case(c))
    *verdict.add_findings() = translate::to_proto(finding);
  return verdict;
}

/// Completes a case as the daemon does, and checks it as daemon and worker do.
/// @param card     of the alloy  @param attachments  folder of the files that the case names
/// @param verdict  with the faults so far
inline void check_whole(const v1::Alloy& card, const std::filesystem::path& attachments,
                        v1::Case& complete, v1::ValidateCaseResponse& verdict) {
  case_file::quality_matters(complete);
  case_file::apply_defaults(complete);
  case_file::complete_alloy(card, *complete.mutable_alloy());
  for (v1::Fault& fault : case_file::check_ranges(complete)) *verdict.add_faults() = fault;
  if (verdict.faults_size() == 0)
    for (v1::Fault& fault : case_file::uncertainty_faults(complete)) *verdict.add_faults() = fault;

  std::vector<std::string> faulty_keys;
  for (const v1::Fault& fault : verdict.faults()) faulty_keys.push_back(fault.field());
  try {
    verdict.MergeFrom(verdict_of_worker(complete, faulty_keys, attachments));
  } catch (const std::exception&) {  // the intake answers with the faults that it has
    require(verdict.faults_size() > 0, "a case without a fault is translated");
  }
}

}  // namespace dccast::fuzz
