#include "proto/case_file/quantity.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

namespace dccast::case_file {
namespace {

TEST(Quantity, ConvertsTheUnitsOfAPlant) {
  EXPECT_NEAR(*parse_quantity("60 mm/min", "m/s").value, 1e-3, 1e-15);
  EXPECT_NEAR(*parse_quantity("60mm/min", "m/s").value, 1e-3, 1e-15);
  EXPECT_NEAR(*parse_quantity("180 l/(min m)", "m2/s").value, 3e-3, 1e-12);
  EXPECT_NEAR(*parse_quantity("37.3 kcal/mol", "J/mol").value, 156167.64, 0.01);
  EXPECT_NEAR(*parse_quantity("12 %", "1").value, 0.12, 1e-15);
  EXPECT_NEAR(*parse_quantity("5 µm", "m").value, 5e-6, 1e-18);
  EXPECT_NEAR(*parse_quantity("500 W/(m² K)", "W/(m2 K)").value, 500, 1e-9);
  EXPECT_NEAR(*parse_quantity("64 MB", "bytes").value, 64e6, 1e-3);
  EXPECT_NEAR(*parse_quantity("150 gpm", "m3/s").value, 9.4635e-3, 1e-7);
  EXPECT_NEAR(*parse_quantity("10 gpm/ft", "l/min/m").value, 124.19, 0.01);
}

TEST(Quantity, TemperaturesKeepTheirOffset) {
  EXPECT_DOUBLE_EQ(*parse_quantity("680 °C", "degC").value, 680.0);
  EXPECT_DOUBLE_EQ(*parse_quantity("680 degC", "degC").value, 680.0);
  EXPECT_NEAR(*parse_quantity("953.15 K", "degC").value, 680.0, 1e-9);
  EXPECT_NEAR(*parse_quantity("1256 °F", "degC").value, 680.0, 1e-9);
}

TEST(Quantity, APerDegreeIsADifference) {
  EXPECT_NEAR(*parse_quantity("500 W/(m2 °C)", "W/(m2 K)").value, 500.0, 1e-9);
  EXPECT_NEAR(*parse_quantity("1.05 kJ/(kg degC)", "J/(kg K)").value, 1050.0, 1e-9);
}

TEST(Quantity, RefusesWhatIsNoQuantity) {
  for (const char* const text :
       {"60 kg", "60", "", "mm/min", "nan m/s", "inf m/s", "1e999 m/s", "0,06 m/s", "60 2 mm/min",
        "60 s since 2000-01-01", "60 furlongs/moon", "60 m/s @ 3"}) {
    const Quantity quantity = parse_quantity(text, "m/s");
    EXPECT_FALSE(quantity.value) << text;
    EXPECT_FALSE(quantity.message.empty()) << text;
  }
}

/// UDUNITS-2 leaks 32 bytes at each of these.
TEST(Quantity, RefusedUnitsHoldNoMemory) {
  const auto refuse = [](const char* text) { EXPECT_FALSE(parse_quantity(text, "m/s").value); };
  for (const char* const text : {"1 mm/0s", "1 m 0foo", "1 kg·0lg", "1 %/0.5e"}) {
    refuse(text);
    const auto before = ::mallinfo2().uordblks;
    for (int repeat = 0; repeat < 1000; ++repeat) refuse(text);
    EXPECT_LT(::mallinfo2().uordblks, before + 16000) << text;
  }
}

TEST(Quantity, SaysThatCIsTheCoulomb) {
  EXPECT_NE(parse_quantity("680 C", "degC").message.find("coulomb"), std::string::npos);
}

TEST(Quantity, NumbersAreWrittenShortAndReadBack) {
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(quantity_text(0.065, "m"), "0.065 m");
  EXPECT_EQ(quoted("a \"b\" \\"), "\"a \\\"b\\\" \\\\\"");
}

}  // namespace
}  // namespace dccast::case_file
