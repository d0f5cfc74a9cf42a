#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::case_file {
namespace {

/// Collects the faults of a message.
class RangeCheck {
public:
  std::vector<v1::Fault> faults;

  void check_message(const Message& message, const std::string& path) {
    for (const FieldDescriptor* const field : fields_of(*message.GetDescriptor()))
      check_field(message, *field, join_path(path, toml_key(*field)));
  }

  /// The depth of the metal and the place of the block describe the same: they must agree.
  void check_depth(const v1::Case& c) {
    constexpr double same = 1e-9;  // [m]
    const v1::Section& section = c.section();
    if (section.has_initial_depth_m() && section.has_block_above_water_m() &&
        std::abs(section.initial_depth_m() + section.block_above_water_m() -
                 c.cooling().water().from_m()) > same)
      add("section.block_above_water", quantity_text(section.block_above_water_m(), "m"),
          "does not agree with section.initial_depth and cooling.water.from", "one of the two keys",
          "give section.initial_depth, or section.block_above_water");
  }

  /// The melt's conductivity is a table, or follows the size of the section.
  void check_stirring(const v1::Alloy& alloy) {
    if (alloy.has_melt_stirring() && alloy.has_melt_conductivity_factor())
      add("alloy.melt_stirring", quantity_text(alloy.melt_stirring(), "1"),
          "alloy.melt_conductivity_factor is given, too", "one of the two keys",
          "give alloy.melt_stirring, or alloy.melt_conductivity_factor");
  }

  /// Metal creeps by one law.
  void check_creep(const v1::Alloy& alloy) {
    if (alloy.has_norton_hoff() && alloy.has_reference_creep())
      add("alloy.reference_creep", "", "alloy.norton_hoff is given, too", "one creep law",
          "give alloy.reference_creep, or alloy.norton_hoff");
  }

  /// Without weight the pool presses nothing against shell and block, and the first step fails.
  void check_gravity(const v1::Mechanics& mechanics) {
    if (mechanics.has_gravity_m_per_s2() && mechanics.gravity_m_per_s2() < least_gravity)
      add("mechanics.gravity", quantity_text(mechanics.gravity_m_per_s2(), "m/s2"),
          "the pool has too little weight to press on shell and block",
          fmt::format("{:g} to 100 m/s2", least_gravity),
          "leave the key out: gravity is 9.81 m/s2");
  }

  /// A monitor is a point, or a mean of points.
  void check_monitor(const v1::Monitor& monitor, const std::string& path) {
    if (monitor.of().empty()) return;
    for (const auto& [key, given] :
         {std::pair("x", monitor.has_x_m()), std::pair("y", monitor.has_y_m()),
          std::pair("z", monitor.has_z_m())})
      if (given)
        add(join_path(path, key), "", "a mean of other monitors has no place",
            fmt::format("{}.of, or x, y and z", path), "leave the place out, or of");
  }

private:
  // Of the Moon it is 1.6 [m/s2]. At 0.1 the checks of the coarse start fail, at 1 they pass.
  static constexpr double least_gravity = 1.0;

  /// Adds a fault.
  void add(const std::string& path, const std::string& value, const std::string& message,
           const std::string& permitted = {}, const std::string& remedy = {}) {
    faults.push_back(make_fault(path, value, message, permitted, remedy));
  }

  /// Adds the fault, if there is one. @return whether there was none
  bool add(std::optional<v1::Fault> fault) {
    if (!fault) return true;
    faults.push_back(std::move(*fault));
    return false;
  }

  void check_field(const Message& message, const FieldDescriptor& field, const std::string& path) {
    if (is_table(field)) return check_tables(message, field, path);
    if (is_curve(field) && is_present(message, field))
      return check_curve(curve_of(message, field), field, path);
    if (is_present(message, field)) return check_scalar(message, field, path);

    if (key_of(field).required() && !is_replaced(message, key_of(field).unless()))
      faults.push_back(missing_fault(field, path));
  }

  /// Whether the key that may be given instead of a required one is given.
  static bool is_replaced(const Message& message, const std::string& key) {
    const FieldDescriptor* const other = field_of_key(*message.GetDescriptor(), key);
    return other != nullptr && is_present(message, *other);
  }

  void check_tables(const Message& message, const FieldDescriptor& field, const std::string& path) {
    const Reflection& reflection = *message.GetReflection();
    if (!field.is_repeated()) {
      if (key_of(field).only_if_given() && !reflection.HasField(message, &field)) return;
      return check_message(reflection.GetMessage(message, &field), path);
    }
    const int count = reflection.FieldSize(message, &field);
    if (!add(count_fault(field, static_cast<std::size_t>(count), path))) return;
    for (int i = 0; i < count; ++i)
      check_message(reflection.GetRepeatedMessage(message, &field, i),
                    element_path(path, static_cast<std::size_t>(i)));
  }

  void check_curve(const v1::Curve& curve, const FieldDescriptor& field, const std::string& path) {
    if (curve.value_size() == 0 && curve.at_size() == 0)
      return add(path, "", "an empty table", "at least one point");
    if (curve.value_size() != curve.at_size())
      return add(path, fmt::format("{} abscissae, {} values", curve.at_size(), curve.value_size()),
                 "as many values as abscissae are needed");
    if (!add(count_fault(field, static_cast<std::size_t>(curve.at_size()), path))) return;

    for (int i = 0; i < curve.value_size(); ++i)
      check_number(field, curve.value(i), element_path(path, static_cast<std::size_t>(i)));

    // A single point is a constant and needs no abscissa; but a number that names none is a fault.
    const auto permitted = abscissae_of(field);
    const bool is_constant = curve.at_size() == 1 && v1::Abscissa_IsValid(curve.abscissa());
    if (!is_constant && std::ranges::count(permitted, curve.abscissa()) == 0)
      add(path, abscissa_name(curve.abscissa()), "not a permitted abscissa of this table");
    check_abscissae(curve, path);
  }

  void check_abscissae(const v1::Curve& curve, const std::string& path) {
    for (int i = 0; i < curve.at_size(); ++i) {
      const std::string point = element_path(path, static_cast<std::size_t>(i));
      if (!std::isfinite(curve.at(i)))
        add(point, number_text(curve.at(i)), "not a finite number");
      else if (i > 0 && !(curve.at(i) > curve.at(i - 1)))
        add(point, quantity_text(curve.at(i), abscissa_unit(curve.abscissa())),
            "must be larger than that of the point before it", "strictly increasing");
    }
  }

  void check_scalar(const Message& message, const FieldDescriptor& field, const std::string& path) {
    const Reflection& reflection = *message.GetReflection();
    if (const auto number = number_of(message, field)) return check_number(field, *number, path);
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
      add(text_fault(field, reflection.GetString(message, &field), path));
    } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
      const int number = reflection.GetEnumValue(message, &field);
      if (field.enum_type()->FindValueByNumber(number) == nullptr)
        add(path, std::to_string(number), "unknown choice");
    }
  }

  void check_number(const FieldDescriptor& field, double number, const std::string& path) {
    add(range_fault(field, number, path, quantity_text(number, key_of(field).unit()), ""));
  }
};

}  // namespace

std::vector<v1::Fault> check_ranges(const Message& message) {
  RangeCheck check;
  check.check_message(message, "");
  if (const auto* c = dynamic_cast<const v1::Case*>(&message)) {
    check.check_depth(*c);
    check.check_stirring(c->alloy());
    check.check_creep(c->alloy());
    check.check_gravity(c->mechanics());
    for (int i = 0; i < c->monitor_size(); ++i)
      check.check_monitor(c->monitor(i), element_path("monitor", std::size_t(i)));
  }
  return std::move(check.faults);
}

}  // namespace dccast::case_file
