#include "core/findings/validity.hpp"

#include <cstdio>
#include <numbers>

#include "core/findings/motion.hpp"
#include "core/findings/run_failure.hpp"
#include "core/findings/shell.hpp"

namespace dccast::casting {

namespace {

constexpr double degrees = 180.0 / std::numbers::pi;
constexpr double millimetres = 1e3;
constexpr double percent = 100.0;

constexpr const char* not_valid = "later results are not valid";

template <class... Values>
std::string sentence(const char* format, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// "(0.1, 0.02) m"
std::string in_words(const std::vector<double>& place) {
  std::string text;
  for (const double coordinate : place)
    text += sentence(text.empty() ? "(%.4g" : ", %.4g", coordinate);
  return text + ") m";
}

/// "0.1 m from the symmetry plane"; for a quarter slab from both.
std::string along_bottom(const std::vector<double>& place) {
  if (place.size() == 2) return sentence("%.4g m from the symmetry plane", place[0]);
  return sentence("%.4g m and %.4g m from the symmetry planes", place[0], place[1]);
}

template <int Dim>
constexpr const char* what_melting_through_means =
    Dim == 2 ? "no solid path connects the symmetry plane to the cooled faces any more"
             : "melt that is connected to the top stands on the block there";

}  // namespace

template <int Dim>
ValidityJudge<Dim>::ValidityJudge(const Case& c)
    : limits_(c.validity),
      properties_(c.alloy),
      // A billet is held by its hoop stress, whatever happens to the shell below its axis.
      judges_shell_(c.section.kind != mesh::SectionKind::axisymmetric &&
                    c.mechanics.options.liquid != mechanics::Liquid::solid),
      // With the paper's weak liquid the pressure error is up to a factor of a hundred; it is not
      // the default, and choosing it is the user's decision.
      judges_pressure_(c.mechanics.options.liquid == mechanics::Liquid::prestressed),
      judges_rotation_(c.mechanics.options.kinematics == mechanics::Kinematics::small_strain),
      solid_below_(c.mechanics.options.liquid == mechanics::Liquid::solid ? c.alloy.liquidus
                                                                          : c.alloy.coherency) {}

template <int Dim>
SolidMotion ValidityJudge<Dim>::judge(const JudgedStep<Dim>& step, ValidityState& state) const {
  const Extreme turned = largest_rotation(step.mesh, step.slab.solid, step.slab.displacement,
                                          step.growing, state.when_liquid);
  const Extreme slid = largest_slip(step.mesh, step.slab.solid, step.slab.displacement,
                                    step.temperature, properties_, solid_below_);
  if (!state.lost) state.lost = shell(step, state);
  if (!state.lost) state.lost = rotation(step, turned);
  if (!state.lost) state.lost = slip(step, slid);
  if (!state.lost) state.lost = liquid_pressure(step);
  return {turned.value, slid.value};
}

template <int Dim>
std::optional<ValidityLoss> ValidityJudge<Dim>::shell(const JudgedStep<Dim>& step,
                                                      ValidityState& state) const {
  if (!judges_shell_) return std::nullopt;
  const double limit = limits_.minimum_shell;
  if (limit <= 0.0 && !melt_touches_bottom(step.mesh, step.slab.solid)) {
    state.shell_stood = true;
    return std::nullopt;
  }
  const auto shell = thinnest_shell(step.mesh, step.slab.solid);
  if (!shell) return std::nullopt;
  const bool stands = shell->value > 0.0 && shell->value >= limit;
  state.shell_stood |= stands;
  if (stands || !state.shell_stood) return std::nullopt;
  std::string message = sentence("at t = %.6g s the shell over the bottom block ", step.time);
  const std::string where = along_bottom(shell->place);
  message +=
      shell->value <= 0.0
          ? "has melted through " + where + ": " + what_melting_through_means<Dim>
          : sentence("is %.3g mm thick ", millimetres * shell->value) + where +
                sentence(", less than validity.minimum_shell = %.3g mm", millimetres * limit);
  return ValidityLoss{name_of(FailureKind::shell_melted_through),
                      message + "; " + not_valid,
                      step.time,
                      shell->place,
                      shell->value,
                      limit,
                      "m"};
}

template <int Dim>
std::optional<ValidityLoss> ValidityJudge<Dim>::rotation(const JudgedStep<Dim>& step,
                                                         const Extreme& found) const {
  if (!judges_rotation_ || found.value <= limits_.maximum_rotation) return std::nullopt;
  return ValidityLoss{
      name_of(FailureKind::motion_too_large),
      sentence("at t = %.6g s the solid at %s has rotated by %.3g degrees, more than "
               "validity.maximum_rotation = %.3g degrees, the limit of small strains; %s",
               step.time, in_words(found.place).c_str(), degrees * found.value,
               degrees * limits_.maximum_rotation, not_valid),
      step.time,
      found.place,
      found.value,
      limits_.maximum_rotation,
      "rad"};
}

template <int Dim>
std::optional<ValidityLoss> ValidityJudge<Dim>::slip(const JudgedStep<Dim>& step,
                                                     const Extreme& found) const {
  if (found.value <= limits_.maximum_slip) return std::nullopt;
  return ValidityLoss{
      name_of(FailureKind::motion_too_large),
      sentence(
          "at t = %.6g s the butt %s has slid %.3g mm over the bottom "
          "block beyond its thermal contraction, more than validity.maximum_slip = %.3g mm; %s",
          step.time, along_bottom(found.place).c_str(), millimetres * found.value,
          millimetres * limits_.maximum_slip, not_valid),
      step.time,
      found.place,
      found.value,
      limits_.maximum_slip,
      "m"};
}

template <int Dim>
std::optional<ValidityLoss> ValidityJudge<Dim>::liquid_pressure(const JudgedStep<Dim>& step) const {
  const Extreme& found = step.liquid_pressure_error;
  if (!judges_pressure_ || found.value <= limits_.maximum_liquid_pressure_error) {
    return std::nullopt;
  }
  return ValidityLoss{
      name_of(FailureKind::liquid_pressure_lost),
      sentence("at t = %.6g s the pressure of the liquid on its front is off by %.3g %% of the "
               "hydrostatic one, most at %s, more than "
               "validity.maximum_liquid_pressure_error = %.3g %%; %s",
               step.time, percent * found.value, in_words(found.place).c_str(),
               percent * limits_.maximum_liquid_pressure_error, not_valid),
      step.time,
      found.place,
      found.value,
      limits_.maximum_liquid_pressure_error,
      "1"};
}

template class ValidityJudge<2>;
template class ValidityJudge<3>;

}  // namespace dccast::casting
