#pragma once

#include "dccast/v1/follow.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::studies {

/// Adds to a forecast what can still be done from its time on: each lever of a study (LeversPlan)
/// with its effect at the end of the casting, and sentences. In each casting of the study an effect
/// is linear between the times from which on the lever was moved, and none at the end. Over the
/// castings it is a straight line in the curl of the plan, on which the forecast places this
/// casting.
///
/// A lever is advised where it lowers the curl at a gauge by more than 1 mm, the band of nine in
/// ten does not reach zero, no other gauge rises as much, and in no casting the runs around this
/// time have a finding that is new or worse.
/// @param study  evaluated; nothing is added before all its runs have ended
/// @param to     with the curls of all gauges
void add_advice(const v1::StudyResult& study, const v1::Following& following, v1::Forecast& to);

}  // namespace dccast::studies
