#include "server/levers/lever_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace dccast::levers {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Speed 60 mm/min, water 120 l/min/m, metal of 680 °C.
v1::Case plan() {
  v1::Case complete;
  complete.mutable_time()->set_end_s(1e4);
  complete.mutable_cooling()->mutable_water()->set_enabled(true);
  v1::Schedule& schedule = *complete.mutable_schedule();
  complete.mutable_cooling()->mutable_water()->set_pulse_period_s(0.0);  // as the defaults
  schedule.mutable_casting_speed_m_per_s()->add_value(1e-3);
  schedule.mutable_water_flow_m2_per_s()->add_value(2e-3);
  schedule.mutable_casting_temperature_c()->add_value(680.0);
  complete.mutable_alloy()->set_liquidus_c(645.0);
  complete.mutable_alloy()->set_solidus_c(575.0);
  return complete;
}

using Change = std::function<void(double, v1::Reading&)>;

/// Readings of every second that are as planned, but for a change of some of them.
std::vector<v1::Reading> readings(double until_s, const Change& change = {}) {
  std::vector<v1::Reading> made;
  for (double t = -10.0; t <= until_s; t += 1.0) {
    v1::Reading& reading = made.emplace_back();
    reading.set_time_s(t);
    reading.set_casting_speed_m_per_s(t <= 0.0 ? 0.0 : 1e-3);
    reading.set_water_flow_m2_per_s(2e-3);
    reading.set_casting_temperature_c(680.0);
    if (change) change(t, reading);
  }
  return made;
}

std::vector<std::string> alarms(const std::vector<v1::Reading>& measured) {
  LeverWatch watch(plan());
  for (const v1::Reading& reading : measured) watch.follow(reading);
  std::vector<std::string> texts;
  for (const v1::ForecastWarning& alarm : watch.under_way())
    texts.push_back(alarm.monitor() + ": " + alarm.text() + " <" + alarm.causes(0) + ">");
  return texts;
}

TEST(LeverWatch, IsSilentWhereAllIsAsPlanned) {
  EXPECT_THAT(alarms(readings(60.0)), IsEmpty());
  EXPECT_THAT(alarms(readings(60.0,
                              [](double t, v1::Reading& reading) {
                                const double off = int(t) % 2 == 0 ? 1.19 : 0.81;
                                reading.set_water_flow_m2_per_s(off * 2e-3);
                                reading.set_casting_temperature_c(t < 30 ? 699.0 : 661.0);
                              })),
              IsEmpty());
  // The block gathers speed.
  EXPECT_THAT(alarms(readings(9.0,
                              [](double, v1::Reading& reading) {
                                reading.set_casting_speed_m_per_s(0.0);
                                reading.set_water_flow_m2_per_s(0.0);
                              })),
              IsEmpty());
}

TEST(LeverWatch, WaterAtZeroIsAnAlarmInTwoReadings) {
  const Change off = [](double t, v1::Reading& reading) {
    if (t >= 30.0) reading.set_water_flow_m2_per_s(0.0);
  };
  EXPECT_THAT(alarms(readings(30.0, off)), IsEmpty());
  EXPECT_THAT(
      alarms(readings(31.0, off)),
      ElementsAre(HasSubstr("water: the water is off: 0 l/min/m, the plan has 120 l/min/m")));
}

TEST(LeverWatch, ALeverOffByAFifthForFiveSecondsIsAnAlarm) {
  for (const double share : {0.75, 0.5, 1.25, 3.0}) {
    const Change off = [&](double t, v1::Reading& reading) {
      if (t >= 30.0) reading.set_casting_speed_m_per_s(share * 1e-3);
    };
    EXPECT_THAT(alarms(readings(34.0, off)), IsEmpty()) << share;
    EXPECT_THAT(alarms(readings(35.0, off)), ElementsAre(HasSubstr("the plan has 60.0 mm/min")))
        << share;
  }
  EXPECT_THAT(alarms(readings(40.0,
                              [](double t, v1::Reading& reading) {
                                if (t >= 30.0) reading.set_casting_temperature_c(655.0);
                              })),
              ElementsAre(HasSubstr("metal: 655 degC, the plan has 680 degC")));
  EXPECT_THAT(alarms(readings(40.0,
                              [](double t, v1::Reading& reading) {
                                if (t >= 30.0) reading.set_casting_speed_m_per_s(0.0);
                              })),
              ElementsAre(HasSubstr("the block stands: 0.0 mm/min")));
}

/// What is no speed and no flow is judged by its distance from the plan.
TEST(LeverWatch, WaterTemperatureAndLevelAreWatchedByTheirDistance) {
  v1::Case described = plan();
  described.mutable_cooling()->mutable_water()->mutable_temperature_c()->add_value(25.0);
  const auto first_alarm = [&](const Change& change) {
    LeverWatch watch(described);
    for (const v1::Reading& reading : readings(40.0, change)) watch.follow(reading);
    const auto alarms = watch.under_way();
    return alarms.empty() ? "" : alarms[0].monitor() + ": " + alarms[0].text();
  };
  EXPECT_EQ(first_alarm([](double, v1::Reading& reading) {
              reading.set_water_temperature_c(34.0);
              reading.set_metal_level_m(-9e-3);
            }),
            "");
  EXPECT_EQ(
      first_alarm([](double, v1::Reading& reading) { reading.set_water_temperature_c(36.0); }),
      "water temperature: 36 degC, the plan has 25 degC");
  EXPECT_EQ(first_alarm([](double, v1::Reading& reading) { reading.set_metal_level_m(-0.012); }),
            "metal level: -12 mm, the plan has 0 mm");
}

TEST(LeverWatch, NamesTheUnitThatExplainsALever) {
  const Change tenth = [](double t, v1::Reading& reading) {
    if (t > 0.0) reading.set_casting_speed_m_per_s(1e-4);
    reading.set_water_flow_m2_per_s(2e-3 / 60.0);
  };
  EXPECT_THAT(alarms(readings(30.0, tenth)),
              ElementsAre(HasSubstr("the unit of its column; if it is a tenth, it is 0.001 m/s"),
                          HasSubstr("what is read per minute is per second")));
}

/// Steps of 1 mm at 20 mm/min: the speed is zero for two seconds, then 60 mm/min.
TEST(LeverWatch, ACoarseCounterIsNoAlarm) {
  const Change coarse = [](double t, v1::Reading& reading) {
    if (t > 0.0) reading.set_casting_speed_m_per_s(int(t) % 3 == 0 ? 3e-3 : 0.0);
  };
  EXPECT_THAT(alarms(readings(120.0, coarse)), IsEmpty());
}

TEST(LeverWatch, AnAlarmEndsWithItsCauseAndIsRememberedForFindings) {
  const Change off = [](double t, v1::Reading& reading) {
    if (t >= 30.0 && t < 60.0) reading.set_water_flow_m2_per_s(t < 45.0 ? 1e-3 : 0.0);
  };
  EXPECT_THAT(alarms(readings(40.0, off)), ElementsAre(HasSubstr("water: 60 l/min/m")));
  EXPECT_THAT(alarms(readings(50.0, off)), ElementsAre(HasSubstr("the water is off")));
  EXPECT_THAT(alarms(readings(60.0, off)), IsEmpty());

  LeverWatch watch(plan());
  for (const v1::Reading& reading : readings(200.0, off)) watch.follow(reading);
  EXPECT_EQ(watch.remedy_at(20.0), "");
  for (const double time_s : {35.0, 59.0, 100.0})
    EXPECT_EQ(watch.remedy_at(time_s), "First bring the water back to its plan, 120 l/min/m.");
  EXPECT_EQ(watch.remedy_at(190.0), "");
}

TEST(LeverWatch, ASensorThatIsSilentRaisesNothing) {
  EXPECT_THAT(alarms(readings(60.0,
                              [](double t, v1::Reading& reading) {
                                if (t >= 30.0) reading.clear_water_flow_m2_per_s();
                              })),
              IsEmpty());
  v1::Case pulsed = plan();
  pulsed.mutable_cooling()->mutable_water()->set_pulse_period_s(2.0);
  LeverWatch watch(pulsed);
  for (v1::Reading& reading : readings(60.0)) {
    reading.set_water_flow_m2_per_s(0.0);
    watch.follow(reading);
  }
  EXPECT_TRUE(watch.under_way().empty()) << "its flow is that of a moment";
}

TEST(PouredLevers, AreThoseThatWereMeasured) {
  const auto poured = poured_levers(plan(), readings(29.0, [](double t, v1::Reading& reading) {
                                      reading.set_water_flow_m2_per_s(t < 20.0 ? 2e-3 : 1e-3);
                                      reading.clear_casting_temperature_c();
                                    }));
  ASSERT_EQ(poured.size(), 2u);
  EXPECT_EQ(poured[0].measured, "60.0 mm/min");
  EXPECT_EQ(poured[1].name, "water");
  EXPECT_EQ(poured[1].planned, "120 l/min/m");
  EXPECT_EQ(poured[1].measured, "90 l/min/m");
  EXPECT_EQ(poured[1].range, "60 l/min/m to 120 l/min/m");
}

}  // namespace
}  // namespace dccast::levers
