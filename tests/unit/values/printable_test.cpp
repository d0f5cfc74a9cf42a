#include "proto/values/printable.hpp"

#include <gtest/gtest.h>

namespace dccast::values {
namespace {

TEST(Unprintable, LetsTextOfAnyLanguagePass) {
  for (const char* text :
       {"", "start-3d 60 mm/min", "K\u00fchlung \u00b0C", "\u94dd\u677f", "\U0001F525"})
    EXPECT_FALSE(unprintable(text)) << text;
}

TEST(Unprintable, NamesTheCharacterAndItsPlace) {
  EXPECT_EQ(unprintable("red\x1b[31m"), "U+001B (ESC) at byte 4");
  EXPECT_EQ(unprintable("a\nb"), "U+000A (line feed) at byte 2");
  EXPECT_EQ(unprintable(std::string_view("a\0b", 3)), "U+0000 (NUL) at byte 2");
  EXPECT_EQ(unprintable("\u009d0;title\u009c"), "U+009D (OSC) at byte 1");
  EXPECT_EQ(unprintable("\u009b31m"), "U+009B (CSI) at byte 1");
  EXPECT_EQ(unprintable("x\u202egnp.exe"), "U+202E at byte 2");
  EXPECT_EQ(unprintable("\u2066x"), "U+2066 at byte 1");
  EXPECT_EQ(unprintable("\x7f"), "U+007F (DEL) at byte 1");
  EXPECT_EQ(unprintable("bott\xe9m"), "the byte 0xE9, which is no UTF-8, at byte 5");
}

TEST(Unprintable, FindsWhatIsNoUtf8) {
  for (const char* text :
       {"\x80", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\xff"})
    EXPECT_TRUE(unprintable(text)) << text;
  EXPECT_EQ(first_broken_utf8("\u00b0\xe9"), 2u);
  EXPECT_FALSE(first_broken_utf8("\u00b0 \x1b"));
}

TEST(Unprintable, SeveralLinesMayEndAndHaveTabs) {
  EXPECT_FALSE(unprintable("a\n\tb", Lines::several));
  EXPECT_TRUE(unprintable("a\r\nb", Lines::several));
}

TEST(Escaped, WritesOutWhatCannotBeShown) {
  EXPECT_EQ(escaped("K\u00fchlung"), "K\u00fchlung");
  EXPECT_EQ(escaped("\x1b[31m\n"), "\\u{1B}[31m\\u{A}");
  EXPECT_EQ(escaped("bott\xe9m"), "bott\\x{E9}m");
  EXPECT_EQ(escaped("a\nb", Lines::several), "a\nb");
  EXPECT_FALSE(unprintable(escaped("\xff\u202e\u009b")));
}

}  // namespace
}  // namespace dccast::values
