#include "client/model/judgement_json.hpp"

#include <cmath>

#include "proto/case_file/quantity.hpp"

namespace dccast::client {
namespace {

void add_number(const std::string& key, const std::string& suffix, const v1::Cell& cell,
                Json& row) {
  const bool whole = suffix.empty() && cell.value() == std::round(cell.value());
  row[key + suffix] = whole ? Json(static_cast<std::int64_t>(cell.value())) : Json(cell.value());
  if (cell.has_until()) row[key + "_until" + suffix] = cell.until();
  if (!cell.has_upper_error()) return;
  if (cell.lower_error() == cell.upper_error()) {
    row[key + "_error" + suffix] = cell.upper_error();
  } else {
    row[key + "_lower_error" + suffix] = cell.lower_error();
    row[key + "_upper_error" + suffix] = cell.upper_error();
  }
}

void add_cell(const v1::Table::Column& column, const v1::Cell& cell, Json& row) {
  const std::string& unit = column.unit().empty() ? cell.unit() : column.unit();
  if (cell.has_value()) {
    add_number(column.key(), std::string(case_file::unit_suffix(unit).value_or("")), cell, row);
    if (!cell.code().empty()) row[column.key() + "_code"] = cell.code();
  } else if (!cell.code().empty())
    row[column.key()] = cell.code();
  else if (!cell.case_value().empty())
    row[column.key()] = cell.case_value();
  else if (!cell.text().empty())
    row[column.key()] = cell.text();
}

Json rows_json(const v1::Table& table) {
  return json_list(table.rows(), [&](const v1::Table::Row& row) {
    Json members = Json::object();
    for (int i = 0; i < row.cells_size(); ++i) add_cell(table.columns(i), row.cells(i), members);
    return members;
  });
}

}  // namespace

Json judgement_json(const v1::Judgement& judgement) {
  Json json{
      {"heading", judgement.heading()},
      {"sentences", json_list(judgement.sentences(), [](const auto& text) { return Json(text); })}};
  Json charts = Json::array();
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.has_table())
      json[part.table().key()] = rows_json(part.table());
    else
      charts.push_back(to_json(part.chart()));
  json["charts"] = std::move(charts);
  return json;
}

Json study_json(const v1::StudyJudgement& answer) {
  Json json = to_json(answer.result());
  json["judgement"] = judgement_json(answer.judgement());
  return json;
}

}  // namespace dccast::client
