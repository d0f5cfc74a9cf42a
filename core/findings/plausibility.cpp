#include "core/findings/plausibility.hpp"

#include <algorithm>
#include <array>

#include "core/findings/of_case.hpp"
#include "core/findings/of_step.hpp"

namespace dccast::casting {

namespace {

constexpr std::array of_case{no_superheat, coherency_in_liquid, water_never_meets, zone_never_meets,
                             table_never_reached};

/// Causes before what they lead to.
constexpr std::array of_step{bleed_out_at_exit,    remelting_in_gap,     bottom_shell_fails,
                             bottom_shell_open,    bleed_out_at_bottom,  sump_too_deep,
                             shell_melted_through, slip_too_large,       rotation_too_large,
                             lift_too_large,       liquid_pressure_lost, hot_tears,
                             curl_outside_band};

bool is_raised(const PlausibilityState& state, const std::string& code) {
  return std::ranges::find(state.raised, code, &Finding::code) != state.raised.end();
}

}  // namespace

std::vector<Finding> findings_of_case(const Case& c) {
  const Course course = course_of(c);
  std::vector<Finding> found;
  for (const auto& look : of_case)
    if (auto finding = look(c, course)) found.push_back(std::move(*finding));
  return found;
}

void raise_findings(const Case& c, const StepFigures& step, PlausibilityState& state) {
  for (const auto& look : of_step) {
    auto finding = look(c, step);
    if (!finding || is_raised(state, finding->code)) continue;
    finding->time = step.time;
    state.raised.push_back(std::move(*finding));
  }
}

template <int Dim>
void judge(const Case& c, const StepView<Dim>& view, results::StepReport& report,
           PlausibilityState& state) {
  const StepFigures figures = figures_of(c, view, state.thickest_bottom_shell);
  report.shell_at_exit = figures.exit_shell.value;
  report.bottom_shell = figures.bottom_shell.value;
  report.mush_strain = figures.mush_strain.value;
  raise_findings(c, figures, state);
}

template void judge(const Case&, const StepView<2>&, results::StepReport&, PlausibilityState&);
template void judge(const Case&, const StepView<3>&, results::StepReport&, PlausibilityState&);

}  // namespace dccast::casting
