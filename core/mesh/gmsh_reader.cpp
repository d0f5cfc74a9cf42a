#include "core/mesh/gmsh_reader.hpp"

#include <fstream>
#include <iterator>

#include "core/mesh/gmsh_import.hpp"

namespace dccast::mesh {

namespace {

int shape_for(int dimension, ElementKind kind) {
  if (dimension == 2) return kind == ElementKind::p1 ? gmsh::triangle : gmsh::quadrilateral;
  return kind == ElementKind::p1 ? gmsh::tetrahedron : gmsh::hexahedron;
}

/// The mesh in a file; empty if there is a fault.
template <int Dim>
std::optional<Mesh<Dim>> mesh_of(const gmsh::File& file, const std::string& name, ElementKind kind,
                                 Faults& faults) {
  const std::size_t before = faults.list().size();
  const auto sound = [&] { return faults.list().size() == before; };
  GmshImport<Dim> imported{file, name, shape_for(Dim, kind), faults};
  import_elements(imported);
  if (sound()) import_patches(imported);
  if (!sound()) return std::nullopt;
  return std::move(imported.mesh);
}

}  // namespace

template <int Dim>
std::optional<Mesh<Dim>> parse_gmsh(std::string_view text, const std::string& name,
                                    ElementKind kind, Faults& faults) {
  try {
    const gmsh::File file = gmsh::parse(text);
    return mesh_of<Dim>(file, name, kind, faults);
  } catch (const gmsh::FormatError& error) {
    faults.add("mesh.file", name, error.what(), "MSH 2.2 or 4.1, ASCII",
               "export it from Gmsh as MSH 4.1 or 2.2 in ASCII");
    return std::nullopt;
  }
}

template <int Dim>
std::optional<Mesh<Dim>> read_gmsh(const std::filesystem::path& path, ElementKind kind,
                                   Faults& faults) {
  const std::string name = path.filename().string();
  std::ifstream stream;
  // A folder can be opened, but not read.
  if (!std::filesystem::is_directory(path)) stream.open(path, std::ios::binary);
  if (!stream.is_open()) {
    faults.add("mesh.file", name, "cannot be read", "a readable Gmsh mesh",
               "name a file that is there, or leave mesh.file out");
    return std::nullopt;
  }
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return parse_gmsh<Dim>(text, name, kind, faults);
}

template std::optional<Mesh<2>> read_gmsh(const std::filesystem::path&, ElementKind, Faults&);
template std::optional<Mesh<3>> read_gmsh(const std::filesystem::path&, ElementKind, Faults&);
template std::optional<Mesh<2>> parse_gmsh(std::string_view, const std::string&, ElementKind,
                                           Faults&);
template std::optional<Mesh<3>> parse_gmsh(std::string_view, const std::string&, ElementKind,
                                           Faults&);

}  // namespace dccast::mesh
