#pragma once

#include <string>

#include "dccast/v1/judgement.pb.h"

/// What the server concludes (judgement.proto), as parts of a page.
namespace dccast::client::render {

/// What an axis shows.
struct Quantity {
  std::string name;  ///< "cast length"
  std::string unit;  ///< SI
};

/// A chart without lines. @param x, y  quantities with their SI units
v1::Chart chart_against(const std::string& heading, const Quantity& x, const Quantity& y);
v1::Chart::Line& add_line(v1::Chart& chart, const std::string& name);
/// @param x, y  in the units of the axes
void add_point(v1::Chart::Line& line, double x, double y);

/// A card with a chart, which a script of the page draws, and a caption below it.
std::string chart_figure(const v1::Chart& chart, const std::string& caption);

/// A table of a judgement as HTML, with its heading and units.
std::string table_part(const v1::Table& table);

/// The sentences as they open a page.
std::string sentences_part(const v1::Judgement& judgement);

/// Tables and charts that are worth their space on a page, in cards.
std::string judgement_parts(const v1::Judgement& judgement);

}  // namespace dccast::client::render
