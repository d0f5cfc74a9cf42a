#include "client/text/watch_output.hpp"

#include <google/protobuf/util/time_util.h>

namespace dccast::client::render {
namespace {

const char* event_name(const v1::JobEvent& event) {
  switch (event.what_case()) {
    case v1::JobEvent::kStateChange:
      return "state";
    case v1::JobEvent::kStep:
      return "step";
    case v1::JobEvent::kMessage:
      return "message";
    case v1::JobEvent::kResumed:
      return "resumed";
    case v1::JobEvent::kValidityLost:
      return "validity_lost";
    case v1::JobEvent::kFinding:
      return "finding";
    default:
      return "unknown";
  }
}

void add_particulars(const v1::JobEvent& event, Json& line) {
  if (event.has_step()) {
    line["time_step_s"] = event.step().time_step_s();
    line["progress"] = event.step().progress();
    line["solver_s"] = event.step().solver_s();
    line["contact_length_m"] = event.step().contact_length_m();
    line["sump_depth_m"] = event.step().sump_depth_m();
  } else if (event.has_state_change()) {
    line["cause"] = event.state_change().cause();
    line["terminal"] = event.state_change().terminal();
    if (event.state_change().has_failure())
      line["failure"] = to_json(event.state_change().failure());
  } else if (event.has_message()) {
    line["text"] = event.message().text();
  } else if (event.has_resumed()) {
    line["resumed_step"] = event.resumed().step();
    line["resumed_time_s"] = event.resumed().time_s();
  } else if (event.has_validity_lost()) {
    line["validity_loss"] = to_json(event.validity_lost());
  } else if (event.has_finding()) {
    line["finding"] = to_json(event.finding());
  }
}

}  // namespace

Json WatchOutput::line(const v1::JobEvent& event) {
  if (event.has_state_change()) state_ = event.state_change().state();
  if (event.has_step()) {
    step_ = event.step();
    stepped_ = true;
    // A watch that begins in the middle of a run has not seen it start.
    if (state_ == v1::JOB_STATE_UNSPECIFIED) state_ = v1::RUNNING;
  }
  Json line;
  line["sequence"] = event.sequence();
  line["event"] = event_name(event);
  line["time"] = google::protobuf::util::TimeUtil::ToString(event.time());
  line["state"] = v1::JobState_Name(state_);
  line["step"] = stepped_ ? Json(step_.step()) : Json(nullptr);
  line["time_s"] = stepped_ ? Json(step_.time_s()) : Json(nullptr);
  line["cast_length_m"] = stepped_ ? Json(step_.cast_length_m()) : Json(nullptr);
  line["iterations"] = stepped_ ? Json(step_.iterations()) : Json(nullptr);
  line["beyond_validity"] = step_.beyond_validity();
  line["monitors"] = Json::array();
  for (const v1::MonitorValue& monitor : step_.monitors())
    line["monitors"].push_back(to_json(monitor));
  add_particulars(event, line);
  return line;
}

}  // namespace dccast::client::render
