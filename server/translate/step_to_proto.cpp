#include "server/translate/step_to_proto.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/results/history_fields.hpp"

namespace dccast::translate {

namespace {

using Field = google::protobuf::FieldDescriptor;

/// @throws std::logic_error  the message lacks it
const Field* field_of(const results::HistoryField& field, int dimension) {
  const std::string name = field.name_in(dimension);
  const Field* found = v1::StepReport::descriptor()->FindFieldByName(name);
  if (found == nullptr) throw std::logic_error("StepReport of job.proto lacks " + name);
  return found;
}

void add_monitors(const results::StepReport& report, const std::vector<casting::Monitor>& monitors,
                  v1::StepReport& to) {
  for (std::size_t i = 0; i < report.monitor_displacement.size(); ++i) {
    auto* value = to.add_monitors();
    if (i < monitors.size()) value->set_name(monitors[i].name);
    for (const double component : report.monitor_displacement[i])
      value->add_displacement_m(component);
    if (i < report.monitor_temperature.size() && std::isfinite(report.monitor_temperature[i]))
      value->set_temperature_c(report.monitor_temperature[i]);
  }
}

v1::Failure::Kind to_proto(casting::FailureKind kind) {
  switch (kind) {
    case casting::FailureKind::solve_failed:
      return v1::Failure::SOLVE_FAILED;
    case casting::FailureKind::check_failed:
      return v1::Failure::CHECK_FAILED;
    case casting::FailureKind::shell_melted_through:
      return v1::Failure::SHELL_MELTED_THROUGH;
    case casting::FailureKind::motion_too_large:
      return v1::Failure::MOTION_TOO_LARGE;
    case casting::FailureKind::liquid_pressure_lost:
      return v1::Failure::LIQUID_PRESSURE_LOST;
    case casting::FailureKind::storage:
      return v1::Failure::STORAGE;
    case casting::FailureKind::other_version:
      return v1::Failure::OTHER_VERSION;
  }
  return v1::Failure::INTERNAL;
}

v1::Finding::Severity to_proto(results::Severity severity) {
  switch (severity) {
    case results::Severity::note:
      return v1::Finding::NOTE;
    case results::Severity::warning:
      return v1::Finding::WARNING;
    case results::Severity::danger:
      return v1::Finding::DANGER;
  }
  return v1::Finding::SEVERITY_UNSPECIFIED;
}

/// By its name in results.h5, which is that of the schema in lower case.
v1::Failure::Kind kind_named(std::string name) {
  std::ranges::transform(name, name.begin(), [](char c) {
    return static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  });
  v1::Failure::Kind kind = v1::Failure::KIND_UNSPECIFIED;
  v1::Failure::Kind_Parse(name, &kind);
  return kind;
}

}  // namespace

v1::StepReport to_proto(const results::StepReport& report,
                        const std::vector<casting::Monitor>& monitors) {
  v1::StepReport to;
  const auto& reflection = *to.GetReflection();
  for (const results::HistoryField& field : results::history_fields()) {
    const Field* of_message = field_of(field, report.dimension);
    switch (of_message->cpp_type()) {
      case Field::CPPTYPE_DOUBLE:
        reflection.SetDouble(&to, of_message, results::real_value(field, report));
        break;
      case Field::CPPTYPE_BOOL:
        reflection.SetBool(&to, of_message, results::integer_value(field, report) != 0);
        break;
      case Field::CPPTYPE_INT32:
        reflection.SetInt32(&to, of_message,
                            static_cast<std::int32_t>(results::integer_value(field, report)));
        break;
      default:
        reflection.SetInt64(&to, of_message, results::integer_value(field, report));
    }
  }
  add_monitors(report, monitors, to);
  to.set_solver_s(report.solver_seconds);
  to.set_process_s(report.process_seconds);
  return to;
}

results::StepReport to_core(const v1::StepReport& report, int dimension) {
  results::StepReport to;
  to.dimension = dimension;
  const auto& reflection = *report.GetReflection();
  for (const results::HistoryField& field : results::history_fields()) {
    const Field* of_message = field_of(field, dimension);
    switch (of_message->cpp_type()) {
      case Field::CPPTYPE_DOUBLE:
        results::set_real(field, to, reflection.GetDouble(report, of_message));
        break;
      case Field::CPPTYPE_BOOL:
        results::set_integer(field, to, reflection.GetBool(report, of_message) ? 1 : 0);
        break;
      case Field::CPPTYPE_INT32:
        results::set_integer(field, to, reflection.GetInt32(report, of_message));
        break;
      default:
        results::set_integer(field, to, reflection.GetInt64(report, of_message));
    }
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

v1::Failure to_proto(const casting::RunFailures& failures) {
  const casting::RunFailure& failure = failures.at(0);
  v1::Failure to;
  to.set_kind(to_proto(failure.kind));
  to.set_message(failure.message);
  to.set_time_s(failure.time);
  to.set_time_step_s(failure.time_step);
  to.mutable_residual_history()->Add(failure.residual_history.begin(),
                                     failure.residual_history.end());
  to.mutable_place_m()->Add(failure.place.begin(), failure.place.end());
  to.set_finding(failure.finding);
  for (std::size_t i = 1; i < failures.size(); ++i)
    to.add_further_causes(v1::Failure::Kind_Name(to_proto(failures[i].kind)) + ": " +
                          failures[i].message);
  return to;
}

v1::ValidityLoss to_proto(const results::ValidityLoss& loss) {
  v1::ValidityLoss to;
  to.set_kind(kind_named(loss.kind));
  to.set_message(loss.message);
  to.set_time_s(loss.time);
  to.mutable_place_m()->Add(loss.place.begin(), loss.place.end());
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
  to.mutable_place_m()->Add(finding.place.begin(), finding.place.end());
  if (finding.value) to.set_value(*finding.value);
  if (finding.limit) to.set_limit(*finding.limit);
  to.set_unit(finding.unit);
  to.set_key(finding.key);
  if (!finding.worst) return to;
  to.mutable_worst()->set_time_s(finding.worst->time);
  to.mutable_worst()->set_value(finding.worst->value);
  to.mutable_worst()->mutable_place_m()->Add(finding.worst->place.begin(),
                                             finding.worst->place.end());
  return to;
}

}  // namespace dccast::translate
