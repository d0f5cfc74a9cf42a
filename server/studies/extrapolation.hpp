#pragma once

#include <optional>
#include <vector>

namespace dccast::studies {

/// A curve on one mesh, at instants that the curves of all meshes have in common.
struct RefinedCurve {
  int refinement = 1;           ///< cells and steps are those of the case divided by this
  std::vector<double> value_m;  ///< NaN where unknown
};

/// Limit of curves on ever finer meshes.
struct CurveLimit {
  std::optional<double> order;        ///< observed; empty if the curves do not converge
  std::vector<double> value_m;        ///< extrapolated; the finest curve if there is no order
  std::vector<double> uncertainty_m;  ///< half width of the interval around `value_m`
};

/// Extrapolates from the last three curves, each with half the cell and step of the one before.
///
/// Between them are the differences d1 and d2. Curves cross at single instants, where a ratio of
/// differences means nothing. So one ratio rho, d2 = rho d1, is fitted to the whole history by
/// least squares, each instant weighted with the time around it. With 0 < rho < 1 the curves
/// converge:
///
///     order        p     = -log2(rho)
///     limit        L(t)  = finest + c rho d1(t),   c = 1 / (2^p - 1), p kept between 1/2 and 1
///     uncertainty  U(t)  = 1.25 c max(|d2(t)|, |rho d1(t)|)
///
/// 1.25 is Roache's factor for three meshes. An order above one is not trusted: the steps are those
/// of backward Euler and are halved with the cells, so that the second order seen on coarse meshes
/// does not last (docs/developers/discretisation.md has the figures). The maximum of two measures
/// keeps the interval open where two curves cross.
///
/// Without three such curves, or if they do not converge, there is no order. The uncertainty is
/// then 1.25 times the largest difference between the curves up to that instant.
/// @param time_s  as long as each curve, rising
/// @param curves  coarsest first, at least two
CurveLimit extrapolate(const std::vector<double>& time_s, const std::vector<RefinedCurve>& curves);

}  // namespace dccast::studies
