#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/casting/case.hpp"
#include "core/casting/plausibility/placed_figure.hpp"
#include "core/mechanics/slab_state.hpp"
#include "core/mesh/mesh.hpp"
#include "core/results/step_report.hpp"
#include "core/results/validity_loss.hpp"

namespace dccast::casting {

/// An accepted step, as findings are measured from it.
template <int Dim>
struct StepView {
  const results::StepReport& report;  ///< all but what is measured here
  double metal_level = 0.0;           ///< [m]
  const mesh::Mesh<Dim>& mesh;
  std::span<const double> temperature;  ///< (node) [°C]
  const mechanics::SlabState<Dim>& slab;
  int growing = 0;                         ///< first element of the row that still stretches
  std::span<const double> monitor_lift{};  ///< [m] upwards; not finite where there is no metal yet
  const std::optional<results::ValidityLoss>& validity_lost;
};

/// What findings judge a step by; it knows no dimension.
struct StepFigures {
  double time = 0.0;             ///< [s]
  bool moves = false;            ///< the block does: the hold is over
  bool last = false;             ///< the casting ends with this step
  bool mechanical = false;       ///< displacements are computed
  double metal_depth = 0.0;      ///< [m] from the bottom to the metal level
  double sump_depth = 0.0;       ///< [m]
  bool left_mould = false;       ///< metal that the mould held has passed its exit
  PlacedFigure exit_surface;     ///< [°C] hottest of the side at the mould exit, or at the foot
  PlacedFigure exit_shell;       ///< [m] there
  bool in_gap = false;           ///< the foot is below the mould contact, and there is an air gap
  double gap_entry = 0.0;        ///< [°C] hottest of the side at the end of the mould contact
  PlacedFigure gap_surface;      ///< [°C] hottest of the side between there and the mould exit
  PlacedFigure bottom_shell;     ///< [m]
  double gap_under_shell = 0.0;  ///< [m] of the bottom under its thinnest place
  double thickest_bottom_shell = 0.0;  ///< [m] it has been since the block moves
  PlacedFigure mush_strain;            ///< [1]
  PlacedFigure lift;                   ///< [m] largest of the bottom
  double rotation = 0.0;               ///< [rad]
  double slip = 0.0;                   ///< [m]
  double greatest_curl = 0.0;          ///< [m] of all monitors
  std::optional<results::ValidityLoss> validity_lost;
};

/// Distance of the mould exit below the metal level [m]: where the water begins.
double mould_exit(const Case& casting_case);
/// Distance below the metal level [m] at which the mould contact, the uppermost zone, ends; that of
/// the mould exit where there is no zone.
double contact_end(const Case& casting_case);

/// @param thickest_bottom_shell  [m] before this step; brought up to date
template <int Dim>
StepFigures figures_of(const Case& casting_case, const StepView<Dim>& view,
                       double& thickest_bottom_shell);

extern template StepFigures figures_of(const Case&, const StepView<2>&, double&);
extern template StepFigures figures_of(const Case&, const StepView<3>&, double&);

}  // namespace dccast::casting
