#pragma once

#include <optional>
#include <span>

#include "core/case/case.hpp"
#include "core/findings/extreme.hpp"
#include "core/findings/validity_state.hpp"
#include "core/material/mechanical_properties.hpp"
#include "core/mechanics/slab_state.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// An accepted mechanical step to be judged.
template <int Dim>
struct JudgedStep {
  double time = 0.0;  ///< [s]
  const mesh::Mesh<Dim>& mesh;
  const mechanics::SlabState<Dim>& slab;
  std::span<const double> temperature;  ///< (node) [°C]
  int growing = 0;                      ///< first element of the row that still stretches
  Extreme liquid_pressure_error;        ///< [1] relative; the place is that of the worst cell
};

/// How far the solid has moved in a step.
struct SolidMotion {
  double rotation = 0.0;  ///< largest_rotation() [rad]
  double slip = 0.0;      ///< largest_slip() [m]
};

/// Judges each step by the limits of the case. Each criterion is computed in a file of its own. If
/// a step violates several, the one closest to the cause is reported: shell, then motion, then
/// pressure.
template <int Dim>
class ValidityJudge {
public:
  explicit ValidityJudge(const Case& casting_case);

  /// Updates the state; the first loss of validity is stored in it.
  SolidMotion judge(const JudgedStep<Dim>& step, ValidityState& state) const;

private:
  std::optional<ValidityLoss> shell(const JudgedStep<Dim>& step, ValidityState& state) const;
  std::optional<ValidityLoss> rotation(const JudgedStep<Dim>& step, const Extreme& found) const;
  std::optional<ValidityLoss> slip(const JudgedStep<Dim>& step, const Extreme& found) const;
  std::optional<ValidityLoss> liquid_pressure(const JudgedStep<Dim>& step) const;

  Validity limits_;
  material::MechanicalProperties properties_;
  bool judges_shell_;
  bool judges_pressure_;
  bool judges_rotation_;  ///< only with small-strain kinematics
  double solid_below_;    ///< [°C]
};

extern template class ValidityJudge<2>;
extern template class ValidityJudge<3>;

}  // namespace dccast::casting
