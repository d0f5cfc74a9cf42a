// Requests, without a server: the first byte chooses the call. Texts of any request are made
// printable, pages and labels are checked, plans of studies are laid out, cases are read.
#include <google/protobuf/descriptor.h>

#include <memory>

#include "dccast/v1/service.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/plant_words.hpp"
#include "server/intake/case_intake.hpp"
#include "server/service/refusals.hpp"
#include "server/studies/study_plan.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

using google::protobuf::Message;

std::unique_ptr<Message> request_of(unsigned choice) {
  static const auto* calls = v1::SubmitJobRequest::descriptor()->file()->service(0);
  const auto* type = calls->method(static_cast<int>(choice % calls->method_count()))->input_type();
  return std::unique_ptr<Message>(
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(type)->New());
}

void read_case(const v1::ReadCaseRequest& request) {
  v1::Case read;
  const bool is_written = request.has_case_() && case_file::check_ranges(request.case_()).empty();
  auto outcome = case_file::read_elsewhere(
      is_written ? case_file::to_toml(request.case_()) : request.text(), "case", read);
  case_file::apply_changes_elsewhere(read, {request.changes().begin(), request.changes().end()},
                                     outcome);
  if (!outcome.ok()) return;
  case_file::apply_defaults(read);
  case_file::planned_charts(read);
}

/// The runs that CreateStudy checks, from the first to the last.
void plan(const v1::CreateStudyRequest& request) {
  service::check_labels(request.labels());
  service::check_changes(request.changes());
  if (!studies::plan_faults(request).empty()) return;
  const auto plan = studies::study_plan(request);
  v1::StudyRun described;
  for (const int number : {0, plan->runs() / 2, plan->runs() - 1}) {
    if (number < 0 || number >= plan->runs()) continue;
    fuzz::require(!plan->run(number).key.empty(), "a run has a key");
    plan->describe(number, described);
  }
}

void list(const v1::ListJobsRequest& request) {
  const auto page = service::read_page("the list", request.page_token(), request.page_size());
  fuzz::require(page.size > 0 && page.size <= 1000, "a page has its limit");
  service::check_labels(request.labels());
  service::check_text("title", request.title());
  service::check_study_of_job(request.study());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  const auto request = request_of(fuzz::take_choice(text));
  if (!request->ParseFromArray(text.data(), static_cast<int>(text.size()))) return 0;
  if (const auto* of = dynamic_cast<const v1::ReadCaseRequest*>(request.get())) read_case(*of);
  try {
    if (const auto* of = dynamic_cast<const v1::CreateStudyRequest*>(request.get())) plan(*of);
    if (const auto* of = dynamic_cast<const v1::ListJobsRequest*>(request.get())) list(*of);
  } catch (const service::Refusal&) {
  }
  intake::make_printable(*request);
  return 0;
}
