#include "tests/verification/program/table.hpp"

#include <cmath>
#include <cstdio>

namespace dccast::verification {

std::string text_of(const Cell& cell) {
  if (cell.is_null()) return "-";
  if (cell.is_string()) return cell.get<std::string>();
  if (cell.is_number_integer()) return std::to_string(cell.get<long>());
  const double value = cell.get<double>();
  if (!std::isfinite(value)) return "-";
  char text[40];
  std::snprintf(text, sizeof text, "%.5g", value);
  return text;
}

std::string to_markdown(const Table& table) {
  std::string out = "### ";
  out += table.title + "\n\n";
  if (!table.setup.empty()) out += table.setup + "\n\n";
  out += "|";
  for (const auto& column : table.columns) out.append(" ").append(column).append(" |");
  out += "\n|";
  for (std::size_t i = 0; i < table.columns.size(); ++i) out += "---|";
  out += "\n";
  for (const auto& row : table.rows) {
    out += "|";
    for (const Cell& cell : row) out.append(" ").append(text_of(cell)).append(" |");
    out += "\n";
  }
  if (!table.remarks.empty()) out += "\n";
  for (const auto& remark : table.remarks) out.append("- ").append(remark).append("\n");
  return out;
}

nlohmann::json to_json(const Table& table) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : table.rows) {
    nlohmann::json object;
    for (std::size_t i = 0; i < row.size(); ++i) object[table.columns[i]] = row[i];
    rows.push_back(std::move(object));
  }
  return {{"title", table.title},
          {"setup", table.setup},
          {"columns", table.columns},
          {"rows", std::move(rows)},
          {"remarks", table.remarks}};
}

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

namespace {

/// Markdown's `code` as HTML.
std::string inline_html(const std::string& text) {
  std::string out;
  bool inside = false;
  for (char c : escaped(text)) {
    if (c != '`') {
      out += c;
      continue;
    }
    out += inside ? "</code>" : "<code>";
    inside = !inside;
  }
  return out;
}

std::string html_cell(const Cell& cell) {
  const std::string text = text_of(cell);
  const char* kind = cell.is_number() ? " class=\"number\"" : "";
  if (text == "pass") kind = " class=\"pass\"";
  if (text == "MISS") kind = " class=\"miss\"";
  return std::string("<td") + kind + ">" + inline_html(text) + "</td>";
}

}  // namespace

std::string to_html(const Table& table) {
  std::string out = "<section><h2>" + escaped(table.title) + "</h2>\n";
  if (!table.setup.empty()) out += "<p class=\"setup\">" + inline_html(table.setup) + "</p>\n";
  out += "<div class=\"wide\"><table><thead><tr>";
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const bool number = !table.rows.empty() && table.rows.front()[i].is_number();
    out += number ? "<th class=\"number\">" : "<th>";
    out += escaped(table.columns[i]) + "</th>";
  }
  out += "</tr></thead><tbody>\n";
  for (const auto& row : table.rows) {
    out += "<tr>";
    for (const Cell& cell : row) out += html_cell(cell);
    out += "</tr>\n";
  }
  out += "</tbody></table></div>\n";
  if (!table.remarks.empty()) {
    out += "<ul class=\"remarks\">";
    for (const auto& remark : table.remarks) out += "<li>" + inline_html(remark) + "</li>";
    out += "</ul>\n";
  }
  return out + "</section>\n";
}

}  // namespace dccast::verification
