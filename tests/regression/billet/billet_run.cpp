#include "tests/regression/billet/billet_run.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/casting/slab_run.hpp"
#include "core/material/thermal_properties.hpp"
#include "core/statistics/sampling.hpp"

namespace dccast::regression {

namespace {

using Run = casting::SlabRun<2>;

constexpr double still_over = 100.0;    // [s]
constexpr double averaged_over = 50.0;  // [s], many times what a row of cells takes to grow

/// A field of one instant on the rows and columns of the built-in mesh.
class Profile {
public:
  Profile(const Run& run)
      : mesh_(run.mesh()),
        temperature_(run.state().heat.temperature),
        columns_(std::size_t(run.growth_row())) {}

  double radius(std::size_t column) const { return mesh_.point(static_cast<int>(column))[0]; }
  double level() const { return mesh_.node.back(); }

  /// Depth at which the temperature, linear between nodes, first falls to `wanted` from above.
  double depth(double at_radius, double wanted) const {
    std::size_t right = 1;
    while (right + 1 < columns_ && radius(right) < at_radius) ++right;
    const double share = (at_radius - radius(right - 1)) / (radius(right) - radius(right - 1));
    const auto at = [&](std::size_t row) {
      const std::size_t n = row * columns_ + right;
      return (1.0 - share) * temperature_[n - 1] + share * temperature_[n];
    };
    const auto height = [&](std::size_t row) {
      return mesh_.point(static_cast<int>(row * columns_))[1];
    };
    for (std::size_t row = temperature_.size() / columns_ - 1; row > 0; --row) {
      if (at(row) < wanted || at(row - 1) >= wanted) continue;
      const double part = (at(row) - wanted) / (at(row) - at(row - 1));
      return level() - height(row) + part * (height(row) - height(row - 1));
    }
    return NAN;
  }

private:
  const mesh::Mesh2D& mesh_;
  const std::vector<double>& temperature_;
  std::size_t columns_;
};

std::vector<double> depths(const Run& run, const std::vector<Isotherm>& measured) {
  const Profile profile(run);
  std::vector<double> found;
  for (const Isotherm& m : measured) {
    found.push_back(profile.depth(m.radius, m.temperature));
  }
  return found;
}

/// Speed times the enthalpy that the metal brings and no longer has at the foot, over the section.
double heat_of_metal(const Run& run, const casting::Case& billet) {
  const material::ThermalProperties properties(billet.alloy);
  const double poured = properties.enthalpy(billet.schedule.casting_temperature(0.0));
  const auto& temperature = run.state().heat.temperature;
  double sum = 0.0;
  for (std::size_t n = 1; n < std::size_t(run.growth_row()); ++n) {
    const double left = run.mesh().point(static_cast<int>(n) - 1)[0];
    const double right = run.mesh().point(static_cast<int>(n))[0];
    const double given = poured - 0.5 * (properties.enthalpy(temperature[n - 1]) +
                                         properties.enthalpy(temperature[n]));
    sum += given * 0.5 * (right * right - left * left);
  }
  return sum * billet.schedule.casting_speed(run.state().time);
}

double largest_relative_change(const std::vector<double>& from, const std::vector<double>& to) {
  double largest = 0.0;
  for (std::size_t i = 0; i < to.size(); ++i) {
    largest = std::max(largest, std::abs(to[i] / from[i] - 1.0));
  }
  return largest;
}

/// Scheil's counterpart for complete diffusion in the solid, the lever rule, on the card's points.
Curve lever_rule(const material::AlloyCard& alloy) {
  constexpr double melting_point = 660.32, partition = 0.17;  // see the card
  std::vector<double> fraction;
  for (const double t : alloy.liquid_fraction.at()) {
    const double below = melting_point - t;
    fraction.push_back((melting_point - alloy.liquidus - partition * below) /
                       ((1.0 - partition) * below));
  }
  fraction.front() = 0.0;
  fraction.back() = 1.0;
  return Curve(Abscissa::temperature, alloy.liquid_fraction.at(), fraction);
}

/// Solid and liquid of the card, mixed by its liquid fraction.
void mix_conductivity(material::AlloyCard& alloy) {
  const double solid = alloy.conductivity(alloy.solidus);
  const double liquid = alloy.conductivity(alloy.liquidus);
  std::vector<double> mixed;
  for (const double f : alloy.liquid_fraction.value())
    mixed.push_back(solid + f * (liquid - solid));
  alloy.conductivity = Curve(Abscissa::temperature, alloy.liquid_fraction.at(), mixed);
}

/// The table with every value multiplied.
Curve times(const Curve& table, double factor) {
  std::vector<double> value = table.value();
  for (double& v : value) v *= factor;
  return {table.abscissa(), table.at(), value};
}

/// The figures of an entry of the record. @param above  [m] of the metal level over their zero
std::vector<Isotherm> read_isotherms(const std::string& entry, double above) {
  std::ifstream file(DCCAST_RECORD "/entries/" + entry + ".json");
  const auto record = nlohmann::json::parse(file);
  std::vector<Isotherm> table;
  for (const auto& figure : record.at("measured")) {
    const auto& at = figure.at("at");
    table.push_back(
        {at.at("radius_m"), at.at("temperature_c"), above + figure.at("value").get<double>()});
  }
  return table;
}

}  // namespace

const std::vector<Isotherm>& measured_isotherms() {
  static const std::vector<Isotherm> table = read_isotherms("billet-al6cu-450", 0.0);
  return table;
}

const std::vector<Isotherm>& measured_in_aa6008() {
  constexpr double level_above_ring = 0.1;  // [m] in aa6008.toml
  static const std::vector<Isotherm> table = read_isotherms("billet-aa6008-155", level_above_ring);
  return table;
}

BilletRun run_billet(const casting::Case& billet, const std::vector<Isotherm>& measured) {
  Run run(billet);
  BilletRun result;
  std::vector<double> before;
  while (!run.finished()) {
    const results::StepReport report = run.advance();
    ++result.steps;
    result.worst_balance = std::max(result.worst_balance, std::abs(report.energy_balance_error));
    if (report.time > billet.time.end - averaged_over) {
      const double by_radian = report.wall_heat_flux * billet.section.half_width;
      result.wall_heat += by_radian * report.time_step / averaged_over;
      result.top_heat +=
          report.level_heat * billet.section.half_width * report.time_step / averaged_over;
    }
    if (before.empty() && report.time >= billet.time.end - still_over)
      before = depths(run, measured);
  }
  result.depth = depths(run, measured);
  result.still = largest_relative_change(before, result.depth);
  result.metal_heat = heat_of_metal(run, billet);
  result.nodes = run.mesh().nodes();
  return result;
}

DepthError depth_error(const BilletRun& run, const std::vector<Isotherm>& measured) {
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const double error = run.depth[i] - measured[i].depth;
    sum += error;
    squares += error * error;
  }
  const double count = static_cast<double>(measured.size());
  return {sum / count, std::sqrt(squares / count)};
}

casting::Case refined(casting::Case billet, int refinement) {
  const double finer = static_cast<double>(refinement) / billet.section.refinement;
  billet.section.refinement = refinement;
  std::vector<double> step;
  for (const double dt : billet.time.step.value()) step.push_back(dt / finer);
  billet.time.step =
      step.size() == 1 ? Curve(step.front()) : Curve(Abscissa::time, billet.time.step.at(), step);
  return billet;
}

std::vector<Variant> variants(const casting::Case& billet) {
  std::vector<Variant> all{{"as shipped: Scheil, melt at rest, Weckman-Niessen", billet}};
  const auto changed = [&](const char* name) -> casting::Case& {
    return all.emplace_back(Variant{name, billet}).billet;
  };
  auto& linear = changed("liquid fraction linear");
  linear.alloy.liquid_fraction =
      Curve(Abscissa::temperature, {billet.alloy.solidus, billet.alloy.liquidus}, {0.0, 1.0});
  mix_conductivity(linear.alloy);
  auto& lever = changed("liquid fraction by the lever rule");
  lever.alloy.liquid_fraction = lever_rule(billet.alloy);
  mix_conductivity(lever.alloy);
  changed("melt conducts 3 times better above fl 0.8").alloy.melt_conductivity_factor =
      Curve(Abscissa::liquid_fraction, {0.3, 0.8}, {1.0, 3.0});
  changed("melt conducts 10 times better above fl 0.8").alloy.melt_conductivity_factor =
      Curve(Abscissa::liquid_fraction, {0.3, 0.8}, {1.0, 10.0});
  changed("metal poured at the liquidus, no superheat").schedule.casting_temperature =
      Curve(billet.alloy.liquidus);
  changed("water at 20 degC").cooling.water.temperature = Curve(20.0);
  auto& both = changed("no superheat and water at 20 degC");
  both.schedule.casting_temperature = Curve(billet.alloy.liquidus);
  both.cooling.water.temperature = Curve(20.0);
  changed("water film 5 kW/(m2 K)").cooling.water.coefficient = Curve(5e3);
  changed("water film 50 kW/(m2 K)").cooling.water.coefficient = Curve(5e4);
  auto& open_gap = changed("air gap 40 W/(m2 K) whatever freezes there").cooling.zones.at(2);
  open_gap.liquid_coefficient = open_gap.solid_coefficient;
  return all;
}

std::vector<std::vector<double>> depth_ensemble(const casting::Case& billet,
                                                const std::vector<Isotherm>& measured,
                                                int members) {
  constexpr double coldest_water = 20.0;  // [°C]
  const auto places = statistics::hypercube(members, 6, 1);
  std::vector<std::vector<double>> depths;
  for (int m = 0; m < members; ++m) {
    const auto between = [&](int axis, double low, double high) {
      return low + places(m, axis) * (high - low);
    };
    casting::Case drawn = billet;
    drawn.alloy.melt_conductivity_factor =
        material::melt_stirring(between(0, 0.0, 19.0), 2.0 * billet.section.half_width);
    drawn.cooling.water.temperature =
        Curve(between(1, coldest_water, billet.cooling.water.temperature(0.0)));
    drawn.schedule.casting_temperature =
        Curve(billet.schedule.casting_temperature(0.0) + between(2, -3.0, 3.0));
    drawn.alloy.conductivity = times(billet.alloy.conductivity, between(3, 0.95, 1.05));
    drawn.alloy.latent_heat *= between(4, 0.97, 1.03);
    for (auto& zone : drawn.cooling.zones) {
      const double factor = std::pow(1.5, between(5, -1.0, 1.0));
      zone.liquid_coefficient = times(zone.liquid_coefficient, factor);
      zone.solid_coefficient = times(zone.solid_coefficient, factor);
    }
    depths.push_back(run_billet(drawn, measured).depth);
  }
  return depths;
}

}  // namespace dccast::regression
