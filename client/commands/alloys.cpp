#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"
#include "client/render/table.hpp"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string name;
  bool local = false;
  bool json = false;
};

std::vector<v1::Alloy> shipped_alloys() {
  std::vector<v1::Alloy> alloys;
  for (const std::string& name : case_file::alloy_names())
    alloys.push_back(case_file::alloy_card(name).alloy);
  return alloys;
}

std::vector<v1::Alloy> alloys_of(const Options& options, Program& program) {
  if (options.local) return shipped_alloys();
  Connection connection = program.connect();
  connection.set_policy({.attempts = 1});  // the shipped cards are available without the server
  v1::ListAlloysResponse response;
  const grpc::Status status =
      connection.try_call(&Stub::ListAlloys, v1::ListAlloysRequest(), response);
  if (status.ok()) return {response.alloys().begin(), response.alloys().end()};
  std::cerr << "dccast: " << failure_of(status, connection.server()).what()
            << "; these are the shipped cards\n";
  return shipped_alloys();
}

ExitCode print_one(const std::vector<v1::Alloy>& alloys, const Options& options) {
  for (const v1::Alloy& alloy : alloys) {
    if (alloy.card() != options.name) continue;
    std::cout << (options.json ? to_json(alloy).dump() + "\n" : case_file::to_toml(alloy));
    return ExitCode::done;
  }
  throw CommandFailed(ExitCode::not_found,
                      "no alloy card named '" + options.name + "'; see `dccast alloys`");
}

ExitCode run(const Options& options, Program& program) {
  const auto alloys = alloys_of(options, program);
  if (!options.name.empty()) return print_one(alloys, options);
  Json list = Json::array();
  render::Table table({"CARD", ">SOLIDUS °C", ">LIQUIDUS °C", "PROVENANCE", "DESCRIPTION"});
  for (const v1::Alloy& alloy : alloys) {
    list.push_back(to_json(alloy));
    table.add({alloy.card(), render::fixed(alloy.solidus_c(), 1),
               render::fixed(alloy.liquidus_c(), 1), alloy.provenance(), alloy.description()});
  }
  std::cout << (options.json ? list.dump() + "\n" : table.text());
  return ExitCode::done;
}

}  // namespace

void add_alloys(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(app, "alloys", "List the alloy cards, or print one as TOML",
                                       "dccast alloys\n  dccast alloys aa5182 > my-alloy.toml");
  command->add_option("CARD", options->name, "Print this card");
  command->add_flag("--local", options->local, "Do not ask the server: shipped cards only");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
