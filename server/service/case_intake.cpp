#include "server/service/case_intake.hpp"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "dccast/v1/worker.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/values/digests.hpp"
#include "server/service/attachment_names.hpp"
#include "server/service/message_size.hpp"

namespace dccast::service {

namespace {

/// Parses what the worker program answered. @throws jobs::WorkerDidNotAnswer
template <class Message>
Message parsed(const std::string& bytes) {
  Message message;
  if (!message.ParseFromString(bytes))
    throw jobs::WorkerDidNotAnswer(jobs::WorkerDidNotAnswer::Why::refused,
                                   "the checker's answer cannot be read");
  return message;
}

/// What the core would find is not known until the first fault is fixed.
void note_that_checks_wait(v1::ValidateCaseResponse& verdict) {
  v1::Fault& waiting = *verdict.add_warnings();
  waiting.set_field(verdict.faults(0).field());
  waiting.set_message("further checks wait until this is fixed");
}

/// Adds the core's faults, save those of keys that have one already.
void merge(v1::ValidateCaseResponse from_core, v1::ValidateCaseResponse& verdict) {
  std::set<std::string> faulty;
  for (const v1::Fault& fault : verdict.faults()) faulty.insert(fault.field());
  for (v1::Fault& fault : *from_core.mutable_faults())
    if (!faulty.contains(fault.field())) *verdict.add_faults() = std::move(fault);
  verdict.mutable_warnings()->MergeFrom(from_core.warnings());
  if (verdict.faults_size() == 0 && from_core.has_estimate())
    *verdict.mutable_estimate() = from_core.estimate();
  *verdict.mutable_findings() = std::move(*from_core.mutable_findings());
}

}  // namespace

CaseIntake::CaseIntake(jobs::CheckerPool& checkers, std::filesystem::path alloy_directory,
                       std::filesystem::path check_directory, const Ceilings& ceilings)
    : checkers_(checkers),
      alloy_directory_(std::move(alloy_directory)),
      check_directory_(std::move(check_directory)),
      ceilings_(ceilings) {
  for (const std::string& name : case_file::alloy_names(alloy_directory_)) {
    const auto card = case_file::alloy_card(name, alloy_directory_);
    if (!card.ok())
      throw std::runtime_error("alloy card " + name + ": " + card.faults.front().field() + ": " +
                               card.faults.front().message());
    alloys_.push_back(card.alloy);
  }
}

ExaminedCase CaseIntake::examine(const v1::Case& submitted, const jobs::Attachments& attachments,
                                 std::vector<std::string> faulty_keys,
                                 const jobs::Patience& patience, jobs::Question question) const {
  ExaminedCase examined = judged(submitted, attachments, std::move(faulty_keys), patience, question);
  make_printable(examined.verdict);  // it repeats values that are refused for what they hold
  return examined;
}

ExaminedCase CaseIntake::judged(const v1::Case& submitted, const jobs::Attachments& attachments,
                                std::vector<std::string> faulty_keys,
                                const jobs::Patience& patience, jobs::Question question) const {
  ExaminedCase examined{submitted, {}};
  v1::ValidateCaseResponse& verdict = examined.verdict;
  check_attachment_names(submitted, attachments, verdict);
  const bool can_be_stored = std::ranges::none_of(
      verdict.faults(), [](const v1::Fault& fault) { return fault.field() == attachments_field; });
  for (v1::Fault& fault : complete(examined.complete)) *verdict.add_faults() = std::move(fault);
  for (const v1::Fault& fault : verdict.faults()) faulty_keys.push_back(fault.field());
  if (!can_be_stored) {
    note_that_checks_wait(verdict);
    return examined;
  }
  try {
    merge(ask_core(question, examined.complete, attachments, faulty_keys, patience), verdict);
  } catch (const jobs::WorkerDidNotAnswer&) {
    if (verdict.faults_size() == 0) throw;  // else a value at fault may well have brought it down
    note_that_checks_wait(verdict);
  }
  hold_against(ceilings_, verdict);
  return examined;
}

std::vector<v1::Fault> CaseIntake::complete(v1::Case& submitted) const {
  case_file::apply_defaults(submitted);
  const auto card = this->card(submitted.alloy().card());
  if (card.ok()) case_file::complete_alloy(card.alloy, *submitted.mutable_alloy());
  std::vector<v1::Fault> faults = card.faults;
  const auto ranges = case_file::check_ranges(submitted);
  faults.insert(faults.end(), ranges.begin(), ranges.end());
  return faults;
}

// Those that are there were read at the start; reading one takes longer than a whole check.
case_file::AlloyCard CaseIntake::card(const std::string& name) const {
  const auto found =
      std::ranges::find(alloys_, name, [](const v1::Alloy& alloy) { return alloy.card(); });
  if (found != alloys_.end()) return {*found, {}};
  return case_file::alloy_card(name, alloy_directory_);
}

v1::ValidateCaseResponse CaseIntake::ask_core(jobs::Question asked, const v1::Case& complete,
                                              const jobs::Attachments& attachments,
                                              const std::vector<std::string>& faulty_keys,
                                              const jobs::Patience& patience) const {
  std::optional<jobs::CheckFolder> folder;
  if (!attachments.empty()) folder.emplace(check_directory_, attachments);
  v1::WorkerOrder question;
  *question.mutable_case_() = complete;
  question.set_directory(folder ? folder->path() : check_directory_);
  *question.mutable_faulty_keys() = {faulty_keys.begin(), faulty_keys.end()};
  return parsed<v1::ValidateCaseResponse>(
      checkers_.ask(asked, question.SerializeAsString(), patience));
}

v1::QueryResultResponse CaseIntake::stored_frame(const std::filesystem::path& job_folder,
                                                 int number, const jobs::Patience& patience) const {
  const std::string question = std::to_string(number) + " " + job_folder.string();
  return parsed<v1::QueryResultResponse>(checkers_.ask(jobs::Question::frame, question, patience));
}

std::string fingerprint(const v1::Case& submitted, const jobs::Attachments& attachments) {
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(submitted, &text);
  if (!status.ok()) throw std::runtime_error("the case cannot be written as JSON");
  std::set<std::string> files;  // in any order they are the same files
  for (const v1::Attachment& attachment : attachments)
    files.insert(attachment.name() + " " + values::sha256(attachment.content()));
  for (const std::string& file : files) text += "\n" + file;
  return values::sha256(text);
}

}  // namespace dccast::service
