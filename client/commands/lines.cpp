#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <vector>

#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/model/typed_castings.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/jobs.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

struct LineOptions {
  std::string name;
  bool json = false, all = false;
  std::string recipe, file, request_id;
  std::vector<std::string> castings;
  TypedWords typed;
};

ExitCode list(const LineOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto answer = connection.call(&Stub::ListLines, v1::ListLinesRequest());
  // A file that cannot be read hides no other line.
  for (const std::string& name : answer.damaged())
    std::cerr << fmt::format(
        "line {0} is damaged: restore its file from a backup, or dccast line forget {0} --all\n",
        name);
  if (options.json) {
    print_line(json_list(answer.lines(), [](const v1::Line& line) { return to_json(line); }));
    return ExitCode::done;
  }

  Table table({"LINE", "OWNER", ">CASTINGS", "SINCE"});
  for (const v1::Line& line : answer.lines())
    table.add({line.name(), line.owner(), std::to_string(line.number()),
               time_text(line.has_restart_time() ? line.restart_time() : line.create_time())});
  if (answer.lines().empty() && answer.damaged().empty())
    std::cerr << "no lines: dccast follow CASE --line NAME begins one\n";
  else if (!answer.lines().empty())
    std::cout << table.text();
  return ExitCode::done;
}

/// "200 sound", "bled-out at 40 mm"
std::string outcome_of(const v1::LineCasting& casting) {
  std::string text = case_file::outcome_word(casting.outcome());
  if (casting.count() > 1) text = fmt::format("{} {}", casting.count(), text);
  if (casting.has_at_m()) text += fmt::format(" at {:.0f} mm", 1e3 * casting.at_m());
  if (casting.has_sawn_off_m())
    text += fmt::format(", {:.0f} mm sawn off", 1e3 * casting.sawn_off_m());
  return text;
}

/// What a casting has told: its last measured curl.
std::string told_text(const v1::LineCasting& casting) {
  if (!casting.ended()) return "has not ended";
  std::vector<std::string> curls;
  for (const double curl : casting.cold_curl_m())
    curls.push_back(fmt::format("{:.1f}", 1e3 * curl));
  if (!curls.empty()) return fmt::format("{} mm cold", fmt::join(curls, " "));
  for (const v1::ObservedCurl& curl : casting.curls())
    if (!curl.time_s().empty())
      curls.push_back(fmt::format("{} {:.1f} mm at {:.0f} s", curl.monitor(),
                                  1e3 * *curl.curl_m().rbegin(), *curl.time_s().rbegin()));
  return curls.empty() ? "nothing" : fmt::format("{}", fmt::join(curls, ", "));
}

ExitCode print(const LineOptions& options, const v1::Line& line) {
  if (options.json) {
    print_line(to_json(line));
    return ExitCode::done;
  }

  std::cout << fmt::format("line {} of {}, since {}\n", line.name(), line.owner(),
                           time_text(line.create_time()));
  if (line.has_restart_time())
    std::cout << fmt::format("begun afresh {}\n", time_text(line.restart_time()));
  // Ids are cut to the length that still tells these jobs apart.
  std::vector<std::string> jobs;
  for (const v1::LineCasting& casting : line.castings())
    if (!casting.job().empty()) jobs.push_back(casting.job());
  const std::size_t length = short_id_length(jobs);
  Table table({"CASTING", "BEGUN", "OUTCOME", "MEASURED", "RECIPE", "TITLE"});
  for (const v1::LineCasting& casting : line.castings())
    table.add({casting.job().empty() ? casting.id() : casting.job().substr(0, length),
               time_text(casting.begin_time()), outcome_of(casting), told_text(casting),
               casting.recipe().substr(0, 8), casting.title()});
  if (line.castings().empty())
    std::cout << "no castings\n";
  else
    std::cout << table.text();
  return ExitCode::done;
}

template <typename Request>
Request request_for(const LineOptions& options) {
  Request request;
  request.set_id(options.name);
  return request;
}

ExitCode show(const LineOptions& options, Program& program) {
  Connection connection = program.connect();
  return print(options, connection.call(&Stub::GetLine, request_for<v1::GetLineRequest>(options)));
}

ExitCode restart(const LineOptions& options, Program& program) {
  Connection connection = program.connect();
  return print(options,
               connection.call(&Stub::RestartLine, request_for<v1::RestartLineRequest>(options)));
}

/// A recipe as the user names it: a case file, or a job.
v1::CastingRecipe recipe_of(Connection& connection, const std::string& text) {
  v1::CastingRecipe recipe;
  if (!std::filesystem::exists(text) && !text.ends_with(".toml")) {
    recipe.set_job(resolve_jobs(connection, {text}).front());
    return recipe;
  }

  const CaseUnderCheck checked = read_case(text);
  if (!checked.faults.empty()) {
    print_faults(checked, std::cerr);
    throw invalid(text + " has faults");
  }
  if (!checked.read.attachments.empty())
    throw invalid(text + " names files: submit it, and name its job as the recipe");
  *recipe.mutable_case_() = checked.description;
  return recipe;
}

/// @param places  (casting) where it stands, for faults; empty: on the command line
ExitCode send(const LineOptions& options, Connection& connection,
              const v1::AddCastingsRequest& request, const std::vector<std::string>& places) {
  const auto answer = connection.call(&Stub::AddCastings, request);
  for (const v1::Fault& fault : answer.faults()) {
    // "castings[3].at": the place of the casting, and the name of what is wrong there.
    std::string field = fault.field();
    int number = 0;
    if (std::sscanf(field.c_str(), "castings[%d].", &number) == 1 &&
        number < static_cast<int>(places.size()))
      field = places[number] + ": " + field.substr(field.find("].") + 2);
    std::cerr << fmt::format("{} = {} {}; permitted: {}; {}\n", field, fault.value(),
                             fault.message(), fault.permitted(), fault.remedy());
  }
  if (!answer.faults().empty()) return ExitCode::invalid;

  if (options.json) {
    print_line(to_json(answer));
    return ExitCode::done;
  }
  const int count = answer.castings_size();
  const std::string records = fmt::format("record{}", count == 1 ? "" : "s");
  std::cerr << fmt::format(
      "line {} {}: {}\n", options.name,
      answer.repeated_request() ? fmt::format("had {} {} of this request", count, records)
                                : fmt::format("has {} new {}", count, records),
      count > 8 ? fmt::format("{} to {}", answer.castings(0), *answer.castings().rbegin())
                : fmt::format("{}", fmt::join(answer.castings(), ", ")));
  return ExitCode::done;
}

/// Throws CommandFailed, after all faults have been printed.
void require_none(const std::vector<std::string>& faults) {
  for (const std::string& fault : faults) std::cerr << fault << '\n';
  if (!faults.empty())
    throw invalid(
        fmt::format("{} fault{}; nothing was added", faults.size(), faults.size() == 1 ? "" : "s"));
}

ExitCode add_casting(const LineOptions& options, Program& program) {
  v1::AddCastingsRequest request;
  request.set_id(options.name);
  request.set_request_id(options.request_id.empty() ? values::random_uuid() : options.request_id);
  v1::LineCasting& record = *request.add_castings()->mutable_record();
  record.set_count(1);
  require_none(read_typed(options.typed, std::time(nullptr), record));

  Connection connection = program.connect();
  *request.add_recipes() = recipe_of(connection, options.recipe);
  return send(options, connection, request, {});
}

ExitCode import_castings(const LineOptions& options, Program& program) {
  std::ostringstream text;
  if (options.file == "-")
    text << std::cin.rdbuf();
  else if (const std::ifstream file(options.file); file)
    text << file.rdbuf();
  else
    throw invalid(options.file + " cannot be read");
  std::istringstream lines(text.str());
  const TypedCastings read = read_castings(lines, options.file, std::time(nullptr));
  require_none(read.faults);

  // The same file adds once, also where the answer to it was lost.
  v1::AddCastingsRequest request;
  request.set_id(options.name);
  request.set_request_id(options.request_id.empty() ? values::sha256(text.str())
                                                    : options.request_id);
  Connection connection = program.connect();
  for (const std::string& recipe : read.recipes)
    *request.add_recipes() = recipe_of(connection, recipe);
  *request.mutable_castings() = {read.castings.begin(), read.castings.end()};
  std::vector<std::string> places;
  for (const int line : read.lines) places.push_back(fmt::format("{}:{}", options.file, line));
  return send(options, connection, request, places);
}

/// The record that a user names by its number, or by the begin of its job.
const v1::LineCasting& find_casting(const v1::Line& line, const std::string& text) {
  std::vector<const v1::LineCasting*> found;
  for (const v1::LineCasting& casting : line.castings())
    if (casting.id() == text || (!casting.job().empty() && casting.job().starts_with(text)))
      found.push_back(&casting);
  if (found.size() == 1) return *found.front();
  throw invalid(fmt::format("line {} has {} castings {}; dccast line show {} lists them",
                            line.name(), found.empty() ? "no" : "several", text, line.name()));
}

ExitCode edit(const LineOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto line = connection.call(&Stub::GetLine, request_for<v1::GetLineRequest>(options));
  v1::EditCastingRequest request;
  request.set_id(options.name);
  const v1::LineCasting& casting = find_casting(line, options.castings.front());
  request.set_casting(casting.id());
  *request.mutable_record() = casting;
  require_none(read_typed(options.typed, std::time(nullptr), *request.mutable_record()));
  if (request.record().outcome() <= v1::LineCasting::SOUND && options.typed.at.empty())
    request.mutable_record()->clear_at_m();

  v1::Line edited;
  edited.set_name(line.name());
  *edited.add_castings() = connection.call(&Stub::EditCasting, request);
  if (options.json)
    print_line(to_json(edited.castings(0)));
  else
    std::cerr << fmt::format("casting {}: {}, {}\n", request.casting(),
                             outcome_of(edited.castings(0)), told_text(edited.castings(0)));
  return ExitCode::done;
}

ExitCode forget_castings(const LineOptions& options, Connection& connection) {
  const auto line = connection.call(&Stub::GetLine, request_for<v1::GetLineRequest>(options));
  v1::ForgetCastingsRequest request;
  request.set_id(options.name);
  for (const std::string& text : options.castings)
    request.add_castings(find_casting(line, text).id());
  connection.call_once(&Stub::ForgetCastings, request);
  if (options.json)
    print_line({{"name", options.name}, {"forgotten", request.castings_size()}});
  else
    std::cerr << fmt::format("line {}: {} of {} records forgotten\n", options.name,
                             request.castings_size(), line.castings_size());
  return ExitCode::done;
}

ExitCode forget(const LineOptions& options, Program& program) {
  if (options.castings.empty() != options.all)
    throw invalid("name the CASTINGs to forget, or give --all for the whole line");
  Connection connection = program.connect();
  if (!options.all) return forget_castings(options, connection);

  connection.call_once(&Stub::DeleteLine, request_for<v1::DeleteLineRequest>(options));
  if (options.json)
    print_line({{"name", options.name}, {"deleted", true}});
  else
    std::cerr << "line " << options.name << " is forgotten; its jobs and studies stay\n";
  return ExitCode::done;
}

/// Options that say how a casting went.
void add_typed_options(const Command& command, TypedWords& typed) {
  command.option("--outcome", typed.outcome, case_file::outcome_words());
  command.option("--count", typed.count, "Castings that went alike");
  command.option("--at", typed.at, "Cast length at which it failed, as \"40 mm\"");
  command.option("--curl", typed.curl,
                 "Cold, by hand, at the points of the plant, as \"38 41 35 37 mm\"");
  command.option("--sawn-off", typed.sawn_off, "Of the butt, as \"60 mm\"");
  command.option("--date", typed.date, "When it was cast; absent: now");
}

}  // namespace

void add_line(CommandLine& line, Program& program) {
  const auto [command, options] = declare<LineOptions>(
      line, program, list, "line",
      "Lines, on which castings share mould, water and metal; what was cast on one. Answers of "
      "dccast uncertainty --line rest on it, and so does the forecast of a casting of dccast "
      "follow --line",
      "dccast line list\n"
      "  dccast line add pit-3 my.toml --count 200 --outcome sound\n"
      "  dccast line add pit-3 last --outcome bled-out --at \"40 mm\"\n"
      "  dccast line add pit-3 my.toml --outcome sound --curl \"38 41 35 37 mm\"\n"
      "  dccast line import pit-3 castings.csv\n"
      "  dccast line edit pit-3 2 --outcome cracked\n"
      "  dccast line forget pit-3 2 3\n"
      "  dccast line restart pit-3    new mould, new water: earlier castings do not count any "
      "more\n"
      "\n"
      "A RECIPE is a job or a case file. A file for import has a line for each casting below the "
      "header\n"
      "recipe, outcome, count, at, curl, sawn off, date; the same file adds once.");
  command.json(options.json);

  // Without an action of its own `dccast line` lists them, as `dccast studies` does.
  const auto add = [&, &options = options](const std::string& name, const std::string& description,
                                           ExitCode (*run)(const LineOptions&, Program&)) {
    const Command added = command.command(name, description);
    added.json(options.json);
    added.action([&options, &program, run] { return run(options, program); });
    if (name != "list") added.option("NAME", options.name, "Name of the line", required);
    return added;
  };
  add("list", "All lines", list);
  add("show", "The castings on a line, and what each has told", show);
  const Command added = add("add", "Add castings of a recipe that were not followed", add_casting);
  added.option("RECIPE", options.recipe, "Job or case file", required);
  add_typed_options(added, options.typed);
  const Command imported =
      add("import", "Add the castings of a table, all or none", import_castings);
  imported.option("FILE", options.file, "Table; - for standard input", required);
  for (const Command& sent : {added, imported})
    sent.option("--request-id", options.request_id,
                "The same id adds once; absent: a new one, of a table that of its text");
  const Command edited = add("edit", "Say anew how a casting went", edit);
  edited.option("CASTING", options.castings, "Its number, or its job", required);
  add_typed_options(edited, options.typed);
  add("restart", "Begin afresh: the castings so far do not count any more", restart);
  const Command forgotten =
      add("forget", "Remove castings of a line, or all of it; its jobs and studies stay", forget);
  forgotten.option("CASTING", options.castings, "Their numbers, or their jobs");
  forgotten.flag("--all", options.all, "The whole line");
}

}  // namespace dccast::client
