#include "proto/case_file/quantity.hpp"

#include <fmt/format.h>
#include <udunits2.h>

#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "proto/values/owned.hpp"
#include "proto/values/printable.hpp"

namespace dccast::case_file {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 25> suffixes{{
    {"", ""},
    {"1", ""},
    {"m", "_m"},
    {"s", "_s"},
    {"degC", "_c"},
    {"bytes", "_bytes"},
    {"rad", "_rad"},
    {"m/s", "_m_per_s"},
    {"m2/s", "_m2_per_s"},
    {"m/s2", "_m_per_s2"},
    {"s-1", "_per_s"},
    {"kg/m3", "_kg_per_m3"},
    {"J/kg", "_j_per_kg"},
    {"J/(kg K)", "_j_per_kg_k"},
    {"J/mol", "_j_per_mol"},
    {"W/m2", "_w_per_m2"},
    {"W/(m K)", "_w_per_m_k"},
    {"W/(m2 K)", "_w_per_m2_k"},
    {"Pa", "_pa"},
    {"Pa s", "_pa_s"},
    {"Pa/s", "_pa_per_s"},
    {"Pa/m", "_pa_per_m"},
    {"m/Pa", "_m_per_pa"},
    {"Pa-1 s-1", "_per_pa_s"},
    {"K", "_k"},
}};

constexpr std::size_t maximum_unit_length = 64;  // no real unit is longer

using Unit = values::Owned<ut_unit, ut_free>;
using Converter = values::Owned<cv_converter, cv_free>;

/// UDUNITS-2 keeps its parser's state in globals, so one call at a time.
std::mutex& udunits_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// The units database, read once. Must be called with the mutex held.
ut_system* unit_system() {
  static ut_system* const system = [] {
    ut_set_error_message_handler(ut_ignore);
    ut_system* const read = ut_read_xml(nullptr);
    if (read == nullptr)
      throw std::runtime_error(
          "the units database of UDUNITS-2 cannot be read; is libudunits2-data installed?");

    // The database has the byte only by its name.
    const Unit byte(ut_parse(read, "byte", UT_UTF8));
    ut_map_symbol_to_unit("B", UT_UTF8, byte.get());

    // Water of American plants; the database has the geopotential metre of that name.
    const Unit gallons(ut_parse(read, "US_liquid_gallon/min", UT_UTF8));
    ut_unmap_symbol_to_unit(read, "gpm", UT_UTF8);
    ut_map_symbol_to_unit("gpm", UT_UTF8, gallons.get());
    return read;
  }();
  return system;
}

/// Null if the dimensions differ or a unit is unknown. Must be called with the mutex held.
Converter make_converter(const std::string& from, const std::string& to) {
  const Unit source(ut_parse(unit_system(), from.c_str(), UT_UTF8));
  const Unit target(ut_parse(unit_system(), to.c_str(), UT_UTF8));
  if (!source || !target) return nullptr;
  return Converter(ut_get_converter(source.get(), target.get()));
}

/// Must be called with the mutex held.
bool is_known(const std::string& unit) {
  return Unit(ut_parse(unit_system(), unit.c_str(), UT_UTF8)) != nullptr;
}

/// Whether a unit contains a number that begins with zero, as in "mm/0s": meaningless, and
/// UDUNITS-2 leaks the word after such a zero.
bool has_zero(const std::string& unit) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  for (std::size_t i = unit.find('0'); i != std::string::npos; i = unit.find('0', i + 1))
    if (i == 0 || !digit(unit[i - 1])) return true;
  return false;
}

/// Whether a text can be a unit of a case. UDUNITS-2 also reads time stamps, logarithmic references
/// and offsets, which cannot.
bool is_plain_unit(const std::string& unit) {
  if (has_zero(unit)) return false;
  if (unit.size() > maximum_unit_length || unit.find('@') != std::string::npos) return false;
  if (unit.find_first_of("0123456789+-.") == 0) return false;
  for (const char* const word : {"since", "after", "from", "ref", "re ", "re:", "RE", "(re"})
    if (unit.find(word) != std::string::npos) return false;
  return true;
}

Quantity refused(std::string unit, std::string message) {
  return {std::nullopt, std::move(unit), std::move(message)};
}

/// A remark on units that are easily confused.
std::string confusion_hint(const std::string& unit, const std::string& wanted) {
  if (wanted == "degC" && unit == "C") return " (C is the coulomb; write degC or °C)";
  if (wanted == "degC" && unit == "F") return " (F is the farad; write degF or °F)";
  return {};
}

Quantity convert_to(double number, const std::string& unit, const std::string& wanted) {
  const std::lock_guard lock(udunits_mutex());
  if (!is_plain_unit(unit) || !is_known(unit))
    return refused(unit, fmt::format("unknown unit '{}'", values::shortened(unit)));

  const Converter converter = make_converter(unit, wanted);
  if (!converter)
    return refused(unit, fmt::format("unit '{}' is of another kind than {}{}", unit, wanted,
                                     confusion_hint(unit, wanted)));

  const double value = cv_convert_double(converter.get(), number);
  if (!std::isfinite(value)) return refused(unit, "not a finite number");
  return {value, unit, {}};
}

}  // namespace

std::optional<std::string_view> unit_suffix(std::string_view unit) {
  for (const auto& [name, suffix] : suffixes)
    if (name == unit) return suffix;
  return std::nullopt;
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

Quantity parse_quantity(std::string_view text, const std::string& unit) {
  const std::string_view body = trimmed(text);
  const std::string_view digits = body.starts_with('+') ? body.substr(1) : body;
  double number = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error == std::errc::result_out_of_range) return refused({}, "number too large or too small");
  if (error != std::errc{}) return refused({}, "no number at its beginning");
  if (!std::isfinite(number)) return refused({}, "not a finite number");

  const std::string_view rest = trimmed(digits.substr(end - digits.data()));
  if (rest.starts_with(',')) return refused({}, "decimal comma; write a point");
  if (!rest.empty()) return convert_to(number, std::string(rest), unit.empty() ? "1" : unit);
  if (unit.empty() || unit == "1") return {number, {}, {}};
  return refused({}, "the unit is missing");
}

bool convertible(const std::string& from, const std::string& to) {
  const std::lock_guard lock(udunits_mutex());
  return is_plain_unit(from) && make_converter(from, to) != nullptr;
}

std::optional<double> convert(double value, const std::string& from, const std::string& to) {
  const std::lock_guard lock(udunits_mutex());
  const Converter converter = make_converter(from, to);
  if (!converter) return std::nullopt;
  return cv_convert_double(converter.get(), value);
}

std::string number_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string quantity_text(double value, const std::string& unit) {
  if (unit.empty() || unit == "1") return number_text(value);
  return fmt::format("{} {}", number_text(value), unit);
}

std::string quoted(const std::string& text) {
  std::string result(1, '"');
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      result += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  result += '"';
  return result;
}

}  // namespace dccast::case_file
