#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/statistics/principal_components.hpp"
#include "core/statistics/sampling.hpp"
#include "core/statistics/sobol_indices.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

/// Accepted curls [m].
struct CurlBand {
  /// Ends of the range over which the runs are spread.
  double least = 0.0, greatest = 0.0;
};

/// The curl of one monitor as a function of inputs that are uniform in (0, 1).
struct SampledCurls {
  statistics::SampledFunction curls;  ///< (place, input) -> (place, instant) [m]
  std::vector<double> time_s, cast_length_m;
  std::vector<double> error_m;  ///< by instant: root mean square error of `curls`
};

/// Distribution of the curl over all values of the inputs: its 5, 50 and 95 % quantiles at every
/// instant, with the error of the function as normal noise, and the shares of the inputs in its
/// variance at some instants; the last share is that of the error. Deterministic.
v1::Spread spread_of(const SampledCurls& sampled, int inputs, const std::optional<CurlBand>& band);

/// The range of one input, in the unit of the schema.
struct InputRange {
  /// Ends of the range.
  double low = 0.0;
  double high = 0.0;
};

/// A run at a place of the domain.
struct SurfaceRun {
  std::vector<double> place;  ///< by input, in the unit of the schema
  RunCurves history;
};

/// Curls of all monitors against time as a function of some inputs. The curves of the runs are
/// decomposed into principal components, whose coefficients are Gaussian processes over the inputs.
class CurlSurface {
public:
  /// @param runs      at least fewest_runs()
  /// @param monitors  of the case
  CurlSurface(std::vector<InputRange> domain, std::vector<SurfaceRun> runs,
              std::vector<std::string> monitors);

  /// Fewest runs for a surface over `inputs` inputs.
  static std::size_t fewest_runs(std::size_t inputs) {
    return std::max<std::size_t>(5, inputs + 3);
  }

  /// Curves with standard errors. @param place  inside the domain
  std::vector<v1::CurlCurve> predict(const std::vector<double>& place) const;
  /// Root mean square leave-one-out error of the final curl, at the worst monitor [m].
  double cross_validated_error_m() const { return error_m_; }
  /// Distribution of a monitor's curl when the inputs vary over the whole domain.
  /// @param band  of accepted curls [m]; empty: none
  v1::Spread spread(const std::string& monitor, const std::optional<CurlBand>& band) const;
  /// Place where the final curls are least certain. @return by input, 0 to 1 over the domain
  const std::vector<double>& next_place() const { return next_place_; }
  int runs() const { return runs_; }
  /// Memory used, without small members [bytes].
  std::size_t bytes() const { return curls_.bytes() + lengths_.bytes(); }

private:
  /// A place in the unit cube.
  Eigen::RowVectorXd scaled(const std::vector<double>& place) const;
  /// The places of all runs, one for each row.
  Eigen::MatrixXd scaled_places(const std::vector<SurfaceRun>& runs) const;
  /// The curves of all runs, one for each row, by monitor and time.
  Eigen::MatrixXd curl_figures(const std::vector<SurfaceRun>& runs);

  std::vector<InputRange> domain_;
  int runs_;
  std::vector<std::string> monitors_;
  std::vector<double> time_s_;
  std::vector<std::vector<Eigen::Index>> figure_;  ///< (monitor, instant) column; -1: unknown
  Eigen::MatrixXd places_;
  statistics::PrincipalComponents curls_;
  statistics::PrincipalComponents lengths_;
  /// Root mean square error at the end, of the worst monitor, from runs left out one by one [m].
  double error_m_ = 0.0;
  /// Place with the largest uncertainty of the final curl.
  std::vector<double> next_place_;
};

}  // namespace dccast::studies
