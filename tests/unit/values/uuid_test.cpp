#include "proto/values/digests.hpp"

#include <gtest/gtest.h>

#include <set>

namespace dccast::values {
namespace {

TEST(Uuid, IsAUuidOfVersion4AndNeverTheSame) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string id = random_uuid();
    EXPECT_TRUE(is_uuid(id)) << id;
    EXPECT_EQ(id[14], '4');
    EXPECT_NE(std::string("89ab").find(id[19]), std::string::npos);
    EXPECT_TRUE(seen.insert(id).second);
  }
}

TEST(Uuid, OfANameIsOfVersion5AndAlwaysTheSame) {
  EXPECT_TRUE(is_uuid(uuid_of("trial-7"))) << uuid_of("trial-7");
  EXPECT_EQ(uuid_of("trial-7")[14], '5');
  EXPECT_EQ(uuid_of("trial-7"), uuid_of("trial-7"));
  EXPECT_NE(uuid_of("trial-7"), uuid_of("trial-8"));
}

TEST(Uuid, RefusesWhatIsNone) {
  for (const char* text :
       {"", "x", "0f2b9a4e-0000-4000-8000-00000000000", "../../../../etc/passwd",
        "0F2B9A4E-0000-4000-8000-000000000000", "0f2b9a4e_0000_4000_8000_000000000000"})
    EXPECT_FALSE(is_uuid(text)) << text;
}

TEST(Hexadecimal, HasTwoDigitsAByte) {
  const unsigned char bytes[] = {0x00, 0x0f, 0xa0, 0xff};
  EXPECT_EQ(hexadecimal(bytes), "000fa0ff");
  EXPECT_EQ(random_hexadecimal(32).size(), 64u);
  EXPECT_NE(random_hexadecimal(32), random_hexadecimal(32));
}

}  // namespace
}  // namespace dccast::values
