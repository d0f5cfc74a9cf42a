#include "server/intake/case_intake.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "dccast/v1/options.pb.h"
#include "dccast/v1/worker.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "proto/values/printable.hpp"

namespace dccast::intake {

namespace {

/// Field of faults that concern the attachments themselves.
constexpr const char* attachments_field = "attachments";

/// Notes that the core will check the case only once the first fault is fixed.
void note_that_checks_wait(v1::ValidateCaseResponse& verdict) {
  *verdict.add_warnings() =
      fault_of(verdict.faults(0).field(), "", "further checks wait until this is fixed");
}

/// Adds the core's faults, except for keys that already have one.
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

std::string gigabytes(double bytes) {
  return fmt::format("{:.3g} GB", bytes * 1e-9);
}

void add_fault(v1::ValidateCaseResponse& verdict, const char* field, const std::string& value,
               const std::string& most, const std::string& setting, const std::string& remedy) {
  *verdict.add_faults() =
      fault_of(field, value, fmt::format("the case has {}, more than this dccastd takes", value),
               fmt::format("at most {}", most),
               fmt::format("{}, or have {} raised in the settings of dccastd", remedy, setting));
}

/// Adds a fault for each ceiling that the estimate exceeds, and then removes the estimate.
void hold_against(const Ceilings& ceilings, v1::ValidateCaseResponse& verdict) {
  if (!verdict.has_estimate()) return;
  const auto& estimate = verdict.estimate();

  const char* coarser = "make the mesh coarser";
  if (estimate.nodes() > ceilings.nodes)
    add_fault(verdict, "mesh", fmt::format("{} nodes at its end", estimate.nodes()),
              fmt::to_string(ceilings.nodes), "per_case.maximum_nodes", coarser);
  if (estimate.steps() > ceilings.steps)
    add_fault(verdict, "time", fmt::format("{} steps", estimate.steps()),
              fmt::to_string(ceilings.steps), "per_case.maximum_steps", "take longer steps");
  if (estimate.memory_bytes() > ceilings.memory_bytes)
    add_fault(verdict, "mesh",
              fmt::format("{} of estimated memory", gigabytes(estimate.memory_bytes())),
              gigabytes(ceilings.memory_bytes), "per_case.maximum_memory", coarser);

  if (verdict.faults_size() > 0) verdict.clear_estimate();
}

/// Checks that each attachment has a plain, printable name of its own.
/// @param names  receives the sound names
void check_names(const jobs::Attachments& attachments, std::set<std::string>& names,
                 v1::ValidateCaseResponse& verdict) {
  for (const jobs::AttachedFile& attachment : attachments) {
    const std::string& name = attachment.name;

    if (!jobs::is_plain_file_name(name))
      *verdict.add_faults() = fault_of(
          attachments_field, values::escaped(name), "is not the plain name of a file",
          "1 to 255 bytes without a slash, not \".\" or \"..\"", "attach it under its last name");
    // The name becomes that of a file in the job folder.
    else if (const auto character = values::unprintable(name))
      *verdict.add_faults() =
          fault_of(attachments_field, values::escaped(name), "contains " + *character,
                   "characters that can be shown", "rename the file");
    else if (!names.insert(name).second)
      *verdict.add_faults() = fault_of(attachments_field, name, "is attached twice",
                                       "one file of a name", "rename one of them");
  }
}

/// Checks that every file named in a message is attached. The recursion follows nested tables.
/// @param path  of the message in the case; empty: the case itself
/// @param used  receives the names of the files
void check_references(const google::protobuf::Message& message, const std::string& path,
                      const std::set<std::string>& attached, std::set<std::string>& used,
                      v1::ValidateCaseResponse& verdict) {
  const auto* reflection = message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);

  for (const auto* field : fields) {
    const std::string name = path.empty() ? field->name() : path + "." + field->name();
    if (field->message_type() != nullptr && !field->is_repeated()) {
      check_references(reflection->GetMessage(message, field), name, attached, used, verdict);
    } else if (field->options().GetExtension(v1::key).attachment()) {
      const std::string file = reflection->GetString(message, field);
      if (!case_file::names_file(*field, file)) continue;
      used.insert(file);
      if (!attached.contains(file))
        *verdict.add_faults() =
            fault_of(name, file, "is not among the attachments",
                     "the name of a file sent with the case", "send it with the case");
    }
  }
}

std::string printable(const std::string& text) {
  return values::escaped(text, values::Lines::several);
}

/// A value as written in a case file.
const char* name_of_quality(v1::Quality quality) {
  switch (quality) {
    case v1::DRAFT:
      return "draft";
    case v1::ENGINEERING:
      return "engineering";
    case v1::FINE:
      return "fine";
    default:
      return "";
  }
}

}  // namespace

void check_attachment_names(const v1::Case& submitted, const jobs::Attachments& attachments,
                            v1::ValidateCaseResponse& verdict) {
  std::set<std::string> names, used;
  check_names(attachments, names, verdict);
  check_references(submitted, "", names, used, verdict);
  for (const std::string& name : names)
    if (!used.contains(name))
      *verdict.add_warnings() = fault_of(attachments_field, name, "is not named in the case", "",
                                         "name it there, or leave it out");
}

v1::Fault fault_of(const std::string& field, const std::string& value, const std::string& message,
                   const std::string& permitted, const std::string& remedy) {
  v1::Fault fault;
  fault.set_field(field);
  fault.set_value(value);
  fault.set_message(message);
  fault.set_permitted(permitted);
  fault.set_remedy(remedy);
  return fault;
}

double memory_per_worker(int workers) {
  double memory =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  std::ifstream group("/sys/fs/cgroup/memory.max");
  if (double permitted = 0.0; group >> permitted) memory = std::min(memory, permitted);
  return 0.9 * memory / std::max(workers, 1);
}

CaseIntake::CaseIntake(jobs::WarmWorkers& workers, std::filesystem::path alloy_directory,
                       std::filesystem::path check_directory, const Ceilings& ceilings)
    : workers_(workers),
      alloy_directory_(std::move(alloy_directory)),
      check_directory_(std::move(check_directory)),
      ceilings_(ceilings) {
  // A faulty card stops the daemon at its start, not the first case that names it.
  for (const std::string& name : case_file::alloy_names(alloy_directory_)) {
    const auto card = case_file::alloy_card(name, alloy_directory_);
    if (!card.ok())
      throw std::runtime_error(fmt::format("alloy card {}: {}: {}", name,
                                           card.faults.front().field(),
                                           card.faults.front().message()));
    alloys_.push_back(card.alloy);
  }
}

ExaminedCase CaseIntake::examine(const v1::Case& submitted, const jobs::Attachments& attachments,
                                 std::vector<std::string> faulty_keys,
                                 const jobs::CallLimits& waiting, bool findings) const {
  const bool stays_sound = faulty_keys.empty() && has_fixed_card(submitted, attachments);
  // As submitted: warnings are about what was given, and a title is checked too.
  const std::string key =
      stays_sound ? fingerprint(submitted, case_file::Same::input, attachments) + submitted.title()
                  : "";
  if (const auto known = stays_sound ? known_->find(key) : nullptr)
    if (known->has_findings || !findings) return known->examined;

  ExaminedCase examined = judged(submitted, attachments, std::move(faulty_keys), waiting, findings);
  make_printable(examined.verdict);  // a fault repeats the value that was refused

  if (stays_sound && examined.verdict.faults_size() == 0) {
    known_->forget(key);  // the one that is kept has no findings
    known_->keep(key, std::make_shared<KnownCase>(KnownCase{examined, findings}),
                 examined.complete.SpaceUsedLong() + examined.verdict.SpaceUsedLong());
  }
  return examined;
}

bool CaseIntake::has_fixed_card(const v1::Case& submitted,
                                const jobs::Attachments& attachments) const {
  const std::string& name = submitted.alloy().card();
  const auto is_named = [&](const auto& each, const auto& its_name) {
    return std::ranges::find(each, name, its_name) != each.end();
  };
  // Without a name it is the default card, which is built in.
  return name.empty() || is_named(attachments, &jobs::AttachedFile::name) ||
         is_named(alloys_, [](const v1::Alloy& alloy) { return alloy.card(); });
}

ExaminedCase CaseIntake::complete_case(const v1::Case& submitted,
                                       const jobs::Attachments& attachments) const {
  ExaminedCase examined{submitted, {}};
  check_attachment_names(submitted, attachments, examined.verdict);
  for (v1::Fault& fault : complete(examined.complete, attachments))
    *examined.verdict.add_faults() = std::move(fault);
  return examined;
}

ExaminedCase CaseIntake::judged(const v1::Case& submitted, const jobs::Attachments& attachments,
                                std::vector<std::string> faulty_keys,
                                const jobs::CallLimits& waiting, bool findings) const {
  ExaminedCase examined = complete_case(submitted, attachments);
  v1::ValidateCaseResponse& verdict = examined.verdict;
  const bool can_be_stored = std::ranges::none_of(
      verdict.faults(), [](const v1::Fault& fault) { return fault.field() == attachments_field; });

  for (const v1::Fault& fault : verdict.faults()) faulty_keys.push_back(fault.field());
  if (!can_be_stored) {
    note_that_checks_wait(verdict);
    return examined;
  }

  try {
    v1::CheckCase check;
    *check.mutable_case_() = examined.complete;
    *check.mutable_faulty_keys() = {faulty_keys.begin(), faulty_keys.end()};
    check.set_findings(findings);
    merge(ask_core(std::move(check), attachments, waiting), verdict);
  } catch (const jobs::WorkerDidNotAnswer&) {
    // A faulty value may have brought the worker down: report that fault first.
    if (verdict.faults_size() == 0) throw;
    note_that_checks_wait(verdict);
  }

  hold_against(ceilings_, verdict);

  if (submitted.quality() != v1::QUALITY_UNSPECIFIED && !case_file::quality_matters(submitted))
    *verdict.add_warnings() =
        fault_of("quality", "", "changes nothing, as the case gives mesh and time steps itself", "",
                 "leave mesh.columns, mesh.rows, time.step and their like away");
  return examined;
}

std::vector<v1::Fault> CaseIntake::complete(v1::Case& submitted,
                                            const jobs::Attachments& attachments) const {
  case_file::apply_defaults(submitted);

  const auto card = this->card(submitted.alloy().card(), attachments);
  if (card.ok()) case_file::complete_alloy(card.alloy, *submitted.mutable_alloy());

  std::vector<v1::Fault> faults = card.faults;
  const auto ranges = case_file::check_ranges(submitted);
  faults.insert(faults.end(), ranges.begin(), ranges.end());
  if (!faults.empty()) return faults;
  return case_file::uncertainty_faults(submitted);
}

// Cards of the daemon are read once, at its start: reading one takes longer than a whole check.
case_file::AlloyCard CaseIntake::card(const std::string& name,
                                      const jobs::Attachments& attachments) const {
  const auto attached = std::ranges::find(attachments, name, &jobs::AttachedFile::name);
  if (attached != attachments.end()) {
    if (attached->bytes > static_cast<std::int64_t>(case_file::maximum_file_bytes))
      return {{}, {fault_of("alloy.card", name, "is too large for a card", "at most 4 MiB", "")}};
    return case_file::own_card(name, storage::read_file(attached->path));
  }

  const auto found =
      std::ranges::find(alloys_, name, [](const v1::Alloy& alloy) { return alloy.card(); });
  if (found != alloys_.end()) return {*found, {}};
  return case_file::alloy_card(name, alloy_directory_);
}

v1::ValidateCaseResponse CaseIntake::ask_core(v1::CheckCase check,
                                              const jobs::Attachments& attachments,
                                              const jobs::CallLimits& waiting) const {
  std::optional<jobs::CheckFolder> folder;
  if (!attachments.empty()) folder.emplace(check_directory_, attachments);
  if (folder) check.set_directory(folder->path());
  v1::WorkerRequest request;
  *request.mutable_check() = std::move(check);
  return std::move(*workers_.ask(request, waiting).mutable_verdict());
}

v1::QueryResultResponse CaseIntake::stored_frame(const std::filesystem::path& job_folder,
                                                 const v1::Artifact& results,
                                                 const FrameChoice& choice,
                                                 const jobs::CallLimits& waiting) const {
  digests_->require_sound(job_folder, results);
  return read_frame(job_folder, choice, false, waiting);
}

v1::QueryResultResponse CaseIntake::frame_so_far(const std::filesystem::path& job_folder,
                                                 const FrameChoice& choice,
                                                 const jobs::CallLimits& waiting) const {
  return read_frame(job_folder, choice, true, waiting);
}

v1::QueryResultResponse CaseIntake::read_frame(const std::filesystem::path& job_folder,
                                               const FrameChoice& choice, bool running,
                                               const jobs::CallLimits& waiting) const {
  v1::WorkerRequest request;
  v1::ReadFrame& asked = *request.mutable_read_frame();
  asked.set_directory(job_folder);
  asked.set_number(choice.number);
  asked.set_field(choice.field);
  asked.set_running(running);
  asked.set_drawing(choice.drawing);
  return std::move(*workers_.ask(request, waiting).mutable_stored());
}

v1::ProbeResultResponse CaseIntake::probe(const std::filesystem::path& job_folder,
                                          const v1::Artifact* results,
                                          const v1::ProbeResultRequest& request,
                                          const jobs::CallLimits& waiting) const {
  if (results) digests_->require_sound(job_folder, *results);

  v1::WorkerRequest order;
  v1::ProbeFrames& asked = *order.mutable_probe_frames();
  asked.set_directory(job_folder);
  asked.set_running(results == nullptr);
  *asked.mutable_request() = request;
  return std::move(*workers_.ask(order, waiting).mutable_probed());
}

std::string fingerprint(const v1::Case& complete, case_file::Same same,
                        const jobs::Attachments& attachments) {
  std::map<std::string, std::string> files;
  for (const jobs::AttachedFile& file : attachments) files[file.name] = file.sha256;
  return case_file::fingerprint(complete, same, files);
}

jobs::NewJob new_job(const v1::Case& submitted, const jobs::Attachments& attachments,
                     const ExaminedCase& examined) {
  jobs::NewJob made;
  made.description.submitted_case = submitted.SerializeAsString();
  made.description.complete_case = examined.complete.SerializeAsString();
  made.description.answer_key =
      fingerprint(examined.complete, case_file::Same::answer, attachments);

  v1::Job& job = made.description.job;
  job.set_title(submitted.title());
  job.set_case_sha256(fingerprint(examined.complete, case_file::Same::input, attachments));
  if (case_file::quality_matters(submitted))
    job.set_quality(name_of_quality(examined.complete.quality()));
  job.set_estimated_s(examined.verdict.estimate().solver_s());
  return made;
}

void make_printable(google::protobuf::Message& message) {
  using google::protobuf::FieldDescriptor;

  const auto* reflection = message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);

  for (const FieldDescriptor* field : fields) {
    // Text fields are rewritten in place, messages recursively; other fields hold no text.
    const bool text = field->type() == FieldDescriptor::TYPE_STRING;
    const int count = field->is_repeated() ? reflection->FieldSize(message, field) : 1;
    for (int i = 0; i < count && (text || field->message_type() != nullptr); ++i) {
      if (text && field->is_repeated())
        reflection->SetRepeatedString(&message, field, i,
                                      printable(reflection->GetRepeatedString(message, field, i)));
      else if (text)
        reflection->SetString(&message, field, printable(reflection->GetString(message, field)));
      else
        make_printable(field->is_repeated()
                           ? *reflection->MutableRepeatedMessage(&message, field, i)
                           : *reflection->MutableMessage(&message, field));
    }
  }
}

}  // namespace dccast::intake
