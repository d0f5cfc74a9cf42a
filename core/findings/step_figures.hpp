#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/case/case.hpp"
#include "core/findings/placed_figure.hpp"
#include "core/mechanics/slab_state.hpp"
#include "core/mesh/mesh.hpp"
#include "core/results/step_report.hpp"
#include "core/results/validity_loss.hpp"

namespace dccast::casting {

/// An accepted step: input of the figures that findings are judged by.
template <int Dim>
struct StepView {
  const results::StepReport& report;  ///< complete except for the figures computed here
  double metal_level = 0.0;           ///< [m]
  const mesh::Mesh<Dim>& mesh;
  std::span<const double> temperature;  ///< (node) [°C]
  const mechanics::SlabState<Dim>& slab;
  int growing = 0;                         ///< first element of the row that still stretches
  std::span<const double> monitor_lift{};  ///< [m] upwards; not finite if there is no metal yet
  const std::optional<results::ValidityLoss>& validity_lost;
};

/// The figures of a step that findings are judged by, for any dimension.
struct StepFigures {
  double time = 0.0;          ///< [s]
  bool moves = false;         ///< the block moves: the hold is over
  bool last = false;          ///< the casting ends with this step
  bool mechanical = false;    ///< displacements are computed
  double metal_depth = 0.0;   ///< [m] from the bottom to the metal level
  double sump_depth = 0.0;    ///< [m]
  bool left_mould = false;    ///< metal that was held by the mould has left it
  PlacedFigure exit_surface;  ///< [°C] hottest point of the side at the mould exit, or at the butt
  PlacedFigure exit_shell;    ///< [m] shell thickness there
  bool in_gap = false;        ///< the butt is below the mould contact, and there is an air gap
  double gap_entry = 0.0;     ///< [°C] hottest point of the side at the end of the mould contact
  PlacedFigure gap_surface;   ///< [°C] hottest point of the side from there to the mould exit
  PlacedFigure bottom_shell;  ///< [m]
  double gap_under_shell = 0.0;        ///< [m] gap between block and slab under the thinnest place
  double thickest_bottom_shell = 0.0;  ///< [m] largest since the block started to move
  PlacedFigure mush_strain;            ///< [1]
  PlacedFigure lift;                   ///< [m] largest lift of the bottom
  double rotation = 0.0;               ///< [rad]
  double slip = 0.0;                   ///< [m]
  double greatest_curl = 0.0;          ///< [m] largest of all monitors
  std::optional<results::ValidityLoss> validity_lost;
};

/// Distance of the mould exit, where the water begins, below the metal level [m].
double mould_exit(const Case& casting_case);
/// Distance below the metal level [m] at which the mould contact, the uppermost zone, ends; without
/// a zone that of the mould exit.
double contact_end(const Case& casting_case);

/// @param thickest_bottom_shell  [m] before this step; updated
template <int Dim>
StepFigures figures_of(const Case& casting_case, const StepView<Dim>& view,
                       double& thickest_bottom_shell);

extern template StepFigures figures_of(const Case&, const StepView<2>&, double&);
extern template StepFigures figures_of(const Case&, const StepView<3>&, double&);

}  // namespace dccast::casting
