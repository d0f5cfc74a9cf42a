#pragma once

#include <istream>
#include <map>
#include <string>
#include <vector>

#include "dccast/v1/line.pb.h"

namespace dccast::client {

/// What a person types of a casting, as texts; empty: nothing is said of it.
struct TypedWords {
  std::string outcome;   ///< "bled-out"
  std::string count;     ///< of castings that went alike: "200"
  std::string at;        ///< cast length at which it failed: "40 mm"
  std::string curl;      ///< of the cold butt, at the points of the plant: "38 41 35 37 mm"
  std::string sawn_off;  ///< "60 mm"
  std::string date;      ///< when it was cast: "2026-11-20", "2 d"
};

/// Reads such texts into a record; those that are empty leave it as it is.
/// @param now  [s] since 1970, from which spans of time are counted
/// @return     what is wrong: name, value, what is permitted
std::vector<std::string> read_typed(const TypedWords& words, std::int64_t now,
                                    v1::LineCasting& record);

/// Castings of a file.
struct TypedCastings {
  std::vector<std::string> recipes;                          ///< jobs and case files, each once
  std::vector<v1::AddCastingsRequest::NewCasting> castings;  ///< in the order of the file
  std::vector<int> lines;                                    ///< (casting) of the file
  std::vector<std::string> faults;                           ///< "castings.csv:3: ..."; empty: none
};

/// Reads castings, one a line; comma, semicolon or tab between columns, "#" before comments. The
/// first line names the columns, in any order; an empty cell says nothing:
///
///     recipe,      outcome,  count, at,    curl,           sawn off, date
///     my.toml,     sound,    200,   ,      ,               ,         2026-11-20
///     5f1c2a9e,    bled-out, 1,     40 mm, ,               ,         2026-11-21
///     my.toml,     sound,    1,     ,      38 41 35 37 mm, 60 mm,    2026-11-22
TypedCastings read_castings(std::istream& stream, const std::string& name, std::int64_t now);

}  // namespace dccast::client
