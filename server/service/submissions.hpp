#pragma once

#include "server/service/refusals.hpp"

/// How jobs and studies are queued, for the calls that queue them: first a check, which asks a
/// worker and throws Refusal, then a write to the disk.
namespace dccast::service {

/// A case that has passed the checks of SubmitJob.
struct SoundSubmission {
  intake::ExaminedCase examined;
  jobs::Attachments attachments;
};

/// Checks a request and its case.
SoundSubmission examine(Context& context, const Call& call, const v1::SubmitJobRequest& request);
/// Stores the job and queues it.
v1::Job submit(Context& context, const Call& call, const v1::SubmitJobRequest& request,
               const SoundSubmission& sound);

/// Completes the plan of a request and checks the cases of its runs, after which Studies::create()
/// takes it. @return the files that its case names
jobs::Attachments examine(Context& context, const Call& call, v1::CreateStudyRequest& request);

}  // namespace dccast::service
