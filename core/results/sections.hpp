#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace dccast::results {

/// Named arrays of exact values: the content of a checkpoint and of each record of a journal. The
/// bytes are described in CHECKPOINT.md.
///
/// Units: reals are in SI units and °C.
class Sections {
public:
  /// Kinds of values; a section has one of them.
  using Reals = std::vector<double>;
  using Integers = std::vector<std::int64_t>;
  using Value = std::variant<Reals, Integers, std::string>;

  void set(std::string name, Value value) { values_[std::move(name)] = std::move(value); }
  void set_real(std::string name, double value) { set(std::move(name), Reals{value}); }
  void set_integer(std::string name, std::int64_t value) { set(std::move(name), Integers{value}); }

  bool has(std::string_view name) const { return values_.find(name) != values_.end(); }
  /// @throws std::out_of_range  there is no section with that name and type
  const Reals& reals(std::string_view name) const { return get<Reals>(name); }
  /// The value of a section. @throws std::out_of_range  it is missing or of another kind
  const Integers& integers(std::string_view name) const { return get<Integers>(name); }
  const std::string& text(std::string_view name) const { return get<std::string>(name); }
  double real(std::string_view name) const { return reals(name).at(0); }
  std::int64_t integer(std::string_view name) const { return integers(name).at(0); }

  /// All sections by name, for writing.
  const std::map<std::string, Value, std::less<>>& all() const { return values_; }

private:
  template <class T>
  const T& get(std::string_view name) const {
    const auto found = values_.find(name);
    if (found == values_.end() || !std::holds_alternative<T>(found->second))
      throw std::out_of_range("no section '" + std::string(name) + "' of that type");
    return std::get<T>(found->second);
  }

  std::map<std::string, Value, std::less<>> values_;
};

/// The bytes of sections.
std::string encode(const Sections& sections);
/// @return nothing if the bytes were not written by encode()
std::optional<Sections> decode(std::string_view bytes);

}  // namespace dccast::results
