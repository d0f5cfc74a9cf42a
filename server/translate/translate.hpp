#pragma once

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "core/case/case.hpp"
#include "core/case/case_check.hpp"
#include "core/casting/simulation.hpp"
#include "core/results/frame.hpp"
#include "core/results/study_table.hpp"
#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/service.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::translate {

/// The core's enumerator for one of the schema, or the other way round. @param otherwise  for one
/// that is not in the table
template <class To, class From>
To counterpart(From from, std::initializer_list<std::pair<From, To>> table, To otherwise) {
  const auto found = std::ranges::find(table, from, &std::pair<From, To>::first);
  return found == table.end() ? otherwise : found->second;
}

/// The core's form of a case.
/// @param complete     with defaults and alloy card filled in, checked against the schema; what is
///                     absent all the same keeps the core's default
/// @param attachments  folder of the files the case names; the names become paths below it
casting::Case to_core(const v1::Case& complete, const std::filesystem::path& attachments);

/// A table; an absent one (no points) becomes an empty curve.
Curve to_core(const v1::Curve& curve);

/// The verdict of the core's check.
v1::ValidateCaseResponse to_proto(const casting::CheckedCase& checked);

/// Faults in one text, for a job that turned out invalid only when it began.
std::string in_words(const std::vector<Fault>& faults);

/// @param header  of the same result file; gives the temperatures where the metal freezes
v1::Frame to_proto(const results::Frame& frame, const results::RunHeader& header);

/// @param monitors  of the case, in its order: the core's reports know them by number
v1::StepReport to_proto(const results::StepReport& report,
                        const std::vector<casting::Monitor>& monitors);

/// The same report, bit by bit. @param dimension  2 in sections, 3 in quarter slabs
results::StepReport to_core(const v1::StepReport& report, int dimension);

/// @param failures  of a run, the cause first; at least one
v1::Failure to_proto(const casting::RunFailures& failures);

v1::ValidityLoss to_proto(const results::ValidityLoss& loss);

v1::Finding to_proto(const results::Finding& finding);

/// The runs of a study as a table. All monitors of a run share the instants of the first of its
/// curves that has any.
results::StudyTable to_table(const v1::StudyResult& result);

}  // namespace dccast::translate
