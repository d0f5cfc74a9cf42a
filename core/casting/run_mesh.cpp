#include "core/casting/run_mesh.hpp"

#include <utility>

#include "core/base/errors.hpp"
#include "core/mesh/gmsh_reader.hpp"

namespace dccast::casting {

template <int Dim>
RunMesh<Dim>::RunMesh(const Case& c) : grows_(c.section.growth) {
  if (c.section.file.empty()) {
    slab_.emplace(c.section);
    return;
  }
  Faults faults;
  auto mesh = mesh::read_gmsh<Dim>(c.section.file, c.section.element, faults);
  if (!mesh) throw InvalidCase(faults);
  imported_ = std::move(*mesh);
}

template class RunMesh<2>;
template class RunMesh<3>;

}  // namespace dccast::casting
