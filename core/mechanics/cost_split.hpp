#pragma once

namespace dccast::mechanics {

/// Where the seconds of the mechanics go [s] by the clock on the wall, all steps so far.
struct CostSplit {
  double analysis = 0.0;        ///< pattern and order of elimination of new elements
  double stiffness = 0.0;       ///< assembly of the tangents
  double forces = 0.0;          ///< strains, return map, residual
  double preconditioner = 0.0;  ///< factorisations, and what else is made before a solution
  double solution = 0.0;        ///< by the factor or by conjugate gradients
  double contact = 0.0;         ///< changes of the contact set, found from gaps and reactions
};

}  // namespace dccast::mechanics
