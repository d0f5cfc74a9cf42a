#pragma once

#include <span>
#include <vector>

#include "core/casting/findings/mush_feeding.hpp"
#include "core/material/mechanical_properties.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/row_merging.hpp"
#include "core/mesh/section_spec.hpp"

/// Hot tears: two indices of all metal that has frozen, not of single elements (docs/findings.md).
/// The strain rate in the window of the alloy orders recipes, the pressure drop of the melt that
/// feeds the mush orders alloys.
namespace dccast::casting {

/// History of an element in the mush so far.
struct MushPassage {
  /// [°C] at the end of the last step; above every liquidus before the first one
  double temperature = 1e9;
  double strain = 0.0;  ///< [1] equivalent viscoplastic strain in the window
  double time = 0.0;    ///< [s] in the window since the mechanics started
  MushFeeding::Path feeding{};

  /// Mean viscoplastic strain rate in the window [1/s]; 0 before it.
  double strain_rate() const { return time > 0.0 ? strain / time : 0.0; }
};

/// A figure of the whole casting and of the two places where butts tear.
struct TearIndex {
  double overall = 0.0;  ///< of all metal that has left the window
  double centre = 0.0;   ///< of the butt's centre
  double surface = 0.0;  ///< of the surface just above the block
};
struct TearIndices {
  TearIndex strain_rate;  ///< [1/s]
  TearIndex pressure;     ///< [Pa]
};

/// Fields by element, for the frames.
struct TearMap {
  std::vector<double> strain_rate;  ///< (element) [1/s] mean in the window so far
  std::vector<double> pressure;     ///< (element) [Pa] drop to the melt so far
};

/// The share of the volume below whose value the rest lies [1].
inline constexpr double tear_percentile = 0.95;

/// A value and the volume that has it.
struct WeightedValue {
  double value = 0.0;   ///< [any unit]
  double weight = 0.0;  ///< [any unit]
};

/// The value that a share of the weight does not exceed; 0 without values. The values of elements
/// stand for the middle of their weight, and are linear between: finer elements give the same.
/// @param share  [1] 0 to 1
double weighted_percentile(std::vector<WeightedValue> values, double share);

/// Follows all elements through the mush and measures the indices.
template <int Dim>
class HotTears {
public:
  /// An accepted step.
  struct Step {
    const mesh::Mesh<Dim>& mesh;
    std::span<const double> temperature;  ///< (node) [°C]
    std::span<const double> creep_rate;   ///< (element) [1/s], see creep_rates()
    double time = 0.0;                    ///< [s] length of the step
    double metal_level = 0.0;             ///< [m]
    int growing = 0;                      ///< first element of the row that still stretches
  };

  HotTears(const material::AlloyCard& card, const mesh::SectionSpec& section);

  /// Equivalent creep rates at the end of a step, which the implicit step holds throughout: means
  /// of the points, zero of melt. Empty before the mechanics begins, and without a window.
  /// @param temperature  (element) [°C] @return  (element) [1/s], of the mesh of the slab
  std::vector<double> creep_rates(const mechanics::SlabState<Dim>& slab,
                                  std::span<const double> temperature) const;

  /// Follows the elements through a step. @param passages  (element) updated; may be shorter
  void follow(const Step& step, std::vector<MushPassage>& passages) const;

  /// @param passages  (element)
  TearIndices indices(const mesh::Mesh<Dim>& mesh, const std::vector<MushPassage>& passages) const;
  /// Both indices by element, for frames. @param passages  (element)
  TearMap map(const std::vector<MushPassage>& passages) const;

private:
  /// Follows one element through the window in a step.
  void pass(const Step& step, int e, MushPassage& passage) const;

  material::MechanicalProperties properties_;
  MushFeeding feeding_;
  bool has_window_;
  double window_begin_ = 0.0, window_end_ = 0.0;  ///< [°C]
  double liquidus_;                               ///< [°C]
  mesh::SectionSpec section_;
};

/// Transfers the passages of elements to the merged mesh: a merged cell takes the mean of its two.
/// @param passages  (element) may be empty
void merge_passages(const mesh::MergedRows& merged, std::vector<MushPassage>& passages);

}  // namespace dccast::casting
