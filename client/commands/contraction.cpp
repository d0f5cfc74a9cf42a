#include <iostream>

#include "client/case_options.hpp"
#include "client/commands/commands.hpp"
#include "client/failure.hpp"
#include "client/job_id.hpp"
#include "client/job_result.hpp"
#include "client/message_json.hpp"
#include "client/render/table.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client::commands {
namespace {

using frames::Contraction, frames::FacePoint, frames::FaceRow;

struct Options {
  std::string id;
  std::vector<std::string> heights;
  std::string wanted;
  bool json = false;
};

/// A row to be shown and its name.
struct NamedRow {
  std::string name;
  const FaceRow* row;
};

/// Butt, middle and head, each row once; or the requested rows.
std::vector<NamedRow> chosen_rows(const Contraction& contraction, const Options& options) {
  constexpr double butt_m = 0.05;  // [m] above the lifted end of the butt
  std::vector<NamedRow> rows;
  const auto add = [&](const char* name, const FaceRow& row) {
    if (rows.empty() || rows.back().row != &row) rows.push_back({name, &row});
  };
  if (!options.heights.empty()) {
    for (const std::string& text : options.heights)
      add("", contraction.at(metres_of(text, "--height")));
    return rows;
  }
  const FaceRow &butt = contraction.at(butt_m), &head = contraction.head();
  add("butt", butt);
  if (head.height_m <= butt.height_m) return rows;
  add("middle", contraction.at(0.5 * (butt.height_m + head.height_m)));
  add("head", head);
  return rows;
}

std::string percent(double part, double whole) {
  return render::fixed(100.0 * part / whole, 2);
}

void print_table(const Contraction& contraction, const Options& options) {
  std::vector<std::string> headings{"place",        ">height mm", ">x mm",           ">mould mm",
                                    ">now mm",      ">20 °C mm",  ">pull-in now mm", ">%",
                                    ">at 20 °C mm", ">%"};
  const bool compared = !options.wanted.empty();
  const double wanted_m = compared ? metres_of(options.wanted, "--wanted") : 0.0;
  if (compared) headings.push_back(">over wanted mm");
  render::Table table(headings);
  for (const auto& [name, row] : chosen_rows(contraction, options))
    for (const FacePoint& p : row->points) {
      std::vector<std::string> cells{name,
                                     render::fixed(1e3 * row->height_m, 1),
                                     render::fixed(1e3 * p.x_m, 1),
                                     render::fixed(1e3 * p.mould_m, 2),
                                     render::fixed(1e3 * p.now_m, 2),
                                     render::fixed(1e3 * p.cold_m, 2),
                                     render::fixed(1e3 * p.pull_in_m(), 2),
                                     percent(p.pull_in_m(), p.mould_m),
                                     render::fixed(1e3 * p.cold_pull_in_m(), 2),
                                     percent(p.cold_pull_in_m(), p.mould_m)};
      if (compared) cells.push_back(render::fixed(1e3 * (p.cold_m - wanted_m), 2));
      table.add(std::move(cells));
    }
  std::cout << table.text() << std::flush;
}

/// NaN is written as null.
Json json_of(const FaceRow& row) {
  Json json{{"height_m", row.height_m}, {"solid", row.solid}};
  for (const FacePoint& p : row.points) {
    json["x_m"].push_back(p.x_m);
    json["mould_half_opening_m"].push_back(p.mould_m);
    json["half_thickness_m"].push_back(p.now_m);
    json["half_thickness_at_20_c_m"].push_back(p.cold_m);
    json["pull_in_m"].push_back(p.pull_in_m());
    json["pull_in_at_20_c_m"].push_back(p.cold_pull_in_m());
  }
  return json;
}

/// All rows, independently of those shown in the table.
void print_json(const std::string& id, const Contraction& contraction) {
  Json json{{"job", id},
            {"time_s", contraction.time_s},
            {"cast_length_m", contraction.cast_length_m},
            {"rows", Json::array()}};
  for (const FaceRow& row : contraction.rows) json["rows"].push_back(json_of(row));
  std::cout << json.dump() << '\n';
}

/// @throws CommandFailed
Contraction read_contraction(const v1::QueryResultResponse& result) {
  try {
    return frames::contraction_of(result.case_(), result.frame());
  } catch (const frames::NoContraction& error) {
    throw CommandFailed(ExitCode::invalid, error.what());
  }
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);
  v1::QueryResultResponse result;
  check(try_query_result(connection, id, true, result), connection.server());
  const Contraction contraction = read_contraction(result);
  if (options.json)
    print_json(id, contraction);
  else
    print_table(contraction, options);
  return ExitCode::done;
}

}  // namespace

void add_contraction(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "contraction",
      "Half-thickness of a quarter slab along its wide face at butt, middle and head in the last "
      "frame, compared with the mould: hot and at 20 degC. The head is the highest row that is "
      "completely solid",
      "dccast contraction JOB\n  dccast contraction last --wanted \"285 mm\" --height \"0.3 m\"");
  command->add_option("JOB", options->id, job_help)->required();
  command->add_option("--height", options->heights,
                      "Show the row nearest to this height above the block instead; repeatable");
  command->add_option("--wanted", options->wanted,
                      "Wanted half-thickness: adds the difference of the cold slab to it");
  command->add_flag("--json", options->json, "As JSON in metres, all rows")
      ->excludes("--height")
      ->excludes("--wanted");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
