#include <array>
#include <random>

#include <gtest/gtest.h>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::case_file {
namespace {

constexpr int mutated_texts = 4000;  // two or three seconds

constexpr std::array pieces{"[",   "]",          "[[",    "{",     "}",    "\"",     "\"\"\"",
                            "'",   "=",          ".",     ",",     "\n",   "#",      "\\",
                            "nan", "-inf",       "1e9",   "1e999", "-1",   "9e18",   "true",
                            " mm", " degC",      " kg/@", "%",     "\xff", "\u00b0", "\\u0000",
                            "[]",  "1979-05-27", "0x7f",  "_"};

/// One change of a text: a byte, a piece put in, a stretch taken out or doubled.
void mutate(std::string& text, std::mt19937& random) {
  if (text.empty()) text = "x";
  const std::size_t at = random() % text.size();
  const std::size_t length = std::min<std::size_t>(1 + random() % 40, text.size() - at);
  switch (random() % 5) {
    case 0:
      text[at] = static_cast<char>(random() % 256);
      break;
    case 1:
      text.erase(at, length);
      break;
    case 2:
      text.insert(at, text.substr(at, length));
      break;
    default:
      text.insert(at, pieces[random() % pieces.size()]);
  }
}

/// Invariants for any file: faults are short, and a file without a fault is a sound case.
void expect_a_sound_answer(const std::string& text) {
  v1::Case message;
  const ReadOutcome outcome = read_text(text, "mutated.toml", message);
  for (const v1::Fault& fault : outcome.faults) EXPECT_LT(fault.ByteSizeLong(), 2000u) << text;
  if (!outcome.ok()) return;
  for (const v1::Fault& fault : check_ranges(message))
    ADD_FAILURE() << fault.DebugString() << " in a file that was taken:\n" << text;
  v1::Case again;
  EXPECT_TRUE(read_text(to_toml(message), "again.toml", again).ok()) << text;
  EXPECT_EQ(message.SerializeAsString(), again.SerializeAsString()) << text;
}

TEST(Fuzz, NoTextBringsTheReaderDownOrIsTakenForWhatItIsNot) {
  std::mt19937 random(20260707);
  const auto& texts = shipped::case_templates();
  for (int i = 0; i < mutated_texts && !HasFailure(); ++i) {
    std::string text = texts[random() % texts.size()].text;
    for (auto changes = 1 + random() % 8; changes > 0; --changes) mutate(text, random);
    expect_a_sound_answer(text);
  }
}

}  // namespace
}  // namespace dccast::case_file
