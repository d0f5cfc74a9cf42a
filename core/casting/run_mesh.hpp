#pragma once

#include <optional>

#include "core/case/case.hpp"
#include "core/mesh/slab_mesh.hpp"

namespace dccast::casting {

/// The mesh of a run: the built-in one, which grows, or an imported one, which does not.
template <int Dim>
class RunMesh {
public:
  /// @throws InvalidCase  the mesh file cannot be read
  explicit RunMesh(const Case& casting_case);

  const mesh::Mesh<Dim>& mesh() const { return slab_ ? slab_->mesh() : imported_; }
  bool grows() const { return slab_.has_value() && grows_; }
  /// @pre built_in() is not null
  mesh::SlabMesh<Dim>& slab() { return *slab_; }
  const mesh::SlabMesh<Dim>* built_in() const { return slab_ ? &*slab_ : nullptr; }

private:
  bool grows_;
  std::optional<mesh::SlabMesh<Dim>> slab_;
  mesh::Mesh<Dim> imported_;
};

extern template class RunMesh<2>;
extern template class RunMesh<3>;

}  // namespace dccast::casting
