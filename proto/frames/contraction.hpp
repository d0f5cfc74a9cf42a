#pragma once

#include <stdexcept>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/service.pb.h"

namespace dccast::frames {

/// Half the thickness of a quarter slab at one place along its wide face.
struct FacePoint {
  double x_m = 0.0;      ///< in the undeformed slab [m]
  double mould_m = 0.0;  ///< half the opening of the mould [m]
  double now_m = 0.0;    ///< half-thickness at the time of the frame [m]
  /// Half-thickness at 20 °C [m]: each piece of the line from the middle plane to the face
  /// contracts freely from its present temperature. NaN if part of the line is not solid yet.
  double cold_m = 0.0;

  /// Positive where the slab is narrower than its mould.
  double pull_in_m() const { return mould_m - now_m; }
  double cold_pull_in_m() const { return mould_m - cold_m; }
};

/// Height above the bottom block, in the undeformed slab, at which the butt is measured [m]: above
/// its lifted end.
inline constexpr double butt_height_m = 0.05;

/// The wide face at one height.
struct FaceRow {
  double height_m = 0.0;          ///< above the bottom block, in the undeformed slab [m]
  bool solid = true;              ///< completely solid at every point
  std::vector<FacePoint> points;  ///< from the middle of the face outwards
};

/// Contraction of the wide face of a quarter slab.
struct Contraction {
  /// Time of the evaluated frame, and cast length then.
  double time_s = 0.0;
  double cast_length_m = 0.0;
  std::vector<FaceRow> rows;  ///< from below

  /// The row nearest to a height.
  const FaceRow& at(double height_m) const;
  /// The highest row that is completely solid; if there is none, the highest row.
  const FaceRow& head() const;
};

/// Half the opening of the mould of a quarter slab [m].
/// @param x_m  from the middle of the wide face [m]
double half_opening_m(const v1::Section& section, double x_m);

/// The contraction cannot be computed from a frame: what is missing, and the remedy.
class NoContraction : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Evaluates a frame along its lines of nodes from the middle plane to the wide face.
/// @param solved  the case of the frame with its alloy card
/// @throws NoContraction  not a quarter slab, or a mesh without such lines
Contraction contraction_of(const v1::Case& solved, const v1::Frame& frame);

/// The wide face of a quarter slab where the casting is steady, away from butt and head.
///
/// The pull-in of a row is final once the row is below the sump. The face is therefore evaluated at
/// nine tenths of the height up to which the slab is completely solid; the differences between the
/// rows above three quarters of this height show how steady the casting is there.
struct SteadyFace {
  double height_m = 0.0;    ///< above the bottom block, in the undeformed slab [m]
  double change_m = 0.0;    ///< largest difference of cold half-thickness between those rows [m]
  std::vector<double> x_m;  ///< from the middle of the face outwards [m]
  std::vector<double> mould_m;  ///< (x) half the opening of the mould [m]
  std::vector<double> cold_m;   ///< (x) half-thickness at 20 °C [m]

  /// Largest deviation from a flat face of this half-thickness [m]. @param wanted_m  [m]
  double residual_m(double wanted_m) const;
};

/// Evaluates the wide face where the casting is steady.
/// @throws NoContraction  the solid part above the butt is not high enough: the run is too short
SteadyFace steady_face(const Contraction& contraction);

}  // namespace dccast::frames
