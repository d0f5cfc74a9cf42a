#pragma once

#include <string>

#include "client/html/svg_chart.hpp"
#include "dccast/v1/judgement.pb.h"

/// What the server concludes (judgement.proto), as parts of a page.
namespace dccast::client::render {

/// In the units of a plant.
Chart chart_of(const v1::Chart& chart);

/// A chart as a separate SVG file that includes the colours of the page.
std::string svg_file(const Chart& chart);

/// A table of a judgement as HTML, with its heading and units.
std::string table_part(const v1::Table& table);

/// The sentences as they open a page.
std::string sentences_part(const v1::Judgement& judgement);

/// Tables and charts that are worth their space on a page, in cards.
std::string judgement_parts(const v1::Judgement& judgement);

}  // namespace dccast::client::render
