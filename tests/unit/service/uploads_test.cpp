// Files of cases as they come: whole or broken, within limits or not, for a while.
#include <gmock/gmock.h>

#include "tests/support/eventually.hpp"
#include "tests/unit/service/service_fixture.hpp"

namespace dccast::service {
namespace {

using ::testing::HasSubstr;
using enum grpc::StatusCode;

v1::Attachment announced(std::int64_t bytes, const std::string& sha256 = std::string(64, '0')) {
  v1::Attachment file;
  file.set_name("slab.msh");
  file.set_sha256(sha256);
  file.set_size_bytes(bytes);
  return file;
}

class UploadsTest : public ServiceTest {
protected:
  using ServiceTest::ServiceTest;

  std::ptrdiff_t files() {
    return std::distance(std::filesystem::directory_iterator(folder_ / "uploads"), {});
  }
  v1::SubmitJobRequest submission_with(const v1::Attachment& file) {
    v1::SubmitJobRequest request = submission();
    request.mutable_case_()->mutable_mesh()->set_file(file.name());
    *request.add_attachments() = file;
    return request;
  }
  /// An upload of which a first part has come.
  struct Begun {
    Begun(const User& user, std::int64_t bytes)
        : call(user.context()), writer(user.stub().UploadAttachment(call.get(), &response)) {
      v1::UploadAttachmentRequest part;
      *part.mutable_attachment() = announced(bytes);
      writer->Write(part);
      part.set_chunk(std::string(1000, 'x'));
      writer->Write(part);
    }
    v1::UploadAttachmentResponse response;
    std::unique_ptr<grpc::ClientContext> call;
    std::unique_ptr<grpc::ClientWriter<v1::UploadAttachmentRequest>> writer;
  };

  User user_ = local_user();
};

TEST_F(UploadsTest, WhatTheServerHasIsNotSentAgain) {
  const v1::Attachment file = user_.uploaded("slab.msh", std::string(200'000, 'x'));
  v1::UploadAttachmentResponse response;
  EXPECT_TRUE(user_.upload(file, {std::string(200'000, 'x')}, &response).ok());
  EXPECT_TRUE(response.was_there());
  EXPECT_EQ(files(), 1);
}

TEST_F(UploadsTest, WhatIsNotAsAnnouncedIsRefusedAndRemoved) {
  const v1::Attachment mesh = announced(4, values::sha256("mesh"));
  for (const char* content : {"mes", "mashy", "mash", ""})
    EXPECT_EQ(user_.upload(mesh, {content}).error_code(), INVALID_ARGUMENT) << content;
  for (const v1::Attachment& faulty :
       {announced(4, ""), announced(4, std::string(64, 'A')), announced(-1, mesh.sha256())})
    EXPECT_EQ(user_.upload(faulty, {"mesh"}).error_code(), INVALID_ARGUMENT);
  EXPECT_EQ(user_.upload(announced(300'000), {std::string(300'000, 'x')}).error_code(),
            INVALID_ARGUMENT)
      << "too large a chunk";

  for (const bool has_chunk : {false, true}) {
    const auto call = user_.context();
    v1::UploadAttachmentResponse response;
    const auto writer = user_.stub().UploadAttachment(call.get(), &response);
    v1::UploadAttachmentRequest part;
    part.set_chunk("mesh");
    if (has_chunk) writer->Write(part);
    writer->WritesDone();
    EXPECT_EQ(writer->Finish().error_code(), INVALID_ARGUMENT) << "a file without a name";
  }
  EXPECT_TRUE(eventually([&] { return files() == 0; }));
}

TEST_F(UploadsTest, AnUploadThatIsCancelledLeavesNothing) {
  Begun upload(user_, 50'000'000);
  ASSERT_TRUE(eventually([&] { return files() == 1; }));
  upload.call->TryCancel();
  EXPECT_TRUE(eventually([&] { return files() == 0; }));
}

TEST_F(UploadsTest, AFileThatIsNotThereIsToBeUploaded) {
  EXPECT_THAT(
      user_.refusal(ABORTED, &Stub::SubmitJob, submission_with(announced(4))).error_message(),
      HasSubstr("upload it"));
}

class UploadLimits : public UploadsTest {
protected:
  UploadLimits()
      : UploadsTest([](v1::DaemonConfig& settings) {
          settings.mutable_per_case()->set_maximum_attachment_bytes(700'000);
          settings.mutable_per_user()->set_maximum_uploads_bytes(1'000'000);
          settings.mutable_limits()->set_maximum_uploads_bytes(2'000'000);
          settings.mutable_retention()->set_upload_lifetime_s(0.5);
        }) {}
  static std::vector<std::string> parts(char letter) { return {3, std::string(200'000, letter)}; }
  v1::Attachment file(const std::string& name, char letter) {
    v1::Attachment file = announced(600'000, values::sha256(std::string(600'000, letter)));
    file.set_name(name);
    return file;
  }
};

TEST_F(UploadLimits, TheRefusalNamesTheQuotaAndUsedFilesGiveWay) {
  const v1::Attachment first = file("first.msh", 'a'), second = file("second.msh", 'b');
  ASSERT_TRUE(user_.upload(first, parts('a')).ok());
  const grpc::Status status = user_.upload(second, parts('b'));
  EXPECT_EQ(status.error_code(), RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("per_user.maximum_uploads = 1 MB"));
  EXPECT_EQ(refusal::read_details(status.error_details())->limit, "per_user.maximum_uploads");
  v1::ValidateCaseResponse verdict;
  ASSERT_TRUE(refusal::read_detail(status.error_details(), verdict));
  const v1::Fault& fault = verdict.faults(0);
  EXPECT_EQ(fault.field(), "attachments");
  EXPECT_THAT(fault.value(), HasSubstr("second.msh"));
  EXPECT_THAT(fault.permitted(), HasSubstr("per_user.maximum_uploads"));
  EXPECT_THAT(fault.remedy(), HasSubstr("submit"));

  submitted(user_, submission_with(first));
  // The call that submits holds the file a moment longer than its answer takes.
  EXPECT_TRUE(eventually([&] { return user_.upload(second, parts('b')).ok(); }))
      << "the job has its own copy of the first";
}

TEST_F(UploadLimits, AFileThatIsTooLarge) {
  const grpc::Status status = user_.upload(announced(700'001), {"x"});
  EXPECT_EQ(status.error_code(), RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("per_case.maximum_attachment"));
}

TEST_F(UploadLimits, AnUploadThatStandsStillIsEnded) {
  Begun upload(user_, 500'000);
  const grpc::Status status = upload.writer->Finish();
  EXPECT_EQ(status.error_code(), DEADLINE_EXCEEDED);
  EXPECT_THAT(status.error_message(), HasSubstr("did not come"));
  EXPECT_TRUE(eventually([&] { return files() == 0; }));
}

TEST_F(UploadLimits, FilesThatAreNotUsedExpire) {
  ASSERT_TRUE(user_.upload(file("first.msh", 'a'), parts('a')).ok());
  EXPECT_TRUE(eventually([&] { return files() == 0; }));
  EXPECT_TRUE(user_.upload(file("second.msh", 'b'), parts('b')).ok());
}

}  // namespace
}  // namespace dccast::service
