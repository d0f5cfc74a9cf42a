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
#include "proto/case_file/quantity.hpp"
#include "proto/values/times.hpp"

namespace dccast::client {
namespace {

using Casting = v1::LineCasting;

const std::vector<std::pair<std::string, Casting::Outcome>> outcomes{
    {"sound", Casting::SOUND},
    {"bled-out", Casting::BLED_OUT},
    {"cracked", Casting::CRACKED},
    {"hung-up", Casting::HUNG_UP},
    {"aborted", Casting::ABORTED}};

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

}  // namespace

std::string outcome_text(Casting::Outcome outcome) {
  const auto found =
      std::ranges::find(outcomes, outcome, &std::pair<std::string, Casting::Outcome>::second);
  return found == outcomes.end() ? "" : found->first;
}

std::vector<std::string> read_typed(const TypedWords& words, std::int64_t now, Casting& record) {
  std::vector<std::string> faults;
  if (!words.outcome.empty()) {
    const auto found = std::ranges::find(outcomes, words.outcome,
                                         &std::pair<std::string, Casting::Outcome>::first);
    if (found == outcomes.end())
      faults.push_back(fault("outcome", words.outcome,
                             fmt::format("{}", fmt::join(outcomes | std::views::keys, ", "))));
    else
      record.set_outcome(found->second);
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
  TypedCastings read;
  std::vector<std::string TypedWords::*> columns;  // null: the recipe
  const std::vector<std::pair<std::string, std::string TypedWords::*>> known{
      {"recipe", nullptr},           {"outcome", &TypedWords::outcome},
      {"count", &TypedWords::count}, {"at", &TypedWords::at},
      {"curl", &TypedWords::curl},   {"sawn off", &TypedWords::sawn_off},
      {"date", &TypedWords::date}};
  char separator = ',';
  const auto fault_at = [&](int line, const std::string& text) {
    read.faults.push_back(fmt::format("{}:{}: {}", name, line, text));
  };

  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    if (columns.empty()) {
      separator = separator_of(line);
      for (const std::string& cell : cells_of(line, separator)) {
        const auto found = std::ranges::find(
            known, lowered(cell), &std::pair<std::string, std::string TypedWords::*>::first);
        if (found == known.end())
          fault_at(number, fmt::format("column \"{}\" is not known; permitted: {}", cell,
                                       fmt::join(known | std::views::keys, ", ")));
        columns.push_back(found == known.end() ? &TypedWords::date : found->second);
      }
      if (!std::ranges::count(columns, nullptr))
        fault_at(number, "no column is named recipe; it has jobs or case files");
      if (!read.faults.empty()) return read;
      continue;
    }

    const auto cells = cells_of(line, separator, columns.size());
    if (cells.size() > columns.size()) {
      fault_at(number, fmt::format("{} cells; permitted: {}, as the header has", cells.size(),
                                   columns.size()));
      continue;
    }
    TypedWords words;
    std::string recipe;
    for (std::size_t i = 0; i < cells.size(); ++i)
      (columns[i] == nullptr ? recipe : words.*columns[i]) = cells[i];
    if (recipe.empty()) fault_at(number, "recipe is empty; permitted: a job or a case file");

    auto& casting = read.castings.emplace_back();
    casting.mutable_record()->set_count(1);
    for (const std::string& text : read_typed(words, now, *casting.mutable_record()))
      fault_at(number, text);
    const auto there = std::ranges::find(read.recipes, recipe);
    casting.set_recipe(static_cast<int>(there - read.recipes.begin()));
    if (there == read.recipes.end()) read.recipes.push_back(recipe);
    read.lines.push_back(number);
  }
  if (read.castings.empty() && read.faults.empty()) fault_at(number, "has no casting");
  return read;
}

}  // namespace dccast::client
