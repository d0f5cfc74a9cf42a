#include "proto/case_file/change_value.hpp"

#include <algorithm>
#include <charconv>

#include "proto/case_file/quantity.hpp"
#include "proto/case_file/text_checks.hpp"

namespace dccast::case_file {
namespace {

constexpr std::string_view prefix = "value = ";

/// A text for the parser that knows for each of its characters where it was written.
class TracedText {
public:
  /// Appends bytes of which each stands where it was written, from `column` on.
  void append_written(std::string_view part, int column) {
    for (const char c : part) append(std::string_view(&c, 1), column++);
  }

  /// Appends bytes that all come from one place.
  void append(std::string_view part, int column) {
    text_ += part;
    for (const char c : part)
      if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) columns_.push_back(column);
  }

  const std::string& text() const { return text_; }
  const std::vector<int>& columns() const { return columns_; }

private:
  std::string text_;
  std::vector<int> columns_;  // by character, as the parser counts them
};

bool is_literal(std::string_view word) {
  if (word == "true" || word == "false") return true;
  const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
  double number = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc{} && end == digits.data() + digits.size();
}

/// A word of a list, with the quotes that a shell may have taken.
void append_word(TracedText& text, std::string_view word, int column) {
  const auto first = word.find_first_not_of(" \t");
  if (first == std::string_view::npos) return text.append_written(word, column);
  const auto last = word.find_last_not_of(" \t");
  const std::string_view core = word.substr(first, last - first + 1);
  column += static_cast<int>(first);
  if (is_literal(core)) return text.append_written(core, column);
  text.append(quoted(std::string(core)), column);
}

/// End of the quoted text that begins at `begin`, or the end of the value.
std::size_t end_of_quotes(std::string_view value, std::size_t begin) {
  const char quote = value[begin];
  for (std::size_t i = begin + 1; i < value.size(); ++i) {
    if (quote == '"' && value[i] == '\\')
      ++i;
    else if (value[i] == quote)
      return i + 1;
  }
  return value.size();
}

/// A list whose words may lack their quotes.
TracedText quoted_list(std::string_view value) {
  TracedText text;
  text.append(prefix, 1);
  std::size_t at = 0;
  while (at < value.size()) {
    const int column = static_cast<int>(at) + 1;
    std::size_t end = at + 1;
    if (value[at] == '"' || value[at] == '\'') {
      end = end_of_quotes(value, at);
      text.append_written(value.substr(at, end - at), column);
    } else if (std::string_view("[],").find(value[at]) != std::string_view::npos) {
      text.append_written(value.substr(at, 1), column);
    } else {
      end = std::min(value.find_first_of("[],\"'", at), value.size());
      append_word(text, value.substr(at, end - at), column);
    }
    at = end;
  }
  return text;
}

TracedText plain(std::string_view value) {
  TracedText text;
  text.append(prefix, 1);
  text.append_written(value, 1);
  return text;
}

TracedText as_string(const std::string& value) {
  TracedText text;
  text.append(prefix, 1);
  text.append(quoted(value), 1);
  return text;
}

std::optional<toml::table> parsed(const TracedText& text) {
  if (check_text(text.text())) return std::nullopt;
  try {
    toml::table table = toml::parse(text.text());
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
  if (!holds_text(field) || in_quotes) readings.push_back(plain(written));
  if (written.starts_with('[')) readings.push_back(quoted_list(written));
  for (const TracedText& reading : readings)
    if (auto table = parsed(reading)) return {std::move(*table), reading.columns()};
  const TracedText text = as_string(written);
  toml::table table;
  table.insert("value", written);
  return {std::move(table), text.columns()};
}

}  // namespace dccast::case_file
