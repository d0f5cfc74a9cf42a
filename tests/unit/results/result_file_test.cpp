#include <gtest/gtest.h>
#include <hdf5.h>

#include <stdexcept>

#include "core/results/journal.hpp"
#include "core/results/result_reader.hpp"
#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"
#include "tests/unit/results/sample_run.hpp"

namespace dccast::results {
namespace {

using storage::read_file;
using storage::StorageError;
using storage::write_file;

/// Publishes a run of 300 steps with a frame at its begin and its end.
void publish_sample(const std::filesystem::path& results, int nodes_per_element, int cells) {
  ResultWriter writer({results.string() + ".journal", results}, sample_header());
  writer.append(sample_frame(0, nodes_per_element, cells));
  for (std::int64_t step = 1; step <= 300; ++step) writer.append(sample_step(step));
  writer.append(sample_frame(300, nodes_per_element, cells + 1));
  writer.publish({"check_failed", "the energy balance"});
  std::filesystem::remove(results.string() + ".journal");
}

TEST(ResultFile, ReturnsHeaderAndSummary) {
  const TemporaryFolder folder;
  publish_sample(folder / "r.h5", 3, 3);

  const ResultReader reader(folder / "r.h5");
  EXPECT_EQ(reader.header(), sample_header());
  EXPECT_EQ(reader.summary().outcome, "check_failed");
  EXPECT_EQ(reader.summary().message, "the energy balance");
  EXPECT_FALSE(reader.summary().validity_lost);
}

TEST(ResultFile, TellsWhenTheModelWasLeft) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
  RunSummary summary;
  summary.validity_lost = {"motion_too_large", "it slid", 1.0 / 3.0, {0.1, 0.2}, 0.03, 0.02, "m"};
  writer.publish(summary);

  const RunSummary read = ResultReader(folder / "r.h5").summary();
  EXPECT_EQ(read.outcome, "succeeded");
  EXPECT_EQ(read.validity_lost, summary.validity_lost);
}

TEST(ResultFile, ReturnsFindingsWithWhatIsAbsent) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
  RunSummary summary;
  summary.findings = {
      {"no_superheat", Severity::danger, "Cold.", {}, {}, -20.0, 5.0, "K", "a.key"},
      {"hot_tears", Severity::warning, "Tears.", 1.0 / 3.0, {0.1, 0.2}, {}, {}, "", ""},
      {"in_3d",
       Severity::note,
       "Deep.",
       2.0,
       {0.1, 0.2, 0.3},
       1.0,
       2.0,
       "m",
       "",
       Exceedance{3.0, 0.5, {0.1, 0.2, 0.4}},
       Certainty::open,
       0.25,
       0.75}};

  writer.publish(summary);
  EXPECT_EQ(ResultReader(folder / "r.h5").summary().findings, summary.findings);
}

TEST(ResultFile, ReturnsEveryFieldOfEveryStep) {
  const TemporaryFolder folder;
  publish_sample(folder / "r.h5", 3, 3);

  const auto history = ResultReader(folder / "r.h5").history();
  ASSERT_EQ(history.size(), 300u);
  for (const StepReport& report : history) {
    StepReport expected = sample_step(report.step);
    expected.solver_seconds = expected.process_seconds = 0.0;  // not in the file
    EXPECT_TRUE(report == expected) << "step " << report.step;
  }
  EXPECT_EQ(history.back().step, 300);
}

TEST(ResultFile, ReturnsFramesOfEachElementFamily) {
  for (const int nodes_per_element : {3, 4}) {
    for (const int cells : {2, 1200}) {  // below and above the size that is compressed
      const TemporaryFolder folder;
      publish_sample(folder / "r.h5", nodes_per_element, cells);

      const ResultReader reader(folder / "r.h5");
      ASSERT_EQ(reader.frames(), 2u);
      EXPECT_EQ(reader.frame(0), sample_frame(0, nodes_per_element, cells));
      EXPECT_EQ(reader.frame(reader.frames() - 1), sample_frame(300, nodes_per_element, cells + 1));
    }
  }
}

TEST(ResultFile, ReturnsARunOfThreeDimensions) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_solid_header());
  writer.append(sample_solid_frame(0, 3));
  writer.append(sample_solid_step(1));
  RunSummary summary;
  summary.validity_lost = {"motion_too_large", "it slid", 0.5, {0.1, 0.2, 0.3}, 0.03, 0.02, "m"};
  writer.publish(summary);

  const ResultReader reader(folder / "r.h5");
  EXPECT_EQ(reader.header(), sample_solid_header());
  EXPECT_EQ(reader.frame(0), sample_solid_frame(0, 3));
  EXPECT_EQ(reader.summary().validity_lost, summary.validity_lost);

  StepReport expected = sample_solid_step(1);
  expected.solver_seconds = expected.process_seconds = 0.0;
  EXPECT_EQ(reader.history().at(0), expected);
}

TEST(ResultFile, HoldsWattsAndNewtonsOfThreeDimensionsUnderTheirOwnNames) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_solid_header());
  writer.append(sample_solid_frame(0, 3));
  writer.append(sample_solid_step(1));
  writer.publish({});

  const hid_t file = H5Fopen((folder / "r.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  EXPECT_GT(H5Lexists(file, "/history/side_heat_w", H5P_DEFAULT), 0);
  EXPECT_GT(H5Lexists(file, "/history/weight_n", H5P_DEFAULT), 0);
  EXPECT_EQ(H5Lexists(file, "/history/side_heat_w_per_m", H5P_DEFAULT), 0);
  H5Fclose(file);
}

TEST(ResultFile, OfAnotherSchemaIsRefusedWithTheRemedy) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
  writer.append(sample_frame(0, 3, 3));
  writer.append(sample_step(1));
  writer.publish({});

  const hid_t file = H5Fopen((folder / "r.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t version = H5Aopen(file, "schema_version", H5P_DEFAULT);
  const std::int64_t other = 2;
  EXPECT_GE(H5Awrite(version, H5T_NATIVE_INT64, &other), 0);
  H5Aclose(version);
  H5Fclose(file);

  try {
    const ResultReader reader(folder / "r.h5");
    FAIL();
  } catch (const storage::StorageError& error) {
    const std::string text = error.what();
    for (const char* part : {"r.h5", "schema version 2", "reads 3", "run the case again"})
      EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

TEST(ResultFile, LeavesOutWhatWasNotComputed) {
  const TemporaryFolder folder;
  Frame heat_only = sample_frame(0, 3, 3);
  for (auto* array : {&heat_only.displacement, &heat_only.stress, &heat_only.viscoplastic_strain,
                      &heat_only.thermal_strain, &heat_only.tear_rate, &heat_only.tear_pressure,
                      &heat_only.bottom_gap, &heat_only.bottom_pressure})
    array->clear();

  RunHeader header = sample_header();
  header.monitor_name.clear();
  header.monitor_position.clear();

  ResultWriter writer({folder / "j", folder / "r.h5"}, header);
  writer.append(heat_only);
  writer.publish({});

  const ResultReader reader(folder / "r.h5");
  EXPECT_EQ(reader.frame(0), heat_only);
  EXPECT_EQ(reader.header(), header);
  EXPECT_TRUE(reader.history().empty());
}

TEST(ResultFile, IsTheSameByteForByteAndHoldsNoTimes) {
  const TemporaryFolder folder;
  publish_sample(folder / "a.h5", 3, 1200);
  ::sleep(1);  // a stored time would differ by now
  publish_sample(folder / "b.h5", 3, 1200);
  EXPECT_EQ(read_file(folder / "a.h5"), read_file(folder / "b.h5"));
}

TEST(ResultFile, GivesEveryNumberAUnitAndAMeaning) {
  for (const HistoryField& field : history_fields()) {
    EXPECT_STRNE(field.unit, "") << field.name;
    EXPECT_STRNE(field.meaning, "") << field.name;
  }
}

TEST(ResultFile, OfAFrameThatDoesNotFitItsMeshIsABug) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
  Frame frame = sample_frame(0, 3, 3);
  frame.temperature.pop_back();
  EXPECT_THROW(writer.append(frame), std::logic_error);
}

TEST(ResultReader, NamesFileAndDatasetOfADamagedArray) {
  const TemporaryFolder folder;
  publish_sample(folder / "r.h5", 3, 1200);
  std::string bytes = read_file(folder / "r.h5");

  const hid_t file = H5Fopen((folder / "r.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, "/frames/000001/node_m", H5P_DEFAULT);
  haddr_t address = 0;
  hsize_t size = 0;
  const hsize_t first[] = {0, 0};
  ASSERT_GE(H5Dget_chunk_info_by_coord(dataset, first, nullptr, &address, &size), 0);
  H5Dclose(dataset);
  H5Fclose(file);

  bytes[address + size / 2] = static_cast<char>(bytes[address + size / 2] ^ 1);
  write_file(folder / "r.h5", bytes);

  const ResultReader reader(folder / "r.h5");
  EXPECT_NO_THROW(reader.frame(0));
  try {
    reader.frame(1);
    FAIL() << "a flipped bit was not detected";
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("r.h5:/frames/000001/node_m"), std::string::npos)
        << error.what();
  }
}

TEST(ResultReader, RefusesWhatIsNotAResultFile) {
  const TemporaryFolder folder;
  EXPECT_THROW(ResultReader(folder / "none.h5"), StorageError);

  write_file(folder / "text.h5", "not HDF5");
  EXPECT_THROW(ResultReader(folder / "text.h5"), StorageError);

  publish_sample(folder / "r.h5", 3, 3);
  write_file(folder / "half.h5", read_file(folder / "r.h5").substr(0, 3000));
  EXPECT_THROW(ResultReader(folder / "half.h5"), StorageError);
}

/// Replaces a dataset.
template <class Value>
void replace(const std::filesystem::path& path, const char* object,
             const std::vector<hsize_t>& shape, hid_t type, const std::vector<Value>& values) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);

  H5Ldelete(file, object, H5P_DEFAULT);
  const hid_t dataset =
      H5Dcreate2(file, object, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);

  H5Dclose(dataset);
  H5Sclose(space);
  H5Fclose(file);
}

/// Replaces an attribute of a group.
void replace_attribute(const std::filesystem::path& path, const char* owner, const char* name,
                       const std::vector<double>& values) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hsize_t count = values.size();
  const hid_t space = H5Screate_simple(1, &count, nullptr);

  ASSERT_GE(H5Adelete_by_name(file, owner, name, H5P_DEFAULT), 0);
  const hid_t attribute = H5Acreate_by_name(file, owner, name, H5T_NATIVE_DOUBLE, space,
                                            H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, values.data()), 0);

  H5Aclose(attribute);
  H5Sclose(space);
  H5Fclose(file);
}

/// Arrays of a file were assumed to fit each other: readers went beyond their end.
TEST(ResultReader, RefusesArraysThatDoNotFitEachOther) {
  const TemporaryFolder folder;
  const auto path = folder / "r.h5";
  const auto fresh = [&] {
    std::filesystem::remove(path);
    publish_sample(path, 3, 3);
  };

  fresh();
  replace<double>(path, "/monitors/position_m", {1, 2}, H5T_NATIVE_DOUBLE, {0.0, 0.0});
  EXPECT_THROW(ResultReader(path).header(), StorageError);

  fresh();
  replace_attribute(path, "/", "liquidus_c", std::vector<double>(64, 600.0));
  EXPECT_THROW(ResultReader(path).header(), StorageError);

  fresh();
  replace_attribute(path, "/frames", "count", {1e18});
  EXPECT_THROW(ResultReader(path).frame_times(), StorageError);

  for (const int node : {-1, 1'000'000}) {
    fresh();
    replace<int>(path, "/frames/000000/element_node", {1, 3}, H5T_NATIVE_INT, {0, 1, node});
    EXPECT_THROW(ResultReader(path).frame(0), StorageError);
  }

  fresh();
  replace<double>(path, "/frames/000000/temperature_c", {2}, H5T_NATIVE_DOUBLE, {0.0, 0.0});
  EXPECT_THROW(ResultReader(path).frame(0), StorageError);

  for (const hsize_t dimension : {hsize_t{0}, hsize_t{7}}) {
    fresh();
    replace<double>(path, "/monitors/displacement_m", {300, 2, dimension}, H5T_NATIVE_DOUBLE,
                    std::vector<double>(600 * dimension));
    EXPECT_THROW(ResultReader(path).history(), StorageError);
  }

  fresh();
  replace<double>(path, "/history/time_s", {299}, H5T_NATIVE_DOUBLE, std::vector<double>(299));
  EXPECT_THROW(ResultReader(path).history(), StorageError);
}

}  // namespace
}  // namespace dccast::results
