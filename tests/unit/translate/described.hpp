#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "core/base/curve.hpp"

/// All members of a struct as text, without a list of them: what is added to a struct of core is
/// described, too. Numbers are written to the last bit.
namespace dccast::testing {

/// Whatever a member is initialised with.
struct Anything {
  template <class Member>
  operator Member&() const;
};

template <class Struct, std::size_t... I>
constexpr bool takes(std::index_sequence<I...>) {
  return requires {
    Struct{(void(I), Anything{})...};
  };
}

/// Number of members of an aggregate.
template <class Struct, std::size_t N = 0>
constexpr std::size_t members() {
  if constexpr (takes<Struct>(std::make_index_sequence<N + 1>()))
    return members<Struct, N + 1>();
  else
    return N;
}

class Description {
public:
  template <class Value>
  Description& add(const Value& value) {
    if constexpr (std::is_enum_v<Value>)
      text_ += fmt::format("{};", static_cast<int>(value));
    else if constexpr (std::is_arithmetic_v<Value>)
      text_ += fmt::format("{:a};", static_cast<double>(value));
    else
      add_all_of(value);
    return *this;
  }
  const std::string& text() const { return text_; }

private:
  void add_all_of(const std::string& value) { text_ += fmt::format("{}:{};", value.size(), value); }
  void add_all_of(const std::filesystem::path& value) { add(value.string()); }
  void add_all_of(const Curve& curve) { add(curve.abscissa()).add(curve.at()).add(curve.value()); }

  template <class Value>
  void add_all_of(const std::optional<Value>& value) {
    add(value.has_value());
    if (value) add(*value);
  }
  template <class Value>
  void add_all_of(const std::vector<Value>& values) {
    add(values.size());
    for (const Value& value : values) add(value);
  }
  template <class Value>
  void add_all_of(const std::map<std::string, Value>& values) {
    add(values.size());
    for (const auto& [name, value] : values) add(name).add(value);
  }
  template <class... Values>
  void add_all_of(const std::variant<Values...>& value) {
    add(value.index());
    std::visit([this](const auto& held) { add(held); }, value);
  }

  template <class Struct>
  void add_all_of(const Struct& value) {
    const auto add_each = [this](const auto&... member) { (add(member), ...); };
    constexpr std::size_t count = members<Struct>();
    // clang-format off
#define DCCAST_OF(number, ...) \
    if constexpr (count == number) { const auto& [__VA_ARGS__] = value; add_each(__VA_ARGS__); }
    DCCAST_OF(1, a)
    DCCAST_OF(2, a, b)
    DCCAST_OF(3, a, b, c)
    DCCAST_OF(4, a, b, c, d)
    DCCAST_OF(5, a, b, c, d, e)
    DCCAST_OF(6, a, b, c, d, e, f)
    DCCAST_OF(7, a, b, c, d, e, f, g)
    DCCAST_OF(8, a, b, c, d, e, f, g, h)
    DCCAST_OF(9, a, b, c, d, e, f, g, h, i)
    DCCAST_OF(10, a, b, c, d, e, f, g, h, i, j)
    DCCAST_OF(11, a, b, c, d, e, f, g, h, i, j, k)
    DCCAST_OF(12, a, b, c, d, e, f, g, h, i, j, k, l)
    DCCAST_OF(13, a, b, c, d, e, f, g, h, i, j, k, l, m)
    DCCAST_OF(14, a, b, c, d, e, f, g, h, i, j, k, l, m, n)
    DCCAST_OF(15, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o)
    DCCAST_OF(16, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p)
    DCCAST_OF(17, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q)
    DCCAST_OF(18, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r)
    DCCAST_OF(19, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s)
    DCCAST_OF(20, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t)
    DCCAST_OF(21, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u)
    DCCAST_OF(22, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v)
    // clang-format on
#undef DCCAST_OF
    static_assert(count >= 1 && count <= 22, "another number of members needs its line above");
  }

  std::string text_;
};

}  // namespace dccast::testing
