#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/results/frame.hpp"

namespace dccast::results {

/// A field that the XDMF sidecar shows.
struct ShownField {
  std::string name;      ///< name in ParaView
  std::string dataset;   ///< in the frame's group
  bool on_nodes = true;  ///< else on elements
  int components = 1;
};

/// The part of a frame that the sidecar needs: sizes, not values.
struct FrameOutline {
  double time = 0.0;  ///< [s]
  int dimension = 2;
  /// Size of the mesh of a frame, by which XDMF finds its arrays in the HDF5 file.
  int nodes_per_element = 3;
  std::int64_t nodes = 0;
  std::int64_t elements = 0;
  std::vector<ShownField> fields;  ///< fields that exist in the frame
};

/// Sizes and fields of a frame.
FrameOutline make_outline(const Frame& frame);

/// The text of the sidecar with which ParaView opens a result file as a time series (XDMF 3). There
/// is one dataset per frame, because one of ParaView's two XDMF readers does not read hyperslabs of
/// a common dataset.
/// @param hdf5_name  name of the result file, which is in the same folder
std::string format_xdmf(const std::vector<FrameOutline>& frames, const std::string& hdf5_name);

/// The same of the last frame alone, as one uniform grid without a time: for programs that read no
/// collections, such as meshio.
std::string format_last_frame(const std::vector<FrameOutline>& frames,
                              const std::string& hdf5_name);

}  // namespace dccast::results
