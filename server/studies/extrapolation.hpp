#pragma once

#include <optional>
#include <vector>

namespace dccast::studies {

/// A curve on one mesh, at instants that the curves of all meshes have in common.
struct RefinedCurve {
  int refinement = 1;           ///< cells and steps are those of the case divided by this
  std::vector<double> value_m;  ///< NaN where nothing is known
};

/// The curve that curves on finer and finer meshes tend to.
struct CurveLimit {
  std::optional<double> order;        ///< observed; nothing where the curves do not settle
  std::vector<double> value_m;        ///< extrapolated; the finest curve where there is no order
  std::vector<double> uncertainty_m;  ///< half width of the interval around `value_m`
};

/// Extrapolates from the last three curves, each with half the cell and step of the one before.
///
/// Between them are the differences d1 and d2. At single instants curves cross, and a ratio taken
/// there means nothing; so one ratio rho, d2 = rho d1, is fitted to the whole history by least
/// squares, every instant weighted with the time it stands for. With 0 < rho < 1 the curves settle:
///
///     order        p     = -log2(rho)
///     limit        L(t)  = finest + c rho d1(t),   c = 1 / (2^p - 1), p kept between 1/2 and 1
///     uncertainty  U(t)  = 1.25 c max(|d2(t)|, |rho d1(t)|)
///
/// 1.25 is Roache's factor for three meshes. More than first order is not believed: the steps are
/// those of backward Euler and halve with the cells, so that the second order that coarse meshes
/// show does not last (docs/developers/discretisation.md has the figures). The larger of two
/// measures keeps the interval from closing where two curves cross.
///
/// Without three such curves, or when they swing or drift apart, there is no limit to offer: then
/// the uncertainty is 1.25 times the largest difference between these curves up to that instant.
/// @param time_s  as long as each curve, rising
/// @param curves  coarsest first, at least two
CurveLimit extrapolate(const std::vector<double>& time_s, const std::vector<RefinedCurve>& curves);

}  // namespace dccast::studies
