#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/errors.hpp"
#include "core/casting/case/case.hpp"
#include "core/casting/case/casting_schedule.hpp"
#include "core/mesh/gmsh_reader.hpp"
#include "core/mesh/plan_file.hpp"
#include "core/mesh/plan_transfer.hpp"
#include "core/mesh/slab_mesh.hpp"

namespace dccast::casting {

/// The mesh of a run: one of rows, which grows, or an imported one, which does not. The heat of a
/// quarter slab may have a mesh of its own; all results are on it.
template <int Dim>
class RunMesh {
public:
  /// @throws InvalidCase  the mesh file cannot be read
  explicit RunMesh(const Case& casting_case);

  /// Of the mechanics.
  const mesh::Mesh<Dim>& mesh() const { return slab_ ? slab_->mesh() : imported_; }
  const mesh::Mesh<Dim>& heat_mesh() const { return slab_ ? slab_->heat_mesh() : imported_; }
  /// Between the two.
  const mesh::PlanTransfer& transfer() const { return transfer_; }
  bool grows() const { return slab_.has_value() && grows_; }
  /// @pre in_rows() is not null
  mesh::SlabMesh<Dim>& slab() { return *slab_; }
  /// The mesh of rows; null for an imported one.
  const mesh::SlabMesh<Dim>* in_rows() const { return slab_ ? &*slab_ : nullptr; }
  double initial_level() const { return initial_level_; }  ///< [m] when the mould is filled
  double level() const { return slab_ ? slab_->level() : initial_level_; }  ///< [m] of the metal
  /// Metal level [m] that a time [s] and cast length [m] ask for; metal that stands higher stays.
  double level_at(const CastingSchedule& schedule, double time, double length) const;

private:
  /// Whether the case lets a mesh of rows grow.
  bool grows_;
  double initial_level_ = 0.0;  ///< [m]
  double first_level_ = 0.0;    ///< [m] with which filling begins
  std::optional<mesh::SlabMesh<Dim>> slab_;
  mesh::PlanTransfer transfer_;
  mesh::Mesh<Dim> imported_;
};

/// The mesh of rows of a section, over the plan of its file or the built-in one.
/// @throws InvalidCase  the file cannot be read
template <int Dim>
mesh::SlabMesh<Dim> make_rows(const mesh::SectionSpec& section) {
  if constexpr (Dim == 3) {
    if (mesh::has_plan_file(section)) {
      Faults faults;
      auto plan = mesh::read_plan(section, faults);
      if (!plan) throw InvalidCase(faults);
      return mesh::SlabMesh<3>(section, std::move(*plan));
    }
  }
  return mesh::SlabMesh<Dim>(section);
}

template <int Dim>
RunMesh<Dim>::RunMesh(const Case& c) : grows_(c.section.growth) {
  if (!mesh::has_mesh_file(c.section)) {
    slab_.emplace(make_rows<Dim>(c.section));
    transfer_ = mesh::PlanTransfer(c.section);
    initial_level_ = slab_->level();
    if (c.schedule.filling > 0.0) slab_->start_filling();
    first_level_ = slab_->level();
    return;
  }
  Faults faults;
  auto mesh = mesh::read_gmsh<Dim>(c.section.file, c.section.element, faults);
  if (!mesh) throw InvalidCase(faults);
  imported_ = std::move(*mesh);
  first_level_ = initial_level_ = imported_.largest(Dim - 1);
}

template <int Dim>
double RunMesh<Dim>::level_at(const CastingSchedule& schedule, double time, double length) const {
  // The mould is filled up to its first level at once, then evenly; what is cast comes on top.
  if (!grows()) return initial_level_;
  return std::max(first_level_, initial_level_ * schedule.filled_share(time)) + length +
         schedule.metal_level(std::min(time, schedule.end_of_casting()), length);
}

}  // namespace dccast::casting
