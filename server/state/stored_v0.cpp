#include "server/state/stored_v0.hpp"

#include <fcntl.h>
#include <fmt/core.h>

#include <exception>
#include <optional>
#include <string>
#include <string_view>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "proto/case_file/quality.hpp"
#include "server/jobs/folder/job_description.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "server/state/stored_v0.pb.h"
#include "server/studies/study_file.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// What old steps do not say themselves: it follows from the case.
struct CaseFacts {
  v1::SectionFigures::Extent extent = v1::SectionFigures::METRE_OF_FACE;
  std::optional<v1::RelativeError> mesh_error;
};

CaseFacts read_case_facts(const fs::path& job_folder) {
  CaseFacts facts;
  v1::Case complete;
  if (!jobs::read_complete_case(job_folder, complete)) return facts;

  if (complete.section().kind() == v1::Section::QUARTER_SLAB)
    facts.extent = v1::SectionFigures::WHOLE_QUARTER;
  facts.mesh_error = case_file::relative_discretisation_error(complete);
  return facts;
}

v1::Finding::Kind to_kind(int number) {
  return v1::Finding::Kind_IsValid(number) ? static_cast<v1::Finding::Kind>(number)
                                           : v1::Finding::KIND_UNSPECIFIED;
}

/// A cause that followed: "STORAGE: the disk is full", or a message without a kind.
v1::Finding to_further(const std::string& text) {
  v1::Finding further;
  const auto colon = text.find(": ");
  v1::Finding::Kind kind = v1::Finding::KIND_UNSPECIFIED;
  const bool has_kind =
      colon != std::string::npos && v1::Finding::Kind_Parse(text.substr(0, colon), &kind);
  further.set_kind(kind);
  further.set_message(has_kind ? text.substr(colon + 2) : text);
  return further;
}

v1::Finding to_finding(const stored_v0::Failure& old) {
  v1::Finding failure;
  failure.set_code(old.finding());
  failure.set_kind(to_kind(old.kind()));
  failure.set_message(old.message());
  failure.set_time_s(old.time_s());
  failure.set_time_step_s(old.time_step_s());
  *failure.mutable_residual_history() = old.residual_history();
  *failure.mutable_place_m() = old.place_m();
  for (const std::string& text : old.further_causes()) *failure.add_further() = to_further(text);
  return failure;
}

v1::Finding to_finding(const stored_v0::ValidityLoss& old) {
  v1::Finding loss;
  loss.set_kind(to_kind(old.kind()));
  loss.set_message(old.message());
  loss.set_time_s(old.time_s());
  *loss.mutable_place_m() = old.place_m();
  loss.set_value(old.value());
  loss.set_limit(old.limit());
  loss.set_unit(old.unit());
  return loss;
}

v1::SectionFigures to_section(const stored_v0::StepReport& old, const CaseFacts& facts) {
  v1::SectionFigures section;
  section.set_extent(facts.extent);
  section.set_wall_heat_flux(old.wall_heat_flux_w_per_m() + old.wall_heat_flux_w());
  section.set_side_heat(old.side_heat_w_per_m() + old.side_heat_w());
  section.set_narrow_heat(old.narrow_heat_w_per_m() + old.narrow_heat_w());
  section.set_bottom_heat(old.bottom_heat_w_per_m() + old.bottom_heat_w());
  section.set_metal_heat(old.metal_heat_w_per_m() + old.metal_heat_w());
  section.set_level_heat(old.level_heat_w_per_m() + old.level_heat_w());
  section.set_stored_heat(old.stored_heat_w_per_m() + old.stored_heat_w());
  section.set_bottom_reaction(old.bottom_reaction_n_per_m() + old.bottom_reaction_n());
  section.set_weight(old.weight_n_per_m() + old.weight_n());
  section.set_pore_volume(old.pore_volume_m3_per_m() + old.pore_volume_m3());
  return section;
}

/// Sets the fields of this version. @param event  as read, with the old fields among the unknown
void convert(const CaseFacts& facts, v1::JobEvent& event) {
  stored_v0::JobEvent old;
  old.ParseFromString(event.SerializeAsString());
  event.DiscardUnknownFields();

  if (event.has_step() && !event.step().has_section()) {
    *event.mutable_step()->mutable_section() = to_section(old.step(), facts);
    for (v1::MonitorValue& monitor : *event.mutable_step()->mutable_monitors())
      case_file::add_curl(facts.mesh_error, monitor);
  }
  if (old.has_validity_lost()) *event.mutable_validity_lost() = to_finding(old.validity_lost());
  if (old.state_change().has_failure())
    *event.mutable_state_change()->mutable_failure() = to_finding(old.state_change().failure());
  if (old.run_ended().has_failure())
    *event.mutable_run_ended()->mutable_failure() = to_finding(old.run_ended().failure());
}

bool begins_with(const fs::path& path, std::string_view header) {
  if (storage::kind_of_entry(path) != storage::regular_file) return false;
  const storage::File file(path, O_RDONLY);
  std::string begin(header.size(), '\0');
  return file.read_at(0, begin) == begin.size() && begin == header;
}

/// A log with nothing but its header, or with records.
std::string converted_log(const fs::path& path, const CaseFacts& facts) {
  std::string bytes = jobs::event_log_header();
  if (fs::file_size(path) == bytes.size()) return bytes;

  const jobs::EventLog log(path);
  jobs::EventLog::Cursor cursor;
  while (auto event = log.read(cursor)) {
    convert(facts, *event);
    bytes += storage::short_records.framed(event->SerializeAsString());
  }
  return bytes;
}

}  // namespace

void convert_job_v0(const fs::path& job_folder) {
  const fs::path path = job_folder / "events.log";
  if (!begins_with(path, jobs::former_event_log_header())) return;

  storage::replace_file(path, converted_log(path, read_case_facts(job_folder)));
}

void convert_stored_v0(const StateFolder& folder) {
  int converted = 0;
  const auto attempt = [&](const std::string& subject, const auto& convert_one) {
    try {
      converted += convert_one() ? 1 : 0;
    } catch (const std::system_error&) {
      throw;
    } catch (const std::exception& error) {
      log::error("{} is of an earlier version and cannot be converted: {}", subject, error.what());
    }
  };

  for (const std::string& id : jobs::folder_ids(folder.jobs()))
    attempt("job " + id, [&] {
      const fs::path job_folder = folder.jobs() / id;
      if (!begins_with(job_folder / "events.log", jobs::former_event_log_header())) return false;
      convert_job_v0(job_folder);
      return true;
    });

  for (const std::string& id : studies::ids_of_study_files(folder.studies()))
    attempt("study " + id, [&] {
      return studies::convert_former_study_file(folder.studies(), id, [](const std::string& bytes) {
        stored_v0::Failure old;
        if (!old.ParseFromString(bytes)) return std::string();
        return bytes.empty() ? bytes : to_finding(old).SerializeAsString();
      });
    });

  if (converted > 0)
    log::info("{} jobs and studies of an earlier version of dccastd were converted", converted);
}

}  // namespace dccast::state
