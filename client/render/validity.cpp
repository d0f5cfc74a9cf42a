#include "client/render/validity.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "client/render/job_text.hpp"
#include "client/render/table.hpp"

namespace dccast::client::render {

std::string figure_text(double value, const std::string& unit) {
  const bool length = unit == "m";
  char text[40];
  std::snprintf(text, sizeof text, "%.3g", length ? 1e3 * value : value);
  if (unit.empty() || unit == "1") return text;
  return std::string(text) + " " + (length ? "mm" : unit);
}

std::string place_text(const google::protobuf::RepeatedField<double>& place_m) {
  constexpr std::array axes{"x ", "y ", "z "};
  std::string text;
  for (int i = 0; i < std::min(place_m.size(), static_cast<int>(axes.size())); ++i)
    text += (i == 0 ? "" : ", ") + std::string(axes[static_cast<std::size_t>(i)]) +
            fixed(1e3 * place_m[i], 1) + " mm";
  return text;
}

std::string validity_text(const v1::ValidityLoss& loss) {
  const std::string begin =
      std::string(beyond_validity) + " from " + fixed(loss.time_s(), 2) + " s on: ";
  if (!loss.message().empty()) return begin + loss.message();  // says where and by how much
  std::string text = begin + failure_kind_text(loss.kind());
  if (loss.limit() != 0.0 || loss.value() != 0.0)
    text += " (" + figure_text(loss.value(), loss.unit()) + ", limit " +
            figure_text(loss.limit(), loss.unit()) + ")";
  const std::string place = place_text(loss.place_m());
  return place.empty() ? text : text + " at " + place;
}

}  // namespace dccast::client::render
