#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/options.hpp"
#include "client_run.hpp"
#include "fake_service.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;

struct Configuration : testing::Test {
  FakeService service;
  std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                 ("dccast_configuration_" + std::to_string(::getpid()));
  std::filesystem::path settings = folder / "client.toml";
  std::string file = (folder / "my.toml").string();

  void SetUp() override {
    std::filesystem::create_directory(folder);
    std::ofstream(file) << shipped::case_templates().back().text;
    service.job.set_id("job");
  }
  void TearDown() override { std::filesystem::remove_all(folder); }
  Result run(std::vector<std::string> arguments, const std::string& text) {
    std::ofstream(settings) << text;
    return dccast(std::move(arguments), "127.0.0.1:1", settings);
  }
  std::string server() const { return "server = \"" + service.address() + "\"\n"; }
};

TEST_F(Configuration, NamesTheServerAndDefaultsOfCommands) {
  const Result result =
      run({"submit", file}, server() + "[submit]\npriority = \"low\"\nlabel = [\"a\", \"b\"]\n");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(service.submitted.priority(), v1::LOW);
  EXPECT_THAT(service.submitted.labels(), testing::ElementsAre("a", "b"));
}

TEST_F(Configuration, TheCommandLineComesFirst) {
  const std::string text = "server = \"127.0.0.1:2\"\n[submit]\npriority = \"low\"\n";
  const Result result =
      run({"submit", "--server", service.address(), "--priority", "high", file}, text);
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(service.submitted.priority(), v1::HIGH);
}

TEST_F(Configuration, TheEnvironmentComesBeforeIt) {
  ::setenv("DCCAST_SERVER", service.address().c_str(), 1);
  const Result result = run({"submit", file}, "server = \"127.0.0.1:2\"\n");
  ::unsetenv("DCCAST_SERVER");
  EXPECT_EQ(result.code, 0) << result.err;
}

TEST_F(Configuration, FaultsHaveTheirPlace) {
  const std::string place = settings.string();
  EXPECT_THAT(run({"info"}, "serverr = \"x\"\n").err,
              HasSubstr(place + ":1:1: unknown key 'serverr'; did you mean 'server'?"));
  EXPECT_THAT(
      run({"info"}, "[submit]\npriorty = \"low\"\n").err,
      HasSubstr(place + ":2:1: unknown option of submit 'priorty'; did you mean 'priority'?"));
  EXPECT_THAT(run({"info"}, "[submit]\npriority = \"lowest\"\n").err, HasSubstr(place + ":2:12: "));
  EXPECT_THAT(run({"info"}, "server = \n").err, HasSubstr("not valid TOML"));
  EXPECT_EQ(run({"info"}, "server = 3\n").code, 2);
}

TEST_F(Configuration, AbsentItSaysNothing) {
  const Result result = dccast({"list"}, service.address(), folder / "none.toml");
  EXPECT_EQ(result.code, 0) << result.err;
}

TEST(ConfigurationFile, FollowsTheXdgFolders) {
  ::setenv("XDG_CONFIG_HOME", "/somewhere", 1);
  EXPECT_EQ(configuration_file(), "/somewhere/dccast/client.toml");
  ::setenv("XDG_CONFIG_HOME", "", 1);
  ::setenv("HOME", "/users/jo", 1);
  EXPECT_EQ(configuration_file(), "/users/jo/.config/dccast/client.toml");
  ::setenv("DCCAST_CONFIG", "/etc/mine.toml", 1);
  EXPECT_EQ(configuration_file(), "/etc/mine.toml");
  ::unsetenv("DCCAST_CONFIG");
}

}  // namespace
}  // namespace dccast::client
