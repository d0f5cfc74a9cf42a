#include "core/case/course.hpp"

#include <algorithm>

#include "core/case/casting_schedule.hpp"

namespace dccast::casting {

namespace {

double cast_length(const CastingSchedule& schedule) {
  constexpr int enough = 1000;  // for a speed against cast length; others are exact in one piece
  const int pieces = schedule.speed_follows_time() ? 1 : enough;
  const double piece = schedule.end() / pieces;
  double length = 0.0;
  for (int i = 0; i < pieces && piece > 0.0; ++i)
    length = schedule.cast_length(length, i * piece, piece);
  return length;
}

struct Range {
  double from, to;
};

/// The range in which a table is evaluated. @pre its abscissa is time or cast length
Range range_of(const Curve& curve, const Course& course) {
  if (curve.abscissa() == Abscissa::cast_length) return {0.0, course.cast_length};
  return {course.begin, course.end};
}

bool follows_course(const Curve& curve) {
  return !curve.empty() && !curve.constant() &&
         (curve.abscissa() == Abscissa::time || curve.abscissa() == Abscissa::cast_length);
}

}  // namespace

Course course_of(const Case& c) {
  const CastingSchedule schedule(c);
  Course course{schedule.begin(), schedule.end(), cast_length(schedule), c.section.initial_depth};
  if (c.section.growth) course.depth += course.cast_length;
  return course;
}

std::vector<double> values_in(const Curve& curve, const Course& course) {
  if (!follows_course(curve)) return curve.value();
  const Range range = range_of(curve, course);
  std::vector<double> values{curve(range.from), curve(range.to)};
  for (std::size_t i = 0; i < curve.at().size(); ++i)
    if (curve.at()[i] > range.from && curve.at()[i] < range.to) values.push_back(curve.value()[i]);
  return values;
}

bool never_reached(const Curve& curve, const Course& course, double shift) {
  if (!follows_course(curve)) return false;
  const Range range = range_of(curve, course);
  if (curve.abscissa() != Abscissa::time) shift = 0.0;
  return curve.at().front() + shift >= range.to || curve.at().back() + shift <= range.from;
}

std::string listed(const std::vector<std::string>& texts) {
  constexpr std::size_t most = 5;
  std::string list;
  for (std::size_t i = 0; i < std::min(most, texts.size()); ++i)
    list += (list.empty() ? "" : ", ") + texts[i];
  if (texts.size() > most) list += " and " + std::to_string(texts.size() - most) + " more";
  return list;
}

}  // namespace dccast::casting
