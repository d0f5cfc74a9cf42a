#include "server/translate/step_to_proto.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace dccast::translate {

namespace {

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

/// Per metre of face in a section, of the whole quarter in a quarter slab.
void add_heat_and_forces(const results::StepReport& report, v1::StepReport& to) {
  if (report.dimension == 3) {
    to.set_wall_heat_flux_w(report.wall_heat_flux);
    to.set_side_heat_w(report.side_heat);
    to.set_narrow_heat_w(report.narrow_heat);
    to.set_bottom_heat_w(report.bottom_heat);
    to.set_bottom_reaction_n(report.bottom_reaction);
    to.set_weight_n(report.weight);
    return;
  }
  to.set_wall_heat_flux_w_per_m(report.wall_heat_flux);
  to.set_side_heat_w_per_m(report.side_heat);
  to.set_bottom_heat_w_per_m(report.bottom_heat);
  to.set_bottom_reaction_n_per_m(report.bottom_reaction);
  to.set_weight_n_per_m(report.weight);
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
  to.set_step(report.step);
  to.set_time_s(report.time);
  to.set_time_step_s(report.time_step);
  to.set_cast_length_m(report.cast_length);
  to.set_iterations(report.iterations);
  to.set_heat_iterations(report.heat_iterations);
  to.set_contact_changes(report.contact_changes);
  to.set_factorizations(report.factorizations);
  to.set_solves(report.solves);
  to.set_failed_attempts(report.failed_attempts);
  add_monitors(report, monitors, to);
  to.set_equilibrium_residual(report.equilibrium_residual);
  to.set_energy_balance_error(report.energy_balance_error);
  add_heat_and_forces(report, to);
  to.set_sump_depth_m(report.sump_depth);
  to.set_contact_length_m(report.contact_length);
  to.set_solver_s(report.solver_seconds);
  to.set_progress(report.progress);
  to.set_nodes(report.nodes);
  to.set_elements(report.elements);
  to.set_maximum_surface_temperature_at_mould_exit_c(report.mould_exit_temperature);
  to.set_complementarity_error(report.complementarity_error);
  to.set_constitutive_residual(report.constitutive_residual);
  to.set_liquid_pressure_error(report.liquid_pressure_error);
  to.set_beyond_validity(report.beyond_validity);
  to.set_maximum_rotation_rad(report.maximum_rotation);
  to.set_bottom_slip_m(report.bottom_slip);
  to.set_shell_at_exit_m(report.shell_at_exit);
  to.set_bottom_shell_m(report.bottom_shell);
  to.set_mush_strain(report.mush_strain);
  to.set_process_s(report.process_seconds);
  to.set_conjugate_gradient_iterations(report.conjugate_gradient_iterations);
  to.set_contact_area_m2(report.contact_area);
  to.set_merged_rows(report.merged_rows);
  to.set_merge_mass_error(report.merge_mass_error);
  to.set_merge_energy_error(report.merge_energy_error);
  to.set_merge_equilibrium_error(report.merge_equilibrium_error);
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
