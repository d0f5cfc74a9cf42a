#include "client/commands/study_options.hpp"

#include "client/case_options.hpp"
#include "client/commands/output_file.hpp"

namespace dccast::client::commands {

void add_study_options(CLI::App& command, StudyOptions& options, const StudyOptionTexts& texts) {
  add_set_option(command, options.base.set);
  command.add_option("--label", options.base.labels, "Label of the study; repeatable");
  command.add_option("--study", options.study, texts.study);
  command.add_flag("--no-wait", options.no_wait, "Do not wait for the runs to end");
  command.add_option("--plot", options.plot, texts.plot);
  add_force_flag(command, options.force);
  command.add_flag("--json", options.json, texts.json);
}

}  // namespace dccast::client::commands
