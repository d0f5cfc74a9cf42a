#pragma once

#include <string>
#include <vector>

#include "client/model/study.hpp"
#include "client/text/table.hpp"
#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// What a study is and how its runs ended, in two lines.
std::string head_of(const v1::StudyResult& result);

/// The answer of a calibration, on one screen of 120 columns.
std::string calibration_text(const v1::StudyResult& result);

/// For screen and page: which keys are narrowed, which cannot be separated, what the model cannot
/// follow, what mesh and steps add, and how the surface agrees with runs.
std::vector<std::string> calibration_sentences(const v1::StudyResult& result);

/// A row for each key: key, range before, value, 5 to 95 % after, width that is left.
Rows key_rows(const v1::StudyResult& result);

/// A row for each measured curve: what and where from, readings, root mean squares before and
/// after, noise, misfit, error of the surface.
Rows curve_rows(const v1::Calibration& calibration);

/// "curl of corner, mm"; of a second casting with its number.
std::string curve_name(const v1::Calibration& calibration, const v1::Calibration::Curve& curve);

/// From the unit of a curve's figures to that of its name: 1000 for curls.
double shown_units(const v1::Calibration::Curve& curve);

}  // namespace dccast::client::render
