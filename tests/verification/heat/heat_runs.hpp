#pragma once

#include <optional>
#include <vector>

#include "core/mesh/section_spec.hpp"
#include "core/thermal/heat_solver.hpp"
#include "tests/verification/heat/exact_solutions.hpp"

/// The heat solver against the exact solutions, each as a plain function from data and mesh to
/// figures. All run the solver a casting runs; nothing of it is bypassed.
namespace dccast::verification {

/// Size and cost of a run.
struct RunSize {
  int nodes = 0;
  int steps = 0;
  long iterations = 0;
  double cpu_s = 0.0;
  double worst_balance = 0.0;  ///< energy balance of a step, relative to the heat that moved
  bool converged = true;       ///< every step did
};

/// A position of a front, computed and exact [m].
struct FrontFigure {
  double time = 0.0;  ///< [s]
  double computed = 0.0;
  double exact = 0.0;
  double relative_error() const { return computed / exact - 1.0; }
};

struct StefanFigures {
  double similarity_constant = 0.0;
  std::vector<FrontFigure> front;                     ///< after 1 s and at the end
  double probe_temperature = 0.0, probe_exact = 0.0;  ///< [°C] 10 mm deep at the end
  double mean_temperature_error = 0.0;                ///< [K] mean over the strip at the end
  RunSize size;
};

/// How a strip is divided: cells of `cell` [m], steps of `time_step` [s].
struct StripSpec {
  double cell = 0.25e-3;
  double time_step = 0.01;
  double length = 0.08;  ///< [m] deep enough that the far end feels nothing
  double end = 6.0;      ///< [s]
  mesh::ElementKind element = mesh::ElementKind::p1;
};

/// Isothermal change; the front is where the solid of the strip would end if it were compact, which
/// is its content of solid, as sharp as the discretisation knows it.
StefanFigures run_stefan(const StefanData& stefan, const StripSpec& strip);

/// Metal of density 1 with the data of the problem.
material::AlloyCard metal_of(const StefanData& stefan);
/// No heat passes but through what the caller opens, and through a pouring top.
thermal::CoolingSpec insulated();
/// Counts a step.
void take(RunSize& size, const thermal::HeatStepOutcome& outcome);

struct MushyFigures {
  FrontFigure solidus, liquidus;                      ///< at the end, by the nodal temperatures
  double probe_temperature = 0.0, probe_exact = 0.0;  ///< [°C] 10 mm deep at the end
  double mean_temperature_error = 0.0;                ///< [K]
  RunSize size;
};
MushyFigures run_mushy_stefan(const MushyStefanData& mushy, const StripSpec& strip);

struct StrandFigures {
  double largest_temperature_error = 0.0;  ///< [K] over the nodes
  double mean_temperature_error = 0.0;     ///< [K]
  /// [m] depth below the metal level at which the temperature of each inner point of H(T) stands.
  std::vector<FrontFigure> isotherm;
  std::vector<double> depth, temperature, exact;  ///< profile by node [m, °C, °C]
  RunSize size;
};

/// Steady strand in `cells` cells. The metal stands still in the solver, as in a casting: in every
/// step the level rises by one cell, whose metal comes at the top's temperature, and the lowest
/// cell is cut off; repeated until a step changes no temperature by more than 1e-7 K. The steady
/// state is that of an upwind difference: first order in the cell.
/// @param strand  temperatures inside the table of H(T), length and speed positive
StrandFigures run_strand(const StrandData& strand, int cells);

/// The same, extrapolated from `cells` and twice as many: second order.
StrandFigures run_strand_extrapolated(const StrandData& strand, int cells);

struct CosineFigures {
  double error = 0.0;  ///< nodal L2 error relative to the mode's amplitude at the end
  RunSize size;
};

/// Decay of cos(pi x/a) cos(pi y/a) in an insulated square of constant properties, in `cells` by
/// `cells` cells and `steps` steps; in an axisymmetric section of J0(j r/a) cos(pi y/a), j the
/// first zero of J1.
CosineFigures run_cosine_mode(int cells, int steps, mesh::ElementKind element,
                              mesh::SectionKind kind = mesh::SectionKind::plane_strain);

/// Order observed between two errors when the size falls by `ratio`.
double observed_order(double coarse_error, double fine_error, double ratio = 2.0);

}  // namespace dccast::verification
