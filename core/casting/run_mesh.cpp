#include "core/casting/run_mesh.hpp"

#include <algorithm>
#include <utility>

#include "core/base/errors.hpp"
#include "core/mesh/gmsh_reader.hpp"

namespace dccast::casting {

template <int Dim>
RunMesh<Dim>::RunMesh(const Case& c) : grows_(c.section.growth) {
  if (c.section.file.empty()) {
    slab_.emplace(c.section);
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
  if (!grows()) return initial_level_;
  return std::max(first_level_, initial_level_ * schedule.filled_share(time)) + length;
}

template class RunMesh<2>;
template class RunMesh<3>;

}  // namespace dccast::casting
