#pragma once

#include "core/base/curve.hpp"
#include "core/material/alloy_card.hpp"

namespace dccast::casting {

/// Pressure drop of the melt that feeds a mush, after Rappaz, Drezet and Gremaud (1999), with the
/// permeability of Carman and Kozeny:
///
///   dp = 180 mu / lambda^2 [(1 + beta) int E fs^2 / (1 - fs)^3 dx + beta int v fs^2 / (1 - fs)^2
///   dx]
///
/// along x through the mush, from the melt to the end of the window, E being the integral of the
/// strain rate times fs from that end on. A place meets the mush in this order, from the melt on,
/// while it freezes. E is then still unknown, and the order of the integrals is exchanged: the rate
/// at a place draws melt through the whole resistance R between it and the melt,
///
///   int E fs^2 / (1 - fs)^3 dx = int fs rate R dx,   R = int fs^2 / (1 - fs)^3 dx from the melt.
///
/// Within a step gradient, velocity and strain rate are constant, and the integrals over the
/// temperature are exact but for the spacing of a table.
class MushFeeding {
public:
  /// Integrals along the way of a place through the mush so far.
  struct Path {
    double resistance = 0.0;  ///< R [m]
    double stretched = 0.0;   ///< int fs rate R dx [m2/s]
    double shrunk = 0.0;      ///< int v fs^2 / (1 - fs)^2 dx [m2/s]
  };

  /// Conditions at a place during a step.
  struct Step {
    double from = 0.0, to = 0.0;  ///< [°C] temperature at the beginning and at the end
    double time = 0.0;            ///< [s] length of the step
    double gradient = 0.0;        ///< [K/m] of the temperature
    double strain_rate = 0.0;     ///< [1/s] viscoplastic
  };

  /// @param card  its arm spacing may be 0: no pressure drop
  explicit MushFeeding(const material::AlloyCard& card);

  /// Whether there is a mush that melt has to feed; false if the metal freezes at one temperature.
  bool applies() const { return begin_ > end_; }
  double begin() const { return begin_; }  ///< [°C] where the way begins, the liquidus
  double end() const { return end_; }      ///< [°C] where it ends

  /// Follows a place through a step. Metal that warms up goes back along its way; at the liquidus a
  /// new one begins.
  void advance(Path& path, const Step& step) const;

  /// Pressure drop to the melt [Pa].
  double pressure_drop(const Path& path) const;

private:
  double begin_ = 0.0, end_ = 0.0;  ///< [°C]
  double scale_ = 0.0;              ///< 180 mu / lambda^2 [Pa s/m2]
  // Integrals from the liquidus down to a temperature.
  Curve resistance_;  ///< of fs^2 / (1 - fs)^3 [K]
  Curve shrinkage_;   ///< of fs^2 / (1 - fs)^2 [K]
  Curve solid_;       ///< of fs [K]
  Curve stretch_;     ///< of fs times resistance_ [K2]
};

}  // namespace dccast::casting
