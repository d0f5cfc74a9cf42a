#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "proto/case_file/schema.hpp"

/// How long a text and a table may be. A case is kept, listed and reported by a daemon that serves
/// others, so nothing in it is without a bound; keys that state none have the general one.
namespace dccast::case_file {

/// Most bytes of a text whose key states no bound.
inline constexpr std::size_t general_maximum_length = 1000;

/// Most entries of a table, or points of a curve, whose key states no bound.
inline constexpr std::size_t general_maximum_count = 10000;

std::size_t maximum_length(const FieldDescriptor& field);
std::size_t maximum_count(const FieldDescriptor& field);

/// "at most 200 bytes", "at most 1000 entries", "at most 10000 points"; empty for other keys.
std::string size_text(const FieldDescriptor& field);

/// What is wrong with the length of a text, or nothing. The fault holds only the text's beginning.
std::optional<v1::Fault> length_fault(const FieldDescriptor& field, const std::string& text,
                                      const std::string& path);

/// What is wrong with the number of entries or points, or nothing.
std::optional<v1::Fault> count_fault(const FieldDescriptor& field, std::size_t count,
                                     const std::string& path);

}  // namespace dccast::case_file
