// A mesh of Gmsh, in two or three dimensions.
#include "core/mesh/gmsh_reader.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

template <int Dim>
void read(std::string_view text, mesh::ElementKind kind) {
  Faults faults;
  const auto read = mesh::parse_gmsh<Dim>(text, "fuzz.msh", kind, faults);
  fuzz::require(read.has_value() == faults.list().empty(), "there is a mesh or a fault");
  if (!read) return;
  for (const int node : read->element_node)
    fuzz::require(node >= 0 && node < read->nodes(), "elements have nodes of the mesh");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  const unsigned choice = fuzz::take_choice(text);
  const auto kind = choice & 2 ? mesh::ElementKind::p1 : mesh::ElementKind::q1;
  choice & 1 ? read<3>(text, kind) : read<2>(text, kind);
  return 0;
}
