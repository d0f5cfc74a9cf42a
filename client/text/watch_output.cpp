#include "client/text/watch_output.hpp"

#include <google/protobuf/util/time_util.h>

#include "client/model/answer.hpp"

namespace dccast::client {
namespace {

/// Adds the members that belong to an event. @return its name
const char* add_particulars(const v1::JobEvent& event, Json& line) {
  switch (event.what_case()) {
    case v1::JobEvent::kStep:
      line["time_step_s"] = event.step().time_step_s();
      line["progress"] = event.step().progress();
      line["solver_s"] = event.step().solver_s();
      line["contact_length_m"] = event.step().contact_length_m();
      line["sump_depth_m"] = event.step().sump_depth_m();
      return "step";

    case v1::JobEvent::kStateChange:
      line["cause"] = event.state_change().cause();
      line["terminal"] = event.state_change().terminal();
      if (event.state_change().has_failure())
        line["failure"] = to_json(event.state_change().failure());
      return "state";

    case v1::JobEvent::kMessage:
      line["text"] = event.message().text();
      return "message";

    case v1::JobEvent::kResumed:
      line["resumed_step"] = event.resumed().step();
      line["resumed_time_s"] = event.resumed().time_s();
      return "resumed";

    case v1::JobEvent::kValidityLost:
      line["validity_loss"] = to_json(event.validity_lost());
      return "validity_lost";

    case v1::JobEvent::kFinding:
      line["finding"] = to_json(event.finding());
      return "finding";

    default:
      return "unknown";
  }
}

}  // namespace

Json WatchOutput::line(const v1::JobEvent& event) {
  if (event.has_state_change()) state_ = event.state_change().state();
  if (event.has_step()) {
    step_ = event.step();
    stepped_ = true;
    // A watch that begins during a run has not received its start.
    if (state_ == v1::JOB_STATE_UNSPECIFIED) state_ = v1::RUNNING;
  }

  const auto of_step = [&](auto value) { return stepped_ ? Json(value) : Json(); };
  Json line{{"sequence", event.sequence()},
            {"event", Json()},
            {"time", google::protobuf::util::TimeUtil::ToString(event.time())},
            {"state", v1::JobState_Name(state_)},
            {"step", of_step(step_.step())},
            {"time_s", of_step(step_.time_s())},
            {"cast_length_m", of_step(step_.cast_length_m())},
            {"iterations", of_step(step_.iterations())},
            {"beyond_validity", step_.beyond_validity()},
            {"monitors", Json::array()}};
  for (const v1::MonitorValue& monitor : step_.monitors())
    line["monitors"].push_back(to_json(monitor));

  const char* const name = add_particulars(event, line);  // moves the members of `line`
  line["event"] = name;
  return line;
}

}  // namespace dccast::client
