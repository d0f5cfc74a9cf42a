#include "proto/case_file/text_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::case_file {
namespace {

using testing::HasSubstr;

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(Nesting, DeepKeysAndListsAreRefusedBeforeTheParserSeesThem) {
  constexpr int deep = 50000;
  for (const std::string& text :
       {repeated("a.", deep) + "a = 1", "[" + repeated("a.", deep) + "a]\n",
        "[[" + repeated("a . ", deep) + "a]]\n", "a = " + repeated("[", deep),
        "a = " + repeated("{a=", deep), repeated("'a'.", deep) + "a = 1",
        "a = {" + repeated("a.", deep) + "a = 1}"}) {
    v1::Case message;
    const ReadOutcome outcome = read_text("\ntitle = \"x\"\n" + text, "my.toml", message);
    ASSERT_EQ(outcome.faults.size(), 1u);
    EXPECT_THAT(outcome.faults[0].message(), HasSubstr("more than 16 deep"));
    EXPECT_EQ(outcome.source.find("").line, 3);
  }
}

TEST(Nesting, CountsNeitherStringsNorCommentsNorWhatIsClosed) {
  EXPECT_FALSE(check_nesting("a = \"" + repeated("[.", 100) + "\""));
  EXPECT_FALSE(check_nesting("a = '''\n" + repeated("[.\n", 100) + "'''"));
  EXPECT_FALSE(check_nesting("a = \"\"\"\\\"\"" + repeated("[", 100) + "\"\"\""));
  EXPECT_FALSE(check_nesting("# " + repeated("[.", 100)));
  EXPECT_FALSE(check_nesting(repeated("[a.b]\n", 100)));
  EXPECT_FALSE(check_nesting("a = [" + repeated("[1.5, 2.5],", 100) + "]"));
  EXPECT_FALSE(check_nesting(repeated("[", maximum_nesting)));
  EXPECT_TRUE(check_nesting(repeated("[", maximum_nesting + 1)));
}

}  // namespace
}  // namespace dccast::case_file
