#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "proto/case_file/schema.hpp"

/// Limits on the length of texts and tables. A case is stored, listed and reported by a daemon that
/// serves several users, so everything in it has a limit; keys without a limit of their own have
/// the general one.
namespace dccast::case_file {

/// Largest length of a text whose key has no limit of its own [bytes].
inline constexpr std::size_t general_maximum_length = 1000;

/// Largest number of entries of a table, or points of a curve, whose key has no limit of its own.
inline constexpr std::size_t general_maximum_count = 10000;

std::size_t maximum_length(const FieldDescriptor& field);
std::size_t maximum_count(const FieldDescriptor& field);

/// "at most 200 bytes", "at most 1000 entries", "at most 10000 points"; empty for other keys.
std::string size_text(const FieldDescriptor& field);

/// The fault of a text that is too long, or has a character that acts on a terminal or a log; empty
/// if there is none. The fault contains only the beginning of the text.
std::optional<v1::Fault> text_fault(const FieldDescriptor& field, const std::string& text,
                                    const std::string& path);

/// The fault of too many entries or points; empty if there is none.
std::optional<v1::Fault> count_fault(const FieldDescriptor& field, std::size_t count,
                                     const std::string& path);

}  // namespace dccast::case_file
