#pragma once

namespace dccast::casting {

/// Chooses time steps: what the case asks for, less after a step that did not converge, growing
/// back when steps succeed.
class StepControl {
public:
  /// @param smallest  [s] below it the run has failed
  explicit StepControl(double smallest) : smallest_(smallest) {}

  /// Step to try [s]. @param wanted  what the case asks for [s]
  double choose(double wanted) const { return wanted < limit_ ? wanted : limit_; }
  void accepted();
  /// @param step  [s] that did not converge @return false when there is no smaller step to try
  bool rejected(double step);

  double limit() const { return limit_; }         ///< [s] for the checkpoint
  void restore(double limit) { limit_ = limit; }  ///< [s]

private:
  static constexpr double unlimited = 1e300;  ///< [s]
  double smallest_;                           ///< [s]
  double limit_ = unlimited;                  ///< [s]
};

}  // namespace dccast::casting
