#include "proto/case_file/text_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "proto/case_file/case_file.hpp"
#include "proto/values/printable.hpp"

namespace dccast::case_file {

namespace {

/// Line and column of a byte of the text.
Position find_position(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line_start = before.rfind('\n');
  const auto column = line_start == std::string_view::npos ? offset : offset - line_start - 1;
  return {static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1,
          static_cast<int>(column) + 1};
}

}  // namespace

std::optional<TextFault> check_text(std::string_view text) {
  if (text.size() > maximum_file_bytes)
    return TextFault{
        {1, 1},
        fmt::format("the file has {} bytes; at most {} are read", text.size(), maximum_file_bytes),
        "put large tables into a file of their own"};
  if (const auto nul = text.find('\0'); nul != std::string_view::npos)
    return TextFault{find_position(text, nul), "a NUL byte: this is not a text file",
                     "give a TOML file; `dccast new start-2d-thickness` writes one"};
  if (const auto broken = values::first_broken_utf8(text))
    return TextFault{find_position(text, *broken), "not UTF-8", "save the file as UTF-8"};
  return check_nesting(text);
}

// Damerau-Levenshtein distance (optimal string alignment).
int edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<int>> cost(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) cost[i][0] = static_cast<int>(i);
  for (std::size_t j = 0; j <= b.size(); ++j) cost[0][j] = static_cast<int>(j);

  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replace = cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, replace});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
    }
  return cost[a.size()][b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t longest_word = 80;  // bounds the time of the comparison
  if (word.size() > longest_word) return {};

  std::string best;
  int best_distance = std::max(2, static_cast<int>(word.size()) / 3) + 1;
  for (const std::string& candidate : known) {
    // A name with a unit suffix, or an abbreviated one, is similar regardless of its length.
    const bool extended =
        word.size() > 3 && (word.starts_with(candidate + "_") || candidate.starts_with(word));
    const int distance = extended ? 1 : edit_distance(word, candidate);
    if (distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::size_t string_end(std::string_view text, std::size_t begin) {
  const char quote = text[begin];
  const std::string three(3, quote);
  const bool several_lines = text.substr(begin).starts_with(three);

  for (std::size_t i = begin + (several_lines ? 3 : 1); i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\')
      ++i;  // the character after it is escaped
    else if (several_lines && text.substr(i).starts_with(three))
      return i + 3;
    else if (!several_lines && (text[i] == quote || text[i] == '\n'))
      return i + 1;
  }
  return text.size();
}

std::optional<TextFault> check_nesting(std::string_view text) {
  int brackets = 0, dots = 0;  // open brackets, and dots of a key
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];

    // Brackets and dots in strings and comments do not count.
    if (c == '"' || c == '\'') {
      i = string_end(text, i);
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }

    if (c == '[' || c == '{') ++brackets;
    if (c == ']' || c == '}') brackets = std::max(0, brackets - 1);
    if (c == '.') ++dots;
    if (c == '=' || c == ',' || c == '\n') dots = 0;

    if (std::max(brackets, dots) > maximum_nesting)
      return TextFault{find_position(text, i),
                       fmt::format("keys or lists are nested more than {} deep", maximum_nesting),
                       "see `dccast schema` for the tables of a case"};
    ++i;
  }
  return std::nullopt;
}

}  // namespace dccast::case_file
