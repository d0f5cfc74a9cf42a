#include "proto/case_file/unit_suffix.hpp"

#include <array>
#include <utility>

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

}  // namespace

std::optional<std::string> unit_suffix(std::string_view unit) {
  for (const auto& [name, suffix] : suffixes)
    if (name == unit) return std::string(suffix);
  return std::nullopt;
}

}  // namespace dccast::case_file
