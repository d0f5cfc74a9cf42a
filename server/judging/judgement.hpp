#pragma once

#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/judgement.pb.h"
#include "proto/case_file/quality.hpp"
#include "proto/figures/plant_units.hpp"
#include "proto/figures/rounding.hpp"
#include "server/judging/comparison.hpp"

/// Building blocks of a v1::Judgement.
namespace dccast::judging {

using figures::plant_unit;

/// "a, b, c". @param text_of  what of an element is shown
template <class Elements, class TextOf = std::identity>
std::string joined(const Elements& elements, const std::string& separator, TextOf text_of = {}) {
  std::string text;
  for (const auto& element : elements) {
    if (!text.empty()) text += separator;
    text += std::invoke(text_of, element);
  }
  return text;
}

/// "within its error"
std::string words(Verdict verdict);

/// A cell; a number that is not known gives an empty one.
v1::Cell text_cell(const std::string& text);
v1::Cell code_cell(const std::string& code);
/// @param value  as in a case file
v1::Cell case_cell(const std::string& value);
/// @param unit  where the column has none
v1::Cell number_cell(double value, const std::string& unit = {});
/// @param error  half the width of the band around the value; empty: not known
v1::Cell number_cell(double value, const std::optional<double>& error);
/// A curl with its errors; empty: not known.
v1::Cell curl_cell(double curl_m, const std::optional<case_file::CurlError>& error);

/// A column of numbers; further properties are set on the result.
/// @param resolution  smallest difference worth showing [unit]
v1::Table::Column number_column(const std::string& key, const std::string& heading,
                                const std::string& unit, double resolution);
/// A column of texts or codes, or of numbers that have their unit in the cell.
v1::Table::Column text_column(const std::string& key, const std::string& heading);

/// Adds columns behind those that the table has.
void add_columns(v1::Table& table, std::initializer_list<v1::Table::Column> columns);
/// Adds a row, with a cell for each column.
void add_row(v1::Table& table, std::initializer_list<v1::Cell> cells);

v1::Table& add_table(v1::Judgement& judgement, const std::string& key, const std::string& heading,
                     v1::JudgementPart::Place place = v1::JudgementPart::ANYWHERE);

/// What a chart shows, and against what.
struct Axes {
  std::string x;       ///< "time"
  std::string x_unit;  ///< SI
  std::string y;
  std::string y_unit;
};
v1::Chart& add_chart(v1::Judgement& judgement, const std::string& key, const std::string& heading,
                     const Axes& axes, v1::JudgementPart::Place place = v1::JudgementPart::PAGE);

/// @param x, y  of equal length
v1::Chart::Line& add_line(v1::Chart& chart, const std::string& name, const std::vector<double>& x,
                          const std::vector<double>& y);

/// The band that mesh and time steps leave around a line of curls.
void add_band(v1::Chart::Line& line, const v1::RelativeError& error);

/// Makes lines of charts coarser until the whole has at most so many points.
void limit_points(v1::Judgement& judgement, int most);

}  // namespace dccast::judging
