#pragma once

#include <optional>
#include <string>

#include "dccast/v1/service.pb.h"

/// Stored frames as the scripts of pages read them (frame_data.js).
namespace dccast::client {

/// Numbers of a frame as they are sent.
enum class Precision {
  full,     ///< 32-bit floats
  drawing,  ///< the same with twelve bits of precision, which are packed into half the space
};

/// A frame that was asked for to be drawn, in binary: a header of eight numbers of 32 bits (nodes,
/// elements, nodes of an element, triangles of the skin, edges of the skin, dimension, 0, 0), then
/// time, length, liquidus and solidus, places, displacements as drawn and temperatures of the nodes
/// (32-bit floats; three coordinates whatever the dimension), elements, triangles, edges (32-bit).
/// Little-endian, as this machine is.
/// @return empty if the arrays of the frame are inconsistent
std::optional<std::string> frame_bytes(const v1::Frame& frame, Precision precision);

/// Values of a field as 32-bit floats.
std::string float_bytes(const google::protobuf::RepeatedField<float>& values, Precision precision);

/// Bytes as text for a page: gzip, then base64.
std::string packed(const std::string& bytes);
/// Bytes as text.
std::string base64(const std::string& bytes);

}  // namespace dccast::client
