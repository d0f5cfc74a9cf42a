#include "client/model/typed_castings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <ranges>
#include <sstream>
#include <utility>

#include "client/model/csv_line.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/values/times.hpp"

namespace dccast::client {
namespace {

using Casting = v1::LineCasting;

std::string fault(const std::string& name, const std::string& value, const std::string& permitted) {
  return fmt::format("{} = {} cannot be read; permitted: {}", name, value, permitted);
}

std::optional<double> length_m(const std::string& text) {
  return case_file::parse_quantity(text, "m").value;
}

/// "38 41 35 37 mm" [m]; empty: it cannot be read.
std::vector<double> curls_m(const std::string& text) {
  std::vector<double> curls;
  std::istringstream words(text);
  std::vector<std::string> parts;
  for (std::string part; words >> part;) parts.push_back(part);
  if (parts.size() < 2) return {};
  for (auto part = parts.begin(); part + 1 != parts.end(); ++part) {
    const auto curl = length_m(*part + " " + parts.back());
    if (!curl) return {};
    curls.push_back(*curl);
  }
  return curls;
}

std::optional<std::int64_t> count_of(const std::string& text) {
  std::int64_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return count;
}

/// A table of castings while it is read.
class CastingTable {
public:
  CastingTable(const std::string& name, std::int64_t now) : name_(name), now_(now) {}

  TypedCastings read(std::istream& stream) {
    for (std::string line; std::getline(stream, line);) {
      ++number_;
      if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
      if (!columns_.empty()) {
        read_row(line);
        continue;
      }
      read_header(line);
      if (!read_.faults.empty()) return read_;
    }
    if (read_.castings.empty() && read_.faults.empty()) add_fault("has no casting");
    return read_;
  }

private:
  using Words = std::string TypedWords::*;  ///< null: the recipe
  using Column = std::pair<std::string, Words>;

  void add_fault(const std::string& text) {
    read_.faults.push_back(fmt::format("{}:{}: {}", name_, number_, text));
  }

  void read_header(const std::string& line) {
    static const std::vector<Column> known{
        {"recipe", nullptr},           {"outcome", &TypedWords::outcome},
        {"count", &TypedWords::count}, {"at", &TypedWords::at},
        {"curl", &TypedWords::curl},   {"sawn off", &TypedWords::sawn_off},
        {"date", &TypedWords::date}};
    separator_ = separator_of(line);
    for (const std::string& cell : cells_of(line, separator_)) {
      const auto found = std::ranges::find(known, lowered(cell), &Column::first);
      if (found != known.end())
        columns_.push_back(found->second);
      else
        add_fault(fmt::format("column \"{}\" is not known; permitted: {}", cell,
                              fmt::join(known | std::views::keys, ", ")));
    }
    if (!std::ranges::count(columns_, Words(nullptr)))
      add_fault("no column is named recipe; it has jobs or case files");
  }

  void read_row(const std::string& line) {
    const auto cells = cells_of(line, separator_, columns_.size());
    if (cells.size() > columns_.size()) {
      add_fault(
          fmt::format("{} cells; permitted: {}, as the header has", cells.size(), columns_.size()));
      return;
    }
    TypedWords words;
    std::string recipe;
    for (std::size_t i = 0; i < cells.size(); ++i)
      (columns_[i] == nullptr ? recipe : words.*columns_[i]) = cells[i];
    if (recipe.empty()) add_fault("recipe is empty; permitted: a job or a case file");

    auto& casting = read_.castings.emplace_back();
    casting.mutable_record()->set_count(1);
    for (const std::string& text : read_typed(words, now_, *casting.mutable_record()))
      add_fault(text);
    const auto there = std::ranges::find(read_.recipes, recipe);
    casting.set_recipe(static_cast<int>(there - read_.recipes.begin()));
    if (there == read_.recipes.end()) read_.recipes.push_back(recipe);
    read_.lines.push_back(number_);
  }

  const std::string& name_;
  const std::int64_t now_;
  int number_ = 0;  ///< of the line
  char separator_ = ',';
  std::vector<Words> columns_;
  TypedCastings read_;
};

}  // namespace

std::vector<std::string> read_typed(const TypedWords& words, std::int64_t now, Casting& record) {
  std::vector<std::string> faults;
  if (!words.outcome.empty()) {
    const auto outcome = case_file::outcome_of(words.outcome);
    if (!outcome) faults.push_back(fault("outcome", words.outcome, case_file::outcome_words()));
    record.set_outcome(outcome.value_or(record.outcome()));
  }
  if (!words.count.empty()) {
    const auto count = count_of(words.count);
    if (!count) faults.push_back(fault("count", words.count, "a whole number"));
    record.set_count(count.value_or(1));
  }
  if (!words.at.empty()) {
    const auto at = length_m(words.at);
    if (!at) faults.push_back(fault("at", words.at, "a cast length, as 40 mm"));
    record.set_at_m(at.value_or(0.0));
  }
  if (!words.curl.empty()) {
    const auto curls = curls_m(words.curl);
    if (curls.empty())
      faults.push_back(fault("curl", words.curl, "numbers and one unit, as 38 41 35 37 mm"));
    record.mutable_cold_curl_m()->Assign(curls.begin(), curls.end());
  }
  if (!words.sawn_off.empty()) {
    const auto sawn_off = length_m(words.sawn_off);
    if (!sawn_off) faults.push_back(fault("sawn off", words.sawn_off, "a length, as 60 mm"));
    record.set_sawn_off_m(sawn_off.value_or(0.0));
  }
  if (!words.date.empty()) {
    const auto date = values::past_time(words.date, now);
    if (!date) faults.push_back(fault("date", words.date, values::past_times));
    record.mutable_begin_time()->set_seconds(date.value_or(0));
  }
  return faults;
}

TypedCastings read_castings(std::istream& stream, const std::string& name, std::int64_t now) {
  return CastingTable(name, now).read(stream);
}

}  // namespace dccast::client
