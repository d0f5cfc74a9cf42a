#include "proto/case_file/nesting.hpp"

#include <algorithm>
#include <string>

namespace dccast::case_file {
namespace {

/// Where the string that begins at `at` ends: behind its last quote, or at the end of the line or
/// text that it leaves open.
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

/// Counts what is open at a place of the text.
class Depth {
public:
  bool too_deep() const { return std::max(brackets_, dots_) > maximum_nesting; }

  void pass(char c) {
    if (c == '[' || c == '{') ++brackets_;
    if (c == ']' || c == '}') brackets_ = std::max(0, brackets_ - 1);
    if (c == '.') ++dots_;
    if (c == '=' || c == ',' || c == '\n') dots_ = 0;
  }

private:
  int brackets_ = 0;
  int dots_ = 0;
};

}  // namespace

std::optional<TextFault> check_nesting(std::string_view text) {
  Depth depth;
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '"' || text[at] == '\'') {
      at = end_of_string(text, at);
    } else if (text[at] == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else {
      depth.pass(text[at]);
      if (depth.too_deep())
        return TextFault{
            position_of(text, at),
            "keys or lists are nested more than " + std::to_string(maximum_nesting) + " deep",
            "see `dccast schema` for the tables of a case"};
      ++at;
    }
  }
  return std::nullopt;
}

}  // namespace dccast::case_file
