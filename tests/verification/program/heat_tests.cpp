#include "tests/verification/program/heat_tests.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace dccast::verification {

namespace {

Result figures_of(const RunSize& size, std::map<std::string, double> more) {
  if (!size.converged) return Failed{0.0, "a heat step did not converge"};
  Figures figures;
  figures.displacement_error = figures.stress_error = std::numeric_limits<double>::quiet_NaN();
  figures.iterations_per_step = size.steps > 0 ? double(size.iterations) / size.steps : 0.0;
  figures.cpu_s = size.cpu_s;
  figures.nodes = size.nodes;
  figures.steps = size.steps;
  figures.more = std::move(more);
  figures.more["worst_energy_balance_error"] = size.worst_balance;
  return figures;
}

StripSpec strip_of(const RunRequest& request) {
  StripSpec strip;
  if (request.cells > 0) strip.cell = strip.length / request.cells;
  strip.time_step = request.dt.value_or(strip.time_step);
  strip.element = request.element;
  return strip;
}

double positive(const nlohmann::json& data, const char* key) {
  const double value = data.at(key).get<double>();
  if (!(value > 0.0)) throw std::invalid_argument(std::string(key) + " must be positive");
  return value;
}

void check(const StrandData& strand) {
  const auto increasing = [](const std::vector<double>& v) {
    return std::adjacent_find(v.begin(), v.end(), std::greater_equal<>()) == v.end();
  };
  if (strand.temperature.size() < 2 || strand.temperature.size() != strand.enthalpy.size() ||
      !increasing(strand.temperature) || !increasing(strand.enthalpy)) {
    throw std::invalid_argument(
        "temperature_c and enthalpy_j_per_m3 must be two increasing lists of the same length");
  }
  if (!(strand.top_temperature > strand.bottom_temperature)) {
    throw std::invalid_argument("top_temperature_c must exceed bottom_temperature_c");
  }
  if (strand.top_temperature > strand.temperature.back() ||
      strand.bottom_temperature < strand.temperature.front()) {
    throw std::invalid_argument("temperature_c must reach from bottom to top temperature");
  }
}

}  // namespace

StrandData read_strand(const std::filesystem::path& file) {
  try {
    std::ifstream in(file);
    if (!in) throw std::invalid_argument("cannot be opened");
    const auto data = nlohmann::json::parse(in);
    StrandData strand;
    strand.conductivity = positive(data, "conductivity_w_per_m_k");
    strand.speed = positive(data, "speed_m_per_s");
    strand.length = positive(data, "length_m");
    strand.top_temperature = data.at("top_temperature_c").get<double>();
    strand.bottom_temperature = data.at("bottom_temperature_c").get<double>();
    strand.temperature = data.at("temperature_c").get<std::vector<double>>();
    strand.enthalpy = data.at("enthalpy_j_per_m3").get<std::vector<double>>();
    check(strand);
    return strand;
  } catch (const std::exception& e) {
    throw std::invalid_argument(file.string() + ": " + e.what());
  }
}

Result run_stefan_by_name(const RunRequest& request) {
  const StefanFigures stefan = run_stefan({}, strip_of(request));
  double front = 0.0;
  for (const FrontFigure& f : stefan.front) front = std::max(front, std::abs(f.relative_error()));
  return figures_of(stefan.size, {{"similarity_constant", stefan.similarity_constant},
                                  {"front_error", front},
                                  {"front_m", stefan.front.back().computed},
                                  {"front_exact_m", stefan.front.back().exact},
                                  {"temperature_c", stefan.probe_temperature},
                                  {"temperature_exact_c", stefan.probe_exact},
                                  {"temperature_error_k",
                                   std::abs(stefan.probe_temperature - stefan.probe_exact)},
                                  {"mean_temperature_error_k", stefan.mean_temperature_error}});
}

Result run_mushy_stefan_by_name(const RunRequest& request) {
  const MushyFigures mushy = run_mushy_stefan({}, strip_of(request));
  return figures_of(mushy.size,
                    {{"solidus_front_error", std::abs(mushy.solidus.relative_error())},
                     {"liquidus_front_error", std::abs(mushy.liquidus.relative_error())},
                     {"solidus_front_m", mushy.solidus.computed},
                     {"liquidus_front_m", mushy.liquidus.computed},
                     {"temperature_error_k", std::abs(mushy.probe_temperature - mushy.probe_exact)},
                     {"mean_temperature_error_k", mushy.mean_temperature_error}});
}

Result run_strand_by_name(const RunRequest& request) {
  const StrandData strand = request.data.empty() ? StrandData{} : read_strand(request.data);
  const StrandFigures run =
      run_strand_extrapolated(strand, request.cells > 0 ? request.cells : 200);
  double worst = 0.0;
  std::map<std::string, double> more{{"largest_temperature_error_k", run.largest_temperature_error},
                                     {"mean_temperature_error_k", run.mean_temperature_error},
                                     {"heat_flow_w_per_m2", StrandSolution(strand).heat_flow()}};
  for (std::size_t i = 0; i < run.isotherm.size(); ++i) {
    const std::string key = "isotherm_" + std::to_string(i + 1);
    worst = std::max(worst, std::abs(run.isotherm[i].relative_error()));
    more[key + "_depth_m"] = run.isotherm[i].computed;
    more[key + "_exact_depth_m"] = run.isotherm[i].exact;
  }
  more["isotherm_error"] = worst;
  return figures_of(run.size, std::move(more));
}

Result run_decaying_mode_by_name(const RunRequest& request) {
  const int cells = request.cells > 0 ? request.cells : 16;
  const CosineFigures mode = run_cosine_mode(cells, 160, request.element);
  return figures_of(mode.size, {{"temperature_error", mode.error}});
}

}  // namespace dccast::verification
