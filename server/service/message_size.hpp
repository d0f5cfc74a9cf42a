#pragma once

#include <cstddef>

#include "dccast/v1/job.pb.h"

namespace dccast::service {

/// What an answer that could go on without end is cut to [bytes]. A client's gRPC takes 4 MiB
/// unless told otherwise.
inline constexpr std::size_t page_bytes = 1 << 20;

/// What any answer is held to [bytes]: those 4 MiB, less the frame of the message.
inline constexpr std::size_t answer_bytes = (4 << 20) - 4096;

/// Cuts what a job says about itself until it is fit for an answer with others: first its title to
/// 1 KiB, then the monitors of its last step, the residuals and the texts of its failure. Cases of
/// today are bounded by the schema; those in a store of an earlier version may hold anything.
void fit_into_list(v1::Job& job);

/// Writes out what would act on a terminal in every text of a message. Cases of today are held
/// against that when they are taken; those of an earlier version may hold anything.
void make_printable(google::protobuf::Message& message);

}  // namespace dccast::service
