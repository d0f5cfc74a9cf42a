#include "proto/case_file/quantity.hpp"
#include "proto/case_file/size_bounds.hpp"
#include "proto/case_file/toml_walker.hpp"

namespace dccast::case_file {
namespace {

std::string against_text(const FieldDescriptor& field) {
  std::string text;
  for (const v1::Abscissa abscissa : abscissae_of(field)) {
    const std::string unit = abscissa_unit(abscissa);
    text += (text.empty() ? "" : ", ") + abscissa_name(abscissa) +
            (unit == "1" ? "" : " [" + unit + "]");
  }
  return text;
}

std::string abscissa_example(v1::Abscissa abscissa) {
  switch (abscissa) {
    case v1::TEMPERATURE:
      return "\"500 degC\"";
    case v1::LIQUID_FRACTION:
      return "0.5";
    case v1::TIME:
      return "\"60 s\"";
    default:
      return "\"30 mm\"";
  }
}

std::string pair_example(const FieldDescriptor& field) {
  const std::string abscissa = abscissa_example(abscissae_of(field).front());
  std::string value = example_text(field);
  return "[" + abscissa + ", " + value + "]";
}

/// Which abscissa is meant, by the unit of the first point; unspecified (and a fault) if none fits.
v1::Abscissa abscissa_of(Walk& walk, const toml::node& node, const FieldDescriptor& field,
                         const std::string& path) {
  const auto choices = abscissae_of(field);
  const auto text = node.is_string() ? node.value<std::string>() : std::nullopt;
  for (const v1::Abscissa choice : choices)
    if ((node.is_number() && abscissa_unit(choice) == "1") ||
        (text && parse_quantity(*text, abscissa_unit(choice)).value))
      return choice;
  if (node.is_number() || text) {
    const Quantity tried = text ? parse_quantity(*text, abscissa_unit(choices.front()))
                                : Quantity{std::nullopt, "", "the unit is missing"};
    walk.add(make_fault(path, written(node), "first number of a point: " + tried.message,
                        "against " + against_text(field), "e.g. " + pair_example(field)),
             node);
  } else {
    walk.add(make_fault(path, written(node), type_name(node) + " where a quantity is expected",
                        "against " + against_text(field), "e.g. " + pair_example(field)),
             node);
  }
  return v1::ABSCISSA_UNSPECIFIED;
}

/// A point of the table; false if it has a fault.
bool read_point(Walk& walk, const toml::node& node, const FieldDescriptor& field, v1::Curve& curve,
                const std::string& path) {
  const toml::array* const pair = node.as_array();
  if (pair == nullptr || pair->size() != 2) {
    walk.add(make_fault(path, written(node), "a point must be a pair [abscissa, value]",
                        "against " + against_text(field), "e.g. " + pair_example(field)),
             node);
    return false;
  }
  const toml::node& first = *pair->get(0);
  if (curve.abscissa() == v1::ABSCISSA_UNSPECIFIED)
    curve.set_abscissa(abscissa_of(walk, first, field, path));
  if (curve.abscissa() == v1::ABSCISSA_UNSPECIFIED) return false;
  const auto at = read_number(walk, first, abscissa_unit(curve.abscissa()),
                              abscissa_example(curve.abscissa()), nullptr, path);
  const auto value =
      read_number(walk, *pair->get(1), key_of(field).unit(), example_text(field), &field, path);
  if (!at || !value) return false;
  if (curve.at_size() > 0 && *at <= curve.at(curve.at_size() - 1)) {
    walk.add(make_fault(path, written(first), "must be larger than that of the point before it",
                        "strictly increasing " + abscissa_name(curve.abscissa())),
             node);
    return false;
  }
  curve.add_at(*at);
  curve.add_value(*value);
  return true;
}

}  // namespace

void read_curve(Walk& walk, const toml::node& node, const FieldDescriptor& field, v1::Curve& curve,
                const std::string& path) {
  const toml::array* const points = node.as_array();
  if (points == nullptr) {
    const auto value =
        read_number(walk, node, key_of(field).unit(), example_text(field), &field, path);
    if (!value) return;
    curve.add_at(0.0);
    curve.add_value(*value);
    return;
  }
  if (points->empty())
    walk.add(make_fault(path, "[]", "an empty table", "at least one point",
                        "e.g. [" + pair_example(field) + "]"),
             node);
  if (auto fault = count_fault(field, points->size(), path))
    return walk.add(std::move(*fault), node);
  bool sound = true;
  for (std::size_t i = 0; i < points->size(); ++i)
    sound = read_point(walk, *points->get(i), field, curve, path + "[" + std::to_string(i) + "]") &&
            sound;
  if (!sound) curve.Clear();
}

}  // namespace dccast::case_file
