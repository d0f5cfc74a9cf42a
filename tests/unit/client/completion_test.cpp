#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client_run.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::client {
namespace {

using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;

std::string script_for(const std::string& shell) {
  const Result result = dccast({"completion", shell}, "127.0.0.1:1");
  EXPECT_EQ(result.code, 0) << result.err;
  return result.out;
}

TEST(Completion, EveryShellKnowsCommandsAndOptions) {
  for (const char* const shell : {"bash", "zsh", "fish"}) {
    const std::string script = script_for(shell);
    for (const char* const word : {"submit", "query", "priority", "dccast list --ids"})
      EXPECT_THAT(script, HasSubstr(word)) << shell;
  }
  EXPECT_EQ(dccast({"completion", "tcsh"}, "127.0.0.1:1").code, 2);
}

/// Completions that bash offers for a command line with the cursor at its end.
std::string completed(const std::string& words) {
  const TemporaryFolder folder;  // tests run side by side
  std::ofstream(folder / "completion.bash") << script_for("bash");
  const std::string command =
      "bash -c 'source " + (folder / "completion.bash").string() + "; COMP_WORDS=(" + words +
      "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _dccast; echo ${COMPREPLY[*]}' > " +
      (folder / "completed").string();
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::string line;
  std::getline(std::ifstream(folder / "completed") >> std::ws, line);
  return line;
}

TEST(Completion, BashCompletesCommandsAndOptions) {
  EXPECT_EQ(completed("dccast sub"), "submit");
  EXPECT_EQ(completed("dccast submit --prio"), "--priority");
  EXPECT_EQ(completed("dccast comp"), "compare completion");
}

/// The program names its commands; what is asked of each is asked of all.
TEST(Completion, EveryCommandHasAnExampleAndAnswersInJson) {
  std::istringstream words(completed("dccast \"\""));
  std::set<std::string> commands, without_json;
  for (std::string word; words >> word;)
    if (!word.starts_with('-')) commands.insert(word);
  EXPECT_GE(commands.size(), 40u);

  for (const std::string& name : commands) {
    const Result help = dccast({name, "--help"}, "127.0.0.1:1");
    EXPECT_EQ(help.code, 0) << name;
    const auto example = help.out.find("Example:\n");
    ASSERT_NE(example, std::string::npos) << name;
    EXPECT_THAT(help.out.substr(example), ContainsRegex("dccast (--server [a-z]+ )?" + name));
    if (help.out.find("  --json") == std::string::npos) without_json.insert(name);
  }

  // These print a file or a script as it is, show a screen, or concern the user's own machine.
  EXPECT_THAT(without_json, ElementsAre("case", "completion", "dashboard", "doctor", "login",
                                        "logout", "logs", "replay", "top"));
}

}  // namespace
}  // namespace dccast::client
