#pragma once

#include <string>
#include <vector>

#include "client/text/terminal.hpp"
#include "dccast/v1/judgement.pb.h"

/// What the server concludes (judgement.proto), in the units of a plant.
namespace dccast::client {

/// A value of a case without quotes, with numbers rounded to six digits and speeds in mm/min.
std::string shown_value(const std::string& value);

/// A column of a table as it is shown.
struct ShownColumn {
  /// Title of the column with its unit.
  std::string heading;
  std::string unit;  ///< of the plant; empty where the cells have theirs
  bool is_number = false;
  /// Whether a column with ± follows.
  bool has_error = false;
  std::vector<std::string> cells;   ///< (row)
  std::vector<std::string> errors;  ///< (row) "1.4", one-sided "-0.0 +3.9"; empty without has_error
};
/// The columns for people, those for programs only left out.
std::vector<ShownColumn> shown_columns(const v1::Table& table);

/// The bar of a row: from its smallest to its largest number, or from zero to its only one;
/// relative to the largest number of the table, -1 to 1.
struct Bar {
  /// Ends of the values that bars are drawn for [unit of the column].
  double low = 0.0;
  double high = 0.0;
};
/// (row) Empty where the table has no such numbers.
std::vector<Bar> bars_of(const v1::Table& table);

/// How tables are printed.
struct TextStyle {
  bool capitals = false;  ///< headings of columns in capitals
  bool headings = true;   ///< a line above each table that names it
  int columns = 120;      ///< of the page
};

/// In at most so many columns, if its numbers fit: longer texts are cut.
std::string table_text(const v1::Table& table, const TextStyle& style = {});

/// Tables and charts that are worth their space on a terminal, with a blank line between them.
std::string parts_text(const v1::Judgement& judgement, const Terminal& terminal,
                       const TextStyle& style = {});

/// The sentences, each on lines of its own. @param indent  blanks before further lines of one
std::string sentences_text(const v1::Judgement& judgement, int columns, int indent);

/// A study: what it is, parts, then sentences: the conclusion stands next to the prompt.
std::string study_judgement_text(const v1::StudyJudgement& study, const Terminal& terminal);

}  // namespace dccast::client
