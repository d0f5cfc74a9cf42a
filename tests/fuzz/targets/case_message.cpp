// A case as it comes over the wire: completed and checked as the daemon does, then translated and
// checked as a worker does.
#include "core/casting/case/case_check.hpp"
#include "core/casting/findings/judge.hpp"
#include "dccast/v1/service.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "server/intake/case_intake.hpp"
#include "server/translate/translate.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

const v1::Alloy& shipped_card() {
  static const v1::Alloy card = case_file::alloy_card(case_file::alloy_names().front()).alloy;
  return card;
}

/// Small enough that a check takes no more than some milliseconds.
void limit(casting::Case& c) {
  c.limits.maximum_nodes = std::min<std::int64_t>(c.limits.maximum_nodes, 2000);
  c.limits.maximum_steps = std::min<std::int64_t>(c.limits.maximum_steps, 2000);
}

v1::ValidateCaseResponse verdict_of_worker(const v1::Case& complete,
                                           const std::vector<std::string>& faulty_keys) {
  casting::Case c = translate::to_core(complete, "/nonexistent");
  limit(c);
  auto verdict = translate::to_proto(casting::check(c, faulty_keys));
  if (verdict.faults_size() > 0 || !faulty_keys.empty()) return verdict;
  for (const results::Finding& finding : casting::findings_of_case(c))
    *verdict.add_findings() = translate::to_proto(finding);
  return verdict;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  v1::SubmitJobRequest request;
  if (!request.ParseFromArray(bytes, static_cast<int>(size))) return 0;
  v1::Case& complete = *request.mutable_case_();
  v1::ValidateCaseResponse verdict;
  jobs::Attachments attachments;
  for (const v1::Attachment& named : request.attachments())
    attachments.push_back({.name = named.name(), .sha256 = named.sha256()});
  intake::check_attachment_names(complete, attachments, verdict);
  case_file::quality_matters(complete);
  case_file::apply_defaults(complete);
  case_file::complete_alloy(shipped_card(), *complete.mutable_alloy());
  for (v1::Fault& fault : case_file::check_ranges(complete)) *verdict.add_faults() = fault;
  if (verdict.faults_size() == 0)
    for (v1::Fault& fault : case_file::uncertainty_faults(complete)) *verdict.add_faults() = fault;
  std::vector<std::string> faulty_keys;
  for (const v1::Fault& fault : verdict.faults()) faulty_keys.push_back(fault.field());
  try {
    verdict.MergeFrom(verdict_of_worker(complete, faulty_keys));
  } catch (const std::exception&) {  // the intake answers with the faults that it has
    fuzz::require(verdict.faults_size() > 0, "a case without a fault is translated");
  }
  intake::make_printable(verdict);
  fuzz::require(!intake::fingerprint(complete, case_file::Same::answer, attachments).empty(),
                "a case has a key");
  return 0;
}
