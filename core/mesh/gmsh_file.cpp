#include "core/mesh/gmsh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "core/mesh/cell_shape.hpp"

namespace dccast::mesh::gmsh {

namespace {

constexpr std::size_t most_quoted = 40;  // characters of a file in a message

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/// Reads the words and numbers of a file in sequence. It knows the name of the present section, for
/// messages.
class Scanner {
public:
  explicit Scanner(std::string_view text) : left_(text) {}

  void enter(std::string_view section) { section_ = section; }

  /// The next word; empty at the end of the text.
  std::string_view word_or_end() {
    std::size_t begin = 0;
    while (begin < left_.size() && is_space(left_[begin])) ++begin;

    std::size_t end = begin;
    while (end < left_.size() && !is_space(left_[end])) ++end;

    const std::string_view word = left_.substr(begin, end - begin);
    left_.remove_prefix(end);
    return word;
  }

  /// The next word. @throws FormatError  at the end of the text
  std::string_view word() {
    const std::string_view word = word_or_end();
    if (word.empty()) throw FormatError(fmt::format("ends in the middle of ${}", section_));
    return word;
  }

  template <class Number>
  Number number() {
    const std::string_view text = word();
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
      throw FormatError(fmt::format("has '{}' in ${} where a number belongs",
                                    text.substr(0, most_quoted), section_));
    return value;
  }

  /// Number of items that follow; each takes at least two bytes of the remaining text.
  std::size_t count() {
    const auto value = number<long>();
    if (value < 0 || static_cast<std::size_t>(value) > left_.size() / 2 + 1)
      throw FormatError(
          fmt::format("ends in the middle of ${}: it announces {} entries", section_, value));
    return static_cast<std::size_t>(value);
  }

  double coordinate() {
    constexpr double farthest = 1e4;  // [m]; products of three stay far from overflow
    const auto value = number<double>();
    if (!std::isfinite(value)) throw FormatError("has a coordinate that is not finite");
    if (std::abs(value) > farthest)
      throw FormatError(
          fmt::format("has a coordinate of {:g}; lengths are in metres, at most {:g} of them",
                      value, farthest));
    return value;
  }

  /// The name at the end of a line, in quotation marks or without.
  std::string name() {
    const std::size_t begin = std::min(left_.find_first_not_of(" \t"), left_.size());
    left_.remove_prefix(begin);
    const bool is_quoted = left_.starts_with('"');
    if (is_quoted) left_.remove_prefix(1);

    const std::size_t end = left_.find_first_of(is_quoted ? "\"" : "\r\n");
    if (end == std::string_view::npos)
      throw FormatError(fmt::format("ends in the middle of ${}", section_));
    std::string text(left_.substr(0, end));
    left_.remove_prefix(end + 1);
    if (!is_quoted) text.resize(text.find_last_not_of(" \t") + 1);
    return text;
  }

  /// The tag of a physical group. It is negative where the group turns its entity round, which
  /// changes no mesh.
  int group() { return static_cast<int>(std::abs(static_cast<long>(number<int>()))); }

  void skip(std::size_t words) {
    for (std::size_t i = 0; i < words; ++i) word();
  }

  /// Reads the end of the section. @throws FormatError  there is something else
  void leave() {
    const std::string_view last = word();
    if (last != "$End" + section_)
      throw FormatError(
          fmt::format("has '{}' where $End{} belongs", last.substr(0, most_quoted), section_));
  }

  /// Skips a section that is not needed.
  void skip_section() {
    while (word() != "$End" + section_) {
    }
  }

private:
  std::string_view left_;
  std::string section_ = "MeshFormat";
};

/// Largest number of physical groups of an entity. Each of its elements has them all: without a
/// limit a file of a megabyte could ask for gigabytes.
constexpr std::size_t most_groups = 100;

/// Physical groups of the geometrical entities, by dimension and tag (4.1 only).
using EntityGroups = std::map<std::pair<int, int>, std::vector<int>>;

void read_group_names(Scanner& scan, File& file) {
  for (std::size_t left = scan.count(); left > 0; --left) {
    const int dimension = scan.number<int>();
    const int tag = scan.number<int>();
    file.group_name[{dimension, tag}] = scan.name();
  }
}

void add_groups(Scanner& scan, std::vector<int>& groups) {
  const std::size_t added = scan.count();
  if (groups.size() + added > most_groups)
    throw FormatError(fmt::format("has an entity in more than {} physical groups", most_groups));
  for (std::size_t i = added; i > 0; --i) groups.push_back(scan.group());
}

/// Words that give a point, or the bounding box of another entity.
constexpr std::size_t words_of_place(int dimension) {
  return dimension == 0 ? 3 : 6;
}

void read_entities(Scanner& scan, EntityGroups& groups) {
  std::array<std::size_t, 4> counts{};
  for (std::size_t& count : counts) count = scan.count();
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (std::size_t left = counts[static_cast<std::size_t>(dimension)]; left > 0; --left) {
      const int tag = scan.number<int>();
      scan.skip(words_of_place(dimension));
      add_groups(scan, groups[{dimension, tag}]);
      if (dimension > 0) scan.skip(scan.count());  // entities that bound it
    }
  }
}

/// Parts of the entities of a mesh that was divided for several processors. Its elements are
/// theirs.
void read_partitioned_entities(Scanner& scan, EntityGroups& groups) {
  scan.skip(1);  // number of partitions
  for (std::size_t ghosts = scan.count(); ghosts > 0; --ghosts) scan.skip(2);

  std::array<std::size_t, 4> counts{};
  for (std::size_t& count : counts) count = scan.count();
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (std::size_t left = counts[static_cast<std::size_t>(dimension)]; left > 0; --left) {
      const int tag = scan.number<int>();
      const int dimension_of_whole = scan.number<int>();
      scan.skip(1);             // tag of the whole entity
      scan.skip(scan.count());  // its partitions
      scan.skip(words_of_place(dimension));

      // A cut through an entity has the groups of that entity, which are none of its own.
      std::vector<int> of_cut;
      const bool is_part = dimension_of_whole == dimension;
      add_groups(scan, is_part ? groups[{dimension, tag}] : of_cut);
      if (dimension > 0) scan.skip(scan.count());  // entities that bound it
    }
  }
}

void read_node(Scanner& scan, File& file) {
  std::array<double, 3> position{};
  for (double& x : position) x = scan.coordinate();
  file.node.push_back(position);
}

/// Nodes in the format 2.2.
void read_nodes_2(Scanner& scan, File& file) {
  for (std::size_t left = scan.count(); left > 0; --left) {
    file.node_tag.push_back(scan.number<long>());
    read_node(scan, file);
  }
}

/// Nodes in the format 4.1.
void read_nodes_4(Scanner& scan, File& file) {
  const std::size_t blocks = scan.count();
  scan.skip(3);  // number of nodes, smallest and largest tag
  for (std::size_t block = 0; block < blocks; ++block) {
    const int dimension = scan.number<int>();
    scan.skip(1);
    const bool parametric = scan.number<int>() != 0;

    const std::size_t count = scan.count();
    for (std::size_t i = 0; i < count; ++i) file.node_tag.push_back(scan.number<long>());
    for (std::size_t i = 0; i < count; ++i) {
      read_node(scan, file);
      if (parametric) scan.skip(static_cast<std::size_t>(std::clamp(dimension, 0, 3)));
    }
  }
}

/// An element without nodes. @throws FormatError  for a shape that is not supported
Element make_element(int shape) {
  if (nodes_of(shape) == 0)
    throw FormatError(fmt::format(
        "has elements of Gmsh's type {}; only linear ones are read (Mesh.ElementOrder = 1)",
        shape));
  Element element;
  element.shape = shape;
  return element;
}

void read_element_nodes(Scanner& scan, Element& element) {
  for (int i = 0; i < nodes_of(element.shape); ++i)
    element.node[static_cast<std::size_t>(i)] = scan.number<long>();
}

/// Elements in the format 2.2.
void read_elements_2(Scanner& scan, File& file) {
  for (std::size_t left = scan.count(); left > 0; --left) {
    scan.skip(1);
    Element element = make_element(scan.number<int>());

    // The first tag is the physical group, zero for none; the others are Gmsh's own.
    const std::size_t tags = scan.count();
    if (tags > 0)
      if (const int group = scan.group(); group != 0) element.groups = {group};
    if (tags > 1) scan.skip(tags - 1);

    read_element_nodes(scan, element);
    file.elements.push_back(std::move(element));
  }
}

/// Elements in the format 4.1.
void read_elements_4(Scanner& scan, const EntityGroups& groups, File& file) {
  const std::size_t blocks = scan.count();
  scan.skip(3);  // number of elements, smallest and largest tag
  for (std::size_t block = 0; block < blocks; ++block) {
    const int dimension = scan.number<int>();
    const int entity = scan.number<int>();
    Element element = make_element(scan.number<int>());
    if (const auto found = groups.find({dimension, entity}); found != groups.end())
      element.groups = found->second;

    for (std::size_t left = scan.count(); left > 0; --left) {
      scan.skip(1);
      read_element_nodes(scan, element);
      file.elements.push_back(element);
    }
  }
}

/// Reads the section of the format. @return its version, 2 or 4
int read_format(Scanner& scan) {
  // Comments may stand before it.
  std::string_view head = scan.word_or_end();
  while (head.starts_with('$') && head != "$MeshFormat") {
    scan.enter(head.substr(1));
    scan.skip_section();
    head = scan.word_or_end();
  }
  if (head != "$MeshFormat") throw FormatError("does not begin with $MeshFormat: not a Gmsh mesh");
  scan.enter("MeshFormat");

  const std::string version(scan.word());
  if (version != "2.2" && version != "4.1")
    throw FormatError(
        fmt::format("has the format version {}; 2.2 and 4.1 are read (Mesh.MshFileVersion)",
                    version.substr(0, 20)));

  if (scan.number<int>() != 0) throw FormatError("is binary; save it as ASCII (Mesh.Binary = 0)");
  scan.skip(1);
  scan.leave();
  return version == "2.2" ? 2 : 4;
}

}  // namespace

int nodes_of(int shape) {
  if (shape == point) return 1;
  const CellShape* known = find_gmsh_shape(shape);
  return known == nullptr ? 0 : known->nodes;
}

int dimension_of(int shape) {
  if (shape == point) return 0;
  const CellShape* known = find_gmsh_shape(shape);
  return known == nullptr ? -1 : known->dimension;
}

File parse(std::string_view text) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  Scanner scan(text);
  const int version = read_format(scan);
  File file;
  EntityGroups groups;
  bool complete = false;

  for (std::string_view head = scan.word_or_end(); !head.empty(); head = scan.word_or_end()) {
    if (head.front() != '$')
      throw FormatError(fmt::format("has '{}' between two sections", head.substr(0, most_quoted)));

    // Sections that are not needed, such as periodic ones, are skipped.
    const std::string_view section = head.substr(1);
    scan.enter(section);
    if (section == "PhysicalNames") {
      read_group_names(scan, file);
    } else if (section == "Entities" && version == 4) {
      read_entities(scan, groups);
    } else if (section == "PartitionedEntities" && version == 4) {
      read_partitioned_entities(scan, groups);
    } else if (section == "Nodes") {
      (version == 2 ? read_nodes_2 : read_nodes_4)(scan, file);
    } else if (section == "Elements") {
      version == 2 ? read_elements_2(scan, file) : read_elements_4(scan, groups, file);
      complete = true;
    } else {
      scan.skip_section();
      continue;
    }
    scan.leave();
  }

  if (!complete) throw FormatError("ends before $Elements");
  return file;
}

}  // namespace dccast::mesh::gmsh
