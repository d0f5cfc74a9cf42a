#include "client/html/frame_bytes.hpp"

#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace dccast::client {
namespace {

float rounded(float value, Precision precision) {
  constexpr std::uint32_t dropped = 1U << 12U;  // of the 23 bits behind the point
  if (precision == Precision::full || !std::isfinite(value)) return value;
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return std::bit_cast<float>((bits + dropped / 2) & ~(dropped - 1));
}

class Bytes {
public:
  explicit Bytes(Precision precision) : precision_(precision) {}

  void add(int number) { append(static_cast<std::int32_t>(number)); }
  void add(double number) { append(rounded(static_cast<float>(number), precision_)); }

  /// Three coordinates of each node; vectors that are missing are zero.
  void add_vectors(const google::protobuf::RepeatedField<double>& values, int dimension,
                   int nodes) {
    const int known = values.size();
    for (int node = 0; node < nodes; ++node)
      for (int c = 0; c < 3; ++c) {
        // The last coordinate points upwards: of a section it is the second.
        const int from = dimension == 3 ? c : c == 1 ? -1 : c / 2;
        const int at = node * dimension + from;
        add(from >= 0 && at < known ? values[at] : 0.0);
      }
  }

  std::string take() { return std::move(bytes_); }

private:
  template <class Number>
  void append(Number number) {
    static_assert(sizeof(Number) == 4);
    char raw[4];
    std::memcpy(raw, &number, sizeof raw);
    bytes_.append(raw, sizeof raw);
  }

  Precision precision_;
  std::string bytes_;
};

/// Whether the arrays of a frame fit each other, and name nodes that exist.
bool is_consistent(const v1::Frame& frame) {
  const int nodes = frame.temperature_c_size(), coordinates = frame.dimension() * nodes;
  const auto names_nodes = [&](const google::protobuf::RepeatedField<std::int32_t>& numbers) {
    return std::ranges::all_of(numbers, [&](int node) { return node >= 0 && node < nodes; });
  };
  return nodes > 0 && frame.node_m_size() == coordinates &&
         (frame.displacement_m().empty() || frame.displacement_m_size() == coordinates) &&
         frame.nodes_per_element() > 0 && !frame.skin_triangle().empty() &&
         frame.element_node_size() % frame.nodes_per_element() == 0 &&
         names_nodes(frame.element_node()) && names_nodes(frame.skin_triangle()) &&
         names_nodes(frame.skin_edge());
}

}  // namespace

std::optional<std::string> frame_bytes(const v1::Frame& frame, Precision precision) {
  if (!is_consistent(frame)) return std::nullopt;

  const int dimension = frame.dimension(), nodes = frame.temperature_c_size();
  Bytes bytes(precision);
  for (const int count :
       {nodes, frame.element_node_size() / frame.nodes_per_element(), frame.nodes_per_element(),
        frame.skin_triangle_size() / 3, frame.skin_edge_size() / 2, dimension, 0, 0})
    bytes.add(count);
  for (const double value :
       {frame.time_s(), frame.cast_length_m(), frame.liquidus_c(), frame.solidus_c()})
    bytes.add(value);

  bytes.add_vectors(frame.node_m(), dimension, nodes);
  bytes.add_vectors(frame.displacement_m(), dimension, nodes);
  for (const double value : frame.temperature_c()) bytes.add(value);
  for (const auto* const numbers :
       {&frame.element_node(), &frame.skin_triangle(), &frame.skin_edge()})
    for (const int node : *numbers) bytes.add(node);
  return bytes.take();
}

std::string float_bytes(const google::protobuf::RepeatedField<float>& values, Precision precision) {
  Bytes bytes(precision);
  for (const float value : values) bytes.add(static_cast<double>(value));
  return bytes.take();
}

std::string packed(const std::string& bytes) {
  constexpr int gzip_window = 15 + 16, memory_level = 9;
  z_stream stream{};
  if (::deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, gzip_window, memory_level,
                     Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("packed: no memory to compress");

  std::string gzip(::deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(gzip.data());
  stream.avail_out = static_cast<uInt>(gzip.size());
  ::deflate(&stream, Z_FINISH);  // ends at once: the output has the space for all of it
  gzip.resize(stream.total_out);
  ::deflateEnd(&stream);
  return base64(gzip);
}

std::string base64(const std::string& bytes) {
  std::string text((bytes.size() + 2) / 3 * 4, '=');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                  reinterpret_cast<const unsigned char*>(bytes.data()),
                  static_cast<int>(bytes.size()));
  return text;
}

}  // namespace dccast::client
