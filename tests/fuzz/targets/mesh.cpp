// A mesh of Gmsh, in two or three dimensions, or the plan of a slab.
#include "core/mesh/gmsh_reader.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

template <class Read>
void check(Read&& reader) {
  Faults faults;
  const auto read = reader(faults);
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
  if (choice & 4)
    check([&](Faults& faults) { return mesh::parse_gmsh_plan(text, "fuzz.msh", faults); });
  else if (choice & 1)
    check([&](Faults& faults) { return mesh::parse_gmsh<3>(text, "fuzz.msh", kind, faults); });
  else
    check([&](Faults& faults) { return mesh::parse_gmsh<2>(text, "fuzz.msh", kind, faults); });
  return 0;
}
