#pragma once

#include <string>

#include "client/model/json.hpp"
#include "dccast/v1/judgement.pb.h"

/// What the server concludes (judgement.proto), as parts of a page.
namespace dccast::client {

/// A chart for drawn.js, with fewer points of its lines where they have more than a picture shows.
Json chart_json(v1::Chart chart);

/// A card with a chart, which a script of the page draws, and its note below it.
std::string chart_figure(const v1::Chart& chart);

/// A table of a judgement by its key; an empty one where there is none.
const v1::Table& find_table(const v1::Judgement& judgement, const std::string& key);

/// A table of a judgement as HTML, with its heading and units.
std::string table_part(const v1::Table& table);

/// That in a card, below a picture. @param picture  HTML; empty: none
std::string table_card(const v1::Table& table, const std::string& picture = {});

/// A card of facts: rows of name, value and remark without a head. Empty for an empty table.
/// @param more  HTML below them
std::string facts_card(const v1::Table& facts, const std::string& more = {});

/// A judgement as pages show it: its parts are {key, html}.
Json judgement_as_shown(const v1::Judgement& judgement);

/// The sentences as they open a page.
std::string sentences_part(const v1::Judgement& judgement);

/// Tables and charts that are worth their space on a page, in cards.
std::string judgement_parts(const v1::Judgement& judgement);

}  // namespace dccast::client
