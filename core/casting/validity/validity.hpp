#pragma once

#include <optional>
#include <span>

#include "core/casting/case.hpp"
#include "core/casting/validity/extreme.hpp"
#include "core/casting/validity/validity_state.hpp"
#include "core/material/mechanical_properties.hpp"
#include "core/mechanics/slab_state.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// An accepted mechanical step.
template <int Dim>
struct JudgedStep {
  double time = 0.0;  ///< [s]
  const mesh::Mesh<Dim>& mesh;
  const mechanics::SlabState<Dim>& slab;
  std::span<const double> temperature;  ///< (node) [°C]
  int growing = 0;                      ///< first element of the row that still stretches
  Extreme liquid_pressure_error;        ///< relative, and the place of the worst cell
};

/// How far the solid has moved in a step.
struct SolidMotion {
  double rotation = 0.0;  ///< largest_rotation() [rad]
  double slip = 0.0;      ///< largest_slip() [m]
};

/// Judges each step by the limits of the case, one function per finding, whose
/// computation is a file of its own. Of several findings in one
/// step the one nearest to the cause comes first: shell, motion, pressure.
template <int Dim>
class ValidityJudge {
public:
  explicit ValidityJudge(const Case& casting_case);

  /// Brings the state up to date; a first loss is put into it.
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
  bool judges_rotation_;  ///< with small strains only
  double solid_below_;    ///< [°C]
};

extern template class ValidityJudge<2>;
extern template class ValidityJudge<3>;

}  // namespace dccast::casting
