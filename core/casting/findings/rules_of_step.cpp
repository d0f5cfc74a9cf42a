#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/casting/findings/rules.hpp"

namespace dccast::casting {

namespace {

using Found = std::optional<Judged>;

constexpr double in_degrees = 180.0 / std::numbers::pi;
constexpr double in_percent = 100.0;
constexpr double in_kilopascal = 1e-3;
constexpr const char* not_valid = "later results are not valid";

/// "(0.1, 0.02) m"
std::string format_place(const std::vector<double>& place) {
  return fmt::format("({:.4g}) m", fmt::join(place, ", "));
}

/// "0.1 m from the symmetry plane"; for a quarter slab from both.
std::string describe_bottom_place(const std::vector<double>& place) {
  if (place.size() == 2) return fmt::format("{:.4g} m from the symmetry plane", place[0]);
  return fmt::format("{:.4g} m and {:.4g} m from the symmetry planes", place[0], place[1]);
}

// Bounds of the checks of a run.
constexpr double energy_bound = 1e-8;   // relative; the heat step solves to 1e-11
constexpr double support_bound = 1e-2;  // share of the weight that may be left unsupported
constexpr double contact_bound = 1e-3;  // gaps relative to 1 mm, forces to the weight

Found energy_not_conserved(const Case&, const StepFigures& f) {
  return Judged{
      PlacedFigure{std::abs(f.energy_balance_error)}, energy_bound,
      "The heat that metal and surfaces exchange does not add up: the temperatures of this run are "
      "not to be used.",
      fmt::format("energy balance off by {:.2e} at t = {:g} s", f.energy_balance_error, f.time)};
}

Found weight_not_carried(const Case&, const StepFigures& f) {
  if (f.weight <= 0.0) return std::nullopt;
  const char* unit = f.solid_model ? "N" : "N/m";
  return Judged{
      PlacedFigure{std::abs(f.bottom_reaction / f.weight - 1.0)}, support_bound,
      "The bottom block does not carry the weight of the slab: the forces and gaps of this run are "
      "not to be used.",
      fmt::format("bottom reaction {:.6g} {} against a weight of {:.6g} {} at t = {:g} s",
                  f.bottom_reaction, unit, f.weight, unit, f.time)};
}

Found contact_violated(const Case&, const StepFigures& f) {
  return Judged{
      PlacedFigure{f.complementarity_error}, contact_bound,
      "The slab penetrates the block or is pulled by it: the gaps of this run are not to be used.",
      fmt::format("contact conditions violated by {:.2e} at t = {:g} s", f.complementarity_error,
                  f.time)};
}

/// A metal level that is held at the casting temperature conducts heat into a colder pool,
/// regardless of how much metal flows in.
Found level_overheats(const Case& c, const StepFigures& f) {
  if (c.cooling.top != thermal::Top::held || f.superheat <= 0.0) return std::nullopt;
  return Judged{PlacedFigure{f.level_heat / f.superheat}, 1.0,
                fmt::format("The metal level, held at the casting temperature, has delivered "
                            "{:.3g} times the superheat of the metal poured so far: no metal "
                            "brings this heat. Shells are too thin and curls too large.",
                            f.level_heat / f.superheat)};
}

Found water_boils_away(const Case&, const StepFigures& f) {
  if (!f.water_boiled_away) return std::nullopt;
  return Judged{PlacedFigure{f.water_share}, 1.0,
                "So little water is left that it no longer covers a face: below, the face is "
                "dry, and the shell can melt again.",
                "", true};
}

Found water_thrown_off(const Case&, const StepFigures& f) {
  if (!f.water_thrown_off) return std::nullopt;
  return Judged{PlacedFigure{f.water_share}, 1.0,
                "A vapour film throws the water off a face that is too hot for this flow: below, "
                "the face is dry. As a start practice this is watched closely; later it bleeds.",
                "", true};
}

/// Occurs with constant limits of the film, which do not depend on the heat that it takes.
Found water_beyond_capacity(const Case&, const StepFigures& f) {
  if (f.water_share <= 1.0 + 1e-9) return std::nullopt;
  return Judged{PlacedFigure{f.water_share}, 1.0,
                fmt::format("A face gives off {:.3g} times the heat that its water could take, "
                            "even if all of it evaporated: set boiling_follows_flow.",
                            f.water_share),
                "", true};
}

/// Steam that cannot get out of a narrow gap lifts the butt until it can: the slab bumps.
Found steam_lifts_butt(const Case& c, const StepFigures& f) {
  const double limit = c.plausibility.greatest_steam_share;
  if (!f.moves || !f.mechanical) return std::nullopt;
  return Judged{PlacedFigure{f.steam_share}, limit,
                fmt::format("Steam under the butt presses up with {:.3g} times the weight of the "
                            "metal, more than {:.3g}: the slab bumps on the block, and the shell "
                            "may tear.",
                            f.steam_share, limit)};
}

/// Smaller lifts are the rocking of a butt on the block, not its shape [m].
constexpr double least_lift = 2e-3;

Found centre_lifts(const Case&, const StepFigures& f) {
  if (!f.mechanical || !f.moves) return std::nullopt;

  return Judged{
      f.centre_lift, std::max(least_lift, f.corner_lift),
      fmt::format("The centre of the butt has risen {:.3g} mm and its edge {:.3g} mm: no slab does "
                  "this. The mould holds the faces for too long, or the metal gains strength too "
                  "late: look at alloy.coherency and shell_solid_fraction.",
                  in_mm * f.centre_lift.value, in_mm * f.corner_lift)};
}

Found hot_exit(const Case& c, const StepFigures& f) {
  const double limit = c.alloy.shell_temperature();
  if (!f.moves || !f.left_mould) return std::nullopt;
  return Judged{
      f.exit_surface, limit,
      fmt::format("The surface leaves the mould at {:.4g} degC, above the {:.6g} degC at which "
                  "metal becomes a shell: nothing holds the melt there, and it runs out.",
                  f.exit_surface.value, limit)};
}

Found thin_exit(const Case& c, const StepFigures& f) {
  const double limit = c.plausibility.minimum_shell;
  if (!f.moves || !f.left_mould) return std::nullopt;
  return Judged{
      f.exit_shell, limit,
      fmt::format("The shell leaves the mould {:.3g} mm thick, less than {:.3g} mm: a scratch, a "
                  "hang-up in the mould or a short loss of water lets the melt through.",
                  in_mm * f.exit_shell.value, in_mm * limit)};
}

/// The least shell below the mould contact, where the wall no longer carries the metal. Metal that
/// stood in the mould during the hold froze under other conditions and is not judged.
Found thin_shell(const Case& c, const StepFigures& f) {
  const double limit = c.plausibility.minimum_shell;
  if (!f.moves || !f.left_contact) return std::nullopt;

  return Judged{
      f.least_shell, limit,
      fmt::format("{:.3g} mm below the metal level, between mould contact and water, the shell is "
                  "{:.3g} mm thick, less than {:.3g} mm: it bulges, sweats, and tears open where "
                  "it hangs up.",
                  in_mm * f.least_shell_depth, in_mm * f.least_shell.value, in_mm * limit)};
}

/// The meniscus folds over a rim that has frozen.
Found freezes_at_meniscus(const Case& c, const StepFigures& f) {
  const double limit = c.plausibility.minimum_meniscus;
  if (!f.moves || !f.left_mould) return std::nullopt;

  return Judged{
      f.shell_begins, limit,
      fmt::format(
          "The side is frozen up to {:.3g} mm below the metal level on average, closer than "
          "{:.3g} mm: the meniscus folds into cold shuts, and the shell hangs up in the mould.",
          in_mm * f.shell_begins.value, in_mm * limit)};
}

/// A shell that is about to fail has lost this share of its largest thickness, and its remaining
/// thickness is below this multiple of the limit. Sound castings stay above
/// (docs/findings.md).
constexpr double lost_share = 0.4;
constexpr double limits_left = 3.0;

/// The gap is the cause if the surface was solid at the end of the mould contact and melts again; a
/// surface that is not yet solid there has another cause.
Found remelting_in_gap(const Case& c, const StepFigures& f) {
  const double limit = c.alloy.shell_temperature();
  if (!f.moves || !f.in_gap || f.gap_entry >= limit) return std::nullopt;

  return Judged{f.gap_surface, limit,
                fmt::format("In the air gap the surface, which was a shell where it left the "
                            "mould wall, is at {:.4g} degC again, above the {:.6g} degC of a "
                            "shell: melt sweats out in bands, and may bleed out.",
                            f.gap_surface.value, limit)};
}

/// Before the surface itself melts, the shell grows thinner between the mould contact and the
/// water.
Found shell_thins_in_gap(const Case&, const StepFigures& f) {
  const double kept = (1.0 - lost_share) * f.entry_shell;
  if (!f.moves || !f.in_gap || !f.left_mould) return std::nullopt;

  return Judged{
      f.least_shell, kept,
      fmt::format("In the air gap the shell melts from {:.3g} mm, where it left the mould wall, to "
                  "{:.3g} mm: melt sweats out in bands, and may bleed out.",
                  in_mm * f.entry_shell, in_mm * f.least_shell.value)};
}

Found bottom_shell_fails(const Case& c, const StepFigures& f) {
  const double limit = std::min(limits_left * c.plausibility.minimum_shell,
                                (1.0 - lost_share) * f.thickest_bottom_shell);
  if (!f.moves || !f.mechanical) return std::nullopt;

  return Judged{
      f.bottom_shell, limit,
      fmt::format(
          "The shell over the bottom block melts again: it was {:.3g} mm thick and is {:.3g} mm "
          "now. It is about to fail.",
          in_mm * f.thickest_bottom_shell, in_mm * f.bottom_shell.value)};
}

/// Gap between shell and bottom block into which melt can run [m]. The surface tension of
/// aluminium, 0.9 N/m, bridges gaps up to 2 gamma / (rho g h), which is 0.39 mm under 0.2 m of
/// melt.
constexpr double open_gap = 0.3e-3;

/// A shell in contact with the block, such as that of a billet near its axis, is supported by the
/// block.
Found bottom_shell_open(const Case& c, const StepFigures& f) {
  if (!f.moves || !f.mechanical || f.gap_under_shell >= open_gap) return std::nullopt;

  return Judged{f.bottom_shell, c.plausibility.minimum_shell,
                fmt::format("The shell over the bottom block is {:.3g} mm thick where it rests "
                            "on the block, less than {:.3g} mm: the block carries the melt now, "
                            "and it bleeds as soon as the butt lifts there.",
                            in_mm * f.bottom_shell.value, in_mm * c.plausibility.minimum_shell)};
}

Found bleed_out_at_bottom(const Case& c, const StepFigures& f) {
  if (!f.moves || !f.mechanical || f.gap_under_shell < open_gap) return std::nullopt;

  return Judged{
      f.bottom_shell, c.plausibility.minimum_shell,
      fmt::format(
          "Over a gap of {:.3g} mm to the bottom block the shell is {:.3g} mm thick, less than "
          "{:.3g} mm: nothing supports it there, and melt runs into the gap and onto the block.",
          in_mm * f.gap_under_shell, in_mm * f.bottom_shell.value,
          in_mm * c.plausibility.minimum_shell)};
}

Found sump_too_deep(const Case& c, const StepFigures& f) {
  if (!f.moves) return std::nullopt;
  return Judged{
      {f.sump_depth / f.metal_depth, {}},
      c.plausibility.maximum_sump_share,
      fmt::format("The sump is {:.4g} mm deep and the slab {:.4g} mm long: it is liquid nearly to "
                  "the bottom block, and any opening in the butt drains it.",
                  in_mm * f.sump_depth, in_mm * f.metal_depth)};
}

Found shell_melted_through(const Case& c, const StepFigures& f) {
  const double limit = c.validity.minimum_shell;
  if (!f.closed_shell || (f.closed_shell->value > 0.0 && f.closed_shell->value >= limit))
    return std::nullopt;

  // The account states which limit fails: no shell at all, or less than required.
  const double thickness = f.closed_shell->value;
  const std::string place = describe_bottom_place(f.closed_shell->place);
  const char* meaning =
      f.solid_model ? "melt that is connected to the top stands on the block there"
                    : "no solid path connects the symmetry plane to the cooled faces any more";
  const std::string state =
      thickness <= 0.0
          ? fmt::format("has melted through {}: {}", place, meaning)
          : fmt::format("is {:.3g} mm thick {}, less than validity.minimum_shell = {:.3g} mm",
                        in_mm * thickness, place, in_mm * limit);
  return Judged{*f.closed_shell, limit,
                "The shell over the bottom block has melted through: the slab bleeds out, and "
                "later results are not valid.",
                fmt::format("at t = {:.6g} s the shell over the bottom block {}; {}", f.time, state,
                            not_valid),
                true};
}

bool has_small_strains(const Case& c) {
  return c.mechanics.options.kinematics == mechanics::Kinematics::small_strain;
}

Found rotation_of_small_strains(const Case& c, const StepFigures& f) {
  const double limit = c.validity.maximum_rotation;
  if (!has_small_strains(c)) return std::nullopt;

  return Judged{
      f.rotation, limit,
      fmt::format("A part of the shell has rotated by {:.3g} degrees since it solidified, too far "
                  "for small strains: the curl is no longer known.",
                  in_degrees * f.rotation.value),
      fmt::format("at t = {:.6g} s the solid at {} has rotated by {:.3g} degrees, more than "
                  "validity.maximum_rotation = {:.3g} degrees, the limit of small strains; {}",
                  f.time, format_place(f.rotation.place), in_degrees * f.rotation.value,
                  in_degrees * limit, not_valid)};
}

/// Axes that follow each element hold further: beside finite strains a plate that has rotated by
/// this much is lifted within 1 % (tests/unit/mechanics/kinematics_test.cpp).
Found rotation_of_corotational_strains(const Case& c, const StepFigures& f) {
  constexpr double limit = 15.0 / in_degrees;
  if (has_small_strains(c)) return std::nullopt;

  return Judged{f.rotation, limit,
                fmt::format("A part of the shell has rotated by {:.3g} degrees since it "
                            "solidified. Beyond 15 degrees the kinematics alone puts the curl "
                            "off by more than 1 %.",
                            in_degrees * f.rotation.value)};
}

/// The message is that of a run that stops at this loss; a run that continues may reach it after
/// another loss.
Found slip_too_large(const Case& c, const StepFigures& f) {
  const double limit = c.validity.maximum_slip;
  if (f.slip.place.empty()) return std::nullopt;  // nothing is cold enough to slide

  return Judged{
      f.slip, limit,
      fmt::format("The butt has slid {:.3g} mm over the bottom block beyond its contraction: its "
                  "shell is open or nothing holds it on the block, and the slab hangs or bleeds.",
                  in_mm * f.slip.value),
      fmt::format("at t = {:.6g} s the butt {} has slid {:.3g} mm over the bottom block beyond its "
                  "thermal contraction, more than validity.maximum_slip = {:.3g} mm; {}",
                  f.time, describe_bottom_place(f.slip.place), in_mm * f.slip.value, in_mm * limit,
                  not_valid)};
}

/// The chord from the centre to the corner may rotate as little as any part of the shell.
Found lift_too_large(const Case& c, const StepFigures& f) {
  const double limit = std::tan(c.validity.maximum_rotation) * c.section.half_width;
  if (!f.mechanical) return std::nullopt;
  return Judged{f.lift, limit,
                fmt::format("The butt has risen {:.4g} mm off the bottom block: such a steep "
                            "butt is unstable, and the slab tilts or hangs in the mould.",
                            in_mm * f.lift.value)};
}

// Hot tears. The indices rank recipes and alloys and have no limit of their own: a plant compares
// with a recipe that it knows to be sound, at the end of the run, where both have the same length.
// Heat alone has no strain rate, and a part of the pressure drop only.

Found tear_rate(const Case& c, const StepFigures& f) {
  const auto& reference = c.plausibility.reference_tear_rate;
  const double rate = f.tears.strain_rate.overall;
  if (!f.mechanical || !f.last || !reference) return std::nullopt;

  return Judged{
      PlacedFigure{rate}, *reference,
      fmt::format("Freezing metal is stretched {:.3g} times as fast as in the reference recipe "
                  "({:.3g} 1/s in the centre of the butt, {:.3g} 1/s at the surface above the "
                  "block): hot tears are more likely than there.",
                  rate / *reference, f.tears.strain_rate.centre, f.tears.strain_rate.surface)};
}

Found tear_pressure(const Case& c, const StepFigures& f) {
  const auto& reference = c.plausibility.reference_tear_pressure;
  const double drop = f.tears.pressure.overall;
  if (!f.mechanical || !f.last || !reference) return std::nullopt;

  return Judged{
      PlacedFigure{drop}, *reference,
      fmt::format("Melt that feeds the mush loses {:.3g} times the pressure of the reference "
                  "recipe ({:.3g} kPa in the centre of the butt, {:.3g} kPa at the surface above "
                  "the block): hot tears are more likely than there.",
                  drop / *reference, in_kilopascal * f.tears.pressure.centre,
                  in_kilopascal * f.tears.pressure.surface)};
}

/// A limit that the user has set for the worst element.
Found mush_strain(const Case& c, const StepFigures& f) {
  const auto& limit = c.plausibility.maximum_mush_strain;
  if (!limit) return std::nullopt;

  return Judged{
      f.mush_strain, *limit,
      fmt::format("Metal that is coherent but not yet tough has been stretched by {:.3g} %, more "
                  "than the {:.3g} % that this case accepts: hot tears are likely there.",
                  in_percent * f.mush_strain.value, in_percent * *limit)};
}

/// The upper limit of the plant's range holds at any time.
Found curl_above_range(const Case& c, const StepFigures& f) {
  const auto& limit = c.plausibility.greatest_curl;
  if (!f.mechanical || !limit) return std::nullopt;
  return Judged{PlacedFigure{f.greatest_curl}, *limit,
                fmt::format("The curl is {:.4g} mm, above the {:.4g} mm that the plant accepts: "
                            "the butt rocks on the block, and more of it is sawn off.",
                            in_mm * f.greatest_curl, in_mm * *limit)};
}

/// The lower limit of the plant's range holds at the end.
Found curl_below_range(const Case& c, const StepFigures& f) {
  const auto& limit = c.plausibility.least_curl;
  if (!f.mechanical || !limit || !f.last) return std::nullopt;
  return Judged{PlacedFigure{f.greatest_curl}, *limit,
                fmt::format("The final curl is {:.4g} mm, below the {:.4g} mm that the plant "
                            "accepts: the recipe misses its aim.",
                            in_mm * f.greatest_curl, in_mm * *limit)};
}

/// The slab hangs up where friction in the mould carries it while the block sinks on. Aluminium on
/// an oiled mould has coefficients of friction from 0.2 to 0.6 (docs/findings.md).
constexpr double least_friction = 0.2, greatest_friction = 0.6;

Judged hang_up(const StepFigures& f, double friction) {
  return {PlacedFigure{f.wall_share}, 1.0 / friction,
          fmt::format("The mould presses on the shell with {:.3g} times the weight of the slab: "
                      "with a friction of {:g} the slab hangs in the mould while the block sinks, "
                      "then falls.",
                      f.wall_share, friction)};
}

Found may_hang_up(const Case&, const StepFigures& f) {
  if (!f.moves || !f.mechanical) return std::nullopt;
  return hang_up(f, greatest_friction);
}

Found hangs_up(const Case&, const StepFigures& f) {
  if (!f.moves || !f.mechanical) return std::nullopt;
  return hang_up(f, least_friction);
}

using enum Severity;
using enum Limit;
using Kind = FailureKind;
constexpr std::nullopt_t goes_on = std::nullopt;

constexpr const char* least_shell = "plausibility.minimum_shell";

// clang-format off
constexpr std::array rules{
    StepRule{"energy_not_conserved", danger, Kind::check_failed, "", "1", upper, "", energy_not_conserved},
    StepRule{"weight_not_carried", danger, Kind::check_failed, "", "1", upper, "", weight_not_carried},
    StepRule{"contact_violated", danger, Kind::check_failed, "", "1", upper, "", contact_violated},
    StepRule{"level_overheats", warning, goes_on, "cooling.top", "1", upper, "", level_overheats},
    StepRule{"water_boils_away", warning, goes_on, "schedule.water_flow", "1", upper, "", water_boils_away},
    StepRule{"water_thrown_off", warning, goes_on, "schedule.water_flow", "1", upper, "", water_thrown_off},
    StepRule{"water_beyond_capacity", warning, goes_on, "cooling.water.boiling_follows_flow", "1", upper, "", water_beyond_capacity},
    StepRule{"steam_lifts_butt", warning, goes_on, "plausibility.greatest_steam_share", "1", upper, "", steam_lifts_butt},
    StepRule{"bleed_out_at_exit", danger, goes_on, "alloy.shell_solid_fraction", "degC", upper, "surface at the mould exit", hot_exit},
    StepRule{"bleed_out_at_exit", danger, goes_on, least_shell, "m", lower, "shell at the mould exit", thin_exit},
    StepRule{"thin_shell", warning, goes_on, least_shell, "m", lower, "shell above the water", thin_shell},
    StepRule{"freezes_at_meniscus", warning, goes_on, "plausibility.minimum_meniscus", "m", lower, "depth at which the side freezes", freezes_at_meniscus},
    StepRule{"remelting_in_gap", warning, goes_on, "alloy.shell_solid_fraction", "degC", upper, "", remelting_in_gap},
    StepRule{"remelting_in_gap", warning, goes_on, "cooling.zone", "m", lower, "", shell_thins_in_gap},
    StepRule{"bottom_shell_fails", warning, goes_on, least_shell, "m", lower, "", bottom_shell_fails},
    StepRule{"bottom_shell_open", warning, goes_on, least_shell, "m", lower, "", bottom_shell_open},
    StepRule{"bleed_out_at_bottom", danger, goes_on, least_shell, "m", lower, "shell over the block", bleed_out_at_bottom},
    StepRule{"sump_too_deep", danger, goes_on, "plausibility.maximum_sump_share", "1", upper, "share of the sump", sump_too_deep},
    StepRule{"shell_melted_through", danger, Kind::shell_melted_through, "validity.minimum_shell", "m", lower, "", shell_melted_through},
    StepRule{"rotation_too_large", danger, Kind::motion_too_large, "validity.maximum_rotation", "rad", upper, "", rotation_of_small_strains},
    StepRule{"rotation_too_large", warning, goes_on, "", "rad", upper, "rotation", rotation_of_corotational_strains},
    StepRule{"slip_too_large", danger, Kind::motion_too_large, "validity.maximum_slip", "m", upper, "", slip_too_large},
    StepRule{"centre_lifts", warning, goes_on, "alloy.shell_solid_fraction", "m", upper, "", centre_lifts},
    StepRule{"lift_too_large", danger, goes_on, "validity.maximum_rotation", "m", upper, "lift of the butt", lift_too_large},
    StepRule{"may_hang_up", warning, goes_on, "", "1", upper, "", may_hang_up},
    StepRule{"hangs_up", danger, goes_on, "", "1", upper, "", hangs_up},
    StepRule{"hot_tears", warning, goes_on, "plausibility.reference_tear_rate", "s-1", upper, "", tear_rate},
    StepRule{"hot_tears", warning, goes_on, "plausibility.reference_tear_pressure", "Pa", upper, "", tear_pressure},
    StepRule{"hot_tears", warning, goes_on, "plausibility.maximum_mush_strain", "1", upper, "", mush_strain},
    StepRule{"curl_outside_band", warning, goes_on, "plausibility.greatest_curl", "m", upper, "curl", curl_above_range},
    StepRule{"curl_outside_band", warning, goes_on, "plausibility.least_curl", "m", lower, "curl", curl_below_range},
};
// clang-format on

}  // namespace

std::span<const StepRule> step_rules() {
  return rules;
}

}  // namespace dccast::casting
