#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/casting/case/case.hpp"
#include "core/casting/findings/hot_tears.hpp"
#include "core/casting/findings/pores.hpp"
#include "core/casting/findings/residual_stress.hpp"
#include "core/casting/findings/shell.hpp"
#include "core/material/mechanical_properties.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/mesh.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// A cold slab off the block, without weight, above the plane that its butt rests on.
struct OffBlock {
  double curl = 0.0;     ///< [m] of output.curl, or the largest; not a number: none has metal
  double saw_off = 0.0;  ///< [m] rise of the butt where it is greatest
};

/// The mechanics of a step on its own mesh: rotations and strains of an element go with its mean
/// temperature.
template <int Dim>
struct MechanicsView {
  const mesh::Mesh<Dim>& mesh;
  const mechanics::SlabState<Dim>& slab;
  std::span<const double> element_temperature;  ///< (element) mean [°C]
  int growing = 0;                              ///< first element of the row that still stretches
};

/// An accepted step: the data from which its figures are measured, on the mesh of the heat.
template <int Dim>
struct StepView {
  double time = 0.0;         ///< [s]
  double time_step = 0.0;    ///< [s]
  double cast_length = 0.0;  ///< [m]
  double metal_level = 0.0;  ///< [m]
  /// [m] from which distances of the mould are counted: its zones, its exit and the water line
  double mould_level = 0.0;
  bool last = false;  ///< the casting ends with this step
  const mesh::Mesh<Dim>& mesh;
  const thermal::HeatStepOutcome& heat;
  std::span<const double> temperature;    ///< (node) [°C]
  const mechanics::SlabState<Dim>& slab;  ///< carried to this mesh; stresses in the last step only
  std::span<const double> creep_rate;     ///< (element) [1/s], see HotTears::creep_rates()
  const MechanicsView<Dim>& mechanics;
  const mechanics::SlabChecks& checks;  ///< of the mechanical step; ignored before the first one
  double superheat = 0.0;               ///< [J/m], [J/rad], [J] of the metal poured so far
  double level_heat = 0.0;              ///< [J/m], [J/rad], [J] in through the metal level so far
  int growing = 0;                      ///< first element of the row that still stretches
  double face_length = 1.0;             ///< forces are divided by it [m], [m/rad] or [1]
  /// (monitor, coordinate) [m]; not finite if there is no metal yet
  std::span<const std::vector<double>> monitor_displacement{};
};

/// The figures of a step from which findings follow, for any dimension.
struct StepFigures {
  double time = 0.0;                  ///< [s]
  double time_step = 0.0;             ///< [s]
  bool moves = false;                 ///< the hold is over, the casting is not
  bool last = false;                  ///< the casting ends with this step
  bool mechanical = false;            ///< displacements are computed
  bool solid_model = false;           ///< three dimensions: forces are those of the whole quarter
  double energy_balance_error = 0.0;  ///< [1] relative to the heat exchanged
  double superheat = 0.0;             ///< [J/m], [J/rad], [J] of the metal poured so far
  double level_heat = 0.0;            ///< [J/m], [J/rad], [J] in through the metal level so far
  double water_share = 0.0;           ///< [1] heat taken by the water of a face, of the most it can
  bool water_boiled_away = false;     ///< on some face too little water is left to cover it
  bool water_thrown_off = false;      ///< a vapour film has thrown the water off some face
  double weight = 0.0;                ///< [N/m], in 3D [N]
  double steam_share = 0.0;           ///< [1] force of the steam under the butt, of the weight
  double bottom_reaction = 0.0;       ///< [N/m] upwards, in 3D [N]
  double wall_share = 0.0;  ///< [1] force of the mould's wall on the shell, of the weight; a mean
  double complementarity_error = 0.0;   ///< [1] relative to 1 mm and the weight
  double metal_depth = 0.0;             ///< [m] from the bottom to the metal level
  double sump_depth = 0.0;              ///< [m]
  double mould_exit_temperature = 0.0;  ///< [°C] largest of the side at the water line
  bool left_contact = false;            ///< metal cast since the start has left the mould contact
  bool left_mould = false;              ///< metal that was held by the mould has left it
  PlacedFigure exit_surface;  ///< [°C] hottest point of the side at the water line, or at the butt
  PlacedFigure exit_shell;    ///< [m] shell thickness there
  /// [m] least shell thickness from the end of the mould contact to the water line. Above it the
  /// mould wall carries the metal, and at the meniscus there is no shell yet.
  PlacedFigure least_shell;
  double least_shell_depth = 0.0;  ///< [m] of it below the metal level
  bool in_gap = false;             ///< the butt is below the mould contact, and there is an air gap
  double gap_entry = 0.0;     ///< [°C] hottest point of the side at the end of the mould contact
  double entry_shell = 0.0;   ///< [m] shell thickness there
  PlacedFigure gap_surface;   ///< [°C] hottest point of the side from there to the water line
  PlacedFigure shell_begins;  ///< [m] mean depth below the metal level at which the side freezes
  PlacedFigure bottom_shell;  ///< [m]
  double gap_under_shell = 0.0;        ///< [m] gap between block and slab under the thinnest place
  double thickest_bottom_shell = 0.0;  ///< [m] largest since the block started to move
  /// [m] thinnest_shell(), once a closed shell has existed; empty if it is not judged, or if it is
  /// closed and has no least thickness
  std::optional<PlacedFigure> closed_shell;
  PlacedFigure mush_strain;  ///< [1]
  /// [m3/m], of a billet per metre of circumference, of a quarter slab [m3]
  double pore_volume = 0.0;
  TearIndices tears;           ///< of the metal that has left the window of hot tears
  PlacedFigure lift;           ///< [m] largest lift of the bottom
  PlacedFigure centre_lift;    ///< [m] of the bottom at the symmetry plane, axis or both planes
  double corner_lift = 0.0;    ///< [m] of the bottom farthest from there
  PlacedFigure rotation;       ///< [rad] largest of an element since it solidified
  PlacedFigure slip;           ///< [m] of the butt beyond its thermal contraction
  double greatest_curl = 0.0;  ///< [m] of output.curl, or largest of all monitors
  /// Of a slab that has cooled down, in the last step.
  std::optional<OffBlock> off_block;
  ResidualStress residual;  ///< of a slab that has cooled down, in the last step
};

/// Data of earlier steps from which figures of a step are measured.
struct FigureHistory {
  bool shell_stood = false;            ///< a closed shell has existed, so that it can melt through
  std::vector<double> when_liquid;     ///< [rad] or [1], see largest_rotation(); of the mechanics
  double thickest_bottom_shell = 0.0;  ///< [m] since the block started to move
  double wall_force = 0.0;             ///< [unit of StepFigures::weight] mean of some seconds
  std::vector<MushPassage> passages;   ///< (element), see HotTears
  // Figures of all elements, which change slowly: measured every few seconds.
  TearIndices tears;
  double pore_volume = 0.0;  ///< as in StepFigures
};

/// Measures the figures of steps, without judging them.
template <int Dim>
class StepMeter {
public:
  /// @param casting_case  must outlive the meter
  explicit StepMeter(const Case& casting_case);

  /// Measures a step. @param history  of the previous steps; updated
  StepFigures measure(const StepView<Dim>& view, FigureHistory& history) const;

  /// The indices of hot tears, for frames.
  const HotTears<Dim>& tears() const { return tears_; }

private:
  /// Shell and surface temperature at the water line.
  void measure_water_line(const StepView<Dim>& view, StepFigures& figures) const;
  /// Shell and surface temperature between mould contact and water, at a few heights.
  void measure_gap(const StepView<Dim>& view, StepFigures& figures) const;
  /// Indices of hot tears and volume of the pores, updated at intervals.
  void measure_frozen_metal(const StepView<Dim>& view, StepFigures& figures,
                            FigureHistory& history) const;
  /// Depth below the metal level at which the side is frozen.
  void measure_meniscus(const StepView<Dim>& view, StepFigures& figures) const;
  /// Shell over the bottom block, and lifts of the butt at centre, corner and highest place.
  void measure_bottom(const StepView<Dim>& view, StepFigures& figures) const;
  std::vector<char> grown_together(const MechanicsView<Dim>& view) const;  ///< (element)
  /// Checks of the mechanics, rotation, slip, pressure of the liquid, and the closed shell.
  void measure_mechanics(const StepView<Dim>& view, StepFigures& figures,
                         FigureHistory& history) const;
  /// Thickness of the shell over the bottom once it has closed.
  void measure_closed_shell(const StepView<Dim>& view, StepFigures& figures,
                            FigureHistory& history) const;

  const Case& case_;
  material::MechanicalProperties properties_;
  HotTears<Dim> tears_;
  Pores pores_;
  double isotherm_;       ///< [°C] at which metal counts as shell
  double fragile_above_;  ///< [°C] at which metal becomes tough
  double solid_below_;    ///< [°C] below which contraction counts
};

}  // namespace dccast::casting
