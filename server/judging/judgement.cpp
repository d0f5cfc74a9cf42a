#include "server/judging/judgement.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::judging {

std::string words(Verdict verdict) {
  switch (verdict) {
    case Verdict::no_difference:
      return "no difference";
    case Verdict::of_unknown_error:
      return "of unknown error";
    case Verdict::within_its_error:
      return "within its error";
    case Verdict::real:
      return "real";
  }
  return {};
}

v1::Cell text_cell(const std::string& text) {
  v1::Cell cell;
  cell.set_text(text);
  return cell;
}

v1::Cell case_cell(const std::string& value) {
  v1::Cell cell;
  cell.set_case_value(value);
  return cell;
}

v1::Cell code_cell(const std::string& code) {
  v1::Cell cell;
  cell.set_code(code);
  return cell;
}

v1::Cell number_cell(double value, const std::string& unit) {
  v1::Cell cell;
  if (!std::isfinite(value)) return cell;
  cell.set_value(value);
  cell.set_unit(unit);
  return cell;
}

v1::Cell number_cell(double value, const std::optional<double>& error) {
  v1::Cell cell = number_cell(value);
  if (!cell.has_value() || !error || !std::isfinite(*error)) return cell;
  cell.set_lower_error(*error);
  cell.set_upper_error(*error);
  return cell;
}

v1::Cell curl_cell(double curl_m, const std::optional<case_file::CurlError>& error) {
  v1::Cell cell = number_cell(curl_m);
  if (!cell.has_value() || !error) return cell;
  cell.set_lower_error(error->lower_m);
  cell.set_upper_error(error->upper_m);
  return cell;
}

v1::Table::Column number_column(const std::string& key, const std::string& heading,
                                const std::string& unit, double resolution) {
  v1::Table::Column column = text_column(key, heading);
  column.set_unit(unit);
  column.set_resolution(resolution);
  return column;
}

v1::Table::Column text_column(const std::string& key, const std::string& heading) {
  v1::Table::Column column;
  column.set_key(key);
  column.set_heading(heading);
  return column;
}

void add_columns(v1::Table& table, std::initializer_list<v1::Table::Column> columns) {
  table.mutable_columns()->Add(columns.begin(), columns.end());
}

void add_row(v1::Table& table, std::initializer_list<v1::Cell> cells) {
  table.add_rows()->mutable_cells()->Add(cells.begin(), cells.end());
}

v1::Table& add_table(v1::Judgement& judgement, const std::string& key, const std::string& heading,
                     v1::JudgementPart::Place place) {
  v1::JudgementPart& part = *judgement.add_parts();
  part.set_place(place);
  part.mutable_table()->set_key(key);
  part.mutable_table()->set_heading(heading);
  return *part.mutable_table();
}

v1::Chart& add_chart(v1::Judgement& judgement, const std::string& key, const std::string& heading,
                     const Axes& axes, v1::JudgementPart::Place place) {
  v1::JudgementPart& part = *judgement.add_parts();
  part.set_place(place);
  v1::Chart& chart = *part.mutable_chart();
  chart.set_key(key);
  chart.set_heading(heading);
  chart.mutable_x()->set_quantity(axes.x);
  chart.mutable_x()->set_unit(axes.x_unit);
  chart.mutable_y()->set_quantity(axes.y);
  chart.mutable_y()->set_unit(axes.y_unit);
  return chart;
}

v1::Chart::Line& add_line(v1::Chart& chart, const std::string& name, const std::vector<double>& x,
                          const std::vector<double>& y) {
  v1::Chart::Line& line = *chart.add_lines();
  line.set_name(name);
  line.mutable_x()->Add(x.begin(), x.end());
  line.mutable_y()->Add(y.begin(), y.end());
  return line;
}

void add_band(v1::Chart::Line& line, const v1::RelativeError& error) {
  for (const double curl_m : line.y()) {
    const case_file::CurlError around = case_file::curl_error(error, curl_m);
    line.add_low(curl_m - around.lower_m);
    line.add_high(curl_m + around.upper_m);
  }
}

namespace {

/// Every `stride`-th value and the last one.
void thin(google::protobuf::RepeatedField<double>& values, int stride) {
  if (values.empty()) return;
  google::protobuf::RepeatedField<double> kept;
  for (int i = 0; i < values.size(); i += stride) kept.Add(values[i]);
  if ((values.size() - 1) % stride != 0) kept.Add(values[values.size() - 1]);
  values.Swap(&kept);
}

}  // namespace

void limit_points(v1::Judgement& judgement, int most) {
  int points = 0;
  for (const v1::JudgementPart& part : judgement.parts())
    for (const v1::Chart::Line& line : part.chart().lines()) points += line.x_size();
  if (points <= most) return;

  const int stride = points / most + 1;
  for (v1::JudgementPart& part : *judgement.mutable_parts()) {
    if (!part.has_chart()) continue;
    for (v1::Chart::Line& line : *part.mutable_chart()->mutable_lines())
      for (auto* values :
           {line.mutable_x(), line.mutable_y(), line.mutable_low(), line.mutable_high()})
        thin(*values, stride);
  }
}

}  // namespace dccast::judging
