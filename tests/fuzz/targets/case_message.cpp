// A case as it comes over the wire: completed and checked as the daemon does, then translated and
// checked as a worker does.
#include "server/intake/case_intake.hpp"
#include "tests/fuzz/whole_check.hpp"

using namespace dccast;

namespace {

const v1::Alloy& shipped_card() {
  static const v1::Alloy card = case_file::alloy_card(case_file::alloy_names().front()).alloy;
  return card;
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

  fuzz::check_whole(shipped_card(), "/nonexistent", complete, verdict);
  intake::make_printable(verdict);
  fuzz::require(!intake::fingerprint(complete, case_file::Same::answer, attachments).empty(),
                "a case has a key");
  return 0;
}
