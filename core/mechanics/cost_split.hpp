#pragma once

namespace dccast::mechanics {

/// Wall time of the mechanics by task, summed over all steps so far.
struct CostSplit {
  double analysis = 0.0;        ///< [s] sparsity pattern and elimination order of new elements
  double stiffness = 0.0;       ///< [s] assembly of the tangents
  double forces = 0.0;          ///< [s] strains, return map, residual
  double preconditioner = 0.0;  ///< [s] factorisations and other preparation of solutions
  double solution = 0.0;        ///< [s] solutions by the factor or by conjugate gradients
  double contact = 0.0;         ///< [s] update of the contact set from gaps and reactions
};

}  // namespace dccast::mechanics
