#pragma once

namespace dccast::casting {

/// Chooses time steps: the step the case asks for, a smaller one after a step that did not
/// converge, growing back as steps succeed.
class StepControl {
public:
  /// @param smallest  [s] the run fails below this step
  explicit StepControl(double smallest) : smallest_(smallest) {}

  /// Step to try [s]. @param wanted  step the case asks for [s]
  double choose(double wanted) const { return wanted < limit_ ? wanted : limit_; }
  void accepted();
  /// @param step  [s] step that did not converge @return false if no smaller step may be tried
  bool rejected(double step);

  double limit() const { return limit_; }         ///< [s] for the checkpoint
  void restore(double limit) { limit_ = limit; }  ///< [s]

private:
  static constexpr double unlimited = 1e300;  ///< [s]
  double smallest_;                           ///< [s]
  double limit_ = unlimited;                  ///< [s]
};

}  // namespace dccast::casting
