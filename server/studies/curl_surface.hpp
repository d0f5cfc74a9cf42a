#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/studies/run_history.hpp"
#include "server/studies/spread.hpp"

namespace dccast::studies {

/// The range of one input, in the unit of the schema.
struct InputRange {
  double low = 0.0;
  double high = 0.0;
};

/// A run at a place of the domain.
struct SurfaceRun {
  std::vector<double> place;  ///< by input, in the unit of the schema
  RunHistory history;
};

/// The curl against time of all monitors as a function of some inputs. The curves of the runs are
/// taken apart into their principal components, whose amounts are Gaussian processes over the
/// inputs.
class CurlSurface {
public:
  /// @param runs      fewest_runs() or more
  /// @param monitors  those of the case
  CurlSurface(std::vector<InputRange> domain, const std::vector<SurfaceRun>& runs,
              const std::vector<std::string>& monitors);
  ~CurlSurface();

  /// Runs that a surface over `inputs` inputs needs.
  static std::size_t fewest_runs(std::size_t inputs) {
    return std::max<std::size_t>(5, inputs + 3);
  }

  /// Curves with standard errors. @param place  inside the domain
  std::vector<v1::CurlCurve> predict(const std::vector<double>& place) const;
  /// Root mean square of what runs left out one by one are off at the end, of the worst monitor
  /// [m].
  double cross_validated_error_m() const;
  /// What the inputs leave open of a monitor's curl when they vary over the whole domain.
  /// @param band  of curls that are accepted [m]; empty: none
  v1::Spread spread(const std::string& monitor, const std::optional<CurlBand>& band) const;
  /// Where the curls at the end are least certain. @return by input, 0 to 1 over the domain
  const std::vector<double>& next_place() const;
  int runs() const;
  /// Of memory, most of it.
  std::size_t bytes() const;

private:
  class Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace dccast::studies
