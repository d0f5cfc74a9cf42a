#include "core/results/temperature_file.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/results/hdf5_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::results {
namespace {

struct TemperatureFile {
  hdf5::Shape time_shape{3};
  std::vector<double> time{0.0, 10.0, 30.0};
  hdf5::Shape temperature_shape{3, 2};
  std::vector<double> temperature{600.0, 500.0, 400.0, 300.0, 200.0, 100.0};

  void write(const std::filesystem::path& path) const {
    auto file = hdf5::File::create(path);
    file.write("/time_s", time_shape, time, "s", "time");
    file.write("/temperature_c", temperature_shape, temperature, "degC", "temperature");
    file.close();
  }
};

/// The one fault of a file for a mesh of two nodes.
std::string fault_of(const TemperatureFile& content) {
  const TemporaryFolder folder;
  content.write(folder / "t.h5");
  Faults faults;
  EXPECT_FALSE(read_temperature_file(folder / "t.h5", 2, faults));
  if (faults.list().size() != 1) return "not one fault";
  EXPECT_EQ(faults.list()[0].field, "thermal.file");
  EXPECT_EQ(faults.list()[0].value, "t.h5");
  return faults.list()[0].message;
}

TEST(TemperatureFile, IsLinearInTimeAndConstantOutside) {
  const TemporaryFolder folder;
  TemperatureFile{}.write(folder / "t.h5");
  Faults faults;
  const auto history = read_temperature_file(folder / "t.h5", 2, faults);

  ASSERT_TRUE(history);
  EXPECT_TRUE(faults.empty());

  std::vector<double> at;
  const auto temperatures_at = [&](double time) {
    history->at(time, at);
    return at;
  };
  EXPECT_EQ(temperatures_at(-5.0), (std::vector{600.0, 500.0}));
  EXPECT_EQ(temperatures_at(0.0), (std::vector{600.0, 500.0}));
  EXPECT_EQ(temperatures_at(2.5), (std::vector{550.0, 450.0}));
  EXPECT_EQ(temperatures_at(10.0), (std::vector{400.0, 300.0}));
  EXPECT_EQ(temperatures_at(25.0), (std::vector{250.0, 150.0}));
  EXPECT_EQ(temperatures_at(31.0), (std::vector{200.0, 100.0}));
}

TEST(TemperatureFile, MustFitTheMesh) {
  TemperatureFile content;
  content.temperature_shape = {2, 3};
  EXPECT_EQ(fault_of(content), "temperature_c has the shape (2, 3)");
}

TEST(TemperatureFile, MustHaveOneDimensionalTimes) {
  TemperatureFile content;
  content.time_shape = {3, 1};
  EXPECT_EQ(fault_of(content), "time_s has the shape (3, 1)");
}

TEST(TemperatureFile, MustGoForwardInTime) {
  TemperatureFile content;
  content.time[2] = 10.0;
  EXPECT_EQ(fault_of(content), "time_s[2] is not later than the one before");
  content.time[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(fault_of(content), "time_s[1] is not a number");
}

TEST(TemperatureFile, MustHoldTemperatures) {
  TemperatureFile content;
  content.temperature[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(fault_of(content), "temperature_c[1, 1] = nan");
  content.temperature[3] = -300.0;
  EXPECT_EQ(fault_of(content), "temperature_c[1, 1] = -300.000000");
}

/// Such a file has a kilobyte: nothing of the array is stored.
TEST(TemperatureFile, AsksForNoMoreThanItHolds) {
  for (const hsize_t times : {hsize_t{1} << 32, hsize_t{1} << 61}) {
    const TemporaryFolder folder;
    const hid_t file =
        H5Fcreate((folder / "t.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk[] = {1, 2};
    for (const int rank : {1, 2}) {
      const hsize_t shape[] = {times, 2};
      const hid_t space = H5Screate_simple(rank, shape, nullptr);
      H5Pset_chunk(layout, rank, chunk);
      const char* name = rank == 1 ? "/time_s" : "/temperature_c";
      const hid_t dataset =
          H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, layout, H5P_DEFAULT);
      ASSERT_GE(dataset, 0);
      H5Dclose(dataset);
      H5Sclose(space);
    }
    H5Pclose(layout);
    H5Fclose(file);
    Faults faults;
    EXPECT_FALSE(read_temperature_file(folder / "t.h5", 2, faults));
    ASSERT_EQ(faults.list().size(), 1u);
    EXPECT_NE(faults.list()[0].message.find("/time_s: has the wrong shape"), std::string::npos)
        << faults.list()[0].message;
  }
}

TEST(TemperatureFile, MustBeThere) {
  Faults faults;
  EXPECT_FALSE(read_temperature_file("nowhere.h5", 2, faults));
  ASSERT_EQ(faults.list().size(), 1u);
  EXPECT_EQ(faults.list()[0].permitted, "a readable HDF5 file");
}

TEST(TemperatureFile, NamesEachMissingDataset) {
  const TemporaryFolder folder;
  hdf5::File::create(folder / "t.h5").close();
  Faults faults;
  EXPECT_FALSE(read_temperature_file(folder / "t.h5", 2, faults));
  ASSERT_EQ(faults.list().size(), 2u);
  EXPECT_EQ(faults.list()[0].message, "has no dataset /time_s");
  EXPECT_EQ(faults.list()[1].message, "has no dataset /temperature_c");
}

}  // namespace
}  // namespace dccast::results
