#include <gtest/gtest.h>
#include <hdf5.h>

namespace dccast::results::hdf5 {
namespace {

/// A run may read prescribed temperatures while its results are being written.
TEST(Hdf5, IsBuiltForSeveralThreads) {
  hbool_t safe = false;
  ASSERT_GE(H5is_library_threadsafe(&safe), 0);
  EXPECT_TRUE(safe);
}

}  // namespace
}  // namespace dccast::results::hdf5
