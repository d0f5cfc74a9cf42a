#!/usr/bin/python3
"""The wall screen of a casting that is followed, in a real Chromium: figures, levers, warnings, age."""
import os

import numpy
from selenium.webdriver.common.by import By

from dashboard_test import InBrowser
from dccast.v1 import case_pb2, follow_pb2, job_pb2, study_pb2
from follow_test import FollowTest, levers
from support import main
from waiting import until

END = 120  # s of the plan


class Wall(FollowTest, InBrowser):
    def plan_job(self):
        """The run of the plan, on which a forecast without an ensemble rests."""
        job_id = self.finished_draft(END)
        self.take_curl_of(job_id)
        return job_id

    def take_curl_of(self, job_id):
        """The curl that curl_m() is a tenth more than."""
        self.computed = numpy.array([(step.time_s, step.monitors[0].curl_m)
                                     for step in self.client.steps(job_id)]).T

    def curl_m(self, t):
        """A casting whose curl is a tenth more than that of its plan."""
        return 1.1 * numpy.interp(t, *self.computed) if t > 0 else 0.0

    def follow_on_line(self, line="pit-3"):
        gauge = follow_pb2.Gauge(monitor="corner", noise_m=2e-4)
        return self.follow(end=END, plan_job=self.plan_job(), gauges=[gauge], line=line)

    def measure(self, job_id, end, begin=-60, curl=None):
        """Readings of every second."""
        made = []
        for number, t in enumerate(range(begin, end + 1), begin + 61):
            speed, water, metal = levers(t)
            made.append(follow_pb2.Reading(
                number=number, time_s=t, casting_speed_m_per_s=speed, water_flow_m2_per_s=water,
                casting_temperature_c=metal,
                curls=[follow_pb2.MeasuredCurl(monitor="corner", curl_m=(curl or self.curl_m)(t))]))
        self.append(job_id, *made)

    def on_wall(self):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": 1920, "height": 1080, "deviceScaleFactor": 1, "mobile": False})

    def text(self, selector):
        return self.read(selector, lambda element: element.text)

    def style(self, selector, name):
        return self.read(selector, lambda element: element.value_of_css_property(name))

    def letters(self, selector):
        """Size of the letters [px]."""
        return float(self.style(selector, "font-size")[:-2])

    def is_stale(self):
        return bool(self.browser.find_elements(By.CSS_SELECTOR, ".stale"))


class Advice(Wall):
    END = 10  # s of casting: the study has 104 runs

    def test_what_can_still_be_done_is_that_of_the_forecast(self):
        with open(self.case_file(self.END), encoding="utf-8") as file:
            case = self.client.ask("ReadCase", text=file.read()).case
        case.quality = case_pb2.DRAFT
        study = self.client.ask("CreateStudy", request_id="levers", case=case,
                                levers=study_pb2.LeversPlan())
        until(lambda: all(each.state != study_pb2.STUDY_RUNNING for each in self.studies()), 180)
        plan = self.client.submit(case)
        self.client.until_state(plan.id, job_pb2.SUCCEEDED, seconds=60)

        gauge = follow_pb2.Gauge(monitor="corner", noise_m=1e-3)
        job_id = self.follow(self.END, plan_job=plan.id, levers=study.id, gauges=[gauge])
        self.append(job_id, *[follow_pb2.Reading(number=t + 61, time_s=t) for t in range(-60, 3)])
        advice = self.forecast(job_id).advice
        self.assertEqual(len(advice), 1)
        self.go("wall")
        self.wait_for(advice[0], ".advice")


class Figures(Wall):
    def test_a_casting_is_read_across_the_hall(self):
        job_id = self.follow_on_line()
        self.measure(job_id, 39)
        self.until_time(job_id, 35)
        self.on_wall()
        self.go("wall")
        self.wait_for("39 s", ".when")
        self.measure(job_id, 40, begin=40)
        self.wait_for("40 s", ".when")
        self.wait_for("not a safety system", ".remarks")

        # The figures are those of the server.
        forecast = self.forecast(job_id).curls[0]
        at = lambda values, t: f"{1e3 * numpy.interp(t, forecast.time_s, values):.1f}"
        for name, t in (("now", 40), ("next", 100)):
            shown = self.text(f"[data-figure={name}]")
            self.assertIn(f"{at(forecast.curl_m, t)} mm", shown)
            self.assertIn(f"{at(forecast.lower_m, t)} to {at(forecast.upper_m, t)} mm", shown)
        self.assertIn(f"measured {1e3 * self.curl_m(40):.1f} mm", self.text("[data-figure=now]"))
        self.assertIn("in 60 s", self.text("[data-figure=next]"))

        # The plan of this case is constant until 60 s.
        speed, water, metal = levers(40)
        for name, measured, planned in (("Speed", f"{6e4 * speed:.1f}", "40.0"),
                                        ("Water", f"{6e4 * water:.0f}", "90"),
                                        ("Metal", f"{metal:.0f}", "680")):
            self.assertEqual(self.text(f"[data-lever='{name}'] .measured"), measured)
            self.assertEqual(self.text(f"[data-lever='{name}'] .planned"), planned)
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, "[data-lever^=Narrow]"), [])

        self.assertIn("40 s", self.text(".when"))
        self.assertRegex(self.text(".age"), r"last reading \d+ s ago")
        self.assertIn("No warning", self.text(".warnings"))
        self.assertIn("was not prepared", self.text(".note"))
        label = self.read(".advice", lambda advice: advice.get_attribute("aria-label"))
        self.assertEqual(label, "What can still be done")

        # Measured, computed and forecast, with the band of this alone.
        self.assertEqual(len(self.browser.find_elements(By.CSS_SELECTOR, "figure circle")), 41)
        self.assertEqual(len(self.browser.find_elements(By.CSS_SELECTOR, "figure path.line")), 2)
        self.assertEqual(len(self.browser.find_elements(By.CSS_SELECTOR, "figure path.band")), 1)

        # What matters most has the largest letters, and all of it is on one screen.
        self.assertGreater(self.letters(".huge"), 2.5 * self.letters("[data-lever] .measured"))
        self.assertGreaterEqual(self.letters("[data-lever] .measured"), 50)
        self.assertGreaterEqual(self.letters(".warnings"), 34)
        below = self.read(".curl-chart", lambda chart: chart.rect)
        self.assertLess(below["y"] + below["height"], 1080)
        self.assertEqual(self.hidden_sideways(), [])
        self.assertEqual(self.complaints(), [])
        if "DCCAST_PICTURES" in os.environ:
            self.browser.save_screenshot(os.path.join(os.environ["DCCAST_PICTURES"], "wall.png"))

        self.on_phone()
        self.assertEqual(self.hidden_sideways(), [])

    def test_a_slipped_gauge_is_a_warning_with_its_cause(self):
        job_id = self.follow_on_line()
        self.measure(job_id, 50, curl=lambda t: self.curl_m(t) + (12e-3 if t > 30 else 0.0))
        warning = self.forecast(job_id).warnings[0]
        self.on_wall()
        self.go("wall")
        self.wait_for(warning.text, ".raised")
        self.assertIn(f"Likeliest: {', '.join(warning.causes)}", self.text(".raised"))
        if "DCCAST_PICTURES" in os.environ:
            self.browser.save_screenshot(os.path.join(os.environ["DCCAST_PICTURES"], "wall-warning.png"))
        self.assertEqual(self.complaints(), [])

    def test_a_lever_off_its_plan_stands_first_and_in_red(self):
        job_id = self.follow_on_line()
        made = []
        for number, t in enumerate(range(-60, 31), 1):
            speed, _, metal = levers(t)
            made.append(follow_pb2.Reading(number=number, time_s=t, casting_speed_m_per_s=speed,
                                           water_flow_m2_per_s=0.0 if t >= 20 else 1.5e-3,
                                           casting_temperature_c=metal))
        self.append(job_id, *made)
        self.on_wall()
        self.go("wall")
        self.wait_for("water: the water is off: 0 l/min/m", ".alarms")
        self.assertEqual(self.style(".alarms", "background-color"), "rgba(179, 38, 30, 1)")
        place = lambda selector: self.read(selector, lambda element: element.rect["y"])
        self.assertLess(place(".alarms"), place(".curls"))
        self.assertNotIn("No warning", self.text(".warnings"))
        self.assertIn("bring the water back", self.text(".advice"))
        self.assertEqual(self.complaints(), [])

    def test_without_a_forecast_the_curls_and_the_reason_are_shown(self):
        gauge = follow_pb2.Gauge(monitor="corner", noise_m=2e-4)
        job_id = self.follow(end=END, gauges=[gauge])
        curls = [follow_pb2.MeasuredCurl(monitor="corner", curl_m=3.3e-3)]
        self.append(job_id, *[follow_pb2.Reading(number=t + 1, time_s=t, casting_speed_m_per_s=6e-4,
                                                 curls=curls) for t in range(20)])
        self.until_time(job_id, 15)
        self.go("wall")
        self.wait_for("neither an ensemble nor a run of its plan", "[data-figure=no-forecast]")
        self.assertIn("Start stage", self.text("h1"))
        self.assertIn("3.3 mm", self.text("[data-figure=measured]"))
        def computed():
            curl = self.client.job(job_id).last_step.monitors[0].curl_m
            return f"{1e3 * curl:.1f} mm" in self.text("[data-figure=computed]")
        self.wait_up_to(20, Exception).until(lambda _: computed())
        self.assertEqual(self.text("[data-lever=Water] .measured"), "–")
        self.assertEqual(self.complaints(), [])


class AgeOfReadings(Wall):
    def test_old_figures_cry_out_until_the_next_reading(self):
        job_id = self.follow_on_line()
        self.on_wall()
        self.go("wall")
        self.wait_for("no reading yet", ".age")
        self.measure(job_id, 40)
        self.wait_for("last reading", ".age")
        self.assertFalse(self.is_stale())

        self.wait_for("No reading for", ".old", seconds=30)
        self.assertRegex(self.text(".old"), r"No reading for 1\d s\n.*are of 40 s, not of now")
        self.assertGreater(self.letters(".old p"), 1.4 * self.letters(".huge"))
        self.assertLess(self.read(".old p", lambda line: line.rect["height"]), 200, "one line")
        self.assertLess(float(self.style(".curls", "opacity")), 0.5)
        if "DCCAST_PICTURES" in os.environ:
            self.browser.save_screenshot(os.path.join(os.environ["DCCAST_PICTURES"], "wall-old.png"))
        self.on_phone()
        self.assertEqual(self.hidden_sideways(), [])

        # The age is of the record: a daemon that starts anew knows it still.
        self.daemon.kill_with_workers()
        self.daemon.settings["listen__socket"] = self.daemon.address
        self.restart()
        self.client.until_state(job_id, job_pb2.RUNNING)
        self.assertGreater(self.client.job(job_id).casting.age_s, 10)
        self.measure(job_id, 41, begin=41)
        self.wait_for("41 s", ".when")
        self.wait_up_to(20).until(lambda _: not self.is_stale())

    def test_a_server_that_is_away_leaves_old_figures(self):
        job_id = self.follow_on_line()
        self.measure(job_id, 40)
        self.go("wall")
        self.wait_for("last reading", ".age")
        self.daemon.kill_with_workers()
        self.wait_for("No reading for", ".old", seconds=30)

    def test_readings_that_have_ended_are_not_old(self):
        job_id = self.follow_on_line()
        self.measure(job_id, 40)
        self.go("wall")
        self.wait_for("last reading", ".age")
        self.append(job_id, follow_pb2.Reading(number=102, closes=True))
        self.client.until_state(job_id, job_pb2.SUCCEEDED, seconds=60)
        self.wait_for("succeeded", ".state")
        self.assertFalse(self.is_stale())
        self.assertEqual(self.complaints(), [])


class Choice(Wall):
    def test_the_wall_prefers_the_casting_that_is_followed(self):
        job_id = self.follow_on_line()
        self.measure(job_id, 10)
        other = self.submit_case("quality=fine", "mesh.refinement=3")
        self.client.until_state(other, job_pb2.RUNNING)
        for job, labels in ((other, ["hall=7"]), (job_id, ["hall=3"])):
            self.client.ask("UpdateJob", id=job, set_labels=labels)
        self.go("wall")
        self.wait_for("pit-3", "h1")
        self.go("wall/hall=7")
        self.wait_for("Start stage", "h1")
        self.wait_for("not a safety system", "main")
        self.assertFalse(self.browser.find_elements(By.CSS_SELECTOR, ".casting"))
        self.go("wall/hall=3")
        self.wait_for("pit-3", "h1")

        # It ends, and the other one is shown again.
        self.client.cancel(job_id)
        self.go("wall")
        self.wait_for("Start stage", "h1")
        self.client.cancel(other)
        self.assertEqual(self.complaints(), [])


if __name__ == "__main__":
    main()
