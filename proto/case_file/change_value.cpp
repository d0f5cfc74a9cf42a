#include <algorithm>
#include <charconv>

#include "proto/case_file/quantity.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/case_file/toml_walker.hpp"

namespace dccast::case_file {
namespace {

constexpr std::string_view prefix = "value = ";

/// A text for the parser with the column of each of its characters in the text as written.
struct TracedText {
  std::string text{prefix};
  std::vector<int> columns = std::vector<int>(prefix.size(), 1);  // (character)

  /// Appends bytes as written, from `column` on.
  void append_written(std::string_view part, int column) {
    for (const char c : part) append(std::string_view(&c, 1), column++);
  }

  /// Appends bytes that all correspond to the text at one column.
  void append(std::string_view part, int column) {
    text += part;
    for (const char c : part)
      if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) columns.push_back(column);
  }
};

/// Whether a word is a TOML value without quotes.
bool is_literal(std::string_view word) {
  if (word == "true" || word == "false") return true;
  const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
  double number = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc{} && end == digits.data() + digits.size();
}

/// Adds quotes to the words of a list that a shell has removed.
TracedText quote_words(std::string_view value) {
  TracedText text;
  std::size_t end = 0;
  for (std::size_t begin = 0; begin < value.size(); begin = end) {
    // A part is a string in quotes, a word, or one character of punctuation.
    const char first = value[begin];
    const bool in_quotes = first == '"' || first == '\'';
    const bool is_word = !in_quotes && std::string_view("[],").find(first) == std::string::npos;
    end = in_quotes ? string_end(value, begin)
          : is_word ? std::min(value.find_first_of("[],\"'", begin), value.size())
                    : begin + 1;

    const std::string_view part = value.substr(begin, end - begin);
    const std::string_view word = is_word ? trimmed(part) : std::string_view();
    const int column = static_cast<int>(begin) + 1;
    if (word.empty())
      text.append_written(part, column);
    else if (const int offset = static_cast<int>(word.data() - part.data()); is_literal(word))
      text.append_written(word, column + offset);
    else
      text.append(quoted(std::string(word)), column + offset);
  }
  return text;
}

/// Parses a text with one key; nothing if it is not TOML.
std::optional<toml::table> parse_one_key(const std::string& text) {
  if (check_text(text)) return std::nullopt;
  try {
    toml::table table = toml::parse(text);
    if (table.size() == 1) return table;
  } catch (const toml::parse_error&) {
  }
  return std::nullopt;
}

bool holds_text(const FieldDescriptor* field) {
  return field != nullptr && (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING ||
                              field->cpp_type() == FieldDescriptor::CPPTYPE_ENUM);
}

}  // namespace

ChangeValue change_value(const std::string& written, const FieldDescriptor* field) {
  const bool in_quotes = written.starts_with('"') || written.starts_with('\'');
  std::vector<TracedText> readings;
  if (!holds_text(field) || in_quotes) readings.emplace_back().append_written(written, 1);
  if (written.starts_with('[')) readings.push_back(quote_words(written));

  for (const TracedText& reading : readings)
    if (auto table = parse_one_key(reading.text)) return {std::move(*table), reading.columns};

  // Any other text is a string.
  TracedText as_string;
  as_string.append(quoted(written), 1);
  return {toml::table{{"value", written}}, as_string.columns};
}

}  // namespace dccast::case_file
