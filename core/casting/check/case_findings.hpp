#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/casting/case_check.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

using Keys = std::vector<std::string>;

/// "0.28 m". @param value  in that unit
std::string with_unit(double value, const char* unit);

/// A case while it is checked: what was found so far, and what later checks may reason from. A
/// check that reasons from a key which is at fault itself is left out, and the answer says so:
/// `sound` decides.
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

  /// The fault that leaves nothing certain about a key; empty when there is none.
  std::string fault_of(std::string_view key) const;
  /// Whether what follows from these keys can be judged; if not, the answer will say what for.
  bool sound(const Keys& keys);
  bool axisymmetric() const { return casting.section.kind == mesh::SectionKind::axisymmetric; }
  bool solid() const { return mesh::dimension_of(casting.section.kind) == 3; }

  /// Everything found; warns of what was not judged.
  CheckedCase answer();

  const Case& casting;
  Faults faults;
  Estimate estimate;
  std::optional<double> final_level;  ///< [m]; there when the course is sound
  std::int64_t mechanical_steps = 0;  ///< of the estimate's steps
  /// There when mesh.file is sound, the one of the section's dimension.
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
