#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// Carries fields between the heat's mesh and the mechanics' mesh of a slab.
///
/// The heat's plan divides every cell of the mechanics' plan into the same number of columns and
/// layers, and both meshes have the same rows. So each mechanics' cell is made of whole heat cells:
/// its mean is a sum over them, which keeps the integral of the field. Each mechanics' node is a
/// heat node, and the interpolation of the mechanics' cell gives the values at all others.
///
/// Fields are flat, by node or by cell, row by row, with any number of components each.
class PlanTransfer {
public:
  /// The two meshes are the same.
  PlanTransfer() = default;
  /// Between the plans of a section, see base_of(). @pre if they differ, one element fills a cell
  explicit PlanTransfer(const SectionSpec& spec);

  bool same_mesh() const { return nodes_.empty(); }

  /// Means over the elements of the mechanics' mesh [unit of the field].
  /// @param field  (heat node) [unit of the field]
  template <int Dim>
  std::vector<double> element_means(const Mesh<Dim>& heat_mesh,
                                    std::span<const double> field) const;

  /// (mechanics' node) the values at its nodes [unit of the field].
  /// @param field  (heat node) [unit of the field]
  std::vector<double> at_mechanics_nodes(std::span<const double> field) const;

  /// (heat node, component) interpolated in the mechanics' cells [unit of the field].
  /// @param field       (mechanics' node, component) [unit of the field]
  /// @param components  of a node
  std::vector<double> at_heat_nodes(std::vector<double> field, std::size_t components = 1) const;

  /// (heat element, component) the values of the mechanics' element in which each lies.
  /// @param field       (mechanics' element, component)
  /// @param components  of an element
  template <class T>
  std::vector<T> in_heat_elements(std::vector<T> field, std::size_t components = 1) const;

private:
  /// A cell of the heat's plan, and its share of the area of the mechanics' cell around it [1].
  struct Part {
    std::size_t cell;
    double share;
  };
  /// A node of the heat's plan: the corners of the mechanics' cell around it and their weights [1].
  struct Place {
    std::array<std::size_t, 4> node;
    std::array<double, 4> weight;
  };

  std::vector<std::size_t> nodes_;        ///< (mechanics' node of a row) the heat node there
  std::vector<std::vector<Part>> parts_;  ///< (mechanics' cell of a row)
  std::vector<std::size_t> around_;       ///< (heat cell of a row) the mechanics' cell
  std::vector<Place> places_;             ///< (heat node of a row)
};

template <int Dim>
std::vector<double> PlanTransfer::element_means(const Mesh<Dim>& heat_mesh,
                                                std::span<const double> field) const {
  std::vector<double> means;
  if (same_mesh()) {
    for (int e = 0; e < heat_mesh.elements(); ++e)
      means.push_back(mean_at_nodes(heat_mesh, e, field));
    return means;
  }

  const int per_row = static_cast<int>(around_.size());
  for (int first = 0; first < heat_mesh.elements(); first += per_row) {
    for (const auto& parts : parts_) {
      double mean = 0.0;
      for (const Part& part : parts)
        mean += part.share * mean_at_nodes(heat_mesh, first + static_cast<int>(part.cell), field);
      means.push_back(mean);
    }
  }
  return means;
}

template <class T>
std::vector<T> PlanTransfer::in_heat_elements(std::vector<T> field, std::size_t components) const {
  if (same_mesh()) return field;

  const std::size_t per_row = parts_.size() * components;
  std::vector<T> carried;
  carried.reserve(field.size() / parts_.size() * around_.size());
  for (std::size_t first = 0; first < field.size(); first += per_row) {
    for (const std::size_t cell : around_) {
      const auto from = field.begin() + std::ptrdiff_t(first + cell * components);
      carried.insert(carried.end(), from, from + std::ptrdiff_t(components));
    }
  }
  return carried;
}

}  // namespace dccast::mesh
