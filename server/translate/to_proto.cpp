#include "server/translate/translate.hpp"

#include <fmt/core.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/casting/findings/run_failure.hpp"
#include "core/results/step_report.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/remedies.hpp"
#include "proto/values/printable.hpp"
#include "server/translate/enumerations.hpp"

namespace dccast::translate {

namespace {

/// Escapes a text for a message, which holds UTF-8 only: a name from a mesh file may be any bytes.
std::string escaped(const std::string& text) {
  return values::escaped(text, values::Lines::several);
}

v1::Fault to_proto(const Fault& from) {
  v1::Fault to;
  to.set_field(escaped(from.field));
  to.set_value(escaped(from.value));
  to.set_message(escaped(from.message));
  to.set_permitted(escaped(from.permitted));
  to.set_remedy(escaped(from.remedy));
  return to;
}

using Field = google::protobuf::FieldDescriptor;

// Types of the members in results::HistoryField; the field of the message has the same type.
using Real = double results::StepReport::*;
using Int = int results::StepReport::*;
using Long = std::int64_t results::StepReport::*;
using Flag = bool results::StepReport::*;

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

/// Whether a figure is one of SectionFigures, whose unit depends on the section.
bool depends_on_section(const results::HistoryField& field) {
  return field.solid_unit != nullptr;
}

/// The name of a figure in SectionFigures, which has no unit: "side_heat" of "side_heat_w_per_m".
std::string section_name(const results::HistoryField& field) {
  std::string_view name = field.name;
  for (const std::string_view suffix : {"_w_per_m", "_n_per_m", "_m3_per_m"})
    if (name.ends_with(suffix)) name.remove_suffix(suffix.size());
  return std::string(name);
}

/// The fields of StepReport or its SectionFigures, in the order of history_fields(). They are
/// looked up only once: a query sends hundreds of steps a second.
/// @throws std::logic_error  the message lacks one
const std::vector<const Field*>& message_fields() {
  static const std::vector<const Field*> fields = [] {
    std::vector<const Field*> found;
    for (const results::HistoryField& field : results::history_fields()) {
      const bool in_section = depends_on_section(field);
      const auto& descriptor =
          in_section ? *v1::SectionFigures::descriptor() : *v1::StepReport::descriptor();
      const std::string name = in_section ? section_name(field) : field.name;
      found.push_back(descriptor.FindFieldByName(name));
      if (found.back() == nullptr)
        throw std::logic_error(fmt::format("{} of job.proto lacks {}", descriptor.name(), name));
    }
    return found;
  }();
  return fields;
}

void add_monitors(const results::StepReport& report, const std::vector<casting::Monitor>& monitors,
                  const std::vector<std::optional<v1::RelativeError>>& errors, v1::StepReport& to) {
  for (std::size_t i = 0; i < report.monitor_displacement.size(); ++i) {
    auto* value = to.add_monitors();
    if (i < monitors.size()) value->set_name(monitors[i].name);
    for (const double along : report.monitor_displacement[i]) value->add_displacement_m(along);
    if (i < report.monitor_temperature.size() && std::isfinite(report.monitor_temperature[i]))
      value->set_temperature_c(report.monitor_temperature[i]);
    case_file::add_curl(i < errors.size() ? errors[i] : std::nullopt, *value);
  }
}

v1::Finding to_finding(const casting::RunFailure& failure) {
  v1::Finding to;
  to.set_code(failure.finding);
  to.set_kind(translate::to_proto(failure.kind));
  to.set_message(failure.message);
  to.set_time_s(failure.time);
  to.set_time_step_s(failure.time_step);
  to.mutable_residual_history()->Add(failure.residual_history.begin(),
                                     failure.residual_history.end());
  to.mutable_place_m()->Add(failure.place.begin(), failure.place.end());
  return to;
}

}  // namespace

v1::ValidateCaseResponse to_proto(const casting::CheckedCase& checked) {
  v1::ValidateCaseResponse verdict;
  for (const Fault& fault : checked.faults.list()) *verdict.add_faults() = to_proto(fault);
  for (const Fault& warning : checked.warnings.list()) *verdict.add_warnings() = to_proto(warning);
  if (!checked.faults.empty()) return verdict;

  auto* estimate = verdict.mutable_estimate();
  estimate->set_nodes(checked.estimate.nodes);
  estimate->set_elements(checked.estimate.elements);
  estimate->set_steps(checked.estimate.steps);
  estimate->set_solver_s(checked.estimate.solver_seconds);
  estimate->set_memory_bytes(checked.estimate.memory_bytes);
  return verdict;
}

std::string describe(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += "; ";
    text += fmt::format("{} = {}: {}", fault.field, fault.value, fault.message);
    if (!fault.permitted.empty()) text += fmt::format(" ({})", fault.permitted);
  }
  return escaped(text);
}

v1::StepReport to_proto(const results::StepReport& report,
                        const std::vector<casting::Monitor>& monitors,
                        const std::vector<std::optional<v1::RelativeError>>& errors) {
  v1::StepReport to;
  v1::SectionFigures& section = *to.mutable_section();
  section.set_extent(report.dimension == 3 ? v1::SectionFigures::WHOLE_QUARTER
                                           : v1::SectionFigures::METRE_OF_FACE);

  // Most fields follow from the table of history fields, so that a new one needs no line here.
  const Field* const* next = message_fields().data();
  for (const results::HistoryField& field : results::history_fields()) {
    const Field* message_field = *next++;
    google::protobuf::Message& message =
        depends_on_section(field) ? static_cast<google::protobuf::Message&>(section) : to;
    const auto& reflection = *message.GetReflection();
    std::visit(Overloaded{[&](Real m) { reflection.SetDouble(&message, message_field, report.*m); },
                          [&](Int m) { reflection.SetInt32(&message, message_field, report.*m); },
                          [&](Long m) { reflection.SetInt64(&message, message_field, report.*m); },
                          [&](Flag m) { reflection.SetBool(&message, message_field, report.*m); }},
               field.member);
  }

  add_monitors(report, monitors, errors, to);
  to.set_solver_s(report.solver_seconds);
  to.set_process_s(report.process_seconds);
  return to;
}

results::StepReport to_core(const v1::StepReport& report, int dimension) {
  results::StepReport to;
  to.dimension = dimension;

  const Field* const* next = message_fields().data();
  for (const results::HistoryField& field : results::history_fields()) {
    const Field* message_field = *next++;
    const google::protobuf::Message& message =
        depends_on_section(field) ? static_cast<const google::protobuf::Message&>(report.section())
                                  : report;
    const auto& reflection = *message.GetReflection();
    std::visit(Overloaded{[&](Real m) { to.*m = reflection.GetDouble(message, message_field); },
                          [&](Int m) { to.*m = reflection.GetInt32(message, message_field); },
                          [&](Long m) { to.*m = reflection.GetInt64(message, message_field); },
                          [&](Flag m) { to.*m = reflection.GetBool(message, message_field); }},
               field.member);
  }

  for (const v1::MonitorValue& value : report.monitors()) {
    to.monitor_displacement.emplace_back(value.displacement_m().begin(),
                                         value.displacement_m().end());
    to.monitor_temperature.push_back(value.has_temperature_c() ? value.temperature_c()
                                                               : std::nan(""));
  }

  to.solver_seconds = report.solver_s();
  to.process_seconds = report.process_s();
  return to;
}

v1::Finding to_proto(const casting::RunFailures& failures) {
  v1::Finding to = to_finding(failures.at(0));
  for (std::size_t i = 1; i < failures.size(); ++i) *to.add_further() = to_finding(failures[i]);
  return to;
}

v1::Finding to_proto(const results::ValidityLoss& loss) {
  v1::Finding to;
  // The result file keeps the name of the kind.
  if (const auto kind = casting::failure_kind(loss.kind)) to.set_kind(to_proto(*kind));
  to.set_message(loss.message);
  to.set_time_s(loss.time);
  to.mutable_place_m()->Assign(loss.place.begin(), loss.place.end());
  to.set_value(loss.value);
  to.set_limit(loss.limit);
  to.set_unit(loss.unit);
  return to;
}

v1::Finding to_proto(const results::Finding& finding) {
  v1::Finding to;
  to.set_code(finding.code);

  to.set_severity(to_proto(finding.severity));
  to.set_message(finding.message);
  if (finding.time) to.set_time_s(*finding.time);
  to.mutable_place_m()->Assign(finding.place.begin(), finding.place.end());
  if (finding.value) to.set_value(*finding.value);
  if (finding.limit) to.set_limit(*finding.limit);
  to.set_unit(finding.unit);
  to.set_key(finding.key);
  to.set_remedy(case_file::remedy_text(to));

  if (!finding.worst) return to;
  to.mutable_worst()->set_time_s(finding.worst->time);
  to.mutable_worst()->set_value(finding.worst->value);
  to.mutable_worst()->mutable_place_m()->Assign(finding.worst->place.begin(),
                                                finding.worst->place.end());
  if (finding.certainty) to.set_certainty(to_proto(*finding.certainty));
  if (finding.lower_error) to.set_lower_error(*finding.lower_error);
  if (finding.upper_error) to.set_upper_error(*finding.upper_error);
  return to;
}

}  // namespace dccast::translate
