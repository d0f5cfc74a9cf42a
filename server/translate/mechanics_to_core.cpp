#include "server/translate/case_parts.hpp"

namespace dccast::translate {

namespace {

mechanics::Algorithm algorithm_of(v1::Mechanics::Algorithm algorithm) {
  switch (algorithm) {
    case v1::Mechanics::VNBM:
      return mechanics::Algorithm::vnbm;
    case v1::Mechanics::SBM:
      return mechanics::Algorithm::sbm;
    case v1::Mechanics::NBM:
      return mechanics::Algorithm::nbm;
    default:
      return mechanics::Algorithm::newton;
  }
}

mechanics::Liquid liquid_of(v1::Mechanics::Liquid liquid) {
  switch (liquid) {
    case v1::Mechanics::WEAK:
      return mechanics::Liquid::weak;
    case v1::Mechanics::SOLID:
      return mechanics::Liquid::solid;
    default:
      return mechanics::Liquid::prestressed;
  }
}

/// Absent: corotational where the butt turns by several degrees, in a quarter slab.
mechanics::Kinematics kinematics_of(const v1::Case& from) {
  switch (from.mechanics().kinematics()) {
    case v1::Mechanics::SMALL_STRAIN:
      return mechanics::Kinematics::small_strain;
    case v1::Mechanics::COROTATIONAL:
      return mechanics::Kinematics::corotational;
    default:
      return from.section().kind() == v1::Section::QUARTER_SLAB
                 ? mechanics::Kinematics::corotational
                 : mechanics::Kinematics::small_strain;
  }
}

mechanics::AlgorithmParameters parameters(const v1::AlgorithmParameters& from) {
  mechanics::AlgorithmParameters to;
  if (from.has_gamma_p_per_pa_s()) to.gamma_p = from.gamma_p_per_pa_s();
  if (from.has_lambda_p_pa_s()) to.lambda_p = from.lambda_p_pa_s();
  if (from.has_gamma_c_pa_per_m()) to.gamma_c = from.gamma_c_pa_per_m();
  if (from.has_lambda_c_m_per_pa()) to.lambda_c = from.lambda_c_m_per_pa();
  if (from.has_relaxation()) to.relaxation = from.relaxation();
  to.plain = from.plain();
  to.increment_test = from.increment_test();
  return to;
}

}  // namespace

casting::MechanicsCase mechanics_to_core(const v1::Case& complete) {
  const v1::Mechanics& from = complete.mechanics();
  casting::MechanicsCase to;
  if (from.has_enabled()) to.enabled = from.enabled();
  to.start = from.start_s();
  mechanics::Options& options = to.options;
  options.algorithm = algorithm_of(from.algorithm());
  options.kinematics = kinematics_of(complete);
  if (from.has_gravity_m_per_s2()) options.gravity = from.gravity_m_per_s2();
  options.liquid = liquid_of(from.liquid());
  if (from.has_liquid_modulus_pa()) options.liquid_modulus = from.liquid_modulus_pa();
  if (from.has_liquid_epsilon()) options.liquid_epsilon = from.liquid_epsilon();
  if (from.has_liquid_delta()) options.liquid_delta = from.liquid_delta();
  if (from.has_liquid_beta()) options.liquid_beta = from.liquid_beta();
  if (from.has_confinement()) options.confinement = from.confinement();
  if (from.hold() == v1::Mechanics::PENALTY)
    options.confinement_by = mechanics::Confinement::penalty;
  if (from.has_mould_penalty_pa_per_m())
    options.confinement_stiffness = from.mould_penalty_pa_per_m();
  if (from.has_mould_wall()) options.mould_wall = from.mould_wall();
  if (from.has_contact()) options.contact = from.contact();
  if (from.has_tolerance()) options.tolerance = from.tolerance();
  if (from.has_maximum_iterations()) options.maximum_iterations = from.maximum_iterations();
  options.parameters = parameters(from.parameters());
  return to;
}

}  // namespace dccast::translate
