#include "proto/case_file/text_checks.hpp"

#include <algorithm>
#include <string>

#include "proto/case_file/case_file.hpp"
#include "proto/values/printable.hpp"

namespace dccast::case_file {

namespace {

/// Line and column of a byte of the text.
Position position_of(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line_start = before.rfind('\n');
  const auto column = line_start == std::string_view::npos ? offset : offset - line_start - 1;
  return {static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1,
          static_cast<int>(column) + 1};
}

}  // namespace

std::optional<TextFault> check_text(std::string_view text) {
  if (text.size() > maximum_file_bytes)
    return TextFault{{1, 1},
                     "the file has " + std::to_string(text.size()) + " bytes; at most " +
                         std::to_string(maximum_file_bytes) + " are read",
                     "tables that large belong into a file of their own"};
  if (const auto nul = text.find('\0'); nul != std::string_view::npos)
    return TextFault{position_of(text, nul), "a NUL byte: this is not a text file",
                     "give a TOML file; `dccast new start-2d-thickness` writes one"};
  if (const auto broken = values::first_broken_utf8(text))
    return TextFault{position_of(text, *broken), "not UTF-8", "save the file as UTF-8"};
  return check_nesting(text);
}

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
  constexpr std::size_t longest_word = 80;  // a key longer than this resembles none
  if (word.size() > longest_word) return {};
  std::string best;
  int best_distance = std::max(2, static_cast<int>(word.size()) / 3) + 1;
  for (const std::string& candidate : known) {
    // A name given with its unit suffix, or cut short, is near whatever its length.
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

std::size_t end_of_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string three(3, quote);
  const bool several_lines = text.substr(at).starts_with(three);
  for (at += several_lines ? 3 : 1; at < text.size(); ++at) {
    if (quote == '"' && text[at] == '\\')
      ++at;
    else if (several_lines && text.substr(at).starts_with(three))
      return at + 3;
    else if (!several_lines && (text[at] == quote || text[at] == '\n'))
      return at + 1;
  }
  return text.size();
}

std::optional<TextFault> check_nesting(std::string_view text) {
  int brackets = 0, dots = 0;  // open brackets, and dots of a key
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at = end_of_string(text, at);
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (c == '[' || c == '{') ++brackets;
    if (c == ']' || c == '}') brackets = std::max(0, brackets - 1);
    if (c == '.') ++dots;
    if (c == '=' || c == ',' || c == '\n') dots = 0;
    if (std::max(brackets, dots) > maximum_nesting)
      return TextFault{
          position_of(text, at),
          "keys or lists are nested more than " + std::to_string(maximum_nesting) + " deep",
          "see `dccast schema` for the tables of a case"};
    ++at;
  }
  return std::nullopt;
}

}  // namespace dccast::case_file
