#include "tests/verification/heat/heat_runs.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <numbers>

#include "core/mesh/slab_mesh.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::verification {
namespace {

using thermal::CoolingSpec;
using thermal::HeatField;
using thermal::HeatSolver;
using thermal::HeatStepInput;
using thermal::HeatStepOutcome;

/// Width of the ramp that replaces a jump in a table [K].
constexpr double ramp = 1e-6;

/// A piecewise constant table against temperature: `value[i]` above `from[i]`. With density 1 it is
/// the slope of H(T).
Curve stepped_table(const std::vector<double>& from, const std::vector<double>& value) {
  std::vector<double> temperature{from.front()}, table{value.front()};
  for (std::size_t i = 1; i < from.size(); ++i) {
    temperature.insert(temperature.end(), {from[i], from[i] + ramp});
    table.insert(table.end(), {value[i - 1], value[i]});
  }
  return {Abscissa::temperature, std::move(temperature), std::move(table)};
}

material::AlloyCard metal_of(const MushyStefanData& mushy) {
  material::AlloyCard card;
  card.solidus = mushy.solidus;
  card.liquidus = mushy.liquidus;
  card.latent_heat = mushy.latent_heat;
  card.density = Curve(1.0);
  card.specific_heat =
      stepped_table({0.0, mushy.solidus, mushy.liquidus},
                    {mushy.solid_capacity, 0.5 * (mushy.solid_capacity + mushy.liquid_capacity),
                     mushy.liquid_capacity});
  card.conductivity = stepped_table(
      {0.0, mushy.solidus, mushy.liquidus},
      {mushy.solid_conductivity, mushy.mushy_conductivity, mushy.liquid_conductivity});
  return card;
}

material::AlloyCard metal_of(const StrandData& strand) {
  std::vector<double> capacity;
  for (std::size_t i = 1; i < strand.temperature.size(); ++i) {
    capacity.push_back((strand.enthalpy[i] - strand.enthalpy[i - 1]) /
                       (strand.temperature[i] - strand.temperature[i - 1]));
  }

  // All of H(T) is in the specific heat; the change of phase of the card lies above all
  // temperatures.
  material::AlloyCard card;
  card.solidus = strand.top_temperature + 1000.0;
  card.liquidus = card.solidus + 1.0;
  card.density = Curve(1.0);
  card.specific_heat =
      stepped_table({strand.temperature.begin(), strand.temperature.end() - 1}, capacity);
  card.conductivity = Curve(strand.conductivity);
  return card;
}

mesh::SectionSpec uniform_section(double width, int columns, double depth, int rows,
                                  mesh::ElementKind element) {
  mesh::SectionSpec section;
  section.half_width = width;
  section.columns = columns;
  section.side_cell = width / columns;
  section.initial_depth = depth;
  section.rows = rows;
  section.bottom_cell = depth / rows;
  section.element = element;
  return section;
}

double seconds_since(std::clock_t start) {
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// A strip with one-dimensional heat flow: its cold wall is the "metal level" at its top, and
/// depths are counted from there.
class Strip {
public:
  Strip(const material::AlloyCard& metal, const CoolingSpec& cooling, double length, int cells,
        mesh::ElementKind element)
      : slab_(uniform_section(2.0 * length / cells, 2, length, cells, element)),
        solver_(material::ThermalProperties(metal), cooling,
                thermal::make_heat_forms(slab_.mesh(), mesh::SectionKind::plane_strain)),
        length_(length) {}

  HeatSolver& solver() { return solver_; }
  int rows() const { return slab_.rows(); }
  int nodes() const { return slab_.mesh().nodes(); }
  double length() const { return length_; }
  double depth(int row) const { return length_ - slab_.row_heights()[std::size_t(rows() - row)]; }
  /// Node of the middle column; rows are counted downwards.
  std::size_t node(int row) const {
    return std::size_t((rows() - row) * slab_.nodes_per_row() + slab_.nodes_per_row() / 2);
  }

  HeatStepOutcome step(HeatField& field, double time, double time_step, double top) {
    return solver_.step(field, {time, time_step, length_, top, 0.0, {}, {}});
  }

  double temperature_at(const HeatField& field, double depth) const {
    for (int row = 1; row <= rows(); ++row) {
      if (this->depth(row) < depth) continue;
      const double share =
          (depth - this->depth(row - 1)) / (this->depth(row) - this->depth(row - 1));
      return (1.0 - share) * field.temperature[node(row - 1)] +
             share * field.temperature[node(row)];
    }
    return field.temperature[node(rows())];
  }

  /// Depth at which the temperature passes a value, linear between nodes.
  double isotherm(const HeatField& field, double temperature) const {
    for (int row = 1; row <= rows(); ++row) {
      const double above = field.temperature[node(row - 1)], below = field.temperature[node(row)];
      if ((above - temperature) * (below - temperature) > 0.0 || above == below) continue;
      const double share = (temperature - above) / (below - above);
      return depth(row - 1) + share * (depth(row) - depth(row - 1));
    }
    return NAN;
  }

  /// Depth of the solid part, by its share of the volume [m].
  double solid_depth(const HeatField& field) const {
    const auto& volume = solver_.forms().volume();
    double solid = 0.0, total = 0.0;
    for (std::size_t i = 0; i < volume.size(); ++i) {
      solid += volume[i] * (1.0 - field.liquid_fraction[i]);
      total += volume[i];
    }
    return solid / total * length_;
  }

  /// Mean absolute error of the temperature over the depth [K].
  double mean_error(const HeatField& field, const std::function<double(double)>& exact) const {
    double sum = 0.0;
    for (int row = 0; row <= rows(); ++row) {
      const double share = row == 0 || row == rows() ? 0.5 : 1.0;
      sum += share * std::abs(field.temperature[node(row)] - exact(depth(row)));
    }
    return sum / rows();
  }

private:
  mesh::SlabMesh2D slab_;
  HeatSolver solver_;
  double length_;
};

constexpr double steady_change = 1e-7;  // [K] in a step

/// A strand in the frame of its metal level, on a strip of fixed length.
class MovingStrand {
public:
  MovingStrand(const StrandData& strand, int cells)
      : strand_(strand),
        time_step_(strand.length / cells / strand.speed),
        strip_(metal_of(strand), cold_at_the_bottom(strand, cells), strand.length, cells,
               mesh::ElementKind::q1),
        row_nodes_(strip_.nodes() / (cells + 1)),
        field_(strip_.solver().uniform_field(strand.top_temperature)) {}

  const Strip& strip() const { return strip_; }
  const HeatField& field() const { return field_; }

  /// Starts from the exact profile, to save steps: the steady state does not depend on it.
  void start_from(const StrandSolution& exact) {
    for (int row = 0; row <= strip_.rows(); ++row) {
      const double depth = std::min(strip_.depth(row), strand_.length);
      std::fill_n(field_.enthalpy.begin() + (strip_.rows() - row) * row_nodes_, row_nodes_,
                  strip_.solver().properties().enthalpy(exact.temperature(depth)));
    }
    strip_.solver().refresh(field_);
  }

  /// One step. @return largest change of a temperature [K]
  double advance(RunSize& size) {
    const std::vector<double> before = field_.temperature;

    // The level rises by a cell: relative to the level all metal sinks by one row.
    auto& enthalpy = field_.enthalpy;
    std::rotate(enthalpy.begin(), enthalpy.begin() + row_nodes_, enthalpy.end());
    std::fill(enthalpy.end() - row_nodes_, enthalpy.end(),
              strip_.solver().properties().enthalpy(strand_.top_temperature));

    time_ += time_step_;
    take(size, strip_.step(field_, time_, time_step_, strand_.top_temperature));

    double change = 0.0;
    for (std::size_t n = 0; n < before.size(); ++n) {
      change = std::max(change, std::abs(field_.temperature[n] - before[n]));
    }
    return change;
  }

private:
  static CoolingSpec cold_at_the_bottom(const StrandData& strand, int cells) {
    CoolingSpec cooling = insulated();
    // Practically a prescribed temperature: the conductance of a cell is k / cell.
    cooling.bottom_block.contact_coefficient =
        Curve(1e6 * strand.conductivity * cells / strand.length);
    cooling.bottom_block.temperature = Curve(strand.bottom_temperature);
    return cooling;
  }

  StrandData strand_;
  double time_step_;
  double time_ = 0.0;
  Strip strip_;
  std::ptrdiff_t row_nodes_;
  HeatField field_;
};

void measure_profile(StrandFigures& figures) {
  figures.largest_temperature_error = figures.mean_temperature_error = 0.0;
  for (std::size_t i = 0; i < figures.depth.size(); ++i) {
    const double error = std::abs(figures.temperature[i] - figures.exact[i]);
    figures.largest_temperature_error = std::max(figures.largest_temperature_error, error);
    figures.mean_temperature_error += error / static_cast<double>(figures.depth.size());
  }
}

constexpr double probe_depth = 0.010;  // [m]
constexpr double first_zero_of_j1 = 3.8317059702075123;

int count_cells(const StripSpec& strip) {
  return static_cast<int>(std::lround(strip.length / strip.cell));
}

}  // namespace

material::AlloyCard metal_of(const StefanData& stefan) {
  material::AlloyCard card;
  card.solidus = card.liquidus = stefan.change;
  card.latent_heat = stefan.latent_heat;
  card.density = Curve(1.0);
  card.specific_heat = {Abscissa::temperature,
                        {stefan.change - ramp, stefan.change},
                        {stefan.solid_capacity, stefan.liquid_capacity}};
  card.conductivity = Curve(stefan.solid_conductivity);
  card.melt_conductivity_factor = {Abscissa::liquid_fraction,
                                   {0.0, 1.0},
                                   {1.0, stefan.liquid_conductivity / stefan.solid_conductivity}};
  return card;
}

/// Cooling without heat exchange, to which the caller adds.
CoolingSpec insulated() {
  CoolingSpec cooling;
  cooling.top = thermal::Top::held;
  cooling.bottom_block.contact_coefficient = Curve(0.0);
  cooling.bottom_block.temperature = Curve(0.0);
  return cooling;
}

void take(RunSize& size, const HeatStepOutcome& outcome) {
  ++size.steps;
  size.iterations += outcome.iterations;
  size.worst_balance = std::max(size.worst_balance, outcome.balance.error);
  size.converged = size.converged && outcome.converged;
}

StefanFigures run_stefan(const StefanData& stefan, const StripSpec& spec) {
  const std::clock_t start = std::clock();
  const NeumannSolution exact(stefan);
  Strip strip(metal_of(stefan), insulated(), spec.length, count_cells(spec), spec.element);

  StefanFigures figures;
  figures.similarity_constant = exact.similarity_constant();
  HeatField field = strip.solver().uniform_field(stefan.initial);

  const int steps = static_cast<int>(std::lround(spec.end / spec.time_step));
  const int first_sample = static_cast<int>(std::lround(1.0 / spec.time_step));
  for (int i = 1; i <= steps; ++i) {
    const double time = i * spec.time_step;
    take(figures.size, strip.step(field, time, spec.time_step, stefan.wall));
    if (i != first_sample && i != steps) continue;
    figures.front.push_back({time, strip.solid_depth(field), exact.front(time)});
  }

  figures.probe_temperature = strip.temperature_at(field, probe_depth);
  figures.probe_exact = exact.temperature(probe_depth, spec.end);
  figures.mean_temperature_error =
      strip.mean_error(field, [&](double depth) { return exact.temperature(depth, spec.end); });
  figures.size.nodes = strip.nodes();
  figures.size.cpu_s = seconds_since(start);
  return figures;
}

MushyFigures run_mushy_stefan(const MushyStefanData& mushy, const StripSpec& spec) {
  const std::clock_t start = std::clock();
  const MushySolution exact(mushy);
  Strip strip(metal_of(mushy), insulated(), spec.length, count_cells(spec), spec.element);

  MushyFigures figures;
  HeatField field = strip.solver().uniform_field(mushy.initial);
  const int steps = static_cast<int>(std::lround(spec.end / spec.time_step));
  for (int i = 1; i <= steps; ++i) {
    take(figures.size, strip.step(field, i * spec.time_step, spec.time_step, mushy.wall));
  }

  figures.solidus = {spec.end, strip.isotherm(field, mushy.solidus), exact.solidus_front(spec.end)};
  figures.liquidus = {spec.end, strip.isotherm(field, mushy.liquidus),
                      exact.liquidus_front(spec.end)};
  figures.probe_temperature = strip.temperature_at(field, probe_depth);
  figures.probe_exact = exact.temperature(probe_depth, spec.end);
  figures.mean_temperature_error =
      strip.mean_error(field, [&](double depth) { return exact.temperature(depth, spec.end); });
  figures.size.nodes = strip.nodes();
  figures.size.cpu_s = seconds_since(start);
  return figures;
}

StrandFigures run_strand(const StrandData& strand, int cells) {
  const std::clock_t start = std::clock();
  const StrandSolution exact(strand);
  MovingStrand moving(strand, cells);
  moving.start_from(exact);

  // Steps until the profile is steady.
  StrandFigures figures;
  double change = INFINITY;
  for (int i = 1; change > steady_change && i < 100 * cells && figures.size.converged; ++i) {
    change = moving.advance(figures.size);
  }
  figures.size.converged = figures.size.converged && change <= steady_change;

  const Strip& strip = moving.strip();
  for (int row = 0; row <= cells; ++row) {
    figures.depth.push_back(strip.depth(row));
    figures.temperature.push_back(moving.field().temperature[strip.node(row)]);
    figures.exact.push_back(exact.temperature(strip.depth(row)));
  }

  for (const double t : strand.temperature) {
    if (t >= strand.top_temperature || t <= strand.bottom_temperature) continue;
    figures.isotherm.push_back({0.0, strip.isotherm(moving.field(), t), exact.depth(t)});
  }

  measure_profile(figures);
  figures.size.nodes = strip.nodes();
  figures.size.cpu_s = seconds_since(start);
  return figures;
}

StrandFigures run_strand_extrapolated(const StrandData& strand, int cells) {
  StrandFigures coarse = run_strand(strand, cells);
  const StrandFigures fine = run_strand(strand, 2 * cells);

  // Richardson extrapolation of a first-order error.
  for (std::size_t i = 0; i < coarse.depth.size(); ++i) {
    coarse.temperature[i] = 2.0 * fine.temperature[2 * i] - coarse.temperature[i];
  }
  measure_profile(coarse);
  for (std::size_t i = 0; i < coarse.isotherm.size(); ++i) {
    coarse.isotherm[i].computed = 2.0 * fine.isotherm[i].computed - coarse.isotherm[i].computed;
  }

  coarse.size.steps += fine.size.steps;
  coarse.size.iterations += fine.size.iterations;
  coarse.size.cpu_s += fine.size.cpu_s;
  coarse.size.nodes = fine.size.nodes;
  coarse.size.worst_balance = std::max(coarse.size.worst_balance, fine.size.worst_balance);
  coarse.size.converged = coarse.size.converged && fine.size.converged;
  return coarse;
}

CosineFigures run_cosine_mode(int cells, int steps, mesh::ElementKind element,
                              mesh::SectionKind kind) {
  const std::clock_t start = std::clock();
  const double side = 0.1, diffusivity = 1e-4, end = 5.0;  // [m], [m2/s], [s]
  const double mean = 300.0, amplitude = 100.0;            // [°C], [K]

  material::AlloyCard card;
  card.solidus = 600.0;
  card.liquidus = 650.0;
  card.density = Curve(2500.0);
  card.specific_heat = Curve(1000.0);
  card.conductivity = Curve(diffusivity * 2500.0 * 1000.0);

  CoolingSpec cooling = insulated();
  cooling.top = thermal::Top::insulated;
  const mesh::SlabMesh2D slab(uniform_section(side, cells, side, cells, element));
  HeatSolver solver(material::ThermalProperties(card), cooling,
                    thermal::make_heat_forms(slab.mesh(), kind));

  // An eigenmode of the insulated body: cosine or Bessel function across, cosine along.
  const bool round = kind == mesh::SectionKind::axisymmetric;
  const double across = round ? first_zero_of_j1 : std::numbers::pi;
  const auto mode = [&](int node) {
    const double* x = slab.mesh().point(node);
    const double radial = across * x[0] / side;
    return (round ? std::cyl_bessel_j(0.0, radial) : std::cos(radial)) *
           std::cos(std::numbers::pi * x[1] / side);
  };

  HeatField field = solver.uniform_field(mean);
  for (int n = 0; n < slab.mesh().nodes(); ++n) {
    field.enthalpy[std::size_t(n)] = solver.properties().enthalpy(mean + amplitude * mode(n));
  }

  CosineFigures figures;
  const double time_step = end / steps;
  for (int i = 1; i <= steps; ++i) {
    take(figures.size, solver.step(field, {i * time_step, time_step, side, mean, 0.0, {}, {}}));
  }

  // Relative error in the L2 norm against the exact decay.
  const double decay = std::exp(-diffusivity * end / (side * side) *
                                (across * across + std::numbers::pi * std::numbers::pi));
  const auto& volume = solver.forms().volume();
  double error_square = 0.0, exact_square = 0.0;
  for (int n = 0; n < slab.mesh().nodes(); ++n) {
    const std::size_t i = std::size_t(n);
    const double exact = amplitude * decay * mode(n);
    const double error = field.temperature[i] - mean - exact;
    error_square += volume[i] * error * error;
    exact_square += volume[i] * exact * exact;
  }
  figures.error = std::sqrt(error_square / exact_square);
  figures.size.nodes = slab.mesh().nodes();
  figures.size.cpu_s = seconds_since(start);
  return figures;
}

double observed_order(double coarse_error, double fine_error, double ratio) {
  return std::log(coarse_error / fine_error) / std::log(ratio);
}

}  // namespace dccast::verification
