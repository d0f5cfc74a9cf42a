#pragma once

#include "core/mesh/extruded_mesh.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// The built-in mesh of a section: its base extruded in rows that are graded from the bottom block.
template <int Dim>
class SlabMesh : public ExtrudedMesh<Dim> {
public:
  /// @param spec  section and division; `file` must be empty
  explicit SlabMesh(const SectionSpec& spec);
};

using SlabMesh2D = SlabMesh<2>;
using SlabMesh3D = SlabMesh<3>;

/// Height of the rows that growth adds to the built-in mesh [m].
double growth_cell(const SectionSpec& spec);

/// Number of rows of the built-in mesh when the metal level is at `level` [m].
int rows_at(const SectionSpec& spec, double level);

extern template class SlabMesh<2>;
extern template class SlabMesh<3>;

}  // namespace dccast::mesh
