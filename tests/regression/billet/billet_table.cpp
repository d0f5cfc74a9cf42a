// Prints what the billet's README shows: measured and computed isotherm depths, their convergence,
// the wall's heat against what comes in, and what the depths depend on.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/material/thermal_properties.hpp"
#include "tests/regression/billet/billet_run.hpp"
#include "tests/support/load_case.hpp"

namespace {

using namespace dccast;
using regression::BilletRun;

double relative(double ours, double measured) {
  return 100.0 * (ours / measured - 1.0);
}

void print_depths(const std::vector<BilletRun>& run) {
  const std::size_t last = run.size() - 1, shipped = std::min<std::size_t>(1, last);
  std::puts(
      "| radius [m] | isotherm [degC] | measured [m] | as shipped [m] | finest [m] | "
      "extrapolated [m] | difference [mm] | [%] |\n|---|---|---|---|---|---|---|---|");
  for (std::size_t i = 0; i < regression::measured_isotherms().size(); ++i) {
    const auto& m = regression::measured_isotherms()[i];
    const double limit = last == 0
                             ? run[0].depth[i]
                             : regression::extrapolated(run[last - 1].depth[i], run[last].depth[i]);
    std::printf("| %g | %g | %.4f | %.4f | %.4f | %.4f | %+.1f | %+.1f |\n", m.radius,
                m.temperature, m.depth, run[shipped].depth[i], run[last].depth[i], limit,
                1e3 * (limit - m.depth), relative(limit, m.depth));
  }
}

void print_checks(const BilletRun& run, int refinement) {
  std::printf("| %d | %d | %d | %.2f | %.2f | %.2f | %.2f | %+.2f | %.1e |\n", refinement,
              run.nodes, run.steps, 100.0 * run.still, 1e-3 * run.metal_heat, 1e-3 * run.top_heat,
              1e-3 * run.wall_heat, 100.0 * run.wall_error(), run.worst_balance);
}

void print_variants(const casting::Case& billet) {
  constexpr double isotherm[] = {600.0, 547.8, 400.0, 200.0};
  std::puts(
      "\n| on the axis [m] | 600 degC | 547.8 degC | 400 degC | 200 degC |\n|---|---|---|---|---|");
  const auto& measured = regression::measured_isotherms();
  const auto row = [&](const char* name, auto&& depth) {
    std::printf("| %s |", name);
    for (const double t : isotherm) {
      const auto at = std::find_if(measured.begin(), measured.end(), [&](const auto& m) {
        return m.radius == 0.0 && m.temperature == t;
      });
      std::printf(" %.3f |", depth(std::size_t(at - measured.begin())));
    }
    std::puts("");
  };
  row("measured", [&](std::size_t i) { return measured[i].depth; });
  for (const auto& variant : regression::variants(billet)) {
    const BilletRun run = regression::run_billet(variant.billet);
    row(variant.name.c_str(), [&](std::size_t i) { return run.depth[i]; });
    std::fflush(stdout);
  }
}

/// Root mean square of the relative errors over every other measured depth inside the billet [%]:
/// at the surface the water decides, and 640 degC is the liquidus. @param first  0 or 1
double error_of_half(const BilletRun& run, std::size_t first) {
  double sum = 0.0;
  std::size_t at = 0, count = 0;
  for (std::size_t i = 0; i < regression::measured_isotherms().size(); ++i) {
    const auto& m = regression::measured_isotherms()[i];
    if (m.radius > 0.2 || m.temperature >= 640.0 || at++ % 2 != first) continue;
    sum += std::pow(relative(run.depth[i], m.depth), 2);
    ++count;
  }
  return std::sqrt(sum / double(count));
}

/// Stirring of the melt is not in the data: it is chosen on every other measured depth and judged
/// on those between.
void print_stirring(casting::Case billet) {
  std::puts(
      "\n| factor above fl 0.8 | level | chosen on these: rms [%] | judged on these: rms [%] "
      "|\n|---|---|---|---|");
  for (const auto top : {thermal::Top::pouring, thermal::Top::held}) {
    for (const double factor : {1.0, 3.0, 6.0, 10.0, 15.0, 20.0}) {
      billet.cooling.top = top;
      billet.alloy.melt_conductivity_factor =
          Curve(Abscissa::liquid_fraction, {0.3, 0.8}, {1.0, factor});
      const BilletRun run = regression::run_billet(billet);
      std::printf("| %g | %s | %.1f | %.1f |\n", factor,
                  top == thermal::Top::held ? "held" : "own heat", error_of_half(run, 0),
                  error_of_half(run, 1));
      std::fflush(stdout);
    }
  }
}

/// The law of size, its gain chosen on the billet of 450 mm, in both billets.
void print_stirring_by_size(const casting::Case& wide, const casting::Case& narrow) {
  std::puts(
      "\n| gain at 450 mm | factor at 450 mm | chosen on these: rms [%] | judged on these: rms [%] "
      "| factor at 155 mm | AA6008: mean; rms [mm] |\n|---|---|---|---|---|---|");
  for (const double gain : {0.0, 3.0, 6.0, 9.0, 12.0, 19.0}) {
    const auto stirred = [&](casting::Case billet) {
      billet.alloy.melt_conductivity_factor =
          material::melt_stirring(gain, 2.0 * billet.section.half_width);
      return billet;
    };
    const casting::Case both[] = {stirred(wide), stirred(narrow)};
    const BilletRun wide_run = regression::run_billet(both[0]);
    const auto& measured = regression::measured_in_aa6008();
    const regression::DepthError narrow_error =
        regression::depth_error(regression::run_billet(both[1], measured), measured);

    std::printf("| %g | %.1f | %.1f | %.1f | %.2f | %+.1f; %.1f |\n", gain,
                both[0].alloy.melt_conductivity_factor(1.0), error_of_half(wide_run, 0),
                error_of_half(wide_run, 1), both[1].alloy.melt_conductivity_factor(1.0),
                1e3 * narrow_error.mean, 1e3 * narrow_error.root_mean_square);
    std::fflush(stdout);
  }
}

/// Depths in the billet of AA6008 with the melt at rest, for getdp_billet.py: as JSON by entry.
void print_rest() {
  casting::Case narrow = support::load_case(DCCAST_AA6008);
  narrow.alloy.melt_conductivity_factor = Curve(1.0);
  const BilletRun run = regression::run_billet(narrow, regression::measured_in_aa6008());
  std::cout << nlohmann::json{{"billet-aa6008-155", run.depth}};
}

/// Depths of both billets with their uncertain data drawn, as JSON by entry of the record, for
/// tests/verification/record/ours.py.
void print_ensembles(int members) {
  const casting::Case wide = regression::refined(support::load_case("billet"), 1);
  const casting::Case narrow = regression::refined(support::load_case(DCCAST_AA6008), 1);
  std::cout << nlohmann::json{
      {"billet-al6cu-450",
       regression::depth_ensemble(wide, regression::measured_isotherms(), members)},
      {"billet-aa6008-155",
       regression::depth_ensemble(narrow, regression::measured_in_aa6008(), members)}};
}

}  // namespace

/// dccast-billet ensemble MEMBERS: what data leave open of the depths.
/// dccast-billet rest: one billet, its melt at rest.
/// dccast-billet [FINEST]: mesh.refinement 1, 2 (as shipped), 4 up to FINEST (default 2).
int main(int count, char** argument) {
  if (count == 3 && std::string(argument[1]) == "ensemble") {
    print_ensembles(std::clamp(std::atoi(argument[2]), 2, 1000));
    return 0;
  }
  if (count == 2 && std::string(argument[1]) == "rest") {
    print_rest();
    return 0;
  }
  const int finest = count > 1 ? std::atoi(argument[1]) : 2;
  if (finest < 1 || finest > 16) {
    std::fputs("usage: dccast-billet [FINEST | ensemble MEMBERS | rest]   FINEST 1 to 16\n",
               stderr);
    return 2;
  }
  const casting::Case billet = support::load_case("billet");
  std::vector<BilletRun> run;
  std::puts(
      "| refinement | nodes | steps | moved in 100 s [%] | metal [kW/rad] | top [kW/rad] | "
      "wall [kW/rad] | in - out [%] | worst energy balance "
      "|\n|---|---|---|---|---|---|---|---|---|");
  for (int refinement = 1; refinement <= finest; refinement *= 2) {
    run.push_back(regression::run_billet(regression::refined(billet, refinement)));
    print_checks(run.back(), refinement);
    std::fflush(stdout);
  }
  std::puts("");
  print_depths(run);
  print_variants(billet);
  print_stirring(regression::refined(billet, 1));
  print_stirring_by_size(regression::refined(billet, 1), support::load_case(DCCAST_AA6008));
}
