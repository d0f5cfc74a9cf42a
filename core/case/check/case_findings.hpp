#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/case/case_check.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

using Keys = std::vector<std::string>;

/// A value with its unit: "0.28 m". @param value  [`unit`]
std::string with_unit(double value, const char* unit);

/// A case during its check: the faults found so far and intermediate results for later checks. A
/// check that depends on a faulty key is skipped and reported as skipped, see sound().
class CaseFindings {
public:
  CaseFindings(const Case& the_case, const std::vector<std::string>& faulty_keys)
      : casting(the_case), faulty_keys_(faulty_keys) {}

  /// As Faults::add().
  template <class... Rest>
  void fault(Rest&&... rest) {
    faults.add(std::forward<Rest>(rest)...);
  }
  template <class... Rest>
  void warning(Rest&&... rest) {
    warnings_.add(std::forward<Rest>(rest)...);
  }

  /// The fault that makes the value of a key unusable; empty if there is none.
  std::string fault_of(std::string_view key) const;
  /// Whether none of these keys has a fault, so that checks depending on them are meaningful. If
  /// not, the answer names the fault they wait for.
  bool sound(const Keys& keys);
  bool axisymmetric() const { return casting.section.kind == mesh::SectionKind::axisymmetric; }
  bool solid() const { return mesh::dimension_of(casting.section.kind) == 3; }

  /// All findings, with warnings for the checks that were skipped.
  CheckedCase answer();

  const Case& casting;
  Faults faults;
  Estimate estimate;
  /// [m] metal level at the end; set if `course_keys` are sound
  std::optional<double> final_level;
  std::int64_t mechanical_steps = 0;  ///< of the estimate's steps
  /// The mesh of the section's dimension, set if mesh.file is sound.
  std::optional<mesh::Mesh2D> imported_plane;
  std::optional<mesh::Mesh3D> imported_solid;

  template <int Dim>
  auto& imported() {
    if constexpr (Dim == 2)
      return imported_plane;
    else
      return imported_solid;
  }

private:
  const std::vector<std::string>& faulty_keys_;
  Faults warnings_;
  std::set<std::string> waited_for_;
};

}  // namespace dccast::casting
