#include <fmt/format.h>

#include "proto/case_file/quantity.hpp"
#include "proto/case_file/toml_walker.hpp"

namespace dccast::case_file {
namespace {

/// Width of a jump of the factor in a table that is interpolated linearly: 1 ms, or the 1 um that a
/// slab moves in this time at 60 mm/min. No time step resolves it.
constexpr double step_width_s = 1e-3;
constexpr double step_width_m = 1e-6;

const char* const example = "e.g. \"0.8 until 100 mm\" or \"1.1 from 20 s until 60 s\"";

/// A part of a recipe and its offset in the text.
struct Part {
  std::string text;
  std::size_t offset = 0;
};

/// The parts of "FACTOR from PLACE until PLACE".
struct WrittenRecipe {
  Part factor;
  std::optional<Part> from, until;
};

/// One value of the abscissa that a recipe names.
struct Place {
  v1::Abscissa abscissa = v1::ABSCISSA_UNSPECIFIED;
  double at = 0.0;
};

/// Adds a fault at a part of a recipe.
void refuse(Walk& walk, const std::string& path, const Part& part, const std::string& message,
            const std::string& permitted) {
  walk.outcome.faults.push_back(make_fault(path, quoted(part.text), message, permitted, example));
  walk.outcome.source.set(path, {1, static_cast<int>(part.offset) + 1});
}

/// The part that follows a word, which begins at `word`, up to `end`.
Part part_after(const std::string& text, std::size_t word, std::size_t length, std::size_t end) {
  const std::size_t begin = word + length;
  return {std::string(trimmed(std::string_view(text).substr(begin, end - begin))), word + 1};
}

WrittenRecipe split_recipe(const std::string& text) {
  constexpr std::string_view from = " from ", until = " until ";
  const std::size_t until_at = text.find(until);
  const std::size_t from_at = text.substr(0, until_at).find(from);

  WrittenRecipe recipe;
  recipe.factor = {
      std::string(trimmed(std::string_view(text).substr(0, std::min(from_at, until_at)))), 0};
  if (from_at != std::string::npos)
    recipe.from = part_after(text, from_at, from.size(), std::min(until_at, text.size()));
  if (until_at != std::string::npos)
    recipe.until = part_after(text, until_at, until.size(), text.size());
  return recipe;
}

std::optional<double> read_factor(Walk& walk, const Part& part, const FieldDescriptor& field,
                                  const std::string& path) {
  const Quantity quantity = parse_quantity(part.text, key_of(field).unit());
  if (!quantity.value) {
    refuse(walk, path, part, quantity.message, range_text(field));
    return std::nullopt;
  }

  auto fault = range_fault(field, *quantity.value, path, part.text, quantity.unit);
  if (!fault) return quantity.value;
  walk.outcome.faults.push_back(std::move(*fault));
  walk.outcome.source.set(path, {1, 1});
  return std::nullopt;
}

std::optional<Place> read_place(Walk& walk, const Part& part, const FieldDescriptor& field,
                                const std::string& path) {
  std::string permitted, message;
  for (const v1::Abscissa abscissa : abscissae_of(field)) {
    const Quantity quantity = parse_quantity(part.text, abscissa_unit(abscissa));
    if (quantity.value) return Place{abscissa, *quantity.value};
    if (message.empty()) message = quantity.message;
    permitted += fmt::format("{}{} [{}]", permitted.empty() ? "" : " or ", abscissa_name(abscissa),
                             abscissa_unit(abscissa));
  }
  refuse(walk, path, part, message, permitted);
  return std::nullopt;
}

/// The factor between two places, 1 outside.
v1::Curve make_steps(double factor, const std::optional<Place>& from,
                     const std::optional<Place>& until) {
  v1::Curve curve;
  const auto add = [&](double at, double value) {
    curve.add_at(at);
    curve.add_value(value);
  };

  if (!from && !until) add(0.0, factor);
  if (from || until) curve.set_abscissa((from ? from : until)->abscissa);
  const double width = curve.abscissa() == v1::TIME ? step_width_s : step_width_m;
  if (from) add(from->at - width, 1.0);
  if (from) add(from->at - width + width, factor);
  if (until) add(until->at, factor);
  if (until) add(until->at + width, 1.0);
  return curve;
}

/// Checks that the two places of a recipe have the same abscissa and are in order.
/// @return false, with a fault, if they are not
bool check_order(Walk& walk, const WrittenRecipe& recipe, const std::optional<Place>& from,
                 const std::optional<Place>& until, const std::string& path) {
  if (!from || !until) return true;
  if (from->abscissa != until->abscissa)
    refuse(walk, path, *recipe.until, "of another kind than the place that follows 'from'",
           fmt::format("{} [{}]", abscissa_name(from->abscissa), abscissa_unit(from->abscissa)));
  else if (!(until->at > from->at))
    refuse(walk, path, *recipe.until, "not after the place that follows 'from'",
           fmt::format("more than {}", recipe.from->text));
  else
    return true;
  return false;
}

}  // namespace

const FieldDescriptor* recipe_field(const FieldDescriptor& table, std::string_view word) {
  if (!is_curve(table) || (word != "scale" && word != "shift")) return nullptr;
  return field_of_key(*table.containing_type(),
                      toml_key(table) + (word == "scale" ? "_factor" : "_shift"));
}

std::string recipe_paths(const Descriptor& descriptor, const std::string& path) {
  std::vector<std::string> paths;
  for (const FieldDescriptor* const field : fields_of(descriptor))
    for (const char* const word : {"scale", "shift"})
      if (recipe_field(*field, word) != nullptr)
        paths.push_back(join_path(join_path(path, toml_key(*field)), word));
  return joined(paths);
}

v1::Curve read_scale(Walk& walk, const std::string& text, const FieldDescriptor& field,
                     const std::string& path) {
  const WrittenRecipe recipe = split_recipe(text);
  std::optional<Place> from, until;
  const auto factor = read_factor(walk, recipe.factor, field, path);
  if (recipe.from) from = read_place(walk, *recipe.from, field, path);
  if (recipe.until) until = read_place(walk, *recipe.until, field, path);
  const bool valid = factor && from.has_value() == recipe.from.has_value() &&
                     until.has_value() == recipe.until.has_value() &&
                     check_order(walk, recipe, from, until, path);
  return valid ? make_steps(*factor, from, until) : v1::Curve();
}

}  // namespace dccast::case_file
